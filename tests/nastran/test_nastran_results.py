"""OP2 files of all makes: the same motion from every one, and everything else refused by its name."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from op2_records import (
    APPROACH,
    HEADER,
    SUBCASE,
    TABLE_CODE,
    THERMAL,
    WIDE,
    converted,
    edit,
    join,
    records,
    rename,
    set_text,
    set_words,
)
from rod_model import read, write_deck

from tedm_cli.errors import InputError
from tedm_cli.nastran.displacements import unit_load_displacements
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.nastran.loads.unit_loads import UnitLoad
from tedm_cli.nastran.op2.reader import open_op2
from tedm_cli.nastran.op2.writer import write_op2
from tedm_cli.nastran.subcase_table import clean_label

GRIDS = [(i, 0, (0.1 * i, 0.01 * i, 0.0), 0) for i in range(1, 7)]
IDS = np.arange(1, 7)
AREAS = ("LEFT", "RIGHT", "UNIFORM")
LOADS = [UnitLoad(i, name, IDS[:2], 1.0, "ALL") for i, name in enumerate(AREAS, start=1)]
MOTION = np.random.default_rng(4).normal(scale=1e-6, size=(3, 6, 6)).astype(np.float32).astype(float)
CASES = [(i, name, m) for i, (name, m) in enumerate(zip(AREAS, MOTION, strict=True), start=1)]


@pytest.fixture(scope="module")
def geometry(tmp_path_factory: pytest.TempPathFactory) -> ModelGeometry:
    """Grids 1 to 6 in a chain of rods, 7 tied to it by an RBE3, 8 free."""
    grids = [*GRIDS, (7, 0, (0.3, 0.4, 0.0), 0), (8, 0, (0.5, 0.5, 0.5), 0)]
    deck = write_deck(tmp_path_factory.mktemp("rods") / "deck.bdf", GRIDS, "RBE3,50,,7,123456,1.,123,1,2\n,3")
    text = deck.read_text().replace("RBE3", "GRID,7,,.3,.4,0.\nGRID,8,,.5,.5,.5\nRBE3")
    deck.write_text(text)
    assert len(grids) == text.count("GRID")
    return read(deck)[1]


@pytest.fixture
def op2(tmp_path: Path) -> Path:
    path = tmp_path / "loads.op2"
    ids = np.arange(1, 8)
    write_op2(path, ids, [(n, label, np.vstack([m, m[:1]])) for n, label, m in CASES])
    return path


def motions(
    files: Path | list[Path], geometry: ModelGeometry, table: dict[str, int] | None = None
) -> dict[str, np.ndarray]:
    paths = [files] if isinstance(files, Path) else files
    return {load.label: np.hstack([t, r])[:6] for load, t, r in unit_load_displacements(paths, LOADS, geometry, table)}


def check(found: dict[str, np.ndarray]) -> None:
    assert set(found) == set(AREAS)
    for name, wanted in zip(AREAS, MOTION, strict=True):
        np.testing.assert_array_equal(found[name], wanted)


def refused(path: Path, geometry: ModelGeometry, fact: str, table: dict[str, int] | None = None) -> None:
    with pytest.raises(InputError, match=fact) as caught:
        motions(path, geometry, table)
    assert path.name in caught.value.where


# --- makes and dialects ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", ["<", ">"])
@pytest.mark.parametrize(("word", "version"), [(4, None), (8, None), (8, b"NX8.5"), (4, b"NX2019.2"), (4, b"OS2018.1")])
def test_byte_order_word_length_and_make(
    op2: Path, geometry: ModelGeometry, order: str, word: int, version: bytes | None
) -> None:
    dense = word == 8 and version is None
    op2.write_bytes(converted(op2.read_bytes(), order=order, word=word, version=version, dense=dense))
    check(motions(op2, geometry))


def test_a_make_that_is_not_known(op2: Path, geometry: ModelGeometry) -> None:
    op2.write_bytes(converted(op2.read_bytes(), version=b"FEM9000"))
    refused(op2, geometry, "does not recognise: unknown version=.*FEM9000")


@pytest.mark.parametrize(
    ("written", "label"),
    [
        ("LEFT" + " " * 90 + "SUBCASE 1", "LEFT"),
        ("  left  ", "left"),
        ("STRUT  3   UPPER", "STRUT 3 UPPER"),
        ("SUBCASE 12", ""),
        ("WALL SUBCASE 3", "WALL SUBCASE 3"),
        ("STATIC    PVAL ID=     120        SUBCASE=       1", "STATIC"),
        ("LEFT" + "\0" * 10, "LEFT"),
    ],
)
def test_labels_as_solvers_write_them(written: str, label: str) -> None:
    assert clean_label(written) == label


@pytest.mark.parametrize("form", ["{:<103}SUBCASE {}", "{:<64}", "   {}"])
def test_labels_of_dialects_are_matched(op2: Path, geometry: ModelGeometry, form: str) -> None:
    ids = np.arange(1, 8)
    cases = [(n + 40, form.format(label.lower(), n + 40), np.vstack([m, m[:1]])) for n, label, m in CASES]
    write_op2(op2, ids, cases)
    check(motions(op2, geometry))


def test_labels_are_cut_at_64_characters(op2: Path, geometry: ModelGeometry) -> None:
    long = "PANEL_" + "X" * 58
    names = [f"{long}_LEFT", f"{long[:-1]}_RIGHT"]
    loads = [UnitLoad(i, name, IDS, 1.0) for i, name in enumerate(names, start=1)]
    cases = [(i, name[:64], np.ones((7, 6))) for i, name in enumerate(names, start=1)]
    write_op2(op2, np.arange(1, 8), cases)
    assert [x[0].label for x in unit_load_displacements([op2], loads, geometry)] == names
    loads = [UnitLoad(i, f"{long}_{name}", IDS, 1.0) for i, name in enumerate(("LEFT", "RIGHT"), start=1)]
    with pytest.raises(InputError, match=r"may be any of .*_LEFT, .*_RIGHT: Nastran keeps 64"):
        list(unit_load_displacements([op2], loads, geometry))


def test_no_labels_and_an_explicit_table(op2: Path, geometry: ModelGeometry) -> None:
    edit(op2, set_text(2, ""))
    refused(op2, geometry, r"subcase 1 \(no label\) belongs to no thermal area")
    check(motions(op2, geometry, {"left": 1, "RIGHT": 2, "UNIFORM": 3}))
    swapped = motions(op2, geometry, {"LEFT": 2, "RIGHT": 1, "UNIFORM": 3})
    np.testing.assert_array_equal(swapped["LEFT"], MOTION[1])


# --- what a file may hold --------------------------------------------------------------------------------------------


def test_grids_in_any_order_and_scalar_points(tmp_path: Path, geometry: ModelGeometry) -> None:
    """Every subcase has its own order and its own scalar points and idle grids; each is a file, any order."""
    random = np.random.default_rng(8)
    files = []
    for n, label, m in CASES[::-1]:
        ids = np.array([*range(1, 8), 8, 5001, 5002] if n != 2 else [*range(1, 8), 6001])
        values = np.vstack([m, m[:1], np.full((len(ids) - 7, 6), 9e9)])
        order = random.permutation(len(ids))
        path = tmp_path / f"part{n}.op2"
        write_op2(path, ids[order], [(n, label, values[order])])
        edit(path, mark_scalar)
        files.append(path)
    check(motions(files, geometry))


def mark_scalar(payloads: list[bytes]) -> list[bytes]:
    """Grid type 2 for ids above 5000."""
    out = []
    for before, payload in zip([b"", b"", b"", b"", *payloads], payloads, strict=False):
        if len(payload) % 32 == 0 and len(payload) >= 6 * 32 and len(before) != HEADER:
            rows = np.frombuffer(payload, "<i4").reshape(-1, 8).copy()
            rows[rows[:, 0] > 50000, 1] = 2
            payload = rows.tobytes()
        out.append(payload)
    return out


def test_every_subcase_of_a_file_in_an_order_of_its_own(op2: Path, geometry: ModelGeometry) -> None:
    """Ids of grids are taken over from one subcase to the next where they are the same, and not otherwise."""
    random = np.random.default_rng(5)

    def shuffle(payloads: list[bytes]) -> list[bytes]:
        tables = [p for p in payloads if len(p) == 7 * 32]
        assert len(tables) == 3
        rows = {p: np.frombuffer(p, "<i4").reshape(-1, 8)[random.permutation(7)] for p in tables[1:]}
        return [rows[p].tobytes() if p in rows else p for p in payloads]

    edit(op2, shuffle)
    check(motions(op2, geometry))


def test_what_was_read_stays_when_the_next_is_read(op2: Path) -> None:
    with open_op2(op2) as (tables, read_table):
        found = [read_table(table) for table in tables]
    for got, motion in zip(found, MOTION, strict=True):
        assert got.motion.dtype == np.float64  # in which the stages compute
        np.testing.assert_array_equal(got.grid_id, np.arange(1, 8))
        np.testing.assert_array_equal(got.motion[:6], motion)


def test_a_block_longer_than_its_marker_says(op2: Path, geometry: ModelGeometry) -> None:
    """The lengths of records agree with each other, and not with the words before."""

    def shorten(payloads: list[bytes]) -> list[bytes]:
        at = max(i for i, p in enumerate(payloads) if len(p) == 7 * 32)
        return [*payloads[:at], payloads[at][:-32], *payloads[at + 1 :]]

    edit(op2, shorten)
    refused(op2, geometry, r"damaged between bytes [\d,]+ and [\d,]+: not as Nastran writes table OUGV1")


def test_subcases_in_two_files(tmp_path: Path, geometry: ModelGeometry, op2: Path) -> None:
    other = tmp_path / "other.op2"
    write_op2(other, np.arange(1, 8), [(9, "RIGHT", np.zeros((7, 6)))])
    with pytest.raises(InputError, match=r"other.op2: area 'RIGHT' was already in .*loads.op2"):
        motions([op2, other], geometry)


def test_missing_areas_are_said_before_anything_is_read(tmp_path: Path, geometry: ModelGeometry) -> None:
    path = tmp_path / "loads.op2"
    write_op2(path, np.arange(1, 8), [(1, "LEFT", np.zeros((7, 6)))])
    with pytest.raises(InputError, match=r"for 2 of 3 unit loads: 'RIGHT' \(subcase 2\), 'UNIFORM'"):
        next(unit_load_displacements([path], LOADS, geometry))


def test_a_set_that_limits_the_output(tmp_path: Path, geometry: ModelGeometry) -> None:
    """Grid 7 carries no element and no mass, but an RBE3: an optical element may sit there. Grid 8 nothing sits on."""
    path = tmp_path / "loads.op2"
    loads = [UnitLoad(4, "LEFT", IDS, 1.0, "31")]
    write_op2(path, np.array([1, 2, 4, 5]), [(4, "LEFT", np.zeros((4, 6)))])
    fact = r"subcase 4 \(area 'LEFT'\): 3 grids have no displacement: 3, 6, 7; .*DISPLACEMENT = 31"
    with pytest.raises(InputError, match=fact) as caught:
        list(unit_load_displacements([path], loads, geometry))
    assert "DISPLACEMENT(PLOT) = ALL" in caught.value.hint
    write_op2(path, np.arange(1, 8), [(4, "LEFT", np.ones((7, 6)))])
    ((_, translation, _),) = unit_load_displacements([path], loads, geometry)
    np.testing.assert_array_equal(translation, [[1, 1, 1]] * 7 + [[0, 0, 0]])


def test_records_in_blocks(op2: Path, geometry: ModelGeometry) -> None:
    """Large records are split into blocks, each with its length before it; 64 words here."""
    payloads = records(op2.read_bytes())
    out: list[bytes] = []
    for payload in payloads:
        if len(payload) == 7 * 32:
            head, tail = payload[:128], payload[128:]
            out[-1] = (len(head) // 4).to_bytes(4, "little")
            out += [head, (len(tail) // 4).to_bytes(4, "little"), tail]
        else:
            out.append(payload)
    assert len(out) == len(payloads) + 6
    op2.write_bytes(join(out))
    check(motions(op2, geometry))


STATIC = 11  # ten times the analysis code, and the device
FOREIGN: dict[str, tuple[Callable[[list[bytes]], list[bytes]], str]] = {
    "modes": (set_words({APPROACH: 21, TABLE_CODE: 7}), r"subcase 1: holds modes \(SOL 103\)"),
    "frequencies": (set_words({APPROACH: 51}), "a frequency response, not static"),
    "transient": (set_words({APPROACH: 61}), "a transient response, not static"),
    "buckling": (set_words({APPROACH: 71}), "buckling modes, not static"),
    "nonlinear": (set_words({APPROACH: 101}), "nonlinear statics, not static"),
    "spectra": (set_words({THERMAL: 2}), r"response spectra \(code 2\), not static"),
    "sorted by grid": (set_words({TABLE_CODE: 2001}), r"sorted by grid \(SORT2\) are not read"),
    "table sorted by grid": (rename("OUGV2"), r"sorted by grid \(SORT2\) are not read"),
    "complex": (set_words({WIDE: 14}), "complex displacements are not read"),
    "other rows": (set_words({WIDE: 9}), r"rows of 9 words \(table OUGV1\)"),
    "superelement": (
        set_text(1, f"{'SOMETHING':<99}SUPERELEMENT 3"),
        r"subcase 1: results of a superelement \(SUPERELEMENT 3\)",
    ),
    "temperatures": (set_words({THERMAL: 1}), r"holds temperatures \(heat transfer, subcase 1\) and no displacements"),
    "subcase twice": (set_words({SUBCASE: 1}, subcase=3), r"subcase 1 occurs 2 times \(table OUGV1\)"),
    "other table": (rename("OQG1"), r"holds no displacements \(tables: OQG1\)"),
    "velocities": (set_words({TABLE_CODE: 10}), r"holds no displacements \(tables: OUGV1\)"),
}


@pytest.mark.parametrize("name", FOREIGN)
def test_other_results_are_refused_by_name(op2: Path, geometry: ModelGeometry, name: str) -> None:
    change, fact = FOREIGN[name]
    edit(op2, change)
    refused(op2, geometry, fact)


def test_temperatures_beside_displacements_are_passed_over(op2: Path, geometry: ModelGeometry) -> None:
    hot = op2.with_name("hot.op2")
    write_op2(hot, np.arange(1, 8), [(8, "HEAT", np.full((7, 6), 300.0)), *with_seven(CASES)])
    edit(hot, set_words({THERMAL: 1}, subcase=8))
    check(motions(hot, geometry))


def with_seven(cases: list[tuple[int, str, np.ndarray]]) -> list[tuple[int, str, np.ndarray]]:
    return [(n, label, np.vstack([m, m[:1]])) for n, label, m in cases]


def test_memory_does_not_grow_with_the_number_of_subcases(tmp_path: Path) -> None:
    """Listing holds headers, reading one subcase at a time."""
    peaks = {}
    ids = np.arange(1, 2001)
    for count in (2, 12):
        path = tmp_path / f"{count}.op2"
        write_op2(path, ids, [(i + 1, f"A{i}", np.full((2000, 6), 1e-6)) for i in range(count)])
        with open_op2(path) as (tables, read_table):
            read_table(tables[0])
            tracemalloc.start()
            for table in tables:
                read_table(table)
            peaks[count] = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
    assert peaks[12] < 1.2 * peaks[2]
    assert peaks[12] < 4 * ids.size * 6 * 8
