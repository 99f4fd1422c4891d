"""tedm init: a project from a sample, never over anything, and nothing half of it."""

from __future__ import annotations

import shutil
import sys
from pathlib import Path

import pytest

sys.path.append(str(Path(__file__).parents[1] / "borders"))

from border_tools import CONFIGS, ROOT, SMALL, snapshot, tedm, untouched

from tedm_cli.samples.shipped import SAMPLES, root
from tedm_cli.stages.chain import init

MINIMAL = ROOT / "sample_models" / "minimal"
NOBODY = 2**22 + 1  # no process has this number


def test_samples_are_read_where_they_are() -> None:
    assert root() == ROOT
    assert {path.name for path in (ROOT / "tedm_cli" / "samples").glob("*")} <= {
        "__init__.py",
        "shipped.py",
        "__pycache__",
    }, "there is no second copy"


def test_minimal(tmp_path: Path) -> None:
    """Its files are those of the repository, in one folder; an empty one that is there already is taken."""
    (tmp_path / "new").mkdir()
    (tmp_path / "new" / ".git").mkdir()
    out = tedm("init", tmp_path / "new").ok().out
    assert "note: the mesh of this sample is coarse, for speed: the warning that many of its areas" in out
    assert out.splitlines()[-1] == f"now: cd {tmp_path / 'new'}; tedm run"
    files = {path.name: path.read_bytes() for path in (tmp_path / "new").iterdir() if path.is_file()}
    assert files == {
        **{name: (MINIMAL / name).read_bytes() for name in ("tedm.toml", "cases.toml")},
        "optics.toml": (CONFIGS / "optics.toml").read_bytes(),
        **{
            path.name: path.read_bytes()
            for path in SMALL.iterdir()
            if path.name != "tedm.toml" and not path.name.startswith("thermal") and path.is_file()
        },
    }


@pytest.mark.parametrize(("sample", "steps"), [("minimal", 15), ("ltp", 38), ("spacecraft", 31), ("lisa", 17)])
def test_every_sample_can_be_run(sample: str, steps: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By what would be run: nothing is missing, and the model is a file of the project."""
    folder = tmp_path / sample
    folder.mkdir()
    monkeypatch.chdir(folder)
    assert tedm("init", "--from", sample).ok().out.splitlines()[-1] == "now: tedm run"
    assert f"{steps} of {steps} steps to run" in tedm("run", "-n").ok().out
    script = SAMPLES[sample].script
    if script is not None:
        assert (folder / script.model).read_text().count("CHEXA") > 1000
        assert f'bdf = "{script.model}"' in (folder / "model.toml").read_text()
    tedm("check-layout").ok()


@pytest.mark.parametrize("name", ["tedm.toml", "thesis.odt"])
def test_nothing_is_overwritten(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("mine")
    with untouched(tmp_path):
        tedm("init", tmp_path).refused(4, f"is not empty: {name}", hint="`tedm init FOLDER`")
    with untouched(tmp_path):
        tedm("init", tmp_path / name).refused(4, f"{name}: is no folder")
        tedm("init", tmp_path / name / "below").refused(4, name)


def test_an_unknown_sample(tmp_path: Path) -> None:
    tedm("init", tmp_path / "new", "--from", "taiji").refused(2, "taiji")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("end", [KeyboardInterrupt(), OSError(28, "No space left on device")])
@pytest.mark.parametrize("existed", [False, True])
@pytest.mark.parametrize("where", ["_make_model", "_put_in_place"])
def test_ended_half_way(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, end: BaseException, existed: bool, where: str
) -> None:
    """Nothing is left, not even the folder if it was not there."""
    folder = tmp_path / "new"
    if existed:
        folder.mkdir()

    def fail(*given: object) -> None:
        if where == "_put_in_place":
            shutil.copy(given[0] / "optics.toml", folder)  # type: ignore[operator]
        raise end

    monkeypatch.setattr(init, where, fail)
    outcome = tedm("init", folder, "--from", "lisa")
    assert outcome.code == (4 if isinstance(end, OSError) else 130)
    assert "no room left" in outcome.err or not isinstance(end, OSError)
    assert list(tmp_path.rglob("*")) == ([folder] if existed else [])


@pytest.mark.parametrize("placed", [0, 2, 8])
def test_after_a_kill(tmp_path: Path, placed: int) -> None:
    """What a killed run has left is told from what is the user's: the same name with another content is."""
    tedm("init", tmp_path / "whole").ok()
    whole = snapshot(tmp_path / "whole")
    folder = tmp_path / "new"
    aside = folder / f".tedm-init.{NOBODY}"
    shutil.copytree(tmp_path / "whole", aside)
    for name in sorted(whole)[:placed]:
        shutil.copy(aside / name, folder)
    if placed == len(whole):  # killed when all was done
        tedm("init", folder).refused(4, "is not empty")
        assert snapshot(folder) == whole, "the project, and nothing beside it"
        return
    if placed:
        (folder / sorted(whole)[0]).write_text("mine")
        with untouched(folder):
            tedm("init", folder).refused(4, "is not empty")
        (folder / sorted(whole)[0]).unlink()
    tedm("init", folder).ok()
    assert snapshot(folder) == whole
