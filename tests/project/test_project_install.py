"""What is installed, as a wheel and as an editable install: both packages, with what they need beside their code."""

from __future__ import annotations

import shutil
import subprocess
import sys
import venv
import zipfile
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

import pytest

from tedm_cli import __version__

ROOT = Path(__file__).parents[2]
pytestmark = pytest.mark.slow

BUILD = "import sys; from setuptools import build_meta; print(getattr(build_meta, sys.argv[1])(sys.argv[2]))"
TRIED = """
import sys, tedm, tedm_cli
from pathlib import Path
print(tedm.__version__, Path(tedm.__file__).parent, Path(tedm_cli.__file__).parent)
assert float(tedm.trace(sys.argv[1], {"TM1": {"ux": 1e-6}}).laser_change.sel(laser_output="PD1A_OPD")) < -1.9e-6
assert {name for name in tedm.__all__ if not hasattr(tedm, name)} == set()
"""
USED = """\
import tedm

project = tedm.load_project("configs")
case = project.run_case(3, temperature={"outside_K": 1e-3})
value: float = float(case.psd.sel(output="TM1_a_x")[0])
field = tedm.cuboid_field([[0.1, 0.0, 0.0]], 0.046)
names: list[str] = project.cases
try:
    tedm.trace(project, {"TM1": {"ux": 1e-6}})
except tedm.Error as error:
    print(error.fact, error.hint)
"""
WRONG = 'import tedm\nproject: int = tedm.load_project("configs")\n'


@dataclass(frozen=True)
class Installed:
    """An environment of its own with tedm in it: how it was installed, its Python, its folder of packages."""

    how: str
    python: Path
    site: Path


@pytest.fixture(scope="module", params=["wheel", "editable"])
def installed(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Installed:
    """Made without a network: what tedm needs is that of the tests' own environment."""
    if int(version("setuptools").split(".")[0]) < 77:
        pytest.skip("setuptools of the extra dev is not installed")
    tree, out, folder = (tmp_path_factory.mktemp(name) for name in ("tree", "out", "venv"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, tree)
    shutil.copytree(ROOT / "tedm_cli", tree / "tedm_cli", ignore=shutil.ignore_patterns("__pycache__"))
    built = run(Path(sys.executable), tree, "-c", BUILD, f"build_{request.param}", str(out)).splitlines()[-1]
    venv.create(folder, symlinks=True)
    site = next(folder.glob("lib/python*/site-packages"))
    with zipfile.ZipFile(out / built) as wheel:
        wheel.extractall(site)
    others = [path for path in sys.path if path.endswith("site-packages")]
    (site / "zz_others.pth").write_text("\n".join(others))
    return Installed(request.param, folder / "bin" / "python", site)


def run(python: Path, folder: Path, *arguments: str) -> str:
    done = subprocess.run([python, *arguments], cwd=folder, env={}, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_both_packages_are_there(installed: Installed, tmp_path: Path) -> None:
    told, here, command_line = run(
        installed.python, tmp_path, "-c", TRIED, str(ROOT / "configs" / "optics.toml")
    ).split()
    assert told == __version__
    if installed.how == "editable":
        assert here.endswith("/tedm_cli/library/top_level/tedm")
        assert here.startswith(command_line)
        assert str(installed.site) not in here
        return
    assert [here, command_line] == [str(installed.site / "tedm"), str(installed.site / "tedm_cli")]
    for name in ("tedm/py.typed", "tedm_cli/py.typed"):
        assert (installed.site / name).is_file(), name
    assert not (installed.site / "tedm_cli" / "library" / "top_level").exists(), "it would be there twice"


def test_a_users_code_is_typed(installed: Installed, tmp_path: Path) -> None:
    """mypy --strict knows the types of what is installed, and finds what is wrong."""
    if installed.how == "editable":
        pytest.skip("mypy does not follow the finder that setuptools installs")
    (tmp_path / "used.py").write_text(USED)
    (tmp_path / "wrong.py").write_text(WRONG)
    told_by = ["--no-site-packages", "--no-incremental", "--strict"]  # tedm alone: to read xarray as well takes long
    done = subprocess.run(
        [sys.executable, "-m", "mypy", *told_by, "used.py", "wrong.py"],
        cwd=tmp_path,
        env={"MYPYPATH": str(installed.site)},
        capture_output=True,
        text=True,
    )
    found = [line for line in done.stdout.splitlines() if line.startswith(("used.py", "wrong.py"))]
    assert len(found) == 1, done.stdout + done.stderr
    assert found[0].startswith("wrong.py:2: error: Incompatible types in assignment")
