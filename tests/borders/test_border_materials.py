"""Materials that lack their expansion, or whose stiffness is in another unit, are told before anything is solved."""

from __future__ import annotations

import pytest
from border_tools import Project, replace, untouched

MAT1 = "MAT1,1,7.+10,,.33,2700.,2.3-5"
BRICKS = "CHEXA,2,1,5,6,7,8,9,10"


def two_materials(tiny: Project, second: str) -> None:
    """The second brick of a material of its own."""
    replace(tiny.folder / "model.bdf", BRICKS, BRICKS.replace("2,1", "2,2", 1))
    replace(tiny.folder / "model.bdf", MAT1, f"{MAT1}\nPSOLID,2,2\n{second}")


@pytest.mark.parametrize("command", ["areas", "write-deck"])
@pytest.mark.parametrize("expansion", ["", "0.0"])
def test_a_forgotten_expansion_is_told(tiny: Project, command: str, expansion: str) -> None:
    """With its material, its elements and the areas that they are of; the areas have others that grow."""
    assert "no expansion" not in tiny.run(command).ok().out
    two_materials(tiny, f"MAT1,2,7.+10,,.33,2700.,{expansion}")
    said = "MAT1 2 has no expansion: 1 element does not grow (in areas LEFT, RIGHT)"
    outcome = tiny.run(command)
    if command == "areas":
        assert said in outcome.ok().out
    else:  # of the area RIGHT no element is left that grows
        outcome.refused(4, "no element of area RIGHT has an expansion: without one in MAT1 2")


def test_areas_that_nothing_moves_are_refused_before_they_are_solved(tiny: Project) -> None:
    replace(tiny.folder / "model.bdf", MAT1, "MAT1,1,7.+10,,.33,2700.")
    with untouched(tiny.folder):
        tiny.run("write-deck").refused(
            4,
            "model.bdf: no element of the areas LEFT, RIGHT has an expansion: without one in MAT1 1 the unit load",
            hint="field A of MAT1",
        )
    assert "areas whose elements have no expansion: LEFT, RIGHT" in tiny.run("areas").ok().out


def test_links_that_expand_may_move_an_area(tiny: Project) -> None:
    """What an RBE2 with an expansion does is not known here: nothing is refused."""
    replace(tiny.folder / "model.bdf", MAT1, "MAT1,1,7.+10,,.33,2700.\nRBE2,9,11,123456,12,1.-5")
    assert "MAT1 1 has no expansion: 2 elements do not grow" in tiny.run("write-deck").ok().out


@pytest.mark.parametrize(
    ("modulus", "said"),
    [
        ("7.+10", ""),
        ("1.1+6", ""),
        ("1.1+12", ""),
        ("1.1+5", "MAT1 1: a largest modulus of 1.1e+05 Pa is softer than rubber"),
        ("9.+13", "MAT1 1: a largest modulus of 9e+13 Pa is stiffer than diamond"),
    ],
)
def test_a_modulus_of_no_structure_is_told(tiny: Project, modulus: str, said: str) -> None:
    replace(tiny.folder / "model.bdf", MAT1, MAT1.replace("7.+10", modulus))
    for command in ("areas", "write-deck"):
        out = tiny.run(command).ok().out
        assert said in out
        assert ("is it in the unit of the deck?" in out) == bool(said)


def test_a_modulus_is_judged_in_the_units_of_the_deck(tiny: Project) -> None:
    """7e10 is aluminium in Pa, and nothing in MPa."""
    assert "largest modulus" not in tiny.run("areas").ok().out
    model = (tiny.folder / "model.bdf").read_text()
    for old, new in (("2700.", "2.7-9"), (",0.1", ",100."), (",0.2", ",200.")):
        model = model.replace(old, new)
    (tiny.folder / "model.bdf").write_text(model)
    replace(tiny.model, "[model]", '[model]\nunits = "mm-t-s"')
    assert "MAT1 1: a largest modulus of 7e+16 Pa is stiffer than diamond" in tiny.run("areas").ok().out


def test_materials_that_no_element_has_are_left_alone(tiny: Project) -> None:
    replace(tiny.folder / "model.bdf", MAT1, f"{MAT1}\nMAT1,7,1.,,.3,2700.")
    assert "MAT1 7" not in tiny.run("write-deck").ok().out
