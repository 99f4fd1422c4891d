"""ingest takes what Nastran and its users really leave behind, and says what is wrong with the rest."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import MODEL_TOML, Project, replace, tiny_ids, tiny_motions, untouched

from tedm_cli.nastran.op2.writer import write_op2


def refuse(tiny: Project, code: int, *pieces: str, hint: str = "") -> None:
    """ingest fails with this message; the file of the last good run, and everything else, is as it was."""
    with untouched(tiny.folder):
        tiny.run("ingest").refused(code, *pieces, hint=hint)


# --- decks -----------------------------------------------------------------------------------------------------------

SUBCASE_2 = "SUBCASE 2\n  LABEL = RIGHT\n  TEMPERATURE(LOAD) = 2\n  DISPLACEMENT(PLOT) = ALL\n"
DECKS = {
    "area without subcase": (SUBCASE_2, "", ["4 of 12 structural grids are in no thermal area: 9, 10, 11, 12"]),
    "grid without area": (
        "TEMP           2      12      1.\n",
        "",
        ["1 of 12 structural grids are in no thermal area: 12"],
    ),
    "same labels": ("LABEL = RIGHT", "LABEL = left", ["subcases 1 and 2 have the same label 'left'"]),
    "no label": ("  LABEL = RIGHT\n", "", ["subcase 2", "no LABEL"]),
    "no temperature": ("  TEMPERATURE(LOAD) = 2\n", "", ["subcase 2 (area 'RIGHT')", "selects no temperatures"]),
    "unknown set": ("TEMPERATURE(LOAD) = 2", "TEMPERATURE(LOAD) = 55", ["area 'RIGHT'", "temperature set 55"]),
    "grid in two areas": ("ENDDATA", "TEMP,2,3,1.\nENDDATA", ["1 of 12 grids", ": 3 (the first in LEFT, RIGHT)"]),
    "uneven step": ("12      1.\nTEMPD", "12      2.\nTEMPD", ["area 'RIGHT'", "by 1 to 2 K"]),
    "two temperatures": ("ENDDATA", "TEMP,2,9,2.\nENDDATA", ["area 'RIGHT'", "grid 9 both 1 and 2"]),
    "unknown grid": ("ENDDATA", "TEMP,2,333,1.\nENDDATA", ["area 'RIGHT'", "333"]),
    "TEMPD off TREF": ("TEMPD          1      0.", "TEMPD          1     20.", ["subcase 1", "20 K", "TREF is 0 K"]),
    "TREF off TEMPD": ("2.3-5", "2.3-5,20.", ["subcase 1", "0 K", "TREF is 20 K"]),
    "initial": ("SPC = 1", "SPC = 1\nTEMPERATURE(INITIAL) = 2", ["TEMPERATURE(INITIAL)"]),
    "SUBCOM": ("SUBCASE 3", "SUBCOM 3", ["unit_loads.bdf:12: SUBCOM"]),
    "TEMPP1 of a solid": ("ENDDATA", "TEMPP1,2,1,1.,0.\nENDDATA", ["unit_loads.bdf:52: TEMPP1 of set 2 names CHEXA 1"]),
    "TEMPP1 in large fields": ("ENDDATA", "TEMPP1*,2,1,1.,0.\n*\nENDDATA", ["unit_loads.bdf:52: TEMPP1"]),
    "TEMPRB": ("ENDDATA", "TEMPRB,2,1,1.,0.\nENDDATA", ["unit_loads.bdf:52: TEMPRB"]),
    "TEMPP3": ("ENDDATA", "TEMPP3,2,1,1.,0.\nENDDATA", ["unit_loads.bdf:52: TEMPP3"]),
    "NSML1 on solids": ("ENDDATA", "NSML1,2,PSOLID,1.,1\nENDDATA", ["PSOLID"]),
    "no such NSM set": ("SPC = 1", "SPC = 1\nNSM = 3", ["NSM = 3"]),
    "CONM1 of one direction": ("ENDDATA", "CONM1,77,3,0,1.\nENDDATA", ["CONM1 77", "differs by direction"]),
    "mass by M2GG": ("SPC = 1", "SPC = 1\nM2GG = MEX", ["M2GG"]),
    "mass by M2PP": ("  LABEL = RIGHT\n", "  LABEL = RIGHT\n  M2PP = MEX\n", ["M2PP"]),
    "load by P2G": ("  LABEL = RIGHT\n", "  LABEL = RIGHT\n  P2G = PEX\n", ["P2G = "]),
    "id of 64 bits": ("CHEXA,2,", f"CHEXA,{2**63},", [f"CHEXA {2**63}: {2**63} is larger than any id"]),
    "grid of 33 bits": (",11,12", f",11,{2**31}", [f"CHEXA 2: {2**31} is larger than any id"]),
    "subcase of 64 bits": ("SUBCASE 2", f"SUBCASE {2**63}", [f"SUBCASE {2**63}: is larger than any id"]),
    "endless SET": ("SPC = 1", "SPC = 1\nSET 1 = 5, 1 THRU 99999999", ["SET of the case control: 1 THRU 99999999"]),
    "corner 0": (",11,12", ",11,0", ["its grids are 5, 6, 7, 8, 9, 10, 11, 0, and some of these are none"]),
    "words for a number": ("TEMPERATURE(LOAD) = 2", "TEMPERATURE(LOAD) = two", ["'TWO' is no whole number"]),
    "subcase twice": ("SUBCASE 2", "SUBCASE 1", ["SUBCASE 1 occurs twice"]),
    "blank corner": (",11,12", ",,12", ["CHEXA 2: field 9 (nid7) is blank, and must be an integer"]),
    "integer for a length": (
        "GRID,2,,0.0,",
        "GRID,2,,0,",
        ["GRID 2: field 3 (x1) is '0', and must be a float"],
    ),
    "frames in a loop": (
        "ENDDATA",
        "CORD2R,5,6,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nCORD2R,6,5,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nENDDATA",
        ["its coordinate systems refer to each other in a loop"],
    ),
    "frame on a line": (
        "ENDDATA",
        "CORD2R,5,,0.,0.,0.,0.,0.,1.\n,0.,0.,2.\nENDDATA",
        ["CORD2R 5: its three points lie on a line"],
    ),
    "CONM2 nowhere": (
        "ENDDATA",
        "CONM2,77,333,,1.\nENDDATA",
        ["unit_loads.bdf:52: CONM2 77 names grid 333, which the deck does not have"],
    ),
    "CMASS2 of one direction": ("ENDDATA", "CMASS2,77,3.,3,1\nENDDATA", ["CMASS 77", "3, 0, 0"]),
    "superelement": ("ENDDATA", "SESET,1,1,2\nENDDATA", ["SESET"]),
    **{
        f"{word} of a subcase": ("  LABEL = RIGHT\n", f"  LABEL = RIGHT\n  {word} = 7\n", ["unit_loads.bdf:10", word])
        for word in ("BCONTACT", "INITS", "BOLTLD", "STEP", "NLPARM", "NLSTEP", "LOADSET", "STATSUB", "MFLUID", "LAOD")
    },
    "NLPARM above": ("SPC = 1", "SPC = 1\nNLPARM = 7", ["unit_loads.bdf:4: subcase 1: NLPARM = 7 makes it no linear"]),
    "two supports of matrices": (
        "  LABEL = RIGHT\n",
        "  LABEL = RIGHT\n  K2GG = K\n",
        ["different K2GG", "K in subcase 2"],
    ),
    "modes": ("  LABEL = RIGHT\n", "  LABEL = RIGHT\n  ANALYSIS = MODES\n", ["subcase 2: ANALYSIS = MODES"]),
    "SPC without equals": ("SPC = 1", "SPC 1", ["unit_loads.bdf:3: SPC 1: has no equals sign"]),
    "another solution": ("SOL 101", "SOL 106", ["SOL 106 is not linear statics"]),
    "INREL in case control": (
        "SPC = 1",
        "SPC = 1\nPARAM,INREL,-2",
        ["unit_loads.bdf:4", "PARAM,INREL,-2: inertia relief"],
    ),
    "INREL in bulk data": ("ENDDATA", "PARAM,INREL,-1\nENDDATA", ["bdf:52: PARAM,INREL,-1: inertia relief"]),
    "INREL misspelt": ("ENDDATA", "PARAM,INERL,-1\nENDDATA", ["bdf:52: PARAM,INERL is not known"]),
    "WTMASS misspelt": ("ENDDATA", "PARAM,WTMASR,.1\nENDDATA", ["bdf:52: PARAM,WTMASR is not known"]),
    "CONM2 misspelt": ("ENDDATA", "RONM2,77,3,,.1\nENDDATA", ["unit_loads.bdf:52: RONM2 card"]),
    "RBE2 misspelt": ("ENDDATA", "SBE2,77,3,123,4\nENDDATA", ["unit_loads.bdf:52: SBE2 card"]),
    "no end": ("ENDDATA", "", ["has no ENDDATA"]),
    "uniform load on one area": (
        "TEMP           3      10      1.      11      1.      12      1.\n",
        "",
        ["subcase 3 (uniform load 'UNIFORM')", "does not warm 3 of 4 grids of area 'RIGHT': 10, 11, 12"],
    ),
    "unknown element": ("ENDDATA", "CNOVEL,5,1,2,3\nENDDATA", ["CNOVEL"]),
    "force": ("  LABEL = RIGHT\n", "  LABEL = RIGHT\n  LOAD = 7\n", ["subcase 2", "LOAD = 7"]),
    "two supports": ("  LABEL = RIGHT\n", "  LABEL = RIGHT\n  SPC = 7\n", ["different SPC", "7 in subcase 2"]),
    "unknown corner": (",11,12", ",11,13", ["unit_loads.bdf:31: CHEXA 2 names grid 13, which the deck does not have"]),
    "unknown material": ("PSOLID,1,1", "PSOLID,1,5", ["unit_loads.bdf:33: PSOLID 1 names material 5, which"]),
    "material of a bar": ("ENDDATA", "PBAR,7,9,.1\nENDDATA", ["unit_loads.bdf:52: PBAR 7 names material 9, which"]),
    "grid twice": (
        "ENDDATA",
        "GRID,1,,5.,5.,5.\nENDDATA",
        [
            "unit_loads.bdf:52: GRID 1: the number is given twice, with different fields (first in ",
            "unit_loads.bdf:17)",
        ],
    ),
    "range backwards": (
        "ENDDATA",
        "SPC1,1,123,4,THRU,1\nENDDATA",
        ["unit_loads.bdf:52: SPC1 1: 4 THRU 1 runs backwards"],
    ),
    "range from nowhere": ("ENDDATA", "SPC1,1,123,THRU,4\nENDDATA", ["unit_loads.bdf:52: SPC1 1: 123 THRU 4 runs"]),
    "range without end": ("ENDDATA", "SPC1,1,123,4,THRU\nENDDATA", ["unit_loads.bdf:52: SPC1 1: THRU lacks its last"]),
    "SET backwards": ("SPC = 1", "SPC = 1\nSET 1 = 9 THRU 2", ["SET of the case control: 9 THRU 2 runs backwards"]),
    "element twice": ("ENDDATA", "CROD,2,1,1,2\nENDDATA", ["unit_loads.bdf:52: CHEXA and CROD 2: the number"]),
    "material twice": ("ENDDATA", "MAT1,1,7.+9,,.3\nENDDATA", ["unit_loads.bdf:52: MAT1 1: the number"]),
    "letters for an id": ("GRID,2,,", "GRID,two,,", ["GRID two"]),
    "missing include": ("SPC1,1", "INCLUDE 'parts/grids.inc'\nSPC1,1", ["unit_loads.bdf:35", "parts/grids.inc"]),
    "open include": ("SPC1,1", "INCLUDE 'grids.inc\nSPC1,1", ["unit_loads.bdf:35", "closing quote"]),
    "no density": ("2700.", "", ["no mass"]),
}


@pytest.mark.parametrize("name", DECKS)
def test_deck_is_refused(tiny: Project, name: str) -> None:
    old, new, pieces = DECKS[name]
    replace(tiny.deck, old, new)
    refuse(tiny, 4, "unit_loads.bdf", *pieces)


@pytest.mark.parametrize(
    ("density", "note"),
    [
        ("", "1 CHEXA of property 2 weigh nothing: their material has no density"),
        ("2.7", "1 CHEXA of property 2 have a density of 2.7 kg/m3"),
        ("50.", ""),
    ],
)
def test_elements_that_weigh_next_to_nothing_are_told(tiny: Project, density: str, note: str) -> None:
    replace(tiny.deck, "CHEXA,2,1,", "CHEXA,2,2,")
    replace(tiny.deck, "ENDDATA", f"PSOLID,2,2\nMAT1,2,7.+10,,.33,{density},2.3-5\nENDDATA")
    told = tiny.run("ingest").ok()
    assert [line.removeprefix("note: ") for line in (told.out + told.err).splitlines() if "CHEXA" in line] == (
        [note] if note else []
    )


def test_missing_deck(tiny: Project) -> None:
    tiny.deck.unlink()
    refuse(tiny, 4, "unit_loads.bdf", hint="write-deck")


@pytest.mark.parametrize("text", ["", "SOL 101\nCEND\n", "SOL 101\nCEND\nBEGIN BULK\nENDDATA\n", "no deck at all\n"])
def test_a_file_without_a_model(tiny: Project, text: str) -> None:
    tiny.deck.write_text(text)
    refuse(tiny, 4, "unit_loads.bdf")


def test_the_model_itself_is_no_unit_load_deck(tiny: Project) -> None:
    shutil.copy(tiny.folder / "model.bdf", tiny.deck)
    refuse(tiny, 4, "no subcase that warms a thermal area", hint="write-deck")


def test_binary_results_named_as_the_deck(tiny: Project) -> None:
    shutil.copy(tiny.op2, tiny.deck)
    refuse(tiny, 4, "unit_loads.bdf")


def test_includes_are_read_scanned_and_recorded(tiny: Project, tmp_path: Path) -> None:
    lines = tiny.deck.read_text().splitlines(keepends=True)
    grids = [line for line in lines if line.startswith("GRID")]
    (tiny.folder / "parts").mkdir()
    (tiny.folder / "parts" / "grids.inc").write_text("".join(grids))
    rest = "".join(line for line in lines if line not in grids)
    tiny.deck.write_text(rest.replace("BEGIN BULK\n", "BEGIN BULK\ninclude 'parts/\n   grids.inc'\n"))
    tiny.run("ingest").ok()
    with h5py.File(tiny.build / "unit_loads.h5") as file:
        assert "../parts/grids.inc" in file["/provenance/input_path"].asstr()[()]
    (tiny.folder / "parts" / "grids.inc").write_text("".join([*grids, "TEMPP1,2,1,1.,0.\n"]))
    refuse(tiny, 4, "grids.inc:13: TEMPP1")


# --- masses and test masses ------------------------------------------------------------------------------------------


def test_a_scalar_point_with_nothing_on_it_is_no_hindrance(tiny: Project) -> None:
    for file in (tiny.folder / "model.bdf", tiny.deck):
        replace(file, "ENDDATA", "SPOINT,77,78\nSPC1,1,0,77\nENDDATA")
    for stage in ("write-deck", "solve", "ingest"):
        tiny.run(stage).ok()
    replace(tiny.deck, "ENDDATA", "MPC,9,77,,1.,1,1,-1.\nENDDATA")
    replace(tiny.deck, "SPC = 1", "SPC = 1\nMPC = 9")
    with untouched(tiny.folder):
        tiny.run("solve").refused(4, "not modelled by the embedded solver: MPC with a scalar point (1)")


@pytest.mark.parametrize(
    ("old", "new", "piece", "hint"),
    [
        ("[0.1, 0.2, 0.0]", "[100.0, 200.0, 0.0]", "test_mass[0].position_m: TM1 is", "metres"),
        ("mass_kg = 1.96", "mass_kg = 19.6", "test_mass[0]: size and mass of TM1 make", "metres"),
        ("side_m = 0.046", "side_m = 46.0", "46 x 46 x 46 m; lengths must be in metres", ""),
        ("mass_kg = 1.96", "mass_kg = 1960.0", "test_mass[0]: density 2.01364e+07 is outside", ""),
    ],
)
def test_test_mass_in_other_units(tiny: Project, old: str, new: str, piece: str, hint: str) -> None:
    replace(tiny.model, old, new)
    refuse(tiny, 3, piece, hint=hint)


def test_weight_densities_need_wtmass(tiny: Project) -> None:
    replace(tiny.deck, "2700.", "26487.")  # N/m3
    replace(tiny.deck, "ENDDATA", "PARAM,WTMASS,.1019368\nENDDATA")
    assert "mass 5.4" in tiny.run("ingest").ok().out


def test_what_stands_for_a_test_mass_is_left_out_and_said(tiny: Project) -> None:
    replace(tiny.deck, "ENDDATA", "CONM2,77,3,,2.\nENDDATA")
    assert "mass 7.4 kg" in tiny.run("ingest").ok().out
    replace(tiny.model, "mass_kg = 1.96", "mass_kg = 1.96\nmodel_parts = { elements = [77] }")
    out = tiny.run("ingest").ok().out
    assert "mass 5.4 kg" in out
    assert "left out: 2 kg that stand for TM1" in out
    replace(tiny.model, "[77]", "[77, 78]")
    refuse(tiny, 3, "test_mass[0].model_parts.elements: the model has none of these: 78")


def test_structure_inside_a_test_mass(tiny: Project) -> None:
    replace(tiny.model, "[0.1, 0.2, 0.0]", "[0.2, 0.1, 0.0]")
    refuse(tiny, 5, "1 grids with mass are inside test mass 'TM1': 10", hint="model_parts")


# --- results ---------------------------------------------------------------------------------------------------------

Motions = list[tuple[int, str, np.ndarray]]


def rewrite(project: Project, change: Callable[[Motions], Motions], ids: np.ndarray | None = None) -> None:
    write_op2(project.op2, tiny_ids() if ids is None else ids, change(tiny_motions()))


@pytest.mark.parametrize(
    ("number", "piece"), [(1, "'LEFT' (subcase 1)"), (2, "'RIGHT' (subcase 2)"), (3, "'UNIFORM' (subcase 3)")]
)
def test_missing_result(tiny: Project, number: int, piece: str) -> None:
    rewrite(tiny, lambda motions: [m for m in motions if m[0] != number])
    refuse(tiny, 4, "unit_loads.op2", "1 of 3 unit loads", piece, hint="result file")


def test_result_of_no_area(tiny: Project) -> None:
    rewrite(tiny, lambda motions: [*motions, (9, "TOP", motions[0][2])])
    refuse(tiny, 4, "unit_loads.op2: subcase 9 (label 'TOP')", hint="[model.subcases]")


def test_results_of_another_model(tiny: Project) -> None:
    rewrite(tiny, lambda motions: motions, ids=tiny_ids() + 1000)
    refuse(tiny, 4, "subcase 1 (area 'LEFT'): 12 grids are not in the deck: 1001, 1002", hint="another model")


def test_results_without_some_grids(tiny: Project) -> None:
    rewrite(tiny, lambda motions: [(n, label, m[:10]) for n, label, m in motions], ids=tiny_ids()[:10])
    refuse(tiny, 4, "2 grids have no displacement: 11, 12", hint="DISPLACEMENT")


def test_massless_grids_off_the_structure_may_have_no_result(tiny: Project) -> None:
    replace(tiny.deck, "ENDDATA", "GRID,99,,0.5,0.,0.\nENDDATA")
    tiny.run("ingest").ok()


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_not_finite(tiny: Project, value: float) -> None:
    data = bytearray(tiny.op2.read_bytes())
    place = data.index(tiny_motions()[1][2].astype(np.float32)[4].tobytes())
    data[place : place + 4] = np.float32(value).tobytes()
    tiny.op2.write_bytes(data)
    refuse(tiny, 4, "unit_loads.op2: subcase 2 (area 'RIGHT')", "1 of 12 displacements", "grid 5")


def test_cut_off_anywhere(tiny: Project) -> None:
    whole = tiny.op2.read_bytes()
    cuts = sorted(
        {1, 3, 4, 8, *np.linspace(12, len(whole) - 12, 28).astype(int) // 4 * 4, len(whole) - 4, len(whole) - 1}
    )
    for cut in cuts:
        tiny.op2.write_bytes(whole[:cut])
        refuse(tiny, 4, "unit_loads.op2")


@pytest.mark.parametrize(
    "contents",
    [
        b"",
        b"a text file\n" * 100,
        b"\x89HDF\r\n\x1a\n" + bytes(500),
        np.random.default_rng(0).bytes(4000),
        b"\x04\0\0\0" + np.random.default_rng(0).bytes(4000),
        b"\x04\0\0\0\x03\0\0\0\x04\0\0\0" + bytes(4000),
    ],
    ids=["empty", "text", "hdf5", "noise", "noise after a marker", "zeros after a marker"],
)
def test_not_an_op2(tiny: Project, contents: bytes) -> None:
    tiny.op2.write_bytes(contents)
    refuse(tiny, 4, "unit_loads.op2")


def test_missing_op2(tiny: Project) -> None:
    tiny.op2.unlink()
    refuse(tiny, 4, "unit_loads.op2: no such result file", hint="tedm solve")


def test_a_folder_named_as_the_op2(tiny: Project) -> None:
    tiny.op2.unlink()
    tiny.op2.mkdir()
    refuse(tiny, 4, "unit_loads.op2")


def translations(project: Project) -> np.ndarray:
    with h5py.File(project.build / "unit_loads.h5") as file:
        return np.asarray(file["/translation"][()])


def test_order_of_grids_and_subcases_is_of_no_account(tiny: Project) -> None:
    expected = translations(tiny)
    order = np.random.default_rng(2).permutation(12)
    rewrite(tiny, lambda motions: [(n, label, m[order]) for n, label, m in motions][::-1], ids=tiny_ids()[order])
    tiny.run("ingest").ok()
    np.testing.assert_array_equal(translations(tiny), expected)


def test_labels_match_without_regard_to_case_and_number(tiny: Project) -> None:
    expected = translations(tiny)
    rewrite(tiny, lambda motions: [(n + 10, label.lower(), m) for n, label, m in motions])
    tiny.run("ingest").ok()
    np.testing.assert_array_equal(translations(tiny), expected)


def split(project: Project, *parts: Motions) -> None:
    names = [f"part{i}.op2" for i in range(len(parts))]
    for name, part in zip(names, parts, strict=True):
        write_op2(project.folder / name, tiny_ids(), part)
    replace(project.model, '["unit_loads.op2"]', str(names).replace("'", '"'))


def test_several_op2_files_are_one_input(tiny: Project) -> None:
    expected = translations(tiny)
    motions = tiny_motions()
    split(tiny, motions[1:], motions[:1])
    tiny.run("ingest").ok()
    np.testing.assert_array_equal(translations(tiny), expected)


def test_several_op2_files_with_one_area_twice(tiny: Project) -> None:
    motions = tiny_motions()
    split(tiny, motions, motions[:1])
    refuse(tiny, 4, "part1.op2: area 'LEFT' was already in", "part0.op2")


def test_explicit_table_of_subcases(tiny: Project) -> None:
    expected = translations(tiny)
    rewrite(tiny, lambda motions: [(n, f"SUBCASE {n}", m) for n, _, m in motions])
    refuse(tiny, 4, "subcase 1", hint="[model.subcases]")
    replace(tiny.model, "[areas]", "[model.subcases]\nLEFT = 1\nRIGHT = 2\nUNIFORM = 3\n\n[areas]")
    tiny.run("ingest").ok()
    np.testing.assert_array_equal(translations(tiny), expected)


def test_table_of_subcases_with_mistakes(tiny: Project) -> None:
    replace(tiny.model, "[areas]", "[model.subcases]\nLEFT = 1\nRIHGT = 2\nUNIFORM = 1\n\n[areas]")
    refuse(tiny, 3, "model.subcases.RIHGT", "did you mean RIGHT?", "model.subcases.UNIFORM: subcase 1 is that of")


# --- attributes of the areas -----------------------------------------------------------------------------------------


def test_area_without_rule_and_rules_without_area(tiny: Project) -> None:
    extra = '    { match = "TOP*", group = "a", shield = "inside" },\n'
    tiny.model.write_text(
        MODEL_TOML.replace('match = "RIGHT"', 'match = "R?T"').replace("rule = [\n", "rule = [\n" + extra)
    )
    refuse(
        tiny,
        3,
        "areas.rule: no rule matches the thermal area 'RIGHT'",
        "areas.rule[0].match: 'TOP*' matches no thermal area",
        "areas.rule[2].match: 'R?T' matches no thermal area",
        hint="LEFT, RIGHT",
    )


def test_rule_that_an_earlier_one_hides(tiny: Project) -> None:
    replace(tiny.model, 'match = "LEFT"', 'match = "*"')
    refuse(tiny, 3, "areas.rule[1].match: 'RIGHT' matches no thermal area that an earlier rule has left over")
