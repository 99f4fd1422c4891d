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
    """Folder of the reference model; TEDM_SHARED_DATA points at the folder that holds it."""
    data = Path(os.environ.get("TEDM_SHARED_DATA", Path(__file__).parents[2] / "shared" / "data"))
    folder = data / "mini_ltp"
    if not folder.is_dir():
        pytest.skip(f"no reference model at {folder} (set TEDM_SHARED_DATA)")
    return folder
