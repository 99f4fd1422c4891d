"""pyNastran beside numpy 2, which its metadata refuse and its code does not."""

from __future__ import annotations

from importlib.util import find_spec
from typing import Any

import numpy as np

from tedm_cli.errors import InputError

_VERSION = "1.4.1"


def restore_names() -> None:
    """Put back into numpy the one name that pyNastran takes from it and numpy 2.4 has dropped: `in1d`, now `isin`."""
    numpy: Any = np
    if not hasattr(numpy, "in1d"):
        numpy.in1d = np.isin


def require_pynastran() -> None:
    """Say how pyNastran is had on a Python where a plain installation leaves it out.

    Raises
    ------
    InputError : pyNastran is not installed.
    """
    if find_spec("pyNastran") is None:
        raise InputError(
            "pyNastran, which reads decks and results, is not installed; on Python 3.13 it needs a separate command",
            hint=f"python -m pip install --no-deps pyNastran=={_VERSION}",
        )
