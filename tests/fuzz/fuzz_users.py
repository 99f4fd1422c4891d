"""Run what users write, damaged, through the commands that read it, and judge what came of it.

A verdict is `same` (all numbers of the sound file), `meaning` (those that the plain writing of what the file now says
makes as well, see `fuzz_meaning`; of an archive, the matrix that NumPy or SciPy reads), `rounding` (of an OP2, sums
within single precision), the exit code of one clear
error, or a failure: `CRASH`, `HANG`, `MEMORY`, `UNCLEAR`, `SILENT` (other numbers than the
file's, or none that are finite).
"""

from __future__ import annotations

import cmath
import csv
import re
import traceback
import warnings
from collections.abc import Callable
from pathlib import Path
from random import Random

import h5py
import numpy as np
from fuzz_binary import BINARY
from fuzz_judge import HangError, Verdict, limits
from fuzz_meaning import meaning, written
from fuzz_text import Mutation
from fuzz_users_project import NUMBERED, Ran, UserProject, balanced, bricks, loop, network
from fuzz_users_text import USERS_BINARY, USERS_TEXT
from label_scales import is_scale_alone

from tedm_cli.contracts import KINDS as CONTRACTS

RUN = ["run-case", "own"]
DYNAMICS = [["build-dynamics"]]
MAP = [["map-temperatures", "tau.csv", "-o", "build/grids.h5"]]
THERMAL = [["build-thermal", "-q"]]  # what is printed has a time in it
#: By kind: the file that is damaged, and the commands that read it.
READERS: dict[str, tuple[str, list[list[str]]]] = {
    "tedm.toml": ("tedm.toml", [["check-layout"]]),
    "model.toml": ("model.toml", [["ingest"], ["build-distortion"], ["build-sensitivity"]]),
    "optics.toml": ("optics.toml", [["check-layout"], ["build-distortion"], ["build-optics"]]),
    "cases.toml": ("cases.toml", [RUN, ["run-series", "all"]]),
    "areas.csv": ("areas.csv", [["areas"]]),
    "blocks.csv": ("blocks.csv", [["build-sensitivity"]]),
    "points.csv": ("points.csv", [["self-gravity", "--points", "points.csv"]]),
    "budget.csv": ("budget.csv", [RUN]),
    "spectra.csv": ("spectra.csv", [RUN]),
    "series.csv": ("series.csv", [["run-series", "warm"]]),
    "map.csv": ("map.csv", MAP),
    "places.csv": ("places.csv", MAP),
    "tau.csv": ("tau.csv", MAP),
    "nodes.csv": ("nodes.csv", [["run-series", "nodes"]]),
    "r.csv": ("r.csv", [RUN]),
    "r.npz": ("r.npz", [["run-case", "npz"]]),
    "S_BW.csv": ("matrices/S_BW.csv", [["build-optics"]]),
    "S_BW.csv.toml": ("matrices/S_BW.csv.toml", [["build-optics"]]),
    "optics.npz": ("matrices/optics.npz", [["build-optics"]]),
    "optics.mat": ("matrices/optics.mat", [["build-optics"]]),
    "dynamics.toml": ("dynamics.toml", DYNAMICS),
    "magnetic.csv": ("magnetic.csv", DYNAMICS),
    "controller.npz": ("controller.npz", DYNAMICS),
    "body.stl": ("body.stl", [["build-sensitivity"]]),
    "adjoint.op2": ("adjoint.op2", [["build-adjoint", "--op2", "adjoint.op2"]]),
    "thermal.toml": ("thermal.toml", THERMAL),
    "loads.toml": ("loads.toml", [["build-loads", "-q"]]),
    "thermal_nodes.csv": ("thermal_nodes.csv", THERMAL),
    "thermal_conductors.csv": ("thermal_conductors.csv", THERMAL),
    "thermal_powers.csv": ("thermal_powers.csv", THERMAL),
    "bus.csv": ("bus.csv", THERMAL),
    "disturbances.csv": ("disturbances.csv", [["simulate-thermal", "disturbances.csv", "--json", "--top", "0"]]),
    "MODEL.TMD": ("MODEL.TMD", THERMAL),
    "balance.toml": ("balance.toml", [["balance"]]),
    "parts.csv": ("parts.csv", [["balance"]]),
    "measured.csv": ("measured.csv", [["balance", "--retrim", "measured.csv"]]),
    "TIMES.TMD": ("TIMES.TMD", [["run-series", "nodes"]]),
}
ARCHIVES = ("r.npz", "optics.npz", "optics.mat", "controller.npz", "MODEL.TMD", "TIMES.TMD")
LOOPS = ("dynamics.toml", "magnetic.csv", "controller.npz")
NETWORKS = (
    "thermal.toml", "thermal_nodes.csv", "thermal_conductors.csv", "thermal_powers.csv", "bus.csv", "disturbances.csv",
    "MODEL.TMD",
)  # fmt: skip
BALANCED = ("balance.toml", "parts.csv", "measured.csv")
#: What a kind needs in a configuration that it is not about: the file, a text in it, and what takes its place.
NAMED = {
    kind: ("optics.toml", "[frame]", f'[imported]\nS_BW = "matrices/{source}"\n\n[frame]')
    for kind, source in (
        ("S_BW.csv", "S_BW.csv"),
        ("S_BW.csv.toml", "S_BW.csv"),
        ("optics.npz", "optics.npz"),
        ("optics.mat", "optics.mat"),
    )
} | {
    "MODEL.TMD": ("thermal.toml", None, '[network]\ntmd = "MODEL.TMD"\n'),
    "TIMES.TMD": (
        "cases.toml",
        'file = "thermal.csv"\nweights = "nodes.csv"\nunit = "degC"',
        'file = "TIMES.TMD"\nweights = "numbers.csv"',
    ),
    "controller.npz": ("dynamics.toml", None, '[controller]\nfile = "controller.npz"\n'),
    "body.stl": ("model.toml", "side_m = 0.046", 'shape = "polyhedron"\nstl = "body.stl"\nstl_unit = "m"'),
}
#: Matrices of archives as results hold them.
_READ = {
    "r.npz": ("casenpz.h5", {"R": "/correlation/real"}),
    "optics.npz": ("optics.h5", {"S_BW": "/S_BW"}),
    "optics.mat": ("optics.h5", {"S_BW": "/S_BW"}),
    "MODEL.TMD": ("thermal.h5", {"T": "/steady_K", "C": "/node/capacity", "Q": "/node/power", "GL": "/conductor/GL"}),
}
#: Of tables, how many columns of labels stand before the numbers.
LABELS = {
    "budget.csv": 0, "spectra.csv": 0, "series.csv": 0, "points.csv": 0, "magnetic.csv": 0, "blocks.csv": 1, "r.csv": 1,
    "S_BW.csv": 2, "nodes.csv": 2, "thermal_conductors.csv": 2, "thermal_powers.csv": 1, "bus.csv": 0,
    "disturbances.csv": 0, "map.csv": 1, "tau.csv": 1, "parts.csv": 1, "measured.csv": 1,
}  # fmt: skip
Numbers = dict[str, np.ndarray]


def mutations_of(kind: str) -> dict[str, Mutation]:
    """The mutations of a kind of file, by name."""
    if kind == "adjoint.op2":
        return BINARY
    if kind.endswith(".TMD"):  # no archive with files in it
        return {name: mutation for name, mutation in USERS_BINARY.items() if name not in ("inside", "bomb")}
    return USERS_BINARY if kind in ARCHIVES else USERS_TEXT


class Users:
    """Projects with every kind of file, and the judge of what becomes of damage."""

    def __init__(self, folder: Path, kinds: tuple[str, ...] = tuple(READERS)) -> None:
        makers: dict[str, Callable[[Path], UserProject]] = {
            "bricks": bricks,
            "loop": loop,
            "network": network,
            "balanced": balanced,
        }
        wanted = {_home(kind) for kind in kinds}
        self.projects = {name: make(folder / name) for name, make in makers.items() if name in wanted}
        self.kept = {p: p.read_bytes() for project in self.projects.values() for p in project.build.glob("*.h5")}
        self.results: dict[str, Numbers] = {}
        for kind in kinds:
            with _Named(self.project(kind).folder, kind):
                code, found = self.numbers(kind)
                assert code == 0, (kind, found)
                assert isinstance(found, dict)
                self.results[kind] = found
                self.restore()

    def project(self, kind: str) -> UserProject:
        return self.projects[_home(kind)]

    def path(self, kind: str) -> Path:
        return self.project(kind).folder / READERS[kind][0]

    def restore(self) -> None:
        """Results as they were: what a mutant has made is no input of the next."""
        for project in self.projects.values():
            for path in set(project.build.iterdir()) - set(self.kept):
                path.unlink()
        for path, data in self.kept.items():
            if not path.exists() or path.read_bytes() != data:
                path.write_bytes(data)

    def judge(self, kind: str, number: int) -> Verdict:
        path = self.path(kind)
        table = mutations_of(kind)
        name = list(table)[number % len(table)]
        with _Named(self.project(kind).folder, kind):
            sound = path.read_bytes()
            data = table[name](Random(f"{kind} {number}"), sound)
            try:
                path.write_bytes(data)
                outcome, detail = self.outcome(kind, sound, data)
            finally:
                path.write_bytes(sound)
                self.restore()
        return Verdict(kind, number, name, outcome, detail)

    def outcome(self, kind: str, sound: bytes, data: bytes) -> tuple[str, str]:
        try:
            with warnings.catch_warnings(), limits():
                warnings.simplefilter("always")
                code, found = self.numbers(kind)
        except HangError:
            return "HANG", ""
        except MemoryError:
            return "MEMORY", traceback.format_exc()[-800:]
        if isinstance(found, Ran):
            problem = unclear(found) or self.nameless(kind, data, found.err)
            failure = "CRASH" if code == 1 or "internal" in found.err else "UNCLEAR"
            return (failure, f"{problem} [{found.err[:600]}]") if problem else (str(code), found.err)
        if code:
            return "SILENT", str(found)
        assert isinstance(found, dict)
        wanted = self.results[kind]
        if kind == "TIMES.TMD":
            return self.temperatures(found)
        if kind in ARCHIVES:
            return self.archive(kind, found)
        if kind == "adjoint.op2":
            return self.sums(kind, found)
        try:
            other = meaning(self.path(kind).name, data) != meaning(self.path(kind).name, sound)
        except (ValueError, csv.Error) as exc:
            return "SILENT", f"taken, where the standard library reads nothing: {exc}"
        if kind in LABELS and (fact := _no_table(meaning(kind, data), LABELS[kind])):
            return "SILENT", f"taken, where {fact}"
        if other:
            self.restore()
            self.path(kind).write_bytes(written(self.path(kind).name, data))
            code, again = self.numbers(kind)
            if code:
                return "SILENT", f"refused in plain writing: {again}"
            assert isinstance(again, dict)
            wanted = again
        differ = [k for k in sorted({*found, *wanted}) if not _equal(found.get(k), wanted.get(k))]
        if differ:
            return "SILENT", f"other numbers than {'in plain writing' if other else 'before'}: {', '.join(differ[:4])}"
        return ("meaning" if other else "same"), ""

    def nameless(self, kind: str, data: bytes, said: str) -> str:
        """What is wrong with the file that a refusal names: one of the project's, and itself where it cannot be read.

        What a readable file says, and another one contradicts, may be said of either.
        """
        try:
            broken = kind in (*ARCHIVES, "adjoint.op2") or not meaning(self.path(kind).name, data)
        except (ValueError, csv.Error):
            broken = True
        wanted = str(self.path(kind) if broken else self.project(kind).folder)
        return "" if wanted in said.splitlines()[0] else f"does not name {wanted}"

    def archive(self, kind: str, found: Numbers) -> tuple[str, str]:
        """Archives have checksums: the same numbers, or those that an independent reader finds in the file."""
        if all(_equal(found.get(k), v) for k, v in self.results[kind].items()):
            return "same", ""
        if kind not in _READ:
            return "SILENT", "other numbers"
        file, pairs = _READ[kind]
        for name, path in pairs.items():
            try:
                read = _independent(self.path(kind), name)
            except Exception as exc:
                return "SILENT", f"taken, where NumPy and SciPy read nothing: {exc}"
            if not _equal(read, found.get(f"{file}{path}")):
                return "SILENT", f"another {name} than in the archive"
        return "meaning", ""

    def temperatures(self, found: Numbers) -> tuple[str, str]:
        """Of temperatures over time the accelerations, as h5py and NumPy alone make them."""
        if all(_equal(found.get(k), v) for k, v in self.results["TIMES.TMD"].items()):
            return "same", ""
        project = self.project("TIMES.TMD")
        with h5py.File(project.folder / "TIMES.TMD") as file, h5py.File(project.build / "sensitivity.h5") as s:
            group = file["AnalysisSet1"]
            names = [word.strip(b"\0 ").decode() for word in group["thermalNodesRealAttributes"][()]]
            T = group["DataGroup1/thermalNodesRealData"][:, :, names.index("T")]
            of = dict(zip(group["thermalNodes"][:, 0].tolist(), (T - T.mean(axis=0)).T, strict=True))
            areas, S, labels = s["area/name"].asstr()[()].tolist(), s["S"][()], s["row/label"].asstr()[()]
        moved = np.zeros((len(areas), len(T)))
        for line in NUMBERED.split()[1:]:
            node, area, weight = line.split(",")
            moved[areas.index(area)] += float(weight) * of[int(node)]
        for label, row in zip(labels, S, strict=True):
            off = np.abs(found[f"series_nodes.h5/series/{label}"] - row @ moved).max()
            if not off <= 1e-9 * (np.abs(row) @ np.abs(moved).max(axis=1)) + 1e-30:
                return "SILENT", f"another {label} than of the temperatures in the file"
        return "meaning", ""

    def sums(self, kind: str, found: Numbers) -> tuple[str, str]:
        """An OP2 has no checksums: the sums are what single precision makes of those of the sound file."""
        wanted, name = self.results[kind], "adjoint.h5/area/sum"
        if all(_equal(found.get(k), v) for k, v in wanted.items()):
            return "same", ""
        block = wanted["adjoint.h5/check/block"]
        for row, one in enumerate(block):
            size = np.abs(wanted[name][block == one]).max()
            off = np.abs(found[name][row] - wanted[name][row]) / size
            if (off > 2.0 * wanted["adjoint.h5/check/allowed"][row]).any():
                return "SILENT", f"another sum of output {row}: {off.max():.2g}"
        return "rounding", ""

    def numbers(self, kind: str) -> tuple[int, Numbers | Ran | str]:
        """All numbers that the commands print and write; or the run that was refused; or what is none (code -1)."""
        project, commands = self.project(kind), READERS[kind][1]
        out: Numbers = {}
        for args in commands:
            stamps = {p: p.stat().st_mtime_ns for p in project.build.glob("*.h5")}
            ran = project.run(args)
            if ran.code or (ran.err and "warning: " not in ran.err):
                return ran.code or 1, ran
            files = [p for p in project.build.glob("*.h5") if stamps.get(p) != p.stat().st_mtime_ns]
            strange = [s for p in files for s in not_finite(p)]
            if re.search(r"\bnan\b|\binf\b", re.sub(r"\(inf\)|margin", "", ran.out)):
                strange.append("printed")
            if strange:
                return -1, f"{' '.join(args)}: not finite: {strange}"
            out[" ".join(args)] = np.array(re.findall(r"(?<![\w.])[-+]?\d+\.?\d*(?:e[-+]?\d+)?(?![\w.])", ran.out))
            for path in files:
                out |= _contents(path)
        return 0, out


class _Named:
    """Within it, the configuration names the file that a kind is about."""

    def __init__(self, folder: Path, kind: str) -> None:
        none: tuple[str | None, str | None, str] = (None, None, "")
        self.file, self.old, self.new = NAMED.get(kind, none)
        self.folder = folder

    def __enter__(self) -> None:
        if self.file is not None:
            self.path = self.folder / self.file
            self.kept = self.path.read_bytes()
            text = self.kept.decode("utf-8")
            new = self.new if self.old is None else text.replace(self.old, self.new, 1)
            self.path.write_text(new, encoding="utf-8")

    def __exit__(self, *_: object) -> None:
        if self.file is not None:
            self.path.write_bytes(self.kept)


def _no_table(rows: object, labels: int) -> str:
    """What makes the cells of a CSV no table of finite numbers, behind a head and its labels."""
    assert isinstance(rows, list)
    for row in rows[1:]:
        if len(row) != len(rows[0]):
            return f"a line has {len(row)} fields, and the head {len(rows[0])}"
        for cell in row[labels:] if row[0] != "unit" else []:
            try:
                sound = cmath.isfinite(complex(cell.replace(" ", "").replace("i", "j")))
            except ValueError:
                sound = False
            if not sound:
                return f"a number is {cell!r}"
    return ""


def _home(kind: str) -> str:
    homes = {"loop": LOOPS, "network": NETWORKS, "balanced": BALANCED}
    return next((home for home, kinds in homes.items() if kind in kinds), "bricks")


def unclear(ran: Ran) -> str:
    """What is wrong with a refusal: `error:` lines, then at most one `hint:`; several errors of configurations."""
    found = ran.err.splitlines()
    errors = [s for s in found if s.startswith("error: ")]
    hints = [s for s in found if s.startswith("hint: ")]
    if ran.code not in (2, 3, 4, 5) or not errors or found != errors + hints or len(hints) > 1:
        return f"exit code {ran.code}, lines of another kind"
    if len(errors) > 1 and ran.code != 3 and "optics.toml" not in ran.err:
        return "several errors"
    if "internal" in ran.err or any(len(s) > 1200 for s in errors):
        return "internal or endless"
    return "" if ran.err.isprintable() or all(s.isprintable() for s in found) else "control characters"


def _contents(path: Path) -> Numbers:
    """All numbers and words of a result but its provenance."""
    out: Numbers = {}

    def visit(name: str, item: object) -> None:
        if isinstance(item, h5py.Dataset) and not name.startswith("provenance/") and not is_scale_alone(item):
            out[f"{path.name}/{name}"] = item[()]

    with h5py.File(path) as file:
        file.visititems(visit)
    return out


def _independent(path: Path, name: str) -> np.ndarray:
    if path.suffix == ".TMD":
        return _of_tmd(path, name)
    if path.suffix == ".npz":
        with np.load(path, allow_pickle=False) as archive:
            return np.array(archive[name])
    from scipy.io import loadmat

    return np.asarray(loadmat(path, simplify_cells=True)[name]["value"])


def _of_tmd(path: Path, name: str) -> np.ndarray:
    """A quantity of the active nodes at the last time, or all conductances: linear ones first, those between active."""
    with h5py.File(path) as file:
        group = file["AnalysisSet1"]
        active = np.array([word[:1] != b"X" for word in group["DataGroup1/thermalNodesStringData"][-1, :, 0]])
        if name == "GL":
            ends = [group[f"conductors{kind}"][()] - 1 for kind in ("GL", "GR")]
            kept = [active[e[:, :2]].all(axis=1) & (e[:, 0] != e[:, 1]) for e in ends]
            return np.append(group["DataGroup1/conductorDataGL"][-1, kept[0], 0], np.zeros(kept[1].sum()))
        real = group["DataGroup1/thermalNodesRealData"][-1][active]
        names = [word.strip(b"\0 ").decode() for word in group["thermalNodesRealAttributes"][()]]
        if name == "T":
            return np.asarray(real[:, names.index("T")] + group.attrs["TAbs"])
        if name == "Q":
            return np.asarray(sum(real[:, names.index(q)] for q in ("QA", "QE", "QI", "QR", "QS") if q in names))
        boundary = group["DataGroup1/thermalNodesStringData"][-1, active, 0] == b"B"
        return np.where(boundary, 0.0, real[:, names.index("C")])


def _equal(a: np.ndarray | None, b: np.ndarray | None) -> bool:
    if a is None or b is None:
        return a is b
    a, b = np.asarray(a), np.asarray(b)
    return a.shape == b.shape and bool(np.array_equal(a, b, equal_nan=a.dtype.kind == b.dtype.kind == "f"))


def not_finite(path: Path) -> list[str]:
    """Datasets with numbers that are not finite, where the contract has finite ones."""
    out: list[str] = []
    with h5py.File(path) as file:
        kind = CONTRACTS[str(file.attrs["schema"]).removeprefix("tedm.")]
        allowed = {p for p, d in kind.datasets.items() if d.open_ended}

        def visit(name: str, item: object) -> None:
            if isinstance(item, h5py.Dataset) and item.dtype.kind == "f" and f"/{name}" not in allowed and item.size:
                values = item[()]
                if not is_scale_alone(item) and not np.isfinite(values).all():
                    out.append(f"{path.name}/{name}")

        file.visititems(visit)
    return out
