"""A wheel, in an environment of its own outside the repository: a project is begun, run and read."""

from __future__ import annotations

import importlib.metadata
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

from tedm_cli.samples.shipped import SAMPLES, sources

ROOT = Path(__file__).parents[2]
BUILT_OF = ("pyproject.toml", "setup.py", "README.md", "LICENSE")
_BUILDS = (70, 1)  # the setuptools that makes wheels by itself

pytestmark = pytest.mark.slow


def run(command: list[object], folder: Path) -> str:
    """Run a command where nothing of this environment is on the path; what it printed."""
    environment = {k: v for k, v in os.environ.items() if not k.startswith(("PYTHON", "VIRTUAL_ENV"))}
    words = [str(word) for word in command]
    done = subprocess.run(words, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program `tedm` of a new environment. Libraries are those of this one: nothing is downloaded."""
    version = re.match(r"(\d+)\.(\d+)", importlib.metadata.version("setuptools"))
    assert version is not None
    if (int(version[1]), int(version[2])) < _BUILDS:
        pytest.skip("needs a setuptools that makes wheels by itself (70.1): pip install -e '.[dev]'")
    folder = tmp_path_factory.mktemp("wheel")
    source, venv = folder / "source", folder / "venv"
    for name in ("tedm_cli", "configs", "sample_models"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in BUILT_OF:
        shutil.copy(ROOT / name, source)
    build = "import sys; from setuptools import build_meta; print(build_meta.build_wheel(sys.argv[1]))"
    subprocess.run([sys.executable, "-c", build, folder], cwd=source, capture_output=True, check=True)
    (wheel,) = folder.glob("*.whl")
    shutil.rmtree(source)
    run([sys.executable, "-m", "venv", "--without-pip", venv], folder)
    python = venv / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--python", python, "--disable-pip-version-check"]
    run([*pip, "install", "--quiet", "--no-deps", "--no-index", "--no-compile", wheel], folder)
    (there,) = venv.glob("lib/python*/site-packages")
    libraries = [p for p in sys.path if p.endswith("site-packages")] or [sysconfig.get_paths()["purelib"]]
    (there / "libraries.pth").write_text("\n".join(libraries) + "\n", encoding="utf-8")
    where = run([python, "-c", "import tedm_cli; print(tedm_cli.__file__)"], folder).strip()
    assert Path(where).is_relative_to(venv), "the wheel is not what is run"
    return venv / "bin" / "tedm"


def test_begun_run_and_read(installed: Path, tmp_path: Path) -> None:
    """From nothing to the report: one case of the read-outs alone, as gravity's kernel would be compiled anew."""
    run([installed, "init", "demo"], tmp_path)
    project = tmp_path / "demo"
    edit(project / "model.toml", r"\[\[test_mass\]\].*", "")
    edit(project / "cases.toml", r"\[\[requirement\]\]\nname = \"lpf_selfgravity_ltp\"\n.*?\n\n", "")
    edit(project / "cases.toml", r"\[\[case\]\].*(?=\[\[case\]\])", "")
    (project / "sub").mkdir()
    said = run([installed, "run", "report"], project / "sub")
    made = ["ingest", "build-distortion", "build-optics", "run-case 3", "plot", "report"]
    assert re.findall(r"(?m)^\[\d/6\] (.+):", said) == made
    report = (project / "build" / "report.html").read_text(encoding="utf-8")
    assert "minimal LTP-like sample" in report
    assert "Correlated outside, correlated inside the thermal shield" in report
    assert "up to date" in run([installed, "run", "report"], project)


def edit(path: Path, old: str, new: str) -> None:
    """Change a text by a pattern that is in it once."""
    text, n = re.subn(old, new, path.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert n == 1
    path.write_text(text, encoding="utf-8")


@pytest.mark.parametrize("sample", ["ltp", "spacecraft", "lisa"])
def test_samples_with_scripts_are_in_it(installed: Path, tmp_path: Path, sample: str) -> None:
    """The same files as from the repository, the model that the script makes among them."""
    run([installed, "init", "--from", sample, "wheel"], tmp_path)
    run([sys.executable, "-m", "tedm_cli.cli", "init", "--from", sample, tmp_path / "repository"], ROOT)
    files = {path.name: path.read_bytes() for path in (tmp_path / "wheel").iterdir()}
    assert files == {path.name: path.read_bytes() for path in (tmp_path / "repository").iterdir()}
    script = SAMPLES[sample].script
    assert script is not None
    assert script.model in files


def test_what_goes_in_is_what_samples_name() -> None:
    assert [name for name in sources() if not (ROOT / name).is_file()] == []
