"""What this program is held to: each goal, what it takes now, and what it took in an older tree, in turn.

Goals of the desk (a chain, a case, a file shown, a folder checked) are commands as a user starts them, in seconds of
the clock. The others are seconds of processor, ratios of these in one process, and memory.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

from benchmarks.growth import AREAS, per_size
from benchmarks.process import ROOT, Usage, run
from benchmarks.scale import CELLS, DECK, ONE_PASS, Measured, grids_of, stages

TREES = ("tedm_cli", "configs", "sample_models")
MANY_GRIDS = 2_000_000
_SMALLER = (43, 25, 17)
_PATH = ("OP2 to unit_loads.h5", "build-distortion", "build-sensitivity")


@dataclass(frozen=True)
class Found:
    """A goal and what was found: the goal in its unit, or None where it is no number."""

    goal: str
    limit: float | None
    unit: str
    value: float
    processor_s: float | None = None


Group = Callable[[Path, Path], Iterator[Found]]


def older(commit: str, folder: Path) -> Path:
    """The code of an older commit, in a folder of its own."""
    command = ["git", "archive", commit, "--", *TREES]
    archive = subprocess.run(command, cwd=ROOT, check=True, capture_output=True).stdout
    with tarfile.open(fileobj=BytesIO(archive)) as tar:
        tar.extractall(folder, filter="data")
    return folder


def rows(before: str | None = None) -> Iterator[dict[str, Any]]:
    """Every goal by this tree and, where a commit is named, by that one, in turn."""
    with tempfile.TemporaryDirectory() as name:
        trees = {"now": ROOT} | ({"before": older(before, Path(name) / "tree")} if before else {})
        for group in GROUPS:
            found = {which: _of_tree(group, tree, Path(name) / which, tree == ROOT) for which, tree in trees.items()}
            for goal in found["now"].values():
                told = {}
                for which, results in found.items():
                    one = results.get(goal.goal)
                    told[which] = _number(one.value) if one else None
                    told[f"{which}_processor_s"] = _number(one.processor_s) if one else None
                yield {"goal": goal.goal, "limit": goal.limit, "unit": goal.unit, "commit": before, **told}


def _of_tree(group: Group, tree: Path, folder: Path, is_this: bool) -> dict[str, Found]:
    """What was found by goal: as far as an older tree knows the files that this one makes up."""
    folder.mkdir(exist_ok=True)
    found = {}
    try:
        for goal in group(tree, folder):
            found[goal.goal] = goal
    except subprocess.CalledProcessError as failed:
        if is_this:
            raise
        print(f"not measured before: {' '.join(failed.cmd)}", file=sys.stderr)
    return found


def desk(tree: Path, folder: Path) -> Iterator[Found]:
    """The chain of the first sample from its model on, and commands on its files; kernels are compiled before."""
    build = folder / "build"
    model = [str(tree / "sample_models" / "ltp_like.py"), "--layout", str(tree / "configs" / "optics.toml")]
    chain = []
    for _ in range(2):  # the first compiles, where nothing has yet
        shutil.rmtree(build, ignore_errors=True)
        build.mkdir()
        parts = [
            run([*model, "-o", str(build / "ltp.bdf")], tree=tree, folder=folder, one_thread=False),
            _tedm(tree, folder, "run", "-j", "2"),
        ]
        chain.append((sum(part.wall_s for part in parts), sum(part.processor_s for part in parts)))
    yield Found("the whole chain of the first sample, two commands at once", 30.0, "s", *min(chain))
    for goal, limit, arguments in (
        ("`tedm run-case 3`", 1.0, ["run-case", "3"]),
        ("`tedm show case03.h5`", 0.3, ["show", str(build / "case03.h5")]),
        ("`tedm check`", 0.3, ["check"]),
    ):
        runs = [_tedm(tree, folder, *arguments) for _ in range(4)]
        yield Found(goal, limit, "s", min(r.wall_s for r in runs), min(r.processor_s for r in runs))


def _tedm(tree: Path, folder: Path, command: str, *arguments: str) -> Usage:
    options = [] if command == "show" else ["-d", str(folder / "build")]
    if command in ("run", "run-case"):
        options += ["-c", str(tree / "configs" / "tedm.toml")]
    return run(["-m", "tedm_cli.cli", command, *arguments, *options], tree=tree, folder=folder, one_thread=False)


def gravity(tree: Path, folder: Path) -> Iterator[Found]:
    """The kernel, its ratios to choclo, and the operator, in one process."""
    found = json.loads(run(["-m", "benchmarks.goals", "--gravity"], tree=tree, folder=folder).output)
    yield Found("six quantities of a cube, within 11 sides", 100.0, "ns a point", found["six_ns"])
    yield Found("F and Γ of a cube against choclo, within 1.5 sides", 1 / 4, "of its time", found["near"])
    yield Found("F and Γ of a cube against choclo, within 11 sides", 1 / 6, "of its time", found["far"])
    yield Found("operator by quadrature, 68,000 grids", 0.6, "µs a source", found["operator_us"])


def _gravity() -> dict[str, float | None]:
    from benchmarks.gravity import against_choclo, all_quantities, operator
    from benchmarks.ratios import FAR, NEAR

    six, block = all_quantities(*FAR), operator(CELLS)
    near, far = (against_choclo(*limits, shared=False).ratio for limits in (NEAR, FAR))
    return {"six_ns": 1e9 * six.each_s, "near": near, "far": far, "operator_us": 1e6 * block.each_s}


def displacements(tree: Path, folder: Path) -> Iterator[Found]:
    """What the displacements take on their way from an OP2 to S and [D] of the optical grids, at 80 areas."""
    plain = "np.fromfile of the whole OP2"
    took = {task: one for task, _, one in stages(80, CELLS, only=_PATH, tree=tree) if task in (*_PATH, plain)}
    seconds = [took[stage].streaming_s or took[stage].processor_s for stage in _PATH]
    yield Found(
        "OP2 to S and D_opt, displacements alone, 68,000 grids × 80 areas",
        2.0,
        "raw reads",
        sum(seconds) / took[plain].processor_s,
        sum(seconds),
    )


def one_pass(tree: Path, folder: Path) -> Iterator[Found]:
    """The same where nothing is stored, with the sum of the file."""
    plain = "np.fromfile of the whole OP2"
    took = {task: one for task, _, one in stages(80, CELLS, only=(ONE_PASS,), tree=tree)}
    found = took[ONE_PASS]
    ratio = found.streaming_s / took[plain].processor_s
    goal = "the same by `build-sensitivity --no-store`, SHA-256 of the file with it"
    yield Found(goal, 2.0, "raw reads", ratio, found.streaming_s)


def decks(tree: Path, folder: Path) -> Iterator[Found]:
    """`ingest` of a deck and its OP2: its resident memory by areas, and what the deck takes of it by grids."""
    task = next(iter(DECK))

    def ingest(areas: int, cells: tuple[int, int, int]) -> Measured:
        found = {name: one for name, _, one in stages(areas, cells, deck=True, only=(task,), tree=tree)}
        return found[task]

    by_areas = {count: ingest(count, CELLS) for count in AREAS}
    for count, one in by_areas.items():
        yield Found(f"resident memory of `ingest`, 68,000 grids × {count} areas", None, "MB", one.resident_mb)
    sizes = {_SMALLER: ingest(AREAS[0], _SMALLER), CELLS: by_areas[AREAS[0]]}
    grids = [grids_of(cells) for cells in sizes]
    seconds = per_size(grids, [one.processor_s - one.streaming_s for one in sizes.values()])
    yield Found("deck of 2 million grids, from the slope", 60.0, "s", MANY_GRIDS * seconds)
    memory = per_size(grids, [1e6 * one.anonymous_mb for one in sizes.values()])
    yield Found("memory of a deck, from the slope", 500.0, "bytes a grid", memory)


GROUPS: Sequence[Group] = (desk, gravity, displacements, one_pass, decks)


def _number(value: float | None) -> float | None:
    return None if value is None else float(f"{value:.4g}")


if __name__ == "__main__":
    assert sys.argv[1:] == ["--gravity"]
    print(json.dumps(_gravity()))
