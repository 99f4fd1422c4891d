"""A campaign over every kind of file: so many mutants by weight, judged by processes that are watched, and counted.

A verdict is right, one clear error, or a failure (see `fuzz_judge`, `fuzz_users`, `fuzz_hdf5_judge`). A mutant has a
kind and a number; the seed says where the numbers begin, and a kind and a number alone make the same mutant again.
"""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import tempfile
import time
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Protocol, TextIO

import fuzz_hdf5_judge
import fuzz_users
from fuzz_judge import KINDS, Judge, Verdict, processor_seconds
from fuzz_model import fuzz_case

LIMIT = 60.0  # s of the processor for one mutant, when its own judge has not stopped it
STILL = 600.0  # s of the clock for one mutant that waits
FAMILIES: dict[str, dict[str, int]] = {
    "decks": {"bdf": 190, "structure": 80, "solver": 50},
    "OP2": {"op2": 190, "adjoint.op2": 20},
    "HDF5 of MSC Nastran": {"msc.h5": 40},
    "TOML": {"tedm.toml": 15, "model.toml": 40, "optics.toml": 40, "cases.toml": 45, "dynamics.toml": 40,
             "thermal.toml": 25, "loads.toml": 15, "balance.toml": 15, "S_BW.csv.toml": 10},
    "CSV": {
        "areas.csv": 25, "blocks.csv": 20, "points.csv": 20, "budget.csv": 15, "spectra.csv": 15, "series.csv": 20,
        "nodes.csv": 15, "r.csv": 20, "S_BW.csv": 15, "magnetic.csv": 10,
        "thermal_nodes.csv": 15, "thermal_conductors.csv": 12, "thermal_powers.csv": 8, "bus.csv": 8,
        "map.csv": 10, "places.csv": 10, "tau.csv": 10, "disturbances.csv": 10, "parts.csv": 8, "measured.csv": 8,
    },
    "NPZ and MAT": {"r.npz": 20, "optics.npz": 15, "controller.npz": 8, "optics.mat": 17},
    "STL": {"body.stl": 10},
    "HDF5 of ESATAN-TMS": {"MODEL.TMD": 15, "TIMES.TMD": 10},
    "HDF5": {**dict.fromkeys(fuzz_hdf5_judge.READERS, 10), "dynamics.h5": 6, "case03.h5": 12},
}  # fmt: skip
WEIGHTS = {kind: weight for kinds in FAMILIES.values() for kind, weight in kinds.items()}
#: What a class of outcomes is called in the table; outcomes that are not here are failures, or classes of errors.
RIGHT = {"same": "same", "rounding": "same", "meaning": "meaning", "exchanged": "exchanged"}
COLUMNS = ("same", "meaning", "exchanged", "one error", "silent", "internal", "unclear", "hanging", "other")
_FAILED = {
    "SILENT": "silent", "CRASH": "internal", "INTERNAL": "internal", "SIGNAL": "internal", "UNCLEAR": "unclear",
    "HANG": "hanging",
}  # fmt: skip
Job = tuple[str, int]


def share(count: int, kinds: Iterable[str] = WEIGHTS) -> dict[str, int]:
    """How many mutants of each kind: by weight, at least one, `count` in all where there are enough."""
    weights = {kind: WEIGHTS[kind] for kind in kinds}
    total = sum(weights.values())
    exact = {kind: count * w / total for kind, w in weights.items()}
    out = {kind: max(1, int(x)) for kind, x in exact.items()}
    for kind in sorted(exact, key=lambda k: int(exact[k]) - exact[k])[: max(0, count - sum(out.values()))]:
        out[kind] += 1
    return out


def jobs(seed: int, count: int, kinds: Iterable[str] = WEIGHTS) -> list[Job]:
    """The mutants of a seed, the kinds in turns, so that any part of the list has some of each."""
    places = [((i + 0.5) / n, kind, seed * 1_000_000 + i) for kind, n in share(count, kinds).items() for i in range(n)]
    return [(kind, number) for _, kind, number in sorted(places)]


class OneJudge(Protocol):
    def judge(self, kind: str, number: int) -> Verdict: ...


class Judges:
    """The judges of all kinds, each made in a folder of its own when the first of its mutants comes."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.made: dict[str, OneJudge] = {}

    def judge(self, kind: str, number: int) -> Verdict:
        return self.of(kind).judge(kind, number)

    def of(self, kind: str) -> OneJudge:
        """The judge of a kind; the first call for a group of kinds makes their project."""
        group = group_of(kind)
        if group not in self.made:
            self.made[group] = self._make(group, self.folder / group)
        return self.made[group]

    @staticmethod
    def _make(group: str, folder: Path) -> OneJudge:
        if group == "inputs":
            return Judge(fuzz_case(folder))
        if group == "hdf5":
            return fuzz_hdf5_judge.Hdf5Judge(folder)
        return fuzz_users.Users(folder, tuple(k for k in fuzz_users.READERS if group_of(k) == group))


def group_of(kind: str) -> str:
    """Kinds whose mutants are judged in one project."""
    if kind in KINDS:
        return "inputs"
    if kind in fuzz_hdf5_judge.READERS:
        return "hdf5"
    return "loop" if kind in fuzz_users.LOOPS else "users"


@dataclass
class Counts:
    """Verdicts counted by kind and class."""

    by_kind: dict[str, Counter[str]] = field(default_factory=dict)
    failed: int = 0

    def add(self, verdict: Verdict) -> None:
        self.by_kind.setdefault(verdict.kind, Counter())[class_of(verdict)] += 1
        self.failed += verdict.failed

    def table(self) -> str:
        """A line for each kind and each family, classes across."""
        lines: list[tuple[str, ...]] = [("", "mutants", *COLUMNS)]
        total = Counter[str]()
        for family, kinds in FAMILIES.items():
            found = {kind: self.by_kind[kind] for kind in kinds if kind in self.by_kind}
            if not found:
                continue
            whole = sum(found.values(), Counter[str]())
            total += whole
            lines += [(family, *_row(whole))]
            lines += [(f"  {kind}", *_row(counts)) for kind, counts in found.items()]
        lines.append(("all", *_row(total)))
        widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
        return "\n".join(
            "  ".join([line[0].ljust(widths[0]), *(x.rjust(w) for x, w in zip(line[1:], widths[1:], strict=True))])
            for line in lines
        )


def _row(counts: Counter[str]) -> list[str]:
    return [f"{n:,}" for n in (sum(counts.values()), *(counts[c] for c in COLUMNS))]


def class_of(verdict: Verdict) -> str:
    if verdict.failed:
        return _FAILED.get(verdict.outcome, "other")
    return RIGHT.get(verdict.outcome, "one error")


def again(kind: str, number: int) -> str:
    """The line that judges one mutant by itself."""
    return f"python tests/fuzz --kind {kind} --first {number} --count 1"


# --- processes -------------------------------------------------------------------------------------------------------


class Worker:
    """A process that judges one mutant after another, and is ended where one does not come to an end."""

    def __init__(self, folder: Path, number: int) -> None:
        ours, theirs = multiprocessing.Pipe()
        context = multiprocessing.get_context("fork")
        self.process = context.Process(target=_serve, args=(theirs, folder, number), daemon=True)
        self.process.start()
        theirs.close()
        self.connection: Connection = ours
        self.job: Job | None = None
        self.ready = False
        self.begun = self.spent = 0.0

    def give(self, job: Job) -> None:
        self.job, self.ready = job, False
        self.connection.send(job)

    def started(self) -> None:
        """The judge of the job has been made: from now on its time counts."""
        self.ready, self.begun, self.spent = True, time.monotonic(), processor_seconds(self.process.pid)

    def overdue(self) -> bool:
        spent = processor_seconds(self.process.pid) - self.spent
        return self.ready and (spent > LIMIT or time.monotonic() - self.begun > STILL)

    def end(self) -> None:
        self.process.kill()
        self.process.join()
        self.connection.close()


def _serve(connection: Connection, folder: Path, number: int) -> None:
    own = Path(tempfile.mkdtemp(dir=folder, prefix=f"{number}-"))
    judges = Judges(own / "judges")
    (own / "here").mkdir()
    os.chdir(own / "here")  # what is left in the working folder is seen, and nobody else leaves anything
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # libraries that print
    while True:
        try:
            kind, at = connection.recv()
        except EOFError:
            return
        judges.of(kind)
        connection.send(None)
        connection.send(judges.judge(kind, at))


def verdicts(wanted: list[Job], processes: int) -> Iterator[Verdict]:
    """Verdicts on all jobs, as they come. A process that dies or hangs is a verdict too, and is followed by another."""
    left = list(reversed(wanted))
    with tempfile.TemporaryDirectory() as name, contextlib.ExitStack() as stack:
        folder = Path(name)
        workers = [Worker(folder, n) for n in range(min(processes, len(left)))]

        def end_all() -> None:  # those that followed others too
            for worker in workers:
                worker.end()

        stack.callback(end_all)
        for worker in workers:
            worker.give(left.pop())
        while any(w.job for w in workers):
            ready = wait([w.connection for w in workers if w.job], timeout=1.0)
            for n, worker in enumerate(workers):
                if worker.job is None:
                    continue
                verdict = None
                if worker.connection in ready:
                    try:
                        answer = worker.connection.recv()
                    except (EOFError, ConnectionError):
                        worker.process.join()
                        verdict = _failed(worker.job, "INTERNAL", f"the process ended with {worker.process.exitcode}")
                    else:
                        if answer is None:
                            worker.started()
                            continue
                        verdict = answer
                elif worker.overdue():
                    verdict = _failed(worker.job, "HANG", f"more than {LIMIT} s, and not to be interrupted")
                if verdict is None:
                    continue
                yield verdict
                if not worker.process.is_alive() or worker.overdue():
                    worker.end()
                    worker = workers[n] = Worker(folder, n)
                worker.job = None
                if left:
                    worker.give(left.pop())


def _failed(job: Job, outcome: str, detail: str) -> Verdict:
    return Verdict(*job, "?", outcome, detail)


def campaign(seed: int, count: int, processes: int, log: Path | None, out: TextIO) -> int:
    """Run a campaign, say how far it is, and print its table; how many mutants failed."""
    wanted, counts, begin, shown = jobs(seed, count), Counts(), time.monotonic(), 0.0
    before = os.times()
    with contextlib.ExitStack() as stack:
        stream = None if log is None else stack.enter_context(open(log, "w", encoding="utf-8"))
        for done, verdict in enumerate(verdicts(wanted, processes), 1):
            counts.add(verdict)
            if verdict.failed:
                text = f"{verdict}\n    {again(verdict.kind, verdict.number)}\n"
                out.write(text)
                if stream is not None:
                    stream.write(text)
                    stream.flush()
            passed = time.monotonic() - begin
            if passed > shown + 20.0:
                shown = passed
                left = passed / done * (len(wanted) - done)
                print(
                    f"{done:,} of {len(wanted):,}, {counts.failed} failed, {left / 60.0:.0f} min left",
                    file=out,
                    flush=True,
                )
    after = os.times()
    used = sum(after[i] - before[i] for i in range(4))
    passed = time.monotonic() - begin
    print(counts.table(), file=out)
    print(
        f"seed {seed}: {len(wanted):,} mutants, {counts.failed} failed; {passed / 60.0:.1f} min on {processes} "
        f"processes, {used / 60.0:.1f} min of processor time",
        file=out,
        flush=True,
    )
    return counts.failed
