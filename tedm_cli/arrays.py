"""Types of the arrays that every room passes on: NumPy arrays by what they hold. Shapes and units are in docstrings."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]
IntArray = NDArray[np.int64]
IndexArray = NDArray[np.intp]
BoolArray = NDArray[np.bool_]
AnyArray = NDArray[Any]  # float64, or complex128 under a complex step or where a spectrum is complex
