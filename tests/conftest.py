import os
from pathlib import Path

# Before NumPy is loaded: on small matrices a second thread of BLAS only waits, and the tests share their cores.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import pytest
from hypothesis import settings

# Machines are shared: how long an example takes says nothing of the code.
settings.register_profile("tedm", deadline=None)
settings.load_profile("tedm")


@pytest.fixture(scope="session")
def mini_ltp_dir() -> Path:
    """Folder of the reference model: a small bench solved by an independent solver (its README tells how)."""
    return Path(__file__).parent / "data" / "mini_ltp"


@pytest.fixture(scope="session")
def nastran_dir() -> Path:
    """Folder of decks and results of commercial solvers, not ours to publish; TEDM_SHARED_DATA names its parent."""
    data = Path(os.environ.get("TEDM_SHARED_DATA", Path(__file__).parents[2] / "shared" / "data"))
    folder = data / "nastran"
    if not folder.is_dir():
        pytest.skip(f"no Nastran files at {folder} (set TEDM_SHARED_DATA)")
    return folder
