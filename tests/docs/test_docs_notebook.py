"""The notebook of the tutorial prints what is kept in it."""

from __future__ import annotations

from pathlib import Path

import pytest
from pages_run import build_sample
from shared_folder import shared


@pytest.mark.slow
def test_the_notebook_prints_what_it_says(tmp_path_factory: pytest.TempPathFactory, tmp_path: Path) -> None:
    nbformat = pytest.importorskip("nbformat")
    pytest.importorskip("nbclient")
    from notebook_run import NOTEBOOK, executed, texts

    sample = shared(tmp_path_factory, "docs_sample", build_sample)
    kept = nbformat.read(NOTEBOOK, as_version=4)
    told = texts(kept)
    assert len(told) >= 6
    assert any("image/png" in o.get("data", {}) for c in kept.cells for o in c.get("outputs", ())), "a figure is kept"
    now = texts(executed(kept, sample, tmp_path))
    assert now == told, "make it again with `python tests/docs/notebook_run.py`"
