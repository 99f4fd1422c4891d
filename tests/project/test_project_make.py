"""Make, and `tedm run`, rebuild what depends on a change and nothing else: the real Makefile, on the small model."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "borders"))

from border_tools import heed_interrupts, tedm

ROOT = Path(__file__).parents[2]

CASES = ["1", "4b"]
"""Cases of the workshop, whose files are named in two ways; that all of them are asked for, a test below shows."""
NETWORK = "T"
"""Case of the thermal network, which the workshop has too."""
THERMAL = ("thermal.toml", *(f"thermal_{name}.csv" for name in ("nodes", "conductors", "powers", "elements")))

UNCERTAIN = """
[[uncertainty.material]]
name = "titanium"
material = 2
of = "expansion"
relative_sigma = 0.02
source = "cases wait for the adjoint then"
"""

pytestmark = pytest.mark.slow


def making(configs: Path, build: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """How Make ended on a project."""
    variables = [f"CONFIGS={configs}", f"BUILD={build}", f"VENV={sys.prefix}"]
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))}
    program = ["make", "--no-print-directory", *arguments, *variables]
    return subprocess.run(program, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)


def commands_in(said: str) -> list[str]:
    return [line.split()[1] for line in said.splitlines() if "/bin/tedm " in line]


class Workshop:
    """A project folder of its own with the small model, and Make on it."""

    def __init__(self, folder: Path) -> None:
        self.configs = folder / "configs"
        self.build = folder / "build"
        self.made = folder / "made"  # a copy of both as Make has left them
        self.configs.mkdir()
        small = ROOT / "sample_models" / "small"
        for name in (
            "tedm.toml",
            "model.toml",
            "ltp_small.bdf",
            "ltp_small_areas.csv",
            "unit_loads.bdf",
            "unit_loads.op2",
            *THERMAL,
        ):
            shutil.copy(small / name, self.configs)
        for name in ("optics.toml", "cases.toml"):
            shutil.copy(ROOT / "configs" / name, self.configs)
        cases = self.configs / "cases.toml"
        head, *tables = cases.read_text(encoding="utf-8").split("[[case]]")
        kept = [table for table in tables if re.search(rf'^id = "({"|".join([*CASES, NETWORK])})"$', table, re.M)]
        cases.write_text("[[case]]".join([head, *kept]), encoding="utf-8")
        with (self.configs / "model.toml").open("a", encoding="utf-8") as model:
            model.write(UNCERTAIN)
        project = (self.configs / "tedm.toml").read_text(encoding="utf-8")
        (self.configs / "tedm.toml").write_text(project.replace("../../configs/", ""), encoding="utf-8")

    def make(self, *arguments: str) -> list[str]:
        """The tedm subcommands that Make ran."""
        done = making(self.configs, self.build, *arguments)
        assert done.returncode == 0, done.stderr
        return commands_in(done.stdout)


@pytest.fixture(scope="module")
def workshop(tmp_path_factory: pytest.TempPathFactory) -> Workshop:
    if shutil.which("make") is None or not (Path(sys.prefix) / ".tedm-installed").exists():
        pytest.skip("needs make, and a virtual environment made by it")
    shop = Workshop(tmp_path_factory.mktemp("make"))
    commands = shop.make("-j2", "stages")
    assert commands.count("run-case") == len(CASES) + 1
    assert commands.count("simulate") == len(CASES) + 1
    assert commands.count("build-thermal") == 1
    assert set(commands) == {
        "make-rules",
        "ingest",
        "build-distortion",
        "build-sensitivity",
        "build-optics",
        "build-adjoint",
        "build-thermal",
        "run-case",
        "build-dynamics",
        "simulate",
        "plot",
        "report",
        "view",
    }
    for name in ("configs", "build"):
        shutil.copytree(shop.configs.parent / name, shop.made / name)
    return shop


def test_second_make_does_nothing(workshop: Workshop) -> None:
    assert (workshop.build / "report.html").exists()
    assert (workshop.build / "view.html").exists()
    assert workshop.make("stages") == []
    assert workshop.make("all") == []


def test_build_folder_is_up_to_date(workshop: Workshop) -> None:
    assert "stale" not in tedm("check", "-d", workshop.build).ok().out


def test_figures_wait_for_the_closed_loop_of_a_project_with_two_test_masses(tmp_path: Path) -> None:
    """The shipped sample, by what Make would run: figures and report are made of the simulations too."""
    if shutil.which("make") is None or not (Path(sys.prefix) / ".tedm-installed").exists():
        pytest.skip("needs make, and a virtual environment made by it")
    variables = [f"CONFIGS={ROOT / 'configs'}", f"BUILD={tmp_path / 'build'}", f"VENV={sys.prefix}"]
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))}
    done = subprocess.run(
        ["make", "--no-print-directory", "-n", "stages", *variables],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    commands = [line.split()[1] for line in done.stdout.splitlines() if "/bin/tedm " in line]
    assert commands.count("run-case") == 13
    assert commands.count("simulate") == 13
    assert commands.count("build-thermal") == 1
    assert commands[-3:] == ["plot", "report", "view"]
    assert commands.index("build-dynamics") < commands.index("simulate")


# --- make all: by the rules whether, in one run what -----------------------------------------------------------------


def test_all_runs_in_one_command_what_the_rules_find_stale(workshop: Workshop, tmp_path: Path) -> None:
    """In a copy the page is gone: it alone is made again, to the byte, and then nothing is."""
    shutil.copytree(workshop.made, tmp_path, dirs_exist_ok=True)
    configs, build = tmp_path / "configs", tmp_path / "build"
    (build / "view.html").rename(tmp_path / "view.html")
    done = making(configs, build, "all")
    assert done.returncode == 0, done.stderr
    assert commands_in(done.stdout) == ["run"]
    assert re.findall(r"(?m)^\[ *\d+/\d+\] (.+?):", done.stdout) == ["view"]
    assert (build / "view.html").read_bytes() == (tmp_path / "view.html").read_bytes()
    assert commands_in(making(configs, build, "all").stdout) == []


def test_all_says_what_a_stage_refuses_and_goes_on_from_there(workshop: Workshop, tmp_path: Path) -> None:
    shutil.copytree(workshop.made, tmp_path, dirs_exist_ok=True)
    configs, build = tmp_path / "configs", tmp_path / "build"
    page = (build / "view.html").read_bytes()
    (build / "view.html").unlink()
    (build / "view.html").mkdir()
    (build / "view.html" / "in_the_way").touch()
    os.utime(build / "view.html", (0, 0))  # older than the cases
    refused = making(configs, build, "all")
    assert refused.returncode == 2
    error, *_ = [line for line in refused.stderr.splitlines() if line.startswith("error: ")]
    assert str(build / "view.html") in error
    assert "Traceback" not in refused.stderr
    shutil.rmtree(build / "view.html")
    assert commands_in(making(configs, build, "all").stdout) == ["run"]
    assert (build / "view.html").read_bytes() == page


# --- tedm run: the same steps, and the same bytes --------------------------------------------------------------------


def words_of_make(configs: Path, build: Path) -> list[str]:
    """The commands that Make would run, without the options that name project and build folder."""
    tedm("make-rules", "-c", configs / "tedm.toml", "-d", build).ok()
    variables = [f"CONFIGS={configs}", f"BUILD={build}", f"VENV={sys.prefix}"]
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))}
    make = ["make", "--no-print-directory", "-n", "stages", *variables]
    done = subprocess.run(make, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return sorted(m[1] for m in re.finditer(r"(?m)^\S*/bin/tedm (.+?) -c ", done.stdout))


def steps_of_run(configs: Path, build: Path) -> dict[str, str]:
    """The commands that `tedm run` would run, and why."""
    lines = tedm("run", "-n", "-c", configs / "tedm.toml", "-d", build).ok().out.splitlines()
    return dict(re.split(r"  +", line, maxsplit=1) for line in lines[1:-1])


def touch(*names: str) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        for name in names:
            os.utime(folder / name)

    return change


def edit(name: str, old: str, new: str) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        text = (folder / name).read_text(encoding="utf-8")
        assert old in text
        (folder / name).write_text(text.replace(old, new, 1), encoding="utf-8")
        touch(name)(folder)

    return change


def remove(*names: str) -> Callable[[Path], None]:
    def change(folder: Path) -> None:
        for name in names:
            (folder / name).unlink()

    return change


def loop_left_out(folder: Path) -> None:
    """One test mass, and what is of the other left out: there is no drag-free loop."""
    path = folder / "configs" / "model.toml"
    text = path.read_text(encoding="utf-8")
    second = text.index('[[test_mass]]\nname = "TM2"')
    rest = text[text.index("[gravity]", second) :].replace(', TM2 = ["IS2"]', "")
    path.write_text(text[:second] + rest.replace('name = "lpf"', 'name = "lpf"\napplies_to = "single"'))
    touch("configs/model.toml")(folder)


def with_series(folder: Path) -> None:
    (folder / "configs" / "warm.csv").write_text("time_s,all\n0,1\n1,2\n", encoding="utf-8")
    table = '\n[[series]]\nname = "warm"\nfile = "warm.csv"\nremove = "mean"\n'
    edit("configs/cases.toml", "\n[frequency]", f"{table}\n[frequency]")(folder)


def without_network(folder: Path) -> None:
    """No thermal model, and no case of it."""
    edit("configs/tedm.toml", 'thermal = "thermal.toml"\n', "")(folder)
    cases = folder / "configs" / "cases.toml"
    text = cases.read_text(encoding="utf-8")
    cases.write_text(text[: text.index(f'[[case]]\nid = "{NETWORK}"')], encoding="utf-8")


def on_no_model(folder: Path) -> None:
    """A thermal model whose frequencies are its own, and which does not lie on the model; no case of it."""
    cases, thermal = (folder / "configs" / f"{name}.toml" for name in ("cases", "thermal"))
    text = cases.read_text(encoding="utf-8")
    cases.write_text(text[: text.index(f'[[case]]\nid = "{NETWORK}"')], encoding="utf-8")
    text = thermal.read_text(encoding="utf-8").split("[map]")[0]
    thermal.write_text(f"{text}[frequency]\nlist_hz = [1e-3]\n", encoding="utf-8")


def solved_here(folder: Path) -> None:
    for name in ("unit_loads.bdf", "unit_loads.op2"):
        edit("configs/model.toml", f'"{name}"', f'"{{build_dir}}/{name}"')(folder)


LAST = {"plot", "report", "view"}
OF_NETWORK = {f"run-case {NETWORK}", f"simulate {NETWORK}"}
NETWORK_RUN = {"build-thermal", *OF_NETWORK}
CASES_RUN = {*(f"run-case {c}" for c in CASES), *NETWORK_RUN}
LOOP = {"build-dynamics", *(f"simulate {c}" for c in (*CASES, NETWORK))}
JUDGED = CASES_RUN | LAST
ADJOINT = {"build-adjoint --or-say-why"}
FROM_OPTICS = {"build-optics", *ADJOINT, *LOOP, *JUDGED}
FROM_DISTORTION = {"build-distortion", "build-sensitivity", *FROM_OPTICS}
ALL = {"ingest", *FROM_DISTORTION}
#: What is done to a folder in which all is up to date; the commands that are run then; a reason that is given.
STATES: dict[str, tuple[Callable[[Path], None], set[str], str]] = {
    "nothing": (lambda _: None, set(), ""),
    "fresh": (lambda folder: shutil.rmtree(folder / "build"), ALL, "unit_loads.h5 is not there"),
    "cases touched": (touch("configs/cases.toml"), JUDGED | LOOP - {"build-dynamics"}, "cases.toml is newer"),
    "optics changed": (
        edit("configs/optics.toml", "wavelength_m = 1.064e-6", "wavelength_m = 1.063e-6"),
        FROM_DISTORTION,
        "optics.toml is newer",
    ),
    "frame moved": (
        edit("configs/optics.toml", "origin_m = [0.0, 0.0, 0.0]", "origin_m = [0.5, 1e-5, 0.5]"),
        ALL,
        "the symmetry plane has changed",
    ),
    "made by hand": (
        remove("build/halves", "build/symmetry_plane", "build/ties"),
        ALL,
        "no `tedm run` has run here yet",
    ),
    "deck touched": (touch("configs/unit_loads.bdf"), ALL, "unit_loads.bdf is newer"),
    "results touched": (touch("configs/unit_loads.op2"), ALL, "unit_loads.op2 is newer"),
    "areas touched": (touch("configs/ltp_small_areas.csv"), ALL, "ltp_small_areas.csv is newer"),
    "model touched": (touch("configs/model.toml"), ALL, "model.toml is newer"),
    "project touched": (touch("configs/tedm.toml"), ALL, "tedm.toml is newer"),
    "optics gone": (remove("build/optics.h5"), FROM_OPTICS, "optics.h5 is not there"),
    "the adjoint gone": (remove("build/adjoint.h5"), ADJOINT | JUDGED, "adjoint.h5 is rebuilt"),
    "the network gone": (remove("build/thermal.h5"), NETWORK_RUN | LAST, "thermal.h5 is rebuilt"),
    "its capacities touched": (touch("configs/thermal_nodes.csv"), NETWORK_RUN | LAST, "thermal_nodes.csv is newer"),
    "its model touched": (touch("configs/thermal.toml"), NETWORK_RUN | LAST, "thermal.toml is newer"),
    "a case gone": (remove("build/case01.h5"), {"run-case 1", *LAST}, "case01.h5 is rebuilt"),
    "the loop gone": (remove("build/dynamics.h5"), LOOP | LAST, "dynamics.h5 is rebuilt"),
    "figures gone": (remove("build/figures.stamp"), {"plot", "report"}, "the figures are not there"),
    "a sensitivity touched": (
        touch("build/sensitivity.h5"),
        ADJOINT | CASES_RUN | LOOP | LAST,
        "sensitivity.h5 is newer",
    ),
    "the page gone": (remove("build/view.html"), {"view"}, "view.html is not there"),
    "no loop": (loop_left_out, ALL - LOOP, "model.toml is newer"),
    "a series": (with_series, JUDGED | LOOP - {"build-dynamics"} | {"run-series warm", "simulate --series warm"}, ""),
    "no thermal model": (without_network, ALL - NETWORK_RUN, "tedm.toml is newer"),
    "a network without the model": (on_no_model, (JUDGED | LOOP) - {"build-dynamics", *OF_NETWORK}, ""),
    "solved here": (solved_here, ALL | {"write-deck", "solve"}, "unit_loads.bdf is not there"),
}


@pytest.mark.parametrize("state", STATES)
def test_tedm_run_would_run_what_make_would(workshop: Workshop, tmp_path: Path, state: str) -> None:
    change, commands, why = STATES[state]
    shutil.copytree(workshop.made, tmp_path, dirs_exist_ok=True)
    change(tmp_path)
    found = steps_of_run(tmp_path / "configs", tmp_path / "build")  # first: make-rules writes what both go by
    assert found.keys() == commands
    assert any(why in reasons for reasons in found.values()) or not why
    assert words_of_make(tmp_path / "configs", tmp_path / "build") == sorted(commands)


def test_contents_tell_what_times_do_not(workshop: Workshop, tmp_path: Path) -> None:
    """A file put back with an older date: Make sees nothing, the sums of the files made from it do."""
    shutil.copytree(workshop.made, tmp_path, dirs_exist_ok=True)
    edit("configs/cases.toml", "safety_factor = 2.0", "safety_factor = 3.0")(tmp_path)
    os.utime(tmp_path / "configs" / "cases.toml", (0, 0))
    found = steps_of_run(tmp_path / "configs", tmp_path / "build")
    assert "cases.toml has changed since" in found["run-case 1"]
    assert found.keys() == STATES["cases touched"][1]
    assert words_of_make(tmp_path / "configs", tmp_path / "build") == []


def test_tedm_run_killed_and_run_again_makes_the_bytes_of_make(workshop: Workshop, tmp_path: Path) -> None:
    """All files but figures and report, in the folder of Make's: files say by which command they were made."""
    theirs, ours = tmp_path / "make", workshop.build
    ours.rename(theirs)
    options = ["-c", str(workshop.configs / "tedm.toml"), "-d", str(ours)]
    program = [sys.executable, "-m", "tedm_cli.cli", "run", "view", "-j", "2", *options]
    try:
        with subprocess.Popen(
            program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heed_interrupts
        ) as process:
            while process.poll() is None and not (ours / "distortion.h5").exists():
                time.sleep(0.02)
            process.send_signal(signal.SIGTERM)
            _, said = process.communicate(timeout=60)
        assert process.returncode == 128 + signal.SIGTERM
        assert said == "error: interrupted; finished files are kept, the unfinished one is removed\n"
        assert not [path.name for path in ours.iterdir() if path.name.startswith(".")]
        done = tedm("run", "view", "-j", "2", *options).ok()
        tedm("run", "build-adjoint", *options).ok()
        began = re.findall(r"(?m)^\[ *\d+/\d+\] (.+?):", done.out)
        assert not {"ingest", "build-distortion"}.intersection(began)
        assert {"build-optics", "view", *CASES_RUN, *LOOP} <= set(began)
        for path in sorted(theirs.iterdir()):
            if path.suffix == ".h5" or path.name in ("view.html", "halves", "symmetry_plane"):
                assert (ours / path.name).read_bytes() == path.read_bytes(), path.name
        assert len(list(ours.glob("*.h5"))) == len(list(theirs.glob("*.h5")))
    finally:
        shutil.rmtree(ours, ignore_errors=True)
        theirs.rename(ours)
