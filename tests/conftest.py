import gc
import os
import sys
from pathlib import Path
from typing import Any

# Before NumPy and Numba are loaded: on small arrays a second thread only waits, and the tests share their cores.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")
# MKL, which PARDISO is of, waits forever in a forked process for the threads that it had before: some tests fork.
os.environ.setdefault("MKL_THREADING_LAYER", "SEQUENTIAL")
# The tests start the commands hundreds of times: each would compile the same modules anew.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

import numpy as np
import pytest
from hypothesis import settings

from tedm_cli.nastran.library import restore_names

restore_names()  # before a test imports pyNastran by itself
sys.dont_write_bytecode = False  # each run of pytest would rewrite all assertions anew

# Machines are shared: how long an example takes says nothing of the code.
settings.register_profile("tedm", deadline=None)
settings.load_profile("tedm")

_approx = pytest.approx


def _relative(expected: Any, rel: Any = None, abs: Any = None, nan_ok: bool = False) -> Any:
    """`pytest.approx` without its tolerance of 1e-12 below all others: accelerations of 1e-15 would equal anything."""
    if abs is None and (rel is not None or np.all(np.asarray(expected) != 0)):
        rel, abs = 1e-6 if rel is None else rel, 0.0
    return _approx(expected, rel=rel, abs=abs, nan_ok=nan_ok)


pytest.approx = _relative


def pytest_collection_finish() -> None:
    """What is there by now stays to the end, thousands of tests and the libraries: no garbage is in it."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(200_000, 50, 1000)  # as the commands


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
