"""Where `import tedm` looks for a project and its results: where the commands look."""

from __future__ import annotations

import re
import traceback
from pathlib import Path

import pytest
import tedm

from tedm_cli.cli.run import outcome
from tedm_cli.config.project import Project

TITLE = "found"


@pytest.fixture(params=["tedm.toml", "configs/tedm.toml"])
def home(request: pytest.FixtureRequest, small: Project, tmp_path: Path) -> Path:
    """The folder of a project whose results are those of the small sample."""
    file = tmp_path / "home" / request.param
    (file.parent / "deep" / "deeper").mkdir(parents=True)
    named = {name: getattr(small, name) for name in ("model", "optics", "cases", "thermal")}
    file.write_text("".join(f'{k} = "{v}"\n' for k, v in {"title": TITLE, **named}.items()), encoding="utf-8")
    (tmp_path / "home" / "build").symlink_to(small.build_dir)
    return tmp_path / "home"


def is_found(project: tedm.Project, home: Path) -> bool:
    return project.title == TITLE and project.build.folder.resolve() == (home / "build").resolve()


@pytest.mark.parametrize("below", ["", "configs", "configs/deep/deeper", "deep"])
def test_of_this_folder_or_of_the_nearest_above(
    home: Path, below: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The library and the command line find the same file and the same build folder."""
    (home / below).mkdir(parents=True, exist_ok=True)
    monkeypatch.chdir(home / below)
    project = tedm.load_project()
    assert is_found(project, home)
    assert tedm.open_build().folder == project.build.folder
    assert "case03.h5" in project.build.files
    monkeypatch.setattr("sys.argv", ["tedm", "run", "ingest", "-v", "-n"])
    assert outcome() == (0, [])
    told = re.search(rf"^{TITLE}: (.*), results in (.*)$", capsys.readouterr().err, re.M)
    assert told is not None
    assert repr(project) == f"<tedm.Project {TITLE!r}: {told[1]}, results in {told[2]}>"


def test_in_the_folder_that_is_given(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not above it; the results are beside the project, wherever one is, and where they are said to be."""
    monkeypatch.chdir(home.parent)
    file = next(home.rglob("tedm.toml"))
    for path in ("home", home, file.parent, file.parent.relative_to(home.parent)):
        assert is_found(tedm.load_project(path), home), path
    assert tedm.load_project(home, "other").build.folder == Path("other")
    assert tedm.load_project(file).build.folder == Path("build"), "of a file, as with --config"
    monkeypatch.chdir(file.parent)
    assert is_found(tedm.load_project("."), home)
    with pytest.raises(tedm.InputError, match=r"deeper: no project in this folder: no tedm\.toml"):
        tedm.load_project(file.parent / "deep" / "deeper")
    monkeypatch.chdir(file.parent / "deep")
    with pytest.raises(tedm.InputError, match="no project in this folder"):
        tedm.load_project(".")


def test_where_there_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One error that says what to do, without those that led to it."""
    monkeypatch.chdir(tmp_path)
    for call in (tedm.load_project, lambda: tedm.load_project("."), lambda: tedm.run_case("nowhere", 3)):
        with pytest.raises(tedm.InputError) as refusal:
            call()
        told = "".join(traceback.format_exception(refusal.value))
        assert told.count("Traceback") == 1
        assert told.endswith("hint: give the folder of a project; `tedm init demo` begins one\n")
    with pytest.raises(tedm.InputError, match=r"^build: no such folder\nhint: `tedm run`"):
        tedm.open_build()


def test_the_command_line_says_the_hint_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for more in ([], ["-vv"]):
        monkeypatch.setattr("sys.argv", ["tedm", "show", "nowhere.h5", *more])
        code, lines = outcome()
        assert code == 4
        assert [line.split(":")[0] for line in lines[-2:]] == ["error", "hint"]
        assert sum(line.startswith("hint: ") for line in lines) == 1
        assert (len(lines) == 2) is not bool(more)
