"""Projects with one half of the chain: self-gravity without optics, read-outs without test masses in the model.

On the small model, with a case of mirror pairs and a temperature series; the other half is nowhere.
"""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "borders"))

from border_tools import CONFIGS, SMALL, Outcome, edited, tedm, untouched
from typer.main import get_command

from tedm_cli.cli.commands import app
from tedm_cli.config.project import load_project
from tedm_cli.contracts import CASE, DISTORTION, OPTICS, SENSITIVITY, SERIES, FileKind
from tedm_cli.errors import InputError
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.progress import silent
from tedm_cli.results.wording import GRAVITY_ALONE, READ_OUT_ALONE
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.noise.case import run_cases
from tedm_cli.stages.noise.series import run_series
from tedm_cli.stages.optics.build import build_optics

ROOT = Path(__file__).parents[2]
GRAVITY, READ_OUT = "gravity", "read_out"
HALVES = (GRAVITY, READ_OUT)
COMMANDS = sorted(n for n, c in get_command(app).commands.items() if not c.hidden)  # type: ignore[attr-defined]
HEAD = '[frequency]\npoints = 21\n\n[[series]]\nname = "warm"\nfile = "warm.csv"\nremove = "mean"\nlowest_hz = 5e-3\n\n'
CASE_TABLES = """
[[case]]
id = "3"
title = "Shield between two worlds"
role = "likely"
blocks = [{ shield = ["inside"] }, { shield = ["outside"], partition = "mirror" }]
"""
REQUIREMENT = {
    GRAVITY: '[[requirement]]\nname = "lpf_selfgravity_ltp"\noutputs = ["TM1_a_x"]\n',
    READ_OUT: '[[requirement]]\nname = "lpf_readout_item"\noutputs = ["A_TM1_x", "B_TM2_x"]\n',
}
pytestmark = pytest.mark.slow


@dataclass(frozen=True)
class Half:
    """A project in a folder of its own, and the subcommands that Make ran to build it."""

    folder: Path
    commands: tuple[str, ...] = ()

    @property
    def build(self) -> Path:
        return self.folder / "build"

    @property
    def arguments(self) -> tuple[str, str, str, str]:
        return "-c", str(self.folder / "tedm.toml"), "-d", str(self.build)

    def run(self, command: str, *arguments: object) -> Outcome:
        return tedm(command, *arguments, *self.arguments)

    def make(self, *arguments: str) -> list[str]:
        """The subcommands that Make ran, or with -n would run."""
        variables = [f"CONFIGS={self.folder}", f"BUILD={self.build}", f"VENV={sys.prefix}"]
        environment = {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))}
        make = ["make", "--no-print-directory", *arguments, *variables]
        done = subprocess.run(make, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return [line.split()[1] for line in done.stdout.splitlines() if "/bin/tedm " in line]

    def copy(self, folder: Path) -> Half:
        shutil.copytree(self.folder, folder)
        return Half(folder)


def described(folder: Path, *halves: str) -> Half:
    """A project with these halves; its unit loads lie beside it, as a solver left them."""
    folder.mkdir()
    for name in ("ltp_small.bdf", "ltp_small_areas.csv", "unit_loads.bdf", "unit_loads.op2"):
        shutil.copy(SMALL / name, folder)
    model = (SMALL / "model.toml").read_text(encoding="utf-8")
    if GRAVITY not in halves:
        model = model.partition("[[test_mass]]")[0]
    if READ_OUT in halves:
        shutil.copy(CONFIGS / "optics.toml", folder)
    requirements = "".join(REQUIREMENT[half] for half in halves)
    (folder / "model.toml").write_text(model, encoding="utf-8")
    (folder / "cases.toml").write_text(f"{HEAD}{requirements}{CASE_TABLES}", encoding="utf-8")
    (folder / "tedm.toml").write_text('title = "half a chain"\n', encoding="utf-8")
    rows = [f"{5 * n},{1e-3 * np.sin(0.1 * n) + 1e-4 * np.cos(1.7 * n * n):.9e}" for n in range(4000)]
    (folder / "warm.csv").write_text("\n".join(["time_s,all", *rows, ""]), encoding="utf-8")
    return Half(folder)


@pytest.fixture(scope="module")
def halves(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Half]:
    """Both, built by the commands that Make names, in this process. Not to be changed: copy them."""
    if shutil.which("make") is None or not (Path(sys.prefix) / ".tedm-installed").exists():
        pytest.skip("needs make, and a virtual environment made by it")
    folder, found = tmp_path_factory.mktemp("halves"), {}
    for half in HALVES:
        project = described(folder / half, half)
        commands = project.make("-n", "stages")  # make-rules is run by this already
        for command in commands:
            if command != "make-rules":
                project.run(command, *{"run-case": ("3",), "run-series": ("warm",)}.get(command, ())).ok()
            if command == "plot":
                (project.build / "figures.stamp").touch()
        if half == GRAVITY:
            project.run("build-sensitivity", "--partial", project.folder / "unit_loads.op2").ok()
        found[half] = Half(project.folder, tuple(commands))
    return found


@pytest.fixture(scope="module")
def whole(halves: dict[str, Half], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The build folder of the same project with both halves, from the same unit loads."""
    made = described(tmp_path_factory.mktemp("whole") / "both", *HALVES)
    made.build.mkdir()
    shutil.copy(halves[GRAVITY].build / "unit_loads.h5", made.build)
    project = load_project(made.folder / "tedm.toml", made.build)
    build_distortion(project, None, silent)
    build_sensitivity(project, None, silent)
    build_optics(project, None)
    run_cases(project, ["3"], None, silent)
    run_series(project, ["warm"], None, silent)
    return made.build


@pytest.mark.parametrize("half", HALVES)
def test_make_and_run_build_what_there_is(halves: dict[str, Half], half: str, tmp_path: Path) -> None:
    matrices = {GRAVITY: ["build-sensitivity", "build-adjoint"], READ_OUT: ["build-optics"]}[half]
    made = ["make-rules", "ingest", "build-distortion", *matrices, "run-case", "run-series"]
    assert sorted(halves[half].commands) == sorted([*made, "plot", "report", "view"])
    assert halves[half].make("all") == []
    assert "all is up to date" in halves[half].run("run", "-n").ok().out
    fresh = tedm("run", "-n", *halves[half].arguments[:2], "-d", tmp_path).ok().out.splitlines()[1:-1]
    assert sorted(line.split()[0] for line in fresh) == sorted({*halves[half].commands} - {"make-rules"})
    files = {path.name for path in halves[half].build.glob("*.h5")}
    own = {GRAVITY: ("sensitivity.h5", "adjoint.h5", "partial_unit_loads.h5"), READ_OUT: ("optics.h5",)}[half]
    assert files == {"unit_loads.h5", "distortion.h5", *own, "case03.h5", "series_warm.h5"}


@contextlib.contextmanager
def both(build: Path, whole: Path, name: str, kind: FileKind) -> Iterator[tuple[Reader, Reader]]:
    """The file of the half, and that of the whole chain."""
    with open_checked(build / name, kind) as one, open_checked(whole / name, kind) as two:
        yield one, two


def same_arrays(one: Reader, two: Reader, paths: list[str]) -> None:
    for path in paths:
        assert one.array(path).tobytes() == two.array(path).tobytes(), path


def test_gravity_alone_is_that_of_the_whole_chain(halves: dict[str, Half], whole: Path) -> None:
    """To the bit: [D], S_SG, and the field at rest; optics are in no file, not even as nothing."""
    build = halves[GRAVITY].build
    with both(build, whole, "sensitivity.h5", SENSITIVITY) as (half, all_of_it):
        same_arrays(half, all_of_it, [SENSITIVITY.S, SENSITIVITY.DC_ACCELERATION, SENSITIVITY.STIFFNESS_LINEARISED])
        assert np.abs(half.array(SENSITIVITY.S)).max() > 0.0
    with both(build, whole, "distortion.h5", DISTORTION) as (half, all_of_it):
        same_arrays(half, all_of_it, [DISTORTION.D_TRANSLATION, DISTORTION.D_ROTATION, DISTORTION.AREA_CENTROID])
        places = ("/optical/", "/D_opt/", "/check/superposition_optics")
        optical = [path for path in DISTORTION.datasets if path.startswith(places)]
        assert len(optical) == 7
        assert not [path for path in optical if half.has(path)]
        assert all(all_of_it.has(path) for path in optical)


def test_read_out_alone_is_that_of_the_whole_chain(halves: dict[str, Half], whole: Path) -> None:
    with both(halves[READ_OUT].build, whole, "optics.h5", OPTICS) as (half, all_of_it):
        same_arrays(half, all_of_it, [OPTICS.S_BW, OPTICS.D, *(OPTICS.N.of(name) for name in "AB")])
        assert np.abs(half.array(OPTICS.N.of("A"))).max() > 0.0


@pytest.mark.parametrize("half", HALVES)
def test_spectra_are_those_of_the_whole_chain(halves: dict[str, Half], whole: Path, half: str) -> None:
    """Of the outputs that there are: of a case, whose mirror pairs are found by the areas' places, and of a series."""
    with both(halves[half].build, whole, "case03.h5", CASE) as (one, two):
        labels, kinds = one.strings(CASE.OUTPUT_LABEL), one.strings(CASE.OUTPUT_KIND)
        assert labels == [x for x in two.strings(CASE.OUTPUT_LABEL) if x.startswith("TM") == (half == GRAVITY)]
        assert all(("acceleration" in kind) == (half == GRAVITY) for kind in kinds)
        # The grid holds the band edges of all requirements, so that of the whole chain may have more.
        at = np.isin(two.array(CASE.FREQUENCY), one.array(CASE.FREQUENCY))
        assert at.sum() == len(one.array(CASE.FREQUENCY))
        for label in labels:
            psd = one.array(CASE.PSD.of(label))
            assert psd.max() > 0.0
            assert psd.tobytes() == two.array(CASE.PSD.of(label))[at].tobytes(), label
        assert one.has(CASE.PATH_NAME) == (half == READ_OUT)
        ratios = one.array(CASE.VERDICT_RATIO).tolist()
        assert ratios
        assert set(ratios) <= set(two.array(CASE.VERDICT_RATIO).tolist())
    with both(halves[half].build, whole, "series_warm.h5", SERIES) as (one, two):
        for label in one.strings(SERIES.OUTPUT_LABEL):
            np.testing.assert_allclose(one.array(SERIES.PSD.of(label)), two.array(SERIES.PSD.of(label)), rtol=1e-9)


#: What each command is told, beside the project.
ARGUMENTS: dict[str, tuple[str, ...]] = {
    **{
        name: ("-o", "{out}/file.h5")
        for name in ("ingest", "build-distortion", "build-sensitivity", "build-optics", "build-adjoint")
    },
    "build-loads": ("-o", "{out}/file.h5"),
    "merge": ("-o", "{out}"),
    "reduce": ("--interface", "850001", "--part", "800101", "-o", "{out}/part.op4"),
    "areas": (),
    "write-deck": ("-o", "{out}/deck.bdf"),
    "solve": ("-o", "{out}/loads.op2"),
    "balance": (),
    "audit-mesh": (),
    "self-gravity": ("--points", "{out}/points.csv"),
    "accuracy": ("8.1", "-o", "{out}"),
    "check-layout": (),
    "explain": ("TM1_x",),
    "suggest-areas": ("--count", "20", "-o", "{out}/areas.csv"),
    "run-case": ("3", "-o", "{out}/case.h5"),
    "run-series": ("warm", "-o", "{out}/series.h5"),
    "build-dynamics": (),
    "simulate": ("3",),
    "build-thermal": (),
    "map-temperatures": ("{out}/points.csv", "-o", "{out}/grids.csv"),
    "simulate-thermal": ("--duration", "1e5", "-o", "{out}/nodes.csv"),
    "plot": ("--area", "STRUT_1", "-o", "{out}"),
    "report": ("--format", "md", "-o", "{out}/report.md"),
    "view": ("-o", "{out}/view.html"),
    "export-state-space": ("3", "-o", "{out}"),
    "run": ("-n",),
}
_TRADE = '[[variant]]\nname = "half"\nproject = "{folder}"\n[[criterion]]\nname = "m"\nkind = "mass"\n'
OF_THE_FOLDER: dict[str, tuple[str, ...]] = {
    "init": ("{out}/new",),
    "check": ("-d", "{build}"),
    "trade": ("{out}/variants.toml", "-d", "{out}"),
    "show": ("{build}/case03.h5",),
    "export": ("-d", "{build}", "-o", "{out}"),
    "export-case": ("-d", "{build}", "-o", "{out}"),
    "export-extremal": ("3", "-d", "{build}", "-o", "{out}"),
    "export-vtu": ("-d", "{build}", "-o", "{out}/mesh.vtu"),
}
NOT_NAMED = {
    "balance": "the project does not say where compensation masses may be",
    "build-loads": "the project has no loads but temperatures",
    "build-thermal": "the project has no thermal model",
    "map-temperatures": "the project has no thermal model",
    "simulate-thermal": "the project has no thermal model",
}
NO_OPTICS, NO_MASSES = "tedm.toml: optics: the project has no optics", "model.toml: test_mass: "
REFUSED = {
    GRAVITY: NOT_NAMED
    | dict.fromkeys(("check-layout", "build-optics", "explain", "build-dynamics", "simulate", "plot"), NO_OPTICS),
    READ_OUT: NOT_NAMED
    | dict.fromkeys(
        (
            "build-sensitivity",
            "merge",
            "audit-mesh",
            "self-gravity",
            "accuracy",
            "build-adjoint",
            "suggest-areas",
            "build-dynamics",
            "simulate",
        ),
        NO_MASSES,
    ),
}


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("half", HALVES)
def test_every_command(halves: dict[str, Half], half: str, command: str, tmp_path: Path) -> None:
    """Each does what it can, or says in one error what the project lacks, and leaves nothing behind."""
    project = halves[half]
    if command in project.commands and command not in REFUSED[half]:
        return  # the project was built by it
    (tmp_path / "points.csv").write_text("x_m,y_m,z_m,mass_kg\n1.0,0.0,0.0,3.0\n", encoding="utf-8")
    (tmp_path / "variants.toml").write_text(_TRADE.format(folder=project.folder), encoding="utf-8")
    given = ARGUMENTS[command] if command in ARGUMENTS else OF_THE_FOLDER[command]
    words = [word.format(out=tmp_path, build=project.build) for word in given]
    with untouched(project.folder):
        where = project.arguments[: 2 if command == "self-gravity" else 4] if command in ARGUMENTS else ()
        outcome = tedm(command, *words, *where)
        if command in REFUSED[half]:
            outcome.refused(3, REFUSED[half][command])
        else:
            outcome.ok()
            assert "Traceback" not in outcome.err


def test_without_test_masses_there_is_no_adjoint_and_no_advice_to_make_one(halves: dict[str, Half]) -> None:
    for command in (("build-adjoint",), ("suggest-areas", "--count", "20"), ("explain", "A_TM1_x", "--grids")):
        outcome = tedm(*command, *halves[READ_OUT].arguments)
        outcome.refused(3, NO_MASSES, "the adjoint, also that of read-outs, is of projects that have")
        assert "make it with" not in outcome.err


@pytest.mark.parametrize("half", HALVES)
def test_report_and_page_say_what_is_not_there(halves: dict[str, Half], half: str) -> None:
    build = halves[half].build
    said, loop = {
        GRAVITY: (GRAVITY_ALONE, "without optics there is no loop."),
        READ_OUT: (READ_OUT_ALONE, "needs two test masses; without them there is no loop."),
    }[half]
    for name in ("report.md", "report_annex.md"):
        text = (build / name).read_text(encoding="utf-8")
        assert said in text
        assert loop in text
        assert ("field at rest" in text.replace(said, "")) == (half == GRAVITY)
        other = {GRAVITY: r"read-out|bench|optical", READ_OUT: r"S_SG|at rest|self-gravity"}[half]
        body = text.replace(said, "").replace(loop, "").partition("## Provenance")[0]
        lines = [line for line in body.splitlines() if re.search(other, line) and "needs the read-outs" not in line]
        assert lines == []
    for name in ("report.html", "report_annex.html", "view.html"):
        assert said in (build / name).read_text(encoding="utf-8")
    figures = {path.name for path in (build / "figures").iterdir()}
    assert ("field_at_rest.svg" in figures) == (half == GRAVITY)
    assert ("bench.svg" in figures) == (half == READ_OUT)


@pytest.mark.parametrize("half", HALVES)
def test_requirements_on_the_half_that_is_not_there(halves: dict[str, Half], half: str, tmp_path: Path) -> None:
    """Refused by make-rules already, before anything is solved, and by what judges; never passed over."""
    project = halves[half].copy(tmp_path / "p")
    other = READ_OUT if half == GRAVITY else GRAVITY
    (project.folder / "cases.toml").write_text(f"{HEAD}{REQUIREMENT[half]}{REQUIREMENT[other]}{CASE_TABLES}")
    name, why = {
        GRAVITY: ("lpf_readout_item judges read-outs (A_TM1_x, B_TM2_x)", "no optics"),
        READ_OUT: ("lpf_selfgravity_ltp judges accelerations (TM1_a_x)", "no test masses"),
    }[half]
    for command in (["make-rules"], ["run-case", "3"], ["run-series", "warm"]):
        with untouched(project.folder):
            outcome = project.run(*command)
            outcome.refused(3, f"cases.toml: requirement[1]: {name}, and the project has {why}", hint="take these requ")


def test_neither_half(tmp_path: Path) -> None:
    project = described(tmp_path / "none")
    for command in (["make-rules"], ["run-case", "3"], ["plot"], ["report"], ["view"], ["export-state-space", "3"]):
        project.run(*command).refused(3, "tedm.toml: the project has no test masses", "and no optics")


def test_a_half_that_is_gone_and_comes_again(halves: dict[str, Half], whole: Path, tmp_path: Path) -> None:
    """Make does again what was made of both, and what lies there of both is not taken for what there is."""
    project = halves[GRAVITY].copy(tmp_path / "p")
    shutil.copy(CONFIGS / "optics.toml", project.folder)
    again = {
        "build-distortion",
        "build-sensitivity",
        "build-adjoint",
        "run-case",
        "run-series",
        "plot",
        "report",
        "view",
    }
    assert set(project.make("-n", "stages")) == again | {"make-rules", "build-optics", "build-dynamics", "simulate"}
    assert project.make("-n", "stages").count("simulate") == 2  # the case and the series
    (project.folder / "optics.toml").unlink()
    assert set(project.make("-n", "stages")) == again | {"make-rules"}
    shutil.copy(CONFIGS / "optics.toml", project.folder)
    for name in ("distortion.h5", "sensitivity.h5", "optics.h5"):
        shutil.copy(whole / name, project.build)
    (project.build / "adjoint.h5").unlink()  # of the half
    project.run("run-case", "3").ok()
    (project.folder / "optics.toml").unlink()
    with untouched(project.folder):
        project.run("plot").refused(
            4, "case03.h5: is stale: made from optics.h5, which is no part of the project any more"
        )


def test_elements_without_their_motion_are_refused(whole: Path, tmp_path: Path) -> None:
    """The optics are in distortion.h5 or not; a part of them is damage."""
    path = tmp_path / "distortion.h5"
    shutil.copy(whole / "distortion.h5", path)
    with edited(path) as file:
        del file["D_opt"]
    refused = pytest.raises(InputError, match="has no /D_opt/translation, but others of its group")
    with refused, open_checked(path, DISTORTION):
        pass


def test_subsystems_without_test_masses_are_refused(tmp_path: Path) -> None:
    project = described(tmp_path / "p", READ_OUT)
    with open(project.folder / "model.toml", "a", encoding="utf-8") as stream:
        stream.write('[gravity.subsystems]\nIS = { TM1 = ["IS1"] }\n[[requirement_at_rest]]\nname = "lpf"\n')
    fact = "the model has no [[test_mass]] whose field at rest there could be"
    project.run("make-rules").refused(3, f"gravity.subsystems: {fact}", f"requirement_at_rest: {fact}")
