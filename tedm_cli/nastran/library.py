"""pyNastran beside numpy 2, which its metadata refuse and its code does not, and without what it loads in vain."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from types import ModuleType
from typing import Any

import numpy as np

from tedm_cli.errors import InputError

_VERSION = "1.4.1"
_INTEGRATION = "scipy.integrate"
_INTEGRALS = ("quad", "trapezoid", "trapz")  # what pyNastran names of it; no reading or writing of ours calls them


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


@contextmanager
def without_integration() -> Iterator[None]:
    """Import parts of pyNastran without `scipy.integrate`, which brings SciPy's optimisers and three times the time.

    Its functions that pyNastran names stand in for themselves: they are loaded when they are called.
    """
    if _INTEGRATION in sys.modules:
        yield
        return
    stand_in = ModuleType(_INTEGRATION)
    for name in _INTEGRALS:
        setattr(stand_in, name, _when_called(name))
    sys.modules[_INTEGRATION] = stand_in
    try:
        yield
    finally:
        del sys.modules[_INTEGRATION]


def _when_called(name: str) -> Callable[..., Any]:
    def call(*arguments: Any, **keywords: Any) -> Any:
        return getattr(importlib.import_module(_INTEGRATION), name)(*arguments, **keywords)

    return call
