"""Sets of non-structural mass: per area and length, lumps, and that only the selected set counts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from mass_decks import deck, read

from tedm_cli.errors import InputError

# Areas 2 (id 1) and 1 (ids 2, 3) m2; lengths 2 (ids 4, 5, 7) and 3 (id 6) m. Structure without mass but for a point.
STRUCTURE = """CQUAD4,1,1,1,2,3,4
CTRIA3,2,2,5,6,7
CTRIA3,3,1,5,7,8
CBAR,4,4,1,2,0.,1.,0.
CBEAM,5,5,3,4,0.,0.,1.
CROD,6,6,1,5
CONROD,7,5,6,1,1.-3
MAT1,9,7.+10,,.3
PSHELL,1,9,.01
PCOMP,2
,9,.01,0.
PBAR,4,9,1.-3,1.,1.,1.
PBEAM,5,9,1.-3,1.,1.,0.,1.
,,,,,,,,
,,,,,,,,
,.1,,.1
PROD,6,9,1.-3
CONM2,99,1,,1.
"""
CONROD = {"CONROD,7,5,6,1": "CONROD,7,5,6,9"}

# cards of set 3, and the masses of elements 1 to 7
SETS = {
    "NSM by property": ("NSM,3,PSHELL,1,.5", [1.0, 0, 0.5, 0, 0, 0, 0]),
    "NSM, two pairs": ("NSM,3,PSHELL,1,.5,2,.25", [1.0, 0.25, 0.5, 0, 0, 0, 0]),
    "laminates count as shells": ("NSM1,3,PSHELL,.5,ALL", [1.0, 0.5, 0.5, 0, 0, 0, 0]),
    "shells named as laminates": ("NSM1,3,PCOMP,.5,2", [0, 0.5, 0, 0, 0, 0, 0]),
    "NSM1 range": ("NSM1,3,ELEMENT,.5,4,THRU,6", [0, 0, 0, 1.0, 1.0, 1.5, 0]),
    "NSM1 of bars, beams, rods": ("NSM1,3,PBAR,1.,4\nNSM1,3,PBEAM,2.,5\nNSM1,3,PROD,3.,6", [0, 0, 0, 2.0, 4.0, 9.0, 0]),
    "CONROD by element": ("NSM1,3,CONROD,.5,ALL", [0, 0, 0, 0, 0, 0, 1.0]),
    "NSML by area": ("NSML,3,PSHELL,1,6.", [4.0, 0, 2.0, 0, 0, 0, 0]),
    "NSML per pair": ("NSML,3,ELEMENT,1,6.,4,3.", [6.0, 0, 0, 3.0, 0, 0, 0]),
    "NSML1 over all": ("NSML1,3,PSHELL,8.,1,2", [4.0, 2.0, 2.0, 0, 0, 0, 0]),
    "NSML1 by length": ("NSML1,3,ELEMENT,7.,4,5,6", [0, 0, 0, 2.0, 2.0, 3.0, 0]),
    "sums": ("NSML1,3,PSHELL,8.,1,2\nNSM1,3,PSHELL,.5,1", [5.0, 2.0, 2.5, 0, 0, 0, 0]),
    "NSMADD": ("NSMADD,3,11,12\nNSM1,11,PBAR,1.,4\nNSML1,12,PROD,9.,6", [0, 0, 0, 2.0, 0, 9.0, 0]),
    "ids that do not exist": ("NSM1,3,PSHELL,.5,1,88\nNSML1,3,PBAR,1.,89", [1.0, 0, 0.5, 0, 0, 0, 0]),
}


def model(cards: str, control: str = "NSM = 3") -> str:
    text = deck(STRUCTURE + cards, control=control)
    for old, new in CONROD.items():
        text = text.replace(old, new)
    return text


@pytest.mark.parametrize("name", SETS)
def test_masses_of_a_set(tmp_path: Path, name: str) -> None:
    cards, masses = SETS[name]
    g = read(tmp_path, model(cards))
    np.testing.assert_allclose(g.elements.mass_kg, masses, rtol=1e-12)
    assert g.total_kg == pytest.approx(1.0 + sum(masses), rel=1e-12)


def test_only_the_selected_set_counts(tmp_path: Path) -> None:
    cards = "NSM1,3,PSHELL,.5,1\nNSM1,4,PSHELL,5.,1"
    assert read(tmp_path, model(cards, "")).total_kg == 1.0
    assert read(tmp_path, model(cards, "NSM = 3")).total_kg == pytest.approx(2.5, rel=1e-12)
    subcases = "SUBCASE 1\nNSM = 4\nSUBCASE 2\nNSM = 4"
    assert read(tmp_path, model(cards, subcases)).total_kg == pytest.approx(16.0, rel=1e-12)
    with pytest.raises(InputError, match="subcases select different sets"):
        read(tmp_path, model(cards, "SUBCASE 1\nNSM = 3\nSUBCASE 2\nNSM = 4"))
    with pytest.raises(InputError, match="NSM = 7, and there is no such set"):
        read(tmp_path, model(cards, "NSM = 7"))


def test_on_a_beam_it_lies_where_the_beam_has_its_loads(tmp_path: Path) -> None:
    """M1 = 0.1 along the element's y: CBEAM 5 runs along -x with its orientation along z."""
    g = read(tmp_path, model("NSM1,3,PBEAM,1.,5"))
    at = g.elements.node_offset[4]
    np.testing.assert_allclose(g.elements.lever[at : at + 2], [[0, 0, 0.1]] * 2, rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("cards", "fact"),
    [
        ("NSML1,3,ELEMENT,7.,1,4", "NSML1 3: a mass spread over areas and lengths together"),
        ("NSM1,3,PBEND,7.,1", "NSM1 3: PBEND is not read"),
        ("CHEXA,8,8,1,2,3,4,5,6,\n,7,8\nPSOLID,8,1\nNSM1,3,ELEMENT,7.,8", "NSM1 3: element 8 has neither"),
    ],
)
def test_what_is_not_read_is_named(tmp_path: Path, cards: str, fact: str) -> None:
    with pytest.raises(InputError, match=fact):
        read(tmp_path, model(cards))


def test_against_pynastran_where_it_follows_the_same_rules(tmp_path: Path) -> None:
    from pyNastran.bdf.bdf import BDF
    from pyNastran.bdf.mesh_utils.mass_properties import mass_properties_nsm

    cards = "NSM1,3,PSHELL,.5,1\nNSML,3,PBAR,4,6.\nNSM1,3,PROD,2.,6"
    g = read(tmp_path, model(cards))
    alone = BDF(debug=None)
    alone.read_bdf(str(tmp_path / "model.bdf"), xref=True)
    theirs, *_ = mass_properties_nsm(alone, nsm_id=3, sym_axis="no")
    assert g.total_kg == pytest.approx(theirs, rel=1e-12)
