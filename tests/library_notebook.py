"""The notebook of the tutorial on the small sample. `python tests/library_notebook.py` runs it again and keeps it."""

from __future__ import annotations

import os
import runpy
import tempfile
from pathlib import Path
from unittest import mock

import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).parents[1]
NOTEBOOK = ROOT / "docs" / "tutorial" / "notebook.ipynb"
SAMPLE = ROOT / "sample_models" / "small"


def executed(notebook: nbformat.NotebookNode, build: Path, folder: Path) -> nbformat.NotebookNode:
    """A copy of the notebook, run in `folder`/docs/tutorial beside the sample and the results that it names."""
    for place, target in (("sample_models/small", SAMPLE), ("build/small", build)):
        (folder / place).parent.mkdir(parents=True, exist_ok=True)
        (folder / place).symlink_to(target.resolve())
    (folder / "docs" / "tutorial").mkdir(parents=True)
    own = {name: str(folder / name.lower()) for name in ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_RUNTIME_DIR")}
    own["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"  # whatever the tests before have chosen
    path = os.pathsep.join([str(ROOT), str(ROOT / "tedm_cli" / "library" / "top_level")])
    copy = nbformat.from_dict(notebook)
    client = NotebookClient(
        copy, timeout=120, kernel_name="python3", resources={"metadata": {"path": str(folder / "docs" / "tutorial")}}
    )
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
    chain = runpy.run_path(str(ROOT / "tests" / "chain" / "conftest.py"))
    with tempfile.TemporaryDirectory() as name:
        build = Path(name) / "results"
        chain["build_cases"](chain["small_in"](build))
        done = executed(nbformat.read(NOTEBOOK, as_version=4), build, Path(name))
    nbformat.write(done, NOTEBOOK)


if __name__ == "__main__":
    main()
