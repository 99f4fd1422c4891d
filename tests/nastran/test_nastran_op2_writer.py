"""The OP2 that the embedded solver writes: a file as pyNastran's own, written one subcase after the other."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tracemalloc
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from pyNastran.op2.op2 import OP2, read_op2
from pyNastran.op2.tables.oug.oug_displacements import RealDisplacementArray

from tedm_cli.errors import InputError, PhysicsError
from tedm_cli.nastran.op2.reader import open_op2
from tedm_cli.nastran.op2.writer import MAX_GRIDS, write_op2

IDS = np.array([1, 4711, 99_999_999])
MOTION = np.random.default_rng(0).standard_normal((3, 6)) * 1e-6
CASES = [(1, "STRUT_1", MOTION), (12_345_678, "mixed Case, and - signs", -MOTION), (5, "x" * 120, 0 * MOTION)]


def written_by_pynastran(path: Path, ids: np.ndarray, cases: list[tuple[int, str, np.ndarray]]) -> bytes:
    """The peer, on the date that our files carry."""
    model = OP2(debug=None)
    model.date = (1, 2, 2000)
    model.set_as_msc()
    node_gridtype = np.column_stack([ids, np.ones(len(ids))]).astype(np.int32)
    for subcase, label, motion in cases:
        table = RealDisplacementArray.add_static_case(
            "OUGV1", node_gridtype, motion.astype(np.float32)[None], subcase, is_msc=True, label=label
        )
        table.lsdvmns = [subcase]
        model.displacements[subcase] = table
    model.write_op2(str(path), post=-1, endian=b"<", nastran_format="msc")
    return path.read_bytes()


@pytest.mark.parametrize(("ids", "cases"), [(IDS, CASES), (IDS[:1], [(7, "", MOTION[:1])])])
def test_the_bytes_are_those_of_pynastrans_writer(
    tmp_path: Path, ids: np.ndarray, cases: list[tuple[int, str, np.ndarray]]
) -> None:
    path = tmp_path / "ours.op2"
    write_op2(path, ids, iter(cases))
    assert path.read_bytes() == written_by_pynastran(tmp_path / "theirs.op2", ids, cases)
    tables = read_op2(str(path), include_results="displacements", debug=None).displacements
    assert {int(k): t.label for k, t in tables.items()} == {n: label for n, label, _ in cases}
    for number, _, data in cases:
        np.testing.assert_array_equal(tables[number].node_gridtype[:, 0], ids)
        np.testing.assert_array_equal(tables[number].data[0], data.astype(np.float32))


def test_the_shipped_results_are_written_again_byte_by_byte(tmp_path: Path) -> None:
    shipped = Path(__file__).parents[2] / "sample_models" / "small" / "unit_loads.op2"
    path = tmp_path / "again.op2"
    with open_op2(shipped) as (tables, read_table):
        ids = read_table(tables[0]).grid_id
        write_op2(path, ids, ((t.subcase, t.label, read_table(t).motion) for t in tables))
    assert path.read_bytes() == shipped.read_bytes()


def test_memory_does_not_grow_with_the_number_of_subcases(tmp_path: Path) -> None:
    peaks = {}
    ids = np.arange(1, 20_001)
    for count in (2, 12):
        cases = ((i + 1, f"A{i}", np.full((len(ids), 6), 1e-6 * i)) for i in range(count))
        tracemalloc.start()
        write_op2(tmp_path / "file.op2", ids, cases)
        peaks[count] = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
    assert peaks[12] < 1.05 * peaks[2]
    assert peaks[12] < 200 * len(ids)


@pytest.mark.parametrize(
    ("ids", "cases", "fact"),
    [
        ([1, 100_000_000], [(1, "a", np.zeros((2, 6)))], "between 1 and 99,999,999"),
        (np.broadcast_to(np.int64(1), MAX_GRIDS + 1), [], "an OP2 holds 67,108,863"),
        ([1], [(1, "a", np.zeros((1, 6))), (1, "b", np.zeros((1, 6)))], "used twice"),
        ([1], [(1, "Bänke", np.zeros((1, 6)))], "plain ASCII"),
        ([1], [(1, "a" * 129, np.zeros((1, 6)))], "128 characters"),
        ([1], [(1, "a", np.full((1, 6), 1e39))], "not finite in single precision"),
        ([1], [], "no subcase"),
    ],
)
def test_refusals_leave_the_old_file(tmp_path: Path, ids: list[int], cases: list, fact: str) -> None:
    target = tmp_path / "old.op2"
    target.write_bytes(b"old")
    with pytest.raises(InputError, match=fact):
        write_op2(target, np.asarray(ids), cases)
    assert target.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["old.op2"]


def test_a_solution_that_fails_midway_leaves_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "old.op2"
    target.write_bytes(b"old")

    def cases() -> Iterator[tuple[int, str, np.ndarray]]:
        yield CASES[0]
        raise PhysicsError("load case 2: relative residual 1e-3")

    with pytest.raises(PhysicsError, match="relative residual"):
        write_op2(target, IDS, cases())
    assert target.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["old.op2"]


def test_a_full_disk_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "old.op2"
    target.write_bytes(b"old")

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="no room left"):
        write_op2(target, IDS, CASES)
    assert target.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["old.op2"]


KILLED = """
import os, signal, sys
from pathlib import Path
import numpy as np
from tedm_cli.nastran.op2.writer import write_op2

def cases():
    yield 1, "A", np.zeros((50_000, 6))
    assert any(p.stat().st_size > 1_000_000 for p in Path(sys.argv[1]).parent.glob(".old.op2.*.tmp"))
    os.kill(os.getpid(), signal.SIGKILL)

write_op2(Path(sys.argv[1]), np.arange(1, 50_001), cases())
"""


def test_a_killed_writer_leaves_the_old_file_and_the_next_one_clears_up(tmp_path: Path) -> None:
    target = tmp_path / "old.op2"
    target.write_bytes(b"old")
    done = subprocess.run([sys.executable, "-c", KILLED, str(target)], check=False)
    assert done.returncode == -signal.SIGKILL
    assert target.read_bytes() == b"old"
    assert len(os.listdir(tmp_path)) == 2
    write_op2(target, IDS, CASES)
    assert os.listdir(tmp_path) == ["old.op2"]
