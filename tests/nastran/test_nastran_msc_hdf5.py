"""MSC Nastran's HDF5: the same motion as the OP2, whatever the order; everything else refused by its name."""

from __future__ import annotations

import contextlib
import io
import sys
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from msc_hdf5_file import CASES as CASE_CONTROL
from msc_hdf5_file import DISPLACEMENT, DOMAINS, INDEX, NODAL, change_table, table_of, write_msc_hdf5
from rod_model import read, write_deck

from tedm_cli.errors import InputError
from tedm_cli.files import record_tables
from tedm_cli.nastran.displacements import Findings, unit_load_displacements
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.nastran.loads.unit_loads import UnitLoad
from tedm_cli.nastran.op2.reader import open_op2
from tedm_cli.nastran.op2.writer import write_op2
from tedm_cli.nastran.result_files import open_result_file, require_whole

GRIDS = [(i, 0, (0.1 * i, 0.01 * i, 0.0), 0) for i in range(1, 8)]
IDS = np.arange(1, 8)
AREAS = ("LEFT", "RIGHT", "UNIFORM")
LOADS = [UnitLoad(i, name, IDS[:2], 1.0, "ALL") for i, name in enumerate(AREAS, start=1)]
MOTION = np.random.default_rng(4).normal(scale=1e-6, size=(3, 7, 6))
CASES = [(i, name, m) for i, (name, m) in enumerate(zip(AREAS, MOTION, strict=True), start=1)]


@pytest.fixture(scope="module")
def geometry(tmp_path_factory: pytest.TempPathFactory) -> ModelGeometry:
    """Grids 1 to 7 in a chain of rods."""
    return read(write_deck(tmp_path_factory.mktemp("rods") / "deck.bdf", GRIDS))[1]


@pytest.fixture
def at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first reading in this process: what it says does not depend on where it runs, and a start takes time."""

    def here(module: str, path: Path, *words: str, size: int, hint: str) -> bytes:
        said = io.StringIO()
        monkeypatch.setattr(sys, "argv", [module, str(path), *words])
        with contextlib.redirect_stdout(said):
            record_tables.main()
        return said.getvalue().encode()

    monkeypatch.setattr(record_tables, "trial", here)


@pytest.fixture
def results(tmp_path: Path) -> Path:
    path = tmp_path / "loads.h5"
    write_msc_hdf5(path, IDS, CASES)
    return path


def motions(files: Path | list[Path], geometry: ModelGeometry, **more: object) -> dict[str, np.ndarray]:
    paths = [files] if isinstance(files, Path) else files
    found = unit_load_displacements(paths, LOADS, geometry, **more)  # type: ignore[arg-type]
    return {load.label: np.hstack([t, r]) for load, t, r in found}


def check(found: dict[str, np.ndarray], cases: list[tuple[int, str, np.ndarray]] = CASES) -> None:
    assert set(found) == set(AREAS)
    for _, name, wanted in cases:
        np.testing.assert_array_equal(found[name], wanted)


def refused(path: Path, geometry: ModelGeometry, fact: str, **more: object) -> None:
    with pytest.raises(InputError, match=fact) as caught:
        motions(path, geometry, **more)
    assert path.name in caught.value.where


# --- what is read ----------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize("index", [True, False])
@pytest.mark.parametrize("order", [None, 1, 2])
@pytest.mark.parametrize("labels", [True, False])
def test_to_the_last_digit_in_any_order(
    results: Path, geometry: ModelGeometry, labels: bool, order: int | None, index: bool
) -> None:
    """Subcases, and parts of them, in any order, with and without labels and index."""
    write_msc_hdf5(results, IDS, CASES, labels=labels, index=index, order=order)
    check(motions(results, geometry))


@pytest.mark.usefixtures("at_once")
def test_both_kinds_together_and_by_content(tmp_path: Path, geometry: ModelGeometry) -> None:
    """Names tell nothing; the coarser precision counts."""
    one, other = tmp_path / "one.op2", tmp_path / "other.h5"
    single = [(n, label, m.astype(np.float32).astype(float)) for n, label, m in CASES]
    write_msc_hdf5(one, IDS, CASES[1:])
    write_op2(other, IDS, single[:1])
    findings = Findings()
    check(motions([one, other], geometry, findings=findings), [single[0], *CASES[1:]])
    assert findings.single
    write_msc_hdf5(other, IDS, CASES[:1])
    findings = Findings()
    check(motions([one, other], geometry, findings=findings))
    assert not findings.single


@pytest.mark.usefixtures("at_once")
def test_single_precision_in_columns_of_double_precision(results: Path, geometry: ModelGeometry) -> None:
    """As of a solver that computes with words of 32 bits: what it writes in 64 bits is no better for it."""
    single = [(n, label, m.astype(np.float32).astype(float)) for n, label, m in CASES]
    for cases, wanted in ((CASES, False), ([CASES[0], single[1], CASES[2]], True)):
        write_msc_hdf5(results, IDS, cases)
        findings = Findings()
        motions(results, geometry, findings=findings)
        assert findings.single is wanted


@pytest.mark.usefixtures("at_once")
def test_the_numbers_of_the_deck_where_there_are_no_labels(results: Path, geometry: ModelGeometry) -> None:
    write_msc_hdf5(results, IDS, CASES[::-1], labels=False)
    findings = Findings()
    check(motions(results, geometry, findings=findings))
    assert findings.by_number == [results]
    write_msc_hdf5(results, IDS, [(n + 10, label, m) for n, label, m in CASES], labels=False)
    refused(results, geometry, r"subcase 11 \(no label\) belongs to no thermal area of the deck")
    findings = Findings()
    check(motions(results, geometry, subcase_table={"LEFT": 11, "RIGHT": 12, "UNIFORM": 13}, findings=findings))
    assert findings.by_number == []


@pytest.mark.usefixtures("at_once")
def test_labels_before_numbers(results: Path, geometry: ModelGeometry) -> None:
    """Other numbers are fine; the deck's own in another order are not, as in an OP2."""
    write_msc_hdf5(results, IDS, [(n + 10, label.lower(), m) for n, label, m in CASES])
    check(motions(results, geometry))
    write_msc_hdf5(results, IDS, [(n, AREAS[(n + 1) % 3], m) for n, _, m in CASES])
    refused(results, geometry, "subcase 1 is labelled 'UNIFORM', and 'LEFT' in the deck")
    write_msc_hdf5(results, IDS, [(n, "", m) for n, _, m in CASES])
    refused(results, geometry, r"subcase 1 \(no label\) belongs to no thermal area")


@pytest.mark.usefixtures("at_once")
def test_scalar_points_are_those_of_the_deck(results: Path, geometry: ModelGeometry) -> None:
    """Their rows look like those of grids."""
    ids = np.array([5001, *IDS, 5002])
    write_msc_hdf5(
        results, ids, [(n, label, np.pad(m, ((1, 1), (0, 0)), constant_values=9e9)) for n, label, m in CASES]
    )
    refused(results, geometry, "2 grids are not in the deck: 5001, 5002")
    check(motions(results, geometry, scalar_points={5001, 5002, 5003}))


def test_memory_is_that_of_one_subcase(tmp_path: Path) -> None:
    """The table of all subcases is never held at once."""
    peaks, ids = {}, np.arange(1, 40_001)
    for count in (2, 8):
        path = tmp_path / f"{count}.h5"
        write_msc_hdf5(path, ids, ((i + 1, f"A{i}", np.full((len(ids), 6), i + 1.0)) for i in range(count)))
        with open_result_file(path) as (tables, read_table):
            read_table(tables[0])
            tracemalloc.start()
            for table in tables:
                assert read_table(table).motion[-1, 5] == table.subcase
            peaks[count] = tracemalloc.get_traced_memory()[1]
            tracemalloc.stop()
    assert peaks[8] < 1.2 * peaks[2]
    assert peaks[8] < 4 * ids.size * 8 * 8


# --- what is refused -------------------------------------------------------------------------------------------------


def set_domain(column: str, value: int, row: int = 1) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        rows = table_of(path, DOMAINS)
        rows[column][row] = value
        change_table(path, DOMAINS, rows)

    return change


def without(table: str, column: str) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        rows = table_of(path, table)
        change_table(path, table, rows[[n for n in rows.dtype.names if n != column]].copy())

    return change


def as_type(table: str, column: str, kind: str) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        rows = table_of(path, table)
        change_table(path, table, rows.astype([(n, kind if n == column else rows.dtype[n]) for n in rows.dtype.names]))

    return change


def move(to: str) -> Callable[[Path], None]:
    def change(path: Path) -> None:
        with h5py.File(path, "r+") as file:
            file.move(DISPLACEMENT, to)

    return change


def schema(value: object, name: str = "SCHEMA") -> Callable[[Path], None]:
    def change(path: Path) -> None:
        with h5py.File(path, "r+") as file:
            if value is None:
                del file.attrs[name]
            else:
                file.attrs[name] = value

    return change


def not_written(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        kind = file[DISPLACEMENT].dtype
        del file[DISPLACEMENT]
        file.create_dataset(DISPLACEMENT, (21,), kind, chunks=(7,))[:7] = np.zeros(7, kind)


def elsewhere(path: Path) -> None:
    with h5py.File(path, "r+") as file:
        file["/NASTRAN/INPUT/OTHER"] = h5py.ExternalLink("other.h5", "/OTHER")


def shifted(path: Path) -> None:
    rows = table_of(path, INDEX)
    rows["POSITION"][1] += 1
    change_table(path, INDEX, rows)


def two_labels(path: Path) -> None:
    rows = table_of(path, CASE_CONTROL)
    rows["SID"][2] = 1
    change_table(path, CASE_CONTROL, rows)


FOREIGN: dict[str, tuple[Callable[[Path], None], str]] = {
    "superelement": (set_domain("SE", 3), r"subcase 2: results of superelement 3 are not read \(SE of domain 2\)"),
    "module": (set_domain("MODULE", 7), "subcase 2: results of module 7 are not read"),
    "design cycle": (set_domain("DESIGN_CYCLE", 1), "subcase 2: results of design cycle 1 are not read"),
    "step": (set_domain("STEP", 1), "subcase 2: results of step 1 are not read"),
    "modes": (set_domain("ANALYSIS", 2), r"subcase 2: holds modes \(SOL 103\), not static displacements"),
    "transient": (set_domain("ANALYSIS", 6), "subcase 2: holds a transient response, not static"),
    "nonlinear": (set_domain("ANALYSIS", 10), "subcase 2: holds nonlinear statics, not static"),
    "unknown analysis": (set_domain("ANALYSIS", 77), "subcase 2: holds results of analysis code 77, not static"),
    "subcase twice": (set_domain("SUBCASE", 1), r"subcase 1 occurs 2 times \(domains 1, 2\)"),
    "domain twice": (set_domain("ID", 1), "DOMAINS has domain 1 twice"),
    "rows of no domain": (set_domain("ID", 9), "rows of domain 2, which /NASTRAN/RESULT/DOMAINS has not"),
    "no domains": (lambda p: change_table(p, DOMAINS, None), "has no table /NASTRAN/RESULT/DOMAINS"),
    "no displacements": (lambda p: change_table(p, DISPLACEMENT, None),  "no displacements .tables of grids: none"),
    "other tables": (move(f"{NODAL}/SPC_FORCE"), r"holds no displacements \(tables of grids: SPC_FORCE\)"),
    "complex": (move(f"{NODAL}/DISPLACEMENT_CPLX"), r"complex displacements \(table DISPLACEMENT_CPLX\), not"),
    "eigenvectors": (move(f"{NODAL}/EIGENVECTOR"), r"holds modes \(table EIGENVECTOR\), not static"),
    "no rows": (
        lambda p: change_table(p, DISPLACEMENT, table_of(p, DISPLACEMENT)[:0]),
        r"holds no displacements \(/NASTRAN/RESULT/NODAL/DISPLACEMENT has no rows\)",
    ),
    "no rotation": (without(DISPLACEMENT, "RY"), r"has no column RY \(SCHEMA 20200\); it has ID, X, Y, Z, RX"),
    "no SE": (without(DOMAINS, "SE"), r"DOMAINS has no column SE \(SCHEMA 20200\)"),
    "no label column": (without(CASE_CONTROL, "LABEL"), "SUBCASE has no column LABEL"),
    "whole numbers": (as_type(DISPLACEMENT, "Z", "<i8"), r"DISPLACEMENT: column Z is int64, wanted a real number"),
    "domains as text": (as_type(DISPLACEMENT, "DOMAIN_ID", "S8"), r"column DOMAIN_ID is \|S8, wanted a whole number"),
    "an array": (lambda p: change_table(p, DISPLACEMENT, np.zeros((21, 8))), "DISPLACEMENT is no table of records"),
    "not written to its end": (not_written, "DISPLACEMENT lacks values: it was not written to its end"),
    "another file": (elsewhere, "/NASTRAN/INPUT/OTHER is a link to another file"),
    "wrong index": (shifted, "INDEX/.*/DISPLACEMENT has domain 2 at rows 9 to 15, .* at rows 8 to 14"),
    "short index": (lambda p: change_table(p, INDEX, table_of(p, INDEX)[:2]), "no more rows, .* 3 at rows 15 to 21"),
    "two labels": (two_labels, "subcase 1 has the labels 'LEFT' and 'UNIFORM'"),
    "no schema": (schema(None), "is HDF5, but not as MSC Nastran writes it: has no attribute SCHEMA"),
    "a schema of words": (schema("new"), "not as MSC Nastran writes it: SCHEMA is 'new', and not a number"),
    "our own": (schema("tedm.distortion", "schema"), r"is tedm's own file \(tedm.distortion\), not results of Nastran"),
}  # fmt: skip


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize("name", FOREIGN)
def test_other_results_are_refused_by_name(results: Path, geometry: ModelGeometry, name: str) -> None:
    change, fact = FOREIGN[name]
    change(results)
    refused(results, geometry, fact)


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize("value", [np.array([20251]), np.array([20182]), 7])
def test_another_schema_with_the_same_columns(results: Path, geometry: ModelGeometry, value: object) -> None:
    schema(value)(results)
    without(DOMAINS, "IMPFID")(results)
    check(motions(results, geometry))


@pytest.mark.usefixtures("at_once")
def test_subcases_and_grids_as_of_an_op2(tmp_path: Path, results: Path, geometry: ModelGeometry) -> None:
    other = tmp_path / "other.h5"
    write_msc_hdf5(other, IDS, [(9, "RIGHT", MOTION[0])])
    with pytest.raises(InputError, match=r"other.h5: area 'RIGHT' was already in .*loads.h5"):
        motions([results, other], geometry)
    refused(other, geometry, r"for 2 of 3 unit loads: 'LEFT' \(subcase 1\), 'UNIFORM'")
    write_msc_hdf5(results, IDS, [*CASES, (4, "TOP", MOTION[0])])
    refused(results, geometry, r"subcase 4 \(label 'TOP'\) belongs to no thermal area")
    write_msc_hdf5(results, IDS[:5], [(n, label, m[:5]) for n, label, m in CASES])
    refused(results, geometry, r"2 grids have no displacement: 6, 7\n")
    spoilt = [(n, label, np.where((np.arange(7) == 3)[:, None] & (n == 2), np.nan, m)) for n, label, m in CASES]
    write_msc_hdf5(results, IDS, spoilt)
    refused(results, geometry, "1 of 7 displacements are NaN or infinite: grid 4")


def test_a_file_that_is_cut_short(results: Path, geometry: ModelGeometry) -> None:
    whole = results.read_bytes()
    for cut in (9, len(whole) // 3, len(whole) - 1):
        results.write_bytes(whole[:cut])
        refused(results, geometry, "not a readable HDF5 file")
    for cut in (0, 7):
        results.write_bytes(whole[:cut])
        refused(results, geometry, "neither .* HDF5|truncated")


def test_damage_within_the_rows(results: Path) -> None:
    """What is compressed has a sum of its own; it is found before a subcase is read."""
    with h5py.File(results) as file:
        chunk = file[DISPLACEMENT].id.get_chunk_info(0)
    data = bytearray(results.read_bytes())
    data[chunk.byte_offset + chunk.size // 2] ^= 4
    results.write_bytes(data)
    with pytest.raises(InputError, match=r"loads.h5: /NASTRAN/RESULT/NODAL/DISPLACEMENT: cannot be read, .* damaged"):
        require_whole(results)


def test_the_file_that_msc_nastran_wrote_is_its_op2_in_double_precision(nastran_dir: Path) -> None:
    """A twin of NX Nastran: the two agree to the rounding of the OP2, in the frames of the grids (all basic)."""
    with open_result_file(nastran_dir / "static_solid_shell_bar.h5") as (tables, read_table):
        assert [(t.subcase, t.label) for t in tables] == [(1, "")]
        found = read_table(tables[0])
    with open_op2(nastran_dir / "static_solid_shell_bar.op2") as (tables, read_table):
        twin = read_table(tables[0])
    np.testing.assert_array_equal(found.grid_id, twin.grid_id)
    assert found.double
    assert not twin.double
    largest = float(np.abs(twin.motion).max())
    assert largest == pytest.approx(2.8e-3, rel=0.05)
    gap = np.abs(found.motion - twin.motion)
    assert 0.0 < gap.max() < 2.0**-24 * largest  # 1.0e-10
