"""Run what users write, damaged, through the commands that read it, and judge what came of it.

A verdict is `same` or `other` (exit code 0, all numbers finite), the exit code of one clear error, or a failure:
`CRASH`, `HANG`, `MEMORY`, `UNCLEAR`, `SILENT` (a result that is not finite). Archives have checksums: of them nothing
but the same matrix will do.
"""

from __future__ import annotations

import contextlib
import io
import re
import sys
import traceback
import warnings
from dataclasses import dataclass
from pathlib import Path
from random import Random
from unittest import mock

import h5py
import numpy as np
from fuzz_judge import HangError, Verdict, limits
from fuzz_model import CONFIGS, Case, fuzz_case
from fuzz_text import Mutation
from fuzz_users_text import USERS_BINARY, USERS_TEXT

from tedm_cli.cli import main
from tedm_cli.contracts import KINDS as CONTRACTS

CASES = """
[[requirement]]
name = "budget"
table = "budget.csv"
quantity = "acceleration"
outputs = ["TM1_a_x"]

[[temperature.override]]
areas = ["TIP"]
preset = "table"
table = "spectra.csv"

[realisation]
seed = 1
rate_hz = 0.5
lowest_hz = 1e-2
samples = 8000

[[series]]
name = "warm"
file = "series.csv"
remove = "linear"
lowest_hz = 0.02

[[case]]
id = "own"
title = "From a file"
matrix = "r.csv"
delays = [{ areas = ["TIP"], delay_s = 3.0 }]

[[case]]
id = "npz"
title = "From an archive"
matrix = "r.npz"
"""
BLOCKS = (
    "name,x_m,y_m,z_m,size_x_m,size_y_m,size_z_m,rotation_x_rad,rotation_y_rad,rotation_z_rad,mass_kg\n"
    "CM1,0.1,-0.2,0.0,0.02,0.03,0.04,0.1,0.2,0.3,0.5\nCM2,0.3,-0.2,0.1,0.02,0.03,0.04,0,0,0,1.5\n"
)
TEXTS = {
    "budget.csv": "frequency_hz,amplitude\n1e-3,1e-12\n5e-3,1e-12\n3e-2,1e-11\n",
    "spectra.csv": "frequency_hz,TIP\n1e-5,1e-2\n1e-3,1e-3\n1,1e-5\n",
    "r.csv": "area,ROOT,WAIST,TIP\nROOT,1,0.5,0.1-0.2j\nWAIST,0.5,1,0\nTIP,0.1+0.2j,0,1\n",
    "points.csv": "x_m,y_m,z_m,mass_kg\n0.5,0.1,0.2,3.0\n-0.4,0.3,0.1,2.5\n",
    "blocks.csv": BLOCKS,
}
RUN = ["run-case", "own"]
#: By kind: the file that is damaged, and the commands that read it.
READERS: dict[str, tuple[str, list[list[str]]]] = {
    "tedm.toml": ("tedm.toml", [["check-layout"]]),
    "model.toml": ("model.toml", [["ingest"], ["build-sensitivity"], ["self-gravity", "--points", "points.csv"]]),
    "optics.toml": ("optics.toml", [["check-layout"], ["build-distortion"], ["build-optics"]]),
    "cases.toml": ("cases.toml", [RUN, ["run-series", "all"]]),
    "areas.csv": ("areas.csv", [["areas"]]),
    "blocks.csv": ("blocks.csv", [["build-sensitivity"]]),
    "points.csv": ("points.csv", [["self-gravity", "--points", "points.csv", "--per-source"]]),
    "budget.csv": ("budget.csv", [RUN]),
    "spectra.csv": ("spectra.csv", [RUN]),
    "series.csv": ("series.csv", [["run-series", "warm"]]),
    "r.csv": ("r.csv", [RUN]),
    "r.npz": ("r.npz", [["run-case", "npz"]]),
    "S_BW.csv": ("matrices/S_BW.csv", [["build-optics"]]),
    "S_BW.csv.toml": ("matrices/S_BW.csv.toml", [["build-optics"]]),
    "optics.npz": ("matrices/optics.npz", [["build-optics"]]),
    "optics.mat": ("matrices/optics.mat", [["build-optics"]]),
}
ARCHIVES = ("r.npz", "optics.npz", "optics.mat")


def mutations_of(kind: str) -> dict[str, Mutation]:
    """The mutations of a kind of file, by name."""
    return USERS_BINARY if kind in ARCHIVES else USERS_TEXT


@dataclass(frozen=True)
class Ran:
    code: int
    out: str
    err: str


def command(*args: object) -> Ran:
    out, err = io.StringIO(), io.StringIO()
    argv = ["tedm", *(str(a) for a in args)]
    with mock.patch.object(sys, "argv", argv), contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            main()
        except SystemExit as exc:
            return Ran(exc.code if isinstance(exc.code, int) else 0, out.getvalue(), err.getvalue())
    return Ran(0, out.getvalue(), err.getvalue())


class Users:
    """A project with every kind of file, and the judge of what becomes of damage."""

    def __init__(self, folder: Path) -> None:
        self.case: Case = fuzz_case(folder / "fuzz")
        self.folder, self.build = self.case.folder, self.case.project.build_dir
        cases = (CONFIGS / "cases.toml").read_text(encoding="utf-8")
        cases = cases[: cases.index("# A requirement of your own")].replace("points = 301", "points = 31")
        first = '\n[[case]]\nid = "1"\ntitle = "All"\nblocks = [{ areas = ["*"], rho = 0.5 }]\n'
        (self.folder / "cases.toml").write_text(re.sub(r"(?s)\[\[requirement\]\].*", "", cases) + CASES + first)
        for name, text in TEXTS.items():
            (self.folder / name).write_text(text)
        rows = "".join(f"{2.0 * n},{293.0 + 0.01 * np.sin(n):.6f},{293.0 + 1e-4 * n:.6f}\n" for n in range(900))
        (self.folder / "series.csv").write_text("time_s,TIP,all\n" + rows)
        R = np.array([[1.0, 0.5, 0.0], [0.5, 1.0, 0.2], [0.0, 0.2, 1.0]])
        np.savez_compressed(self.folder / "r.npz", area=np.array(["ROOT", "WAIST", "TIP"]), R=R)
        model = self.folder / "model.toml"
        model.write_text(model.read_text() + '\n[gravity]\ncompensation_masses = "blocks.csv"\n')
        for args in (["ingest"], ["build-distortion"], ["build-sensitivity"], ["build-optics"]):
            self.sound(args)
        for fmt in ("csv", "npz", "mat"):
            self.sound(["export", "--format", fmt, "-o", str(self.folder / "matrices")], config=False)
        self.layout = (self.folder / "optics.toml").read_bytes()
        self.kept = {p: p.read_bytes() for p in self.build.iterdir()}
        self.results = {}
        for kind, (_, commands) in READERS.items():
            self.use(kind)
            self.results[kind] = [self.sound(args) for args in commands]
            self.restore()

    def sound(self, args: list[str], config: bool = True) -> dict[str, bytes]:
        ran = self.run(args, config)
        assert ran.code == 0, (args, ran.err)
        return self.contents()

    def run(self, args: list[str], config: bool = True) -> Ran:
        args = [str(self.folder / a) if a.endswith(".csv") else a for a in args]
        project = ["-c", self.folder / "tedm.toml"] if config else []
        return command(*args, *project, *([] if args[0] == "self-gravity" else ["-d", self.build]))

    def use(self, kind: str) -> None:
        """Let the layout name the matrices that this kind is about."""
        source = {
            "S_BW.csv": "S_BW.csv",
            "S_BW.csv.toml": "S_BW.csv",
            "optics.npz": "optics.npz",
            "optics.mat": "optics.mat",
        }
        text = self.layout
        if kind in source:
            text = text.replace(b"[frame]", f'[imported]\nS_BW = "matrices/{source[kind]}"\n\n[frame]'.encode(), 1)
        (self.folder / "optics.toml").write_bytes(text)

    def restore(self) -> None:
        """Results as they were: what a mutant has made is no input of the next."""
        for path in set(self.build.iterdir()) - set(self.kept):
            path.unlink()
        for path, data in self.kept.items():
            if path.read_bytes() != data:
                path.write_bytes(data)

    def contents(self) -> dict[str, bytes]:
        """Bytes of the matrices that were read, as results hold them."""
        out = {}
        for name, paths in (("optics.h5", ("/S_BW",)), ("casenpz.h5", ("/correlation/real",))):
            if (self.build / name).exists():
                with h5py.File(self.build / name) as file:
                    out |= {f"{name}{p}": file[p][()].tobytes() for p in paths}
        return out

    def judge(self, kind: str, number: int) -> Verdict:
        file, commands = READERS[kind]
        self.use(kind)
        path = self.folder / file
        sound = path.read_bytes()
        table = mutations_of(kind)
        name = list(table)[number % len(table)]
        data = table[name](Random(f"{kind} {number}"), sound)
        path.write_bytes(data)
        try:
            outcome, detail = self.outcome(kind, commands)
        finally:
            path.write_bytes(sound)
            self.restore()
        return Verdict(kind, number, name, outcome, detail)

    def outcome(self, kind: str, commands: list[list[str]]) -> tuple[str, str]:
        for args in commands:
            stamps = {p: p.stat().st_mtime_ns for p in self.build.glob("*.h5")}
            try:
                with warnings.catch_warnings(), limits():
                    warnings.simplefilter("always")
                    ran = self.run(args)
            except HangError:
                return "HANG", " ".join(args)
            except MemoryError:
                return "MEMORY", traceback.format_exc()[-800:]
            if ran.code:
                problem = unclear(ran)
                kind_of = "CRASH" if ran.code == 1 or "internal" in ran.err else "UNCLEAR"
                return (kind_of, f"{problem} [{ran.err[:600]}]") if problem else (str(ran.code), ran.err)
            if ran.err and "warning: " not in ran.err:
                return "UNCLEAR", f"exit code 0, but {ran.err[:600]!r}"
            written = [p for p in self.build.glob("*.h5") if stamps.get(p) != p.stat().st_mtime_ns]
            strange = [s for p in written for s in not_finite(p)]
            if re.search(r"\bnan\b|\binf\b", re.sub(r"\(inf\)|margin", "", ran.out)):
                strange.append("printed")
            if strange:
                return "SILENT", f"{' '.join(args)}: {strange}"
        same = self.contents().items() >= self.results[kind][-1].items()
        if kind in ARCHIVES and not same:
            return "SILENT", "another matrix"
        return ("same" if same else "other"), ""


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


def not_finite(path: Path) -> list[str]:
    """Datasets with numbers that are not finite, where the contract has finite ones."""
    out: list[str] = []
    with h5py.File(path) as file:
        kind = CONTRACTS[str(file.attrs["schema"]).removeprefix("tedm.")]
        allowed = {p for p, d in kind.datasets.items() if d.open_ended}

        def visit(name: str, item: object) -> None:
            if isinstance(item, h5py.Dataset) and item.dtype.kind == "f" and f"/{name}" not in allowed and item.size:
                values = item[()]
                if not name.startswith("n_") and not np.isfinite(values).all():
                    out.append(f"{path.name}/{name}")

        file.visititems(visit)
    return out
