"""Every command that reads a deck wants its end, says what it left out of it, and refuses what no body is."""

from __future__ import annotations

import numpy as np
import pytest
from border_tools import Project, replace

# write-deck reads model.bdf, ingest and solve the unit-load deck, areas the model or, without definitions, the deck.
READERS = ["write-deck", "areas", "areas of the deck", "solve", "ingest"]
DECKS = {"write-deck": "model.bdf", "areas": "model.bdf"}


def prepared(tiny: Project, reader: str) -> tuple[str, str]:
    """The command, and the file it reads."""
    if reader == "areas of the deck":
        replace(tiny.model, 'areas_csv = "areas.csv"\n', "")
    return reader.split()[0] if reader != "write-deck" else reader, DECKS.get(reader, "unit_loads.bdf")


@pytest.mark.parametrize("reader", READERS)
def test_a_deck_without_its_end(tiny: Project, reader: str) -> None:
    command, name = prepared(tiny, reader)
    deck = tiny.folder / name
    replace(deck, "ENDDATA\n", "")
    tiny.run(command).refused(4, f"{name}: has no ENDDATA", hint="model.allow_missing_enddata")
    replace(tiny.model, "[model]\n", "[model]\nallow_missing_enddata = true\n")
    tiny.run(command).ok()


@pytest.mark.parametrize("reader", READERS)
def test_cards_without_influence_are_told(tiny: Project, reader: str) -> None:
    command, name = prepared(tiny, reader)
    assert "not read" not in tiny.run(command).ok().out
    replace(tiny.folder / name, "ENDDATA\n", "SET4,1,PROP,PSOLID,1\nSET4,2,PROP,PSOLID,1\nPANEL,A,1\nENDDATA\n")
    told = tiny.run(command).ok().out
    assert "note: not read, without influence on unit loads and masses: PANEL (1), SET4 (2)\n" in told


@pytest.mark.parametrize("reader", READERS)
def test_a_card_of_unknown_name(tiny: Project, reader: str) -> None:
    command, name = prepared(tiny, reader)
    deck = tiny.folder / name
    line = deck.read_text().splitlines().index("CHEXA,2,1,5,6,7,8,9,10") + 1
    replace(deck, "CHEXA,2", "BHEXA,2")
    tiny.run(command).refused(4, f"{name}:{line}: BHEXA card: cards of this name are not read", hint="misspelt")


@pytest.mark.parametrize("reader", READERS)
def test_a_parameter_misspelt(tiny: Project, reader: str) -> None:
    command, name = prepared(tiny, reader)
    deck = tiny.folder / name
    replace(deck, "ENDDATA\n", "PARAM,WTMASR,.5\nENDDATA\n")
    line = deck.read_text().splitlines().index("PARAM,WTMASR,.5") + 1
    tiny.run(command).refused(4, f"{name}:{line}: PARAM,WTMASR is not known", hint="WTMASS")


@pytest.mark.parametrize("reader", ["write-deck", "areas of the deck", "solve", "ingest"])
@pytest.mark.parametrize("parameter", ["HEATSTAT,YES", "CHECKOUT,YES", "EXTOUT,DMIGPCH"])
def test_a_parameter_that_alters_a_unit_load(tiny: Project, reader: str, parameter: str) -> None:
    command, name = prepared(tiny, reader)
    replace(tiny.folder / name, "ENDDATA\n", f"PARAM,{parameter}\nENDDATA\n")
    tiny.run(command).refused(4, name, f"PARAM,{parameter.split(',')[0]}")


@pytest.mark.parametrize("reader", READERS)
def test_a_card_after_the_end(tiny: Project, reader: str) -> None:
    command, name = prepared(tiny, reader)
    deck = tiny.folder / name
    with deck.open("a") as file:
        file.write("CONM2,77,3,,.1\n")
    line = len(deck.read_text().splitlines())
    tiny.run(command).refused(4, f"{name}:{line}: CONM2 card after ENDDATA", hint="ENDDATA")


@pytest.mark.parametrize("reader", READERS)
@pytest.mark.parametrize(
    ("old", "new", "fact"),
    [
        ("2700.", "-2700.", "MAT1 1: a density of -2700 is negative"),
        ("2.3-5", "1.+30", "MAT1 1: an expansion of 1e+30"),
    ],
)
def test_a_material_that_nothing_is_made_of(tiny: Project, reader: str, old: str, new: str, fact: str) -> None:
    command, name = prepared(tiny, reader)
    replace(tiny.folder / name, old, new)
    tiny.run(command).refused(4, name, fact)


def test_an_inertia_that_no_body_has(tiny: Project) -> None:
    """A negative mass is allowed, as a correction; far out it takes away more than the structure has."""
    replace(tiny.deck, "ENDDATA", "GRID,99,,5.,0.,0.\nCONM1,77,99,0,-1.,,-1.,,\n,-1.\nENDDATA")
    tiny.run("ingest").refused(5, "unit_loads.bdf: no body can have its moments of inertia", hint="negative")
    replace(tiny.deck, "CONM1,77,99,0,-1.,,-1.,,\n,-1.", "CONM1,77,3,0,-.1,,-.1,,\n,-.1")
    assert "mass 5.3 kg" in tiny.run("ingest").ok().out


def test_the_uniform_load_is_a_step_on_every_area(tiny: Project) -> None:
    """Also where the sum of the areas' displacements is that of the uniform load: the deck says another load."""
    from tedm_cli.nastran.op2.writer import write_op2

    grids = np.arange(1, 13)
    motion = np.zeros((12, 6))
    write_op2(tiny.op2, grids, [(1, "LEFT", motion), (2, "RIGHT", motion), (3, "UNIFORM", motion)])
    tiny.run("ingest").ok()
    replace(tiny.deck, "TEMP           3      10      1.      11      1.      12      1.\n", "")
    tiny.run("ingest").refused(4, "subcase 3 (uniform load 'UNIFORM'): does not warm 3 of 4 grids of area 'RIGHT'")


def test_links_that_lead_nowhere(tiny: Project) -> None:
    """A deck to be written takes the place of a link to itself; one to be read is missing."""
    tiny.deck.unlink()
    tiny.deck.symlink_to(tiny.deck.name)
    tiny.run("ingest").refused(4, "unit_loads.bdf: no such deck")
    tiny.run("write-deck").ok()
    assert tiny.deck.is_file()


@pytest.mark.parametrize("reader", ["solve", "ingest"])
@pytest.mark.parametrize("value", ["1SUBCASE 1", "1.5", "ALL"])
def test_a_selection_is_the_id_of_a_set(tiny: Project, reader: str, value: str) -> None:
    replace(tiny.deck, "SPC = 1\n", f"SPC = {value}\n")
    tiny.run(reader).refused(4, "unit_loads.bdf:", f"SPC = {value}: is no id of a set", hint="its number alone")
