"""What the README and the page of the library show runs on the small sample."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import matplotlib
import pytest
import tedm

from tedm_cli.config.project import Project

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "reference" / "library.md").read_text(encoding="utf-8")


def blocks(document: str) -> list[str]:
    return re.findall(r"```python\n(.*?)```", document, re.S)


@pytest.fixture
def folder(small: Project, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with `configs` and `build`, as the documents have it."""
    (tmp_path / "configs").symlink_to(small.file.path.parent)
    (tmp_path / "build").symlink_to(small.build_dir)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("name", ["README.md", "docs/reference/library.md"])
def test_what_a_document_shows_runs(folder: Path, name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """One block after the other, as a reader types them."""
    matplotlib.use("Agg")
    known: dict[str, object] = {}
    code = blocks((ROOT / name).read_text(encoding="utf-8"))
    assert code
    for block in code:
        exec(compile(block, name, "exec"), known)
    from matplotlib import pyplot

    axes = pyplot.gcf().axes[0]
    assert "power spectral density" in " ".join(axes.get_ylabel().split())
    assert "TM1_a_x" in axes.get_title()
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    pyplot.close("all")
    if name != "README.md":
        assert "correlation" in capsys.readouterr().out, "a matrix that is none is refused"


def test_the_reference_is_complete() -> None:
    """Names as exported, signatures as they are, and everything that a class offers."""
    reference = PAGE[PAGE.index("## Reference") :]
    rows = re.findall(r"^\| (`.*?) \| (.*) \|$", reference, re.M)
    named = {n for cell, _ in rows for n in re.findall(r"`(\w+)", cell)}
    assert named == set(tedm.__all__)
    for cell, said in rows:
        for name, arguments in re.findall(r"`(\w+)\((.*?)\)`", cell):
            found = inspect.signature(getattr(tedm, name)).parameters.values()
            bare = [p.replace(annotation=inspect.Parameter.empty) for p in found]
            assert str(inspect.Signature(bare)) == f"({arguments})", name
        for name in re.findall(r"`(Project|Build)`", cell):
            public = {n for n in vars(getattr(tedm, name)) if not n.startswith("_")}
            public |= {"folder"} if name == "Build" else set()
            assert set(re.findall(r"`(\w+)`", said)) == public, name


def test_docstrings_tell_what_goes_in_and_out() -> None:
    for name in ("run_case", "self_gravity", "cuboid_field", "trace", "table", "load_project"):
        text = inspect.getdoc(getattr(tedm, name)) or ""
        for heading in ("Parameters", "Raises"):
            assert f"{heading}\n---" in text, (name, heading)
        for argument in inspect.signature(getattr(tedm, name)).parameters:
            assert re.search(rf"^{argument} : ", text, re.M), (name, argument)
