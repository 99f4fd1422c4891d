"""The stages from an OP2 to S and their peers, each in a process of its own, on a made-up model of any size.

`python -m benchmarks.scale AREAS CELLS CELLS CELLS [deck]` prints all of one size. With `deck`, the deck is written and
ingested as well; without, the geometry is made up. All files are in the page cache: what counts is the processor.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from benchmarks import synthetic
from benchmarks.process import ROOT, run
from tedm_cli.nastran.loads.unit_loads import UnitLoads

CELLS = (64, 38, 26)  # 68,000 grids
ENOUGH_S, RUNS = 2.0, 3
_PIECE = 1 << 24
DISPLACEMENTS = ("translation", "rotation")

#: Stage or part of one, and the peers that are run beside it.
NOTHING = "Python and its libraries, nothing done"
RESULTS: dict[str, tuple[str, ...]] = {
    "OP2 written": ("plain write of the OP2's bytes",),
    "OP2 read": ("plain read of the OP2's bytes", "np.fromfile of the whole OP2", "pyNastran reads the OP2"),
    "OP2 to unit_loads.h5": ("np.fromfile of the whole OP2",),
}
DECK: dict[str, tuple[str, ...]] = {"ingest with its deck": ("pyNastran reads the deck",)}
ONE_PASS = "deck and OP2 to S in one pass"  # writes the files of the other stages in its own way: only where asked for
STAGES: dict[str, tuple[str, ...]] = {
    "build-distortion": ("h5py copies the translations",),
    "build-sensitivity": ("plain read of [D]",),
    "build-sensitivity, lumped": ("plain read of [D]",),
}
_NEEDS = {
    **dict.fromkeys(("OP2 read", "OP2 to unit_loads.h5", *DECK, ONE_PASS), "OP2 written"),
    "build-distortion": "OP2 to unit_loads.h5",
    **dict.fromkeys(("build-sensitivity", "build-sensitivity, lumped"), "build-distortion"),
}
#: Peers of writing an OP2 that hold all of it; for the table of OP2 only.
WRITING_PEERS = ("pyNastran writes the OP2",)


@dataclass(frozen=True)
class Measured:
    """A task without its imports: seconds of processor and clock, and of the processor for displacements alone.

    Where the task does not tell, streaming_s is 0. Memory of the process, MB, as in `process.Usage`.
    """

    processor_s: float
    wall_s: float
    streaming_s: float
    resident_mb: float
    anonymous_mb: float
    file_mb: float


def measure(
    tasks: Sequence[str], folder: Path, areas: int, cells: tuple[int, int, int], *, tree: Path = ROOT
) -> dict[str, Measured]:
    """Run tasks in turn, each time in a process of its own; short ones up to three times, and the quickest counts."""
    found: dict[str, list[Measured]] = {task: [] for task in tasks}
    for _ in range(RUNS):
        for task, runs in found.items():
            if sum(one.processor_s for one in runs) < ENOUGH_S:
                arguments = ["-m", "benchmarks.scale", "--task", task, str(folder), *map(str, (areas, *cells))]
                usage = run(arguments, tree=tree, folder=folder)
                processor_s, wall_s, streaming_s = json.loads(usage.output.splitlines()[-1])
                memory = (usage.resident_mb, usage.anonymous_mb, usage.file_mb)
                runs.append(Measured(processor_s, wall_s, streaming_s, *memory))
    return {task: min(runs, key=lambda one: one.processor_s) for task, runs in found.items()}


def _tasks(folder: Path, areas: int, cells: tuple[int, int, int], lumped: bool) -> dict[str, Callable[[Any], object]]:
    """Every task, as a function of the step by which it tells its progress."""
    from tedm_cli.stages.gravity.sensitivity import build_sensitivity
    from tedm_cli.stages.model.distortion import build_distortion
    from tedm_cli.stages.model.ingest import ingest

    unit, distortion, copy = folder / "unit_loads.h5", folder / "distortion.h5", folder / "copy"
    deck, op2 = folder / "unit_loads.bdf", folder / "unit_loads.op2"
    project = synthetic.project(folder, "lumped" if lumped else "quadrature")

    def made_up() -> tuple[synthetic.Block, UnitLoads]:  # not in the processes of the stages, whose memory is measured
        model = synthetic.block(cells)
        return model, synthetic.unit_loads(model, areas)

    def one_pass(step: Any) -> None:
        from tedm_cli.stages.gravity.pulls import reduction_of
        from tedm_cli.stages.gravity.sensitivity import GivenColumns
        from tedm_cli.stages.model.one_pass import reduce_here

        def finish(pulls: Any) -> Callable[[Any, Any], object]:
            return lambda columns, parts: build_sensitivity(project, None, step, GivenColumns(columns, parts, pulls))

        reduce_here(project, reduction_of, finish, step)

    def read(step: Any) -> None:
        model, loads = made_up()
        step(0, 1, "reading")
        deque(synthetic.displacements_of([op2], loads, model), 0)

    return {
        NOTHING: lambda step: None,
        "OP2 written": lambda step: synthetic.write_results(op2, *made_up()),
        "plain write of the OP2's bytes": lambda step: _written(copy, op2.stat().st_size),
        "pyNastran writes the OP2": lambda step: _written_by_pynastran(op2, copy, step),
        "OP2 read": read,
        "plain read of the OP2's bytes": lambda step: read_plainly(op2),
        "np.fromfile of the whole OP2": lambda step: np.fromfile(op2, dtype=np.float32),
        "pyNastran reads the OP2": lambda step: _read_by_pynastran(op2),
        "OP2 to unit_loads.h5": lambda step: synthetic.write_unit_loads(
            project, synthetic.block(cells), areas, step, [op2]
        ),
        "deck written": lambda step: synthetic.write_deck(deck, *made_up()),
        "ingest with its deck": lambda step: ingest(project, None, step),
        "pyNastran reads the deck": lambda step: _deck_by_pynastran(deck),
        ONE_PASS: one_pass,
        "build-distortion": lambda step: build_distortion(project, None, step),
        "h5py copies the translations": lambda step: _copied(unit, copy),
        "build-sensitivity": lambda step: build_sensitivity(project, None, step),
        "build-sensitivity, lumped": lambda step: build_sensitivity(project, None, step),
        "plain read of [D]": lambda step: _read_distortion(distortion),
    }


def read_plainly(path: Path) -> int:
    """Bytes of a file, read in pieces of 16 MB into the same memory."""
    piece, total = memoryview(bytearray(_PIECE)), 0
    with open(path, "rb", buffering=0) as stream:
        while size := stream.readinto(piece):
            total += size
    return total


def _written(target: Path, size: int) -> None:
    """A plain file, in pieces of 16 MB, on the disk at the end as those of the stages are."""
    piece = np.ones(_PIECE, dtype=np.uint8)
    with open(target, "wb") as stream:
        for start in range(0, size, _PIECE):
            piece[: size - start].tofile(stream)
        stream.flush()
        os.fsync(stream.fileno())
    target.unlink()


def _copied(source: Path, target: Path) -> None:
    """The translations area by area into a contiguous dataset."""
    with h5py.File(source) as old, h5py.File(target, "w") as new:
        data = new.create_dataset("translation", old["translation"].shape, old["translation"].dtype)
        for i in range(len(data)):
            data[i] = old["translation"][i]
    target.unlink()


def _read_distortion(source: Path) -> None:
    with h5py.File(source) as file:
        for i in range(len(file["D/translation"])):
            file["D/translation"][i]


def _read_by_pynastran(path: Path) -> Any:
    model = _pynastran()[1](debug=None)
    model.read_op2(str(path), build_dataframe=False)
    return model


def _written_by_pynastran(path: Path, target: Path, step: Any) -> None:
    model = _read_by_pynastran(path)
    step(0, 1, "reading")  # what it wrote before, it has to have
    model.write_op2(str(target))
    target.unlink()


def _deck_by_pynastran(path: Path) -> None:
    _pynastran()[0](debug=None).read_bdf(str(path), xref=False, punch=False)


def _pynastran() -> tuple[Any, Any]:
    """Its readers of decks and of results."""
    from tedm_cli.nastran.library import without_integration

    with without_integration():
        from pyNastran.bdf.bdf import BDF
        from pyNastran.op2.op2 import OP2
    return BDF, OP2


def _run(task: str, folder: Path, areas: int, cells: tuple[int, int, int]) -> tuple[float, float, float]:
    """In the process of the task: seconds of processor and clock, and of the processor for displacements."""
    work, marks = _tasks(folder, areas, cells, task.endswith("lumped"))[task], list[float]()
    if task.startswith("pyNastran"):
        _pynastran()  # whose import is no part of the task

    def step(done: int, total: int, what: str) -> None:
        if task == ONE_PASS:
            streams = what.startswith("reducing")
        else:
            streams = what.startswith(("contracting", "reading")) or (what.startswith("summing") and done == total)
        if streams:
            marks.append(time.process_time())

    clock, processor = time.perf_counter(), time.process_time()
    work(step)
    end, seconds = time.process_time(), time.perf_counter() - clock
    last = marks[-1] if marks and task.startswith(("build", ONE_PASS)) else end
    streaming = last - marks[0] if marks else 0.0
    return end - processor, seconds, streaming


def stages(
    areas: int, cells: tuple[int, int, int], *, deck: bool = False, only: tuple[str, ...] = (), tree: Path = ROOT
) -> Iterator[tuple[str, str, Measured]]:
    """Task, its stage (itself, or that whose peer it is) and what was measured, in a folder that is removed.

    `only` some stages: those whose files they need are run and not told. The OP2 goes as soon as it is not needed.
    """
    every = {**RESULTS, **(DECK if deck else {}), **STAGES}
    if ONE_PASS in only:
        every[ONE_PASS] = RESULTS["OP2 to unit_loads.h5"]
    wanted = {stage: peers for stage, peers in every.items() if not only or stage in _with_needs(only)}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        yield NOTHING, NOTHING, measure([NOTHING], folder, areas, cells, tree=tree)[NOTHING]
        for stage, peers in wanted.items():
            if stage in DECK or stage == ONE_PASS:
                measure(["deck written"], folder, areas, cells, tree=tree)
            told = not only or stage in only
            for task, found in measure([stage, *(peers if told else ())], folder, areas, cells, tree=tree).items():
                if told:
                    yield task, stage, found
            if stage == [one for one in wanted if one not in STAGES][-1]:
                (folder / "unit_loads.op2").unlink()


def _with_needs(only: tuple[str, ...]) -> set[str]:
    found = set(only)
    for stage in reversed([*RESULTS, *DECK, *STAGES, ONE_PASS]):
        if stage in found and stage in _NEEDS:
            found.add(_NEEDS[stage])
    return found


def grids_of(cells: tuple[int, int, int]) -> int:
    """Number of grids of the block, without those of the optical layout."""
    return int(np.prod([n + 1 for n in cells]))


def row(task: str, stage: str, areas: int, cells: tuple[int, int, int], found: Measured) -> dict[str, Any]:
    """What is stored of a task."""
    numbers = {key: float(f"{value:.4g}") for key, value in asdict(found).items()}
    return {"grids": grids_of(cells), "areas": areas, "stage": stage, "task": task, **numbers}


def main() -> None:
    if sys.argv[1] == "--task":
        task, folder, areas, *cells = sys.argv[2:]
        nx, ny, nz = map(int, cells)
        print(json.dumps(_run(task, Path(folder), int(areas), (nx, ny, nz))))
        return
    count, nx, ny, nz = map(int, sys.argv[1:5])
    grids = grids_of((nx, ny, nz))
    print(f"{grids:,} grids, {count} areas, {grids * count * 12 / 1e9:.2f} GB for each of /translation, /rotation, [D]")
    heads = ("processor s", "streaming s", "wall s", "resident MB", "anonymous MB", "file MB")
    print(f"{'':42}" + "".join(f"{head:>14}" for head in heads), flush=True)
    for task, stage, found in stages(count, (nx, ny, nz), deck="deck" in sys.argv[5:]):
        numbers = (found.processor_s, found.streaming_s, found.wall_s)
        memory = (found.resident_mb, found.anonymous_mb, found.file_mb)
        told = "".join(f"{x:14.3f}" for x in numbers) + "".join(f"{x:14.0f}" for x in memory)
        print(f"{task if task == stage else '  ' + task:42}{told}", flush=True)


if __name__ == "__main__":
    main()
