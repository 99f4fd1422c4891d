import os
from pathlib import Path

import pytest


@pytest.fixture(scope="session")
def nastran_dir() -> Path:
    """Folder of decks and results of commercial solvers; TEDM_SHARED_DATA points at the folder that holds it."""
    data = Path(os.environ.get("TEDM_SHARED_DATA", Path(__file__).parents[3] / "shared" / "data"))
    folder = data / "nastran"
    if not folder.is_dir():
        pytest.skip(f"no Nastran files at {folder} (set TEDM_SHARED_DATA)")
    return folder
