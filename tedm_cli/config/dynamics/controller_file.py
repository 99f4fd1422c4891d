"""A controller of one's own from a file: A, B, C, D with the names of its inputs and outputs, in MAT, NPZ or TOML."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from tedm_cli import quantities as q
from tedm_cli.arrays import FloatArray
from tedm_cli.config.base import Bounded, Strict, load
from tedm_cli.dynamics.loops import StateSpace
from tedm_cli.dynamics.own_controller import StateSpaceController
from tedm_cli.errors import InputError, TedmError
from tedm_cli.matrix_files.mat_file import mat_variables
from tedm_cli.matrix_files.named import text_list
from tedm_cli.matrix_files.npz_file import npz_variables

_MATRICES = ("A", "B", "C", "D")
_NUMBERS = ("delay_s", "dt_s")
_BOUNDS = {**dict.fromkeys(_MATRICES, q.MATRIX_ENTRY), "delay_s": q.CONTROL_DELAY, "dt_s": q.DURATION}
Rows = list[list[Annotated[float, Bounded(q.MATRIX_ENTRY)]]]


class ControllerFile(Strict):
    """A controller u = C x + D y, x' = A x + B y (or, sampled, its next x)."""

    inputs: list[str] = Field(
        min_length=1, description="Names of what it measures, in the order of the columns of B and D."
    )
    outputs: list[str] = Field(
        min_length=1, description="Names of the forces that it commands, in the order of the rows of C and D."
    )
    A: Rows = Field(default_factory=list, description="State by state. Without states it is left out.")
    B: Rows = Field(default_factory=list, description="State by input.")
    C: Rows = Field(default_factory=list, description="Output by state.")
    D: Rows = Field(description="Output by input.")
    delay_s: Annotated[float, Bounded(q.CONTROL_DELAY)] = Field(default=0.0, description="Delay of all commands.")
    dt_s: Annotated[float, Bounded(q.DURATION)] | None = Field(
        default=None,
        description="Step of a sampled controller, whose commands are held between. Without it the controller "
        "is continuous.",
    )


def read_controller(path: Path) -> StateSpaceController:
    """The controller in a file of one of the three kinds, by its ending.

    Raises
    ------
    InputError : not there, another ending, a matrix or list that is missing or of another kind.
    ConfigError : a TOML file that is not as `ControllerFile` says.
    PhysicsError : names or shapes that do not fit.
    """
    suffix = path.suffix.lower()
    if suffix == ".toml":
        _, table = load(ControllerFile, path)
        values: dict[str, Any] = table.model_dump(exclude_none=True)
    elif suffix == ".npz":
        values = npz_variables(path)
    elif suffix == ".mat":
        values = mat_variables(path)
    else:
        raise InputError(
            f"is no controller: its ending is {suffix!r}", where=str(path), hint="wanted .toml, .npz or .mat"
        )
    missing = [name for name in ("D", "inputs", "outputs") if name not in values]
    if missing:
        raise InputError(f"holds no {' and no '.join(missing)}", where=str(path), hint="A, B, C, D, inputs, outputs")
    inputs, outputs = (tuple(text_list(values[name])) for name in ("inputs", "outputs"))
    states = np.atleast_2d(_matrix(values.get("A", []), path, "A")).shape[0] if np.size(values.get("A", [])) else 0
    shapes = {"A": (states, states), "B": (states, len(inputs)), "C": (len(outputs), states), "D": None}
    read = {}
    for name in _MATRICES:
        matrix = _matrix(values.get(name, []), path, name)
        shape = shapes[name]
        read[name] = np.zeros(shape) if matrix.size == 0 and shape is not None else np.atleast_2d(matrix)
    delay, dt = (_number(values.get(name), path, name) for name in _NUMBERS)
    for name, bound in _BOUNDS.items():
        _check_bounds(path, name, np.asarray(values.get(name, 0.0), dtype=np.float64), bound)
    try:
        return StateSpaceController(
            StateSpace(*(read[n] for n in _MATRICES)), inputs, outputs, delay or 0.0, dt or None
        )
    except TedmError as error:
        error.where = str(path)
        raise


def _matrix(value: Any, path: Path, name: str) -> FloatArray:
    try:
        if np.iscomplexobj(value):
            raise ValueError("complex")
        return np.asarray(value, dtype=np.float64)
    except (TypeError, ValueError) as exc:
        raise InputError(f"{name} is no matrix of real numbers", where=str(path)) from exc


def _check_bounds(path: Path, name: str, value: FloatArray, bound: q.Quantity) -> None:
    """Refuse a number outside the bounds of its quantity, as a TOML file's is; what is not given is 0."""
    at = None if not value.any() else bound.first_outside(value)
    if at is not None:
        place = f"{name}[{', '.join(str(i + 1) for i in at)}]" if at else name
        raise InputError(f"{place}: {bound.fact(float(value[at]))}", where=str(path))


def _number(value: Any, path: Path, name: str) -> float | None:
    if value is None:
        return None
    array = _matrix(value, path, name).reshape(-1)
    if array.size != 1:
        raise InputError(f"{name} is no single number", where=str(path))
    return float(array[0])
