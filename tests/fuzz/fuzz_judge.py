"""Run a mutated input through the stages, and judge what came of it.

A verdict is `same` (the distortion matrix of the sound input, bit for bit), `rounding` (within what single precision
can tell), `meaning` (the deck now says something else, and an independent reading of it finds the same), `exchanged`
(the displacements of two areas have changed places as they are: no identity tells), the name of the error class, or a
failure: `CRASH`, `HANG`, `MEMORY`, `LITTER`, `UNCLEAR`, `SILENT`.
"""

from __future__ import annotations

import contextlib
import os
import resource
import signal
import traceback
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
from fuzz_binary import BINARY
from fuzz_memory import MemoryFile, in_memory
from fuzz_model import Case, in_frames
from fuzz_msc_hdf5 import MSC_HDF5
from fuzz_solver import compare_decks, plain_deck, solver_parts
from fuzz_structure import STRUCTURE
from fuzz_text import TEXT, Mutation

from tedm_cli.errors import TedmError
from tedm_cli.nastran.op2.reader import open_op2

SECONDS = 10.0  # of the processor, which others may share; one run takes 0.05 s
ROOM = 1 << 30  # bytes of address space beyond what is taken at the start
FAILURES = ("CRASH", "INTERNAL", "SIGNAL", "HANG", "MEMORY", "LITTER", "UNCLEAR", "SILENT")
KINDS: dict[str, dict[str, Mutation]] = {
    "bdf": TEXT,
    "op2": BINARY,
    "msc.h5": MSC_HDF5,
    "solver": TEXT,
    "structure": STRUCTURE,
}


@dataclass(frozen=True)
class Verdict:
    kind: str
    number: int
    mutation: str
    outcome: str
    detail: str

    @property
    def failed(self) -> bool:
        return self.outcome in FAILURES

    def __str__(self) -> str:
        return f"{self.kind} {self.number} ({self.mutation}): {self.outcome} {self.detail}"


class HangError(BaseException):
    """Not an `Exception`: nobody may take it for a fault of the file."""


@contextlib.contextmanager
def limits() -> Iterator[None]:
    """A limit of processor time for what runs within, and of address space."""

    def stop(*_: object) -> None:
        raise HangError

    before = signal.signal(signal.SIGPROF, stop)
    space = resource.getrlimit(resource.RLIMIT_AS)
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (taken + ROOM, space[1]))
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        resource.setrlimit(resource.RLIMIT_AS, space)
        signal.signal(signal.SIGPROF, before)


def processor_seconds(pid: int | None) -> float:
    """Processor time that a process has taken so far, s; others may share the processor, so the clock says less."""
    with contextlib.suppress(OSError):
        words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")
    return 0.0


def mutant(kind: str, number: int, data: bytes) -> tuple[str, bytes]:
    """The mutation of a number: the kinds take turns, the number seeds the rest."""
    table = KINDS[kind]
    name = list(table)[number % len(table)]
    return name, table[name](Random(f"{kind} {number}"), data)


def clear(exc: TedmError, folder: Path) -> str:
    """What an error lacks: its file, a fact of one line, a class of its own."""
    said = exc.placed
    lines = said.splitlines()
    if type(exc) is TedmError or "internal" in said:
        return "is no class of errors"
    if str(folder) not in exc.where:
        return f"does not name the file: {exc.where!r}"
    if len(lines) != 1 or not exc.fact.strip():
        return f"is not one line: {lines}"
    if len(said) > 600 + 2 * len(str(folder)) or not said.isprintable():
        return f"is no readable line: {said[:300]!r}"
    return ""


class Judge:
    """Judges mutations of one case."""

    def __init__(self, case: Case) -> None:
        self.case = case
        twin = case.folder.parent / "twin" / "unit_loads.bdf"  # without frames, which the embedded solver refuses
        # What a result file is its contents tell: HDF5 takes the place of the OP2.
        self.files = {
            "bdf": case.deck, "op2": case.op2, "msc.h5": case.op2, "solver": twin, "structure": case.deck
        }  # fmt: skip
        self.sound = {kind: file.read_bytes() for kind, file in self.files.items()}
        self.sound["msc.h5"] = case.msc_hdf5.read_bytes()
        (twin.parent / "loop.inc").write_text("INCLUDE 'loop.inc'\n")
        (case.folder / "loop.inc").write_text("INCLUDE 'loop.inc'\n")
        self.parts = solver_parts(twin)
        plain_deck(twin)
        self.listing = self.snapshot()
        with in_memory() as made:
            case.run()
            self.expected = made["distortion.h5"].data
            self.total = made["unit_loads.h5"].data
        self.in_double = self.of_hdf5()
        with open_op2(case.op2) as (tables, read):
            self.motions = {t.label: read(t) for t in tables}

    def of_hdf5(self) -> dict[str, Any]:
        """The distortion of the sound HDF5."""
        before = self.case.op2.read_bytes()
        self.case.op2.write_bytes(self.sound["msc.h5"])
        with in_memory() as made:
            self.case.run()
        self.case.op2.write_bytes(before)
        assert made["unit_loads.h5"].data["/results/precision"] == "double"
        return made["distortion.h5"].data

    def snapshot(self) -> dict[str, tuple[int, int]]:
        ours = {*self.files.values(), self.files["solver"].with_name("plain.bdf")}
        kept = [p for p in self.case.folder.parent.rglob("*") if p not in ours and p.is_file()]
        found = {str(p): (p.stat().st_size, p.stat().st_mtime_ns) for p in kept}
        return found | {str(p): (0, 0) for p in Path.cwd().glob("*")}  # others may work in the working folder

    def judge(self, kind: str, number: int) -> Verdict:
        name, data = mutant(kind, number, self.sound[kind])
        before = self.files[kind].read_bytes()
        self.files[kind].write_bytes(data)
        try:
            outcome, detail = self.outcome(kind)
        finally:
            self.files[kind].write_bytes(before)
        if self.snapshot() != self.listing:
            outcome, detail = "LITTER", str(sorted(set(self.snapshot()) ^ set(self.listing)))
        return Verdict(kind, number, name, outcome, detail)

    def outcome(self, kind: str) -> tuple[str, str]:
        with in_memory() as made, warnings.catch_warnings():
            warnings.simplefilter("error")  # a warning is a second line beside the one error
            try:
                with limits():
                    if kind == "solver":
                        found = solver_parts(self.files[kind])
                    else:
                        self.case.run()
            except TedmError as exc:
                problem = clear(exc, self.case.folder.parent)
                return ("UNCLEAR", f"{problem} [{exc}]") if problem else (type(exc).__name__, str(exc))
            except HangError:
                return "HANG", f"more than {SECONDS} s"
            except MemoryError:
                return "MEMORY", traceback.format_exc()[-1500:]
            except Exception:
                return "CRASH", traceback.format_exc()[-1500:]
            if kind == "solver":
                return compare_decks(found, self.parts, self.files[kind])
            if kind == "structure":
                return self.unchanged(made)
            double = made["unit_loads.h5"].data["/results/precision"] == "double"
            return self.compare(made["distortion.h5"], kind, double)

    def unchanged(self, made: dict[str, MemoryFile]) -> tuple[str, str]:
        """Whether all of the model and of D is what it was; damage to the structure of a deck makes no other model."""
        sound = {"unit_loads.h5": self.total, "distortion.h5": self.expected}
        differ = [k for name, data in sound.items() for k in data if not _equal(data[k], made[name].data.get(k))]
        return ("SILENT", f"changed: {', '.join(differ)}") if differ else ("same", "")

    def compare(self, made: MemoryFile, kind: str, double: bool) -> tuple[str, str]:
        names = [str(n) for n in made.data["/area/name"]]
        sound = self.in_double if kind == "msc.h5" else self.expected
        keys = [k for k in sound if k.startswith(("/D", "/area", "/grid"))]
        same = all(np.array_equal(made.data[k], sound[k]) for k in keys)
        if kind in ("op2", "msc.h5"):
            return ("same", "") if same else self.within_rounding(made, sound, double)
        try:
            wanted = self.by_the_deck(names, made.data["/grid/id"])
        except Exception as exc:
            return "SILENT", f"the reference cannot read the deck: {type(exc).__name__}: {exc}"
        gap = np.abs(made.data["/D/translation"] - wanted).max() / np.abs(wanted).max()
        if not gap < 1e-12:
            return "SILENT", f"differs from the deck's own meaning by {gap:.2g}"
        return ("same", "") if same else ("meaning", "")

    def within_rounding(self, made: MemoryFile, sound: dict[str, Any], double: bool) -> tuple[str, str]:
        """Largest change of anything in D, over the sum of what all loads do there and, as a share, anywhere."""
        worst, allowed = 0.0, ALLOWED_DOUBLE if double else ALLOWED
        for key in ("/D/translation", "/D/rotation", "/D_opt/translation", "/D_opt/rotation"):
            new, old = made.data[key], sound[key]
            if new.shape != old.shape:
                return "SILENT", f"{key} has another shape"
            local = np.linalg.norm(old, axis=-1).sum(axis=0) + np.linalg.norm(old.sum(axis=0), axis=-1)
            moved = np.linalg.norm(new - old, axis=-1).max(axis=0)
            worst = max(worst, float((moved / (local + 0.25 * local.max())).max()) * 2.0**24)
        if worst <= allowed:
            return "rounding", f"{worst:.2g} roundings"
        old, new = sound["/D/translation"], made.data["/D/translation"]
        if np.array_equal(np.sort(old, axis=0), np.sort(new, axis=0)):
            return "exchanged", "whole records of two subcases have changed places, which no identity can tell"
        return "SILENT", f"D changed by {worst:.3g} roundings"

    def by_the_deck(self, names: list[str], ids: np.ndarray) -> np.ndarray:
        """D [k, N, 3] from the sound results and what pyNastran alone reads in the deck."""
        from pyNastran.bdf.bdf import BDF

        with open(os.devnull, "w") as null, contextlib.redirect_stdout(null), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            model = BDF(debug=None)
            model._parse_primary_file_header = lambda _: None
            model.read_bdf(str(self.case.deck), xref=False, punch=False, encoding="latin-1")
            out = []
            steps = {str(s.params["LABEL"][0]).upper(): s for n, s in model.subcases.items() if n}
            for name in names:
                got = self.motions[name.upper()]
                motion = in_frames(self.case.deck, got.grid_id, got.motion, to_basic=True)
                whole = np.zeros((len(ids), 3))
                whole[np.searchsorted(ids, got.grid_id)] = motion[:, :3]
                out.append(whole / self.step(model, steps[name.upper()]))
        return np.array(out)

    @staticmethod
    def step(model: Any, subcase: Any) -> float:
        """The one step of a subcase: the TEMP that differ from TREF."""
        key = next(k for k in ("TEMPERATURE(LOAD)", "TEMPERATURE(BOTH)", "TEMPERATURE") if k in subcase.params)
        sid = int(subcase.params[key][0])
        tref = next(iter({m.tref for m in model.materials.values()}))
        if "TEMPERATURE(INITIAL)" in subcase.params:
            raise NotImplementedError("initial temperatures")
        cards = [c for c in model.loads.get(sid, []) if c.type == "TEMP"]
        steps = {t - tref for c in cards for t in c.temperatures.values()} - {0.0}
        steps = steps or {model.tempds[sid].temperature - tref}
        (only,) = steps
        return float(only)


def _equal(old: Any, new: Any) -> bool:
    return new is not None and np.array_equal(old, new, equal_nan=np.asarray(old).dtype.kind == "f")


ALLOWED = 20.0  # roundings (2^-24) of the local sum of all loads plus a quarter of the largest: what the stage allows
ALLOWED_DOUBLE = 1.25e-8 * 2.0**24  # of results in double precision
