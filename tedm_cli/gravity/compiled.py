"""Compilation of the numerical kernels to machine code."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TypeVar, cast

import numba

Function = TypeVar("Function", bound=Callable[..., object])
_decorator = partial(numba.njit, nogil=True, error_model="numpy", fastmath={"contract"})


def compiled(function: Function) -> Function:
    """Compile at the first call and keep the result beside the source file, or in the user's cache folder.

    The kept code is renewed when its own file changes, so a compiled function may call compiled functions of its own
    module only. Products may be fused with sums: results agree between machines to rounding, not to the bit.
    """
    try:
        return cast(Function, _decorator(function, cache=True))
    except RuntimeError:
        # no folder can be written: every run compiles anew
        return cast(Function, _decorator(function))


def inlined(function: Function) -> Function:
    """A step of `compiled` functions of its module, made part of their code so that loops over it can be vectorised."""
    return cast(Function, _decorator(function, forceinline=True))
