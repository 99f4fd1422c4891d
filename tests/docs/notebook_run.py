"""The notebook of the tutorial in the sample of `tedm init`.

`python tests/docs/notebook_run.py` runs it again and keeps it.
"""

from __future__ import annotations

import os
import tempfile
from pathlib import Path
from unittest import mock

import nbformat
from nbclient import NotebookClient
from pages import ROOT
from pages_run import build_sample

NOTEBOOK = ROOT / "docs" / "tutorial" / "notebook.ipynb"


def executed(notebook: nbformat.NotebookNode, project: Path, scratch: Path) -> nbformat.NotebookNode:
    """A copy of the notebook, run in the folder of a project that has its results."""
    own = {name: str(scratch / name.lower()) for name in ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_RUNTIME_DIR")}
    own["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"  # whatever the tests before have chosen
    path = os.pathsep.join([str(ROOT), str(ROOT / "tedm_cli" / "library" / "top_level")])
    copy = nbformat.from_dict(notebook)
    client = NotebookClient(copy, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(project)}})
    with mock.patch.dict(os.environ, {**own, "PYTHONPATH": path}):
        client.execute()
    copy.metadata = notebook.metadata  # which Python ran it is no result
    for cell in copy.cells:
        cell.metadata.clear()  # times of the run
    return copy


def texts(notebook: nbformat.NotebookNode) -> list[str]:
    """What the cells print and return, as text; names of objects in memory are left out."""
    found = []
    for cell in notebook.cells:
        for output in cell.get("outputs", ()):
            text = output.get("text") or output.get("data", {}).get("text/plain", "")
            if not text.startswith("<") or "image/png" in output.get("data", {}):
                found.append("" if text.startswith("<") else text)
    return found


def main() -> None:
    """Build the sample's results, run the notebook, and keep it."""
    with tempfile.TemporaryDirectory() as name:
        project, scratch = Path(name).resolve() / "demo", Path(name).resolve() / "scratch"
        project.mkdir()
        build_sample(project)
        done = executed(nbformat.read(NOTEBOOK, as_version=4), project, scratch)
    nbformat.write(done, NOTEBOOK)


if __name__ == "__main__":
    main()
