"""Make rebuilds what depends on a change and nothing else. Runs the real Makefile on the small model."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]

CASES = ["1", "4b"]
"""Cases of the workshop, whose files are named in two ways; that all twelve are asked for, the last test shows."""

pytestmark = pytest.mark.slow


class Workshop:
    """A project folder of its own with the small model, and Make on it."""

    def __init__(self, folder: Path) -> None:
        self.configs = folder / "configs"
        self.build = folder / "build"
        self.configs.mkdir()
        small = ROOT / "sample_models" / "small"
        for name in (
            "tedm.toml",
            "model.toml",
            "ltp_small.bdf",
            "ltp_small_areas.csv",
            "unit_loads.bdf",
            "unit_loads.op2",
        ):
            shutil.copy(small / name, self.configs)
        for name in ("optics.toml", "cases.toml"):
            shutil.copy(ROOT / "configs" / name, self.configs)
        cases = self.configs / "cases.toml"
        head, *tables = cases.read_text(encoding="utf-8").split("[[case]]")
        kept = [table for table in tables if re.search(rf'^id = "({"|".join(CASES)})"$', table, re.M)]
        cases.write_text("[[case]]".join([head, *kept]), encoding="utf-8")
        project = (self.configs / "tedm.toml").read_text(encoding="utf-8")
        (self.configs / "tedm.toml").write_text(project.replace("../../configs/", ""), encoding="utf-8")

    def make(self, *arguments: str) -> list[str]:
        """The tedm subcommands that Make ran."""
        variables = [f"CONFIGS={self.configs}", f"BUILD={self.build}", f"VENV={sys.prefix}"]
        environment = {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))}
        done = subprocess.run(
            ["make", "--no-print-directory", *arguments, *variables],
            cwd=ROOT,
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        lines = [line.split() for line in done.stdout.splitlines() if "/bin/tedm " in line]
        return [words[1] for words in lines]


@pytest.fixture(scope="module")
def workshop(tmp_path_factory: pytest.TempPathFactory) -> Workshop:
    if shutil.which("make") is None or not (Path(sys.prefix) / ".tedm-installed").exists():
        pytest.skip("needs make, and a virtual environment made by it")
    shop = Workshop(tmp_path_factory.mktemp("make"))
    commands = shop.make("-j2", "all")
    assert commands.count("run-case") == commands.count("simulate") == len(CASES)
    assert set(commands) == {
        "make-rules",
        "ingest",
        "build-distortion",
        "build-sensitivity",
        "build-optics",
        "run-case",
        "build-dynamics",
        "simulate",
        "plot",
        "report",
        "view",
    }
    return shop


def test_second_make_does_nothing(workshop: Workshop) -> None:
    assert (workshop.build / "report.html").exists()
    assert (workshop.build / "view.html").exists()
    assert workshop.make("all") == []


def test_touching_the_cases_reruns_cases_plots_report_and_view(workshop: Workshop) -> None:
    """The last three by what Make would run."""
    (workshop.configs / "cases.toml").touch()
    assert workshop.make(str(workshop.build / "rules.mk")) == ["make-rules"]
    assert set(workshop.make("-n", "all")) == {"run-case", "simulate", "plot", "report", "view"}
    cases = [str(workshop.build / f"case{name}.h5") for name in ("01", "4b")]
    assert workshop.make(*cases) == ["run-case"] * len(CASES)
    assert workshop.make(*cases) == []
    assert set(workshop.make("-n", "all")) == {"simulate", "plot", "report", "view"}


def test_build_folder_is_up_to_date(workshop: Workshop) -> None:
    tedm = [sys.executable, "-m", "tedm_cli.cli", "check", "-d", str(workshop.build)]
    done = subprocess.run(tedm, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stderr
    assert "stale" not in done.stdout


def test_touching_the_optics_leaves_ingest_and_gravity_alone(workshop: Workshop) -> None:
    """By what Make would run."""
    (workshop.configs / "optics.toml").touch()
    commands = set(workshop.make("-n", "all"))
    assert {"build-distortion", "build-optics", "run-case", "report"} <= commands
    assert "ingest" not in commands


def test_figures_wait_for_the_closed_loop_of_a_project_with_two_test_masses(tmp_path: Path) -> None:
    """The shipped sample, by what Make would run: figures and report are made of the simulations too."""
    if shutil.which("make") is None or not (Path(sys.prefix) / ".tedm-installed").exists():
        pytest.skip("needs make, and a virtual environment made by it")
    variables = [f"CONFIGS={ROOT / 'configs'}", f"BUILD={tmp_path / 'build'}", f"VENV={sys.prefix}"]
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))}
    done = subprocess.run(
        ["make", "--no-print-directory", "-n", "all", *variables],
        cwd=ROOT,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    commands = [line.split()[1] for line in done.stdout.splitlines() if "/bin/tedm " in line]
    assert commands.count("simulate") == commands.count("run-case") == 12
    assert commands[-3:] == ["plot", "report", "view"]
    assert commands.index("build-dynamics") < commands.index("simulate")
