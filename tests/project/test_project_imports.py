"""What commands load: a library that a command has no use for would cost each of its runs up to half a second."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

SMALL = Path(__file__).parents[2] / "sample_models" / "small"
HEAVY = {"matplotlib", "pyNastran", "numba", "pandas", "xarray", "sklearn", "jinja2", "scipy.stats", "scipy.signal"}
LOADED = "print('loaded', *sys.modules, file=sys.stderr)"
COMMAND = f"""
import sys
sys.argv = ["tedm", *sys.argv[1:]]
from tedm_cli.cli.run import run
try:
    run()
finally:
    {LOADED}
"""


def loaded_by(code: str, *arguments: object) -> set[str]:
    """The modules that a program of its own has at its end."""
    program = [sys.executable, "-c", code, *map(str, arguments)]
    done = subprocess.run(program, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-2000:]
    return set(done.stderr.splitlines()[-1].split())


@pytest.fixture(scope="module")
def build(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("imports") / "build"
    found = loaded_by(COMMAND, "ingest", "-q", "-c", SMALL / "tedm.toml", "-d", folder)
    assert "pyNastran" in found  # what is asked here is heard
    return folder


@pytest.mark.parametrize("command", ["check", "run", "show"])
def test_what_only_reads_loads_no_heavy_library(build: Path, command: str) -> None:
    arguments: dict[str, list[object]] = {
        "check": ["-d", build],
        "run": ["-n", "-c", SMALL / "tedm.toml", "-d", build],
        "show": [build / "unit_loads.h5"],
    }
    found = loaded_by(COMMAND, command, *arguments[command])
    assert "h5py" in found
    assert not HEAVY & found
    if command == "show":  # nor what reads other kinds of file
        assert not {"scipy", "tedm_cli.config.cases", "tedm_cli.results.thermal.file"} & found


def test_the_stage_of_cases_loads_none_before_it_needs_it() -> None:
    """Uncertainty does: its samples and shares are SciPy's statistics."""
    stage = "import sys; import tedm_cli.stages.noise.case, tedm_cli.cli.printing.case"
    assert not HEAVY & loaded_by(f"{stage}; {LOADED}")
