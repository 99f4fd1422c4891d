"""A controller of one's own as a state space: u = C x + D y, continuous or sampled, with a delay."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.dynamics.loops import StateSpace, pade_delay, pade_response
from tedm_cli.dynamics.signals import COORDINATES, INPUTS, N_COORDINATES, N_INPUTS
from tedm_cli.errors import PhysicsError


@dataclass(frozen=True, eq=False)
class StateSpaceController:
    """u = C x + D y of the named read-outs and forces; what is not named is not measured or not actuated.

    Parameters
    ----------
    system : A, B, C, D.
    inputs : names of `COORDINATES` in the order of the columns of B and D.
    outputs : names of `INPUTS` in the order of the rows of C and D.
    delay_s : of all commands.
    dt_s : sampling period of a discrete system, x[k+1] = A x[k] + B y[k], whose commands are held; None: continuous.

    Raises
    ------
    PhysicsError : matrices that do not fit each other or the names, unknown or repeated names, numbers not finite.
    """

    system: StateSpace
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    delay_s: float = 0.0
    dt_s: float | None = None

    def __post_init__(self) -> None:
        _check_names(self.inputs, COORDINATES, "input")
        _check_names(self.outputs, INPUTS, "output")
        s, n = self.system, len(self.system.a)
        wanted = {
            "A": (s.a, (n, n)),
            "B": (s.b, (n, len(self.inputs))),
            "C": (s.c, (len(self.outputs), n)),
            "D": (s.d, (len(self.outputs), len(self.inputs))),
        }
        for name, (matrix, shape) in wanted.items():
            if matrix.shape != shape:
                raise PhysicsError(
                    f"{name} of the controller is {' x '.join(map(str, matrix.shape))}; {n} states,"
                    f" {len(self.inputs)} inputs and {len(self.outputs)} outputs want {shape[0]} x {shape[1]}"
                )
            if not np.isfinite(matrix).all():
                raise PhysicsError(f"{name} of the controller has values that are not finite")
        if not 0.0 <= self.delay_s < np.inf or (self.dt_s is not None and not 0.0 < self.dt_s < np.inf):
            raise PhysicsError("delay_s of the controller must be finite and not negative, dt_s finite and positive")

    @property
    def loops(self) -> tuple[str, ...]:
        return self.inputs

    @cached_property
    def returns(self) -> FloatArray:
        """[L, 15]: the loops are broken at the read-outs."""
        rows = np.zeros((len(self.inputs), N_COORDINATES))
        rows[range(len(self.inputs)), [COORDINATES.index(name) for name in self.inputs]] = 1.0
        return rows

    def command(self, s: ComplexArray) -> ComplexArray:
        """[F, 18, L]; `PhysicsError` for a frequency above half the sampling rate."""
        if self.dt_s is None:
            inner, hold = self.system.response(s), np.ones_like(s)
        else:
            if np.abs(s.imag).max() > np.pi / self.dt_s * (1.0 + 1e-12):
                raise PhysicsError(
                    f"the controller samples every {self.dt_s:g} s and has no frequencies above {0.5 / self.dt_s:g} Hz;"
                    f" {np.abs(s.imag).max() / 2 / np.pi:g} Hz is asked for",
                    hint="narrow the frequencies",
                )
            x = s * self.dt_s
            inner, hold = self.system.response(np.exp(x)), -np.expm1(-x) / x
        return self._on_inputs(-inner * (hold * pade_response(s, self.delay_s))[:, None, None])

    def sequence(self, s: ComplexArray) -> ComplexArray:
        """[F, 18, 15]: minus the commands by the read-outs, both sequences of a sampled controller; no delay."""
        assert self.dt_s is not None
        return np.asarray(self._on_inputs(-self.system.response(np.exp(s * self.dt_s))) @ self.returns)

    def _on_inputs(self, values: ComplexArray) -> ComplexArray:
        """[F, 18, L] from the rows of its outputs."""
        out = np.zeros((len(values), N_INPUTS, len(self.inputs)), dtype=np.complex128)
        out[:, [INPUTS.index(name) for name in self.outputs]] = values
        return out

    def state_space(self) -> StateSpace:
        """From the read-outs [15] to minus u [18]; of a sampled controller in its own time, without the delay."""
        pick = np.zeros((N_INPUTS, len(self.outputs)))
        pick[[INPUTS.index(name) for name in self.outputs], range(len(self.outputs))] = -1.0
        s = self.system
        whole = StateSpace(s.a, s.b @ self.returns, pick @ s.c, pick @ s.d @ self.returns)
        if self.dt_s is not None or self.delay_s == 0.0:
            return whole
        return delays(self.delay_s, self.outputs).after(whole)


def delays(delay_s: float, outputs: Sequence[str]) -> StateSpace:
    """The same delay, as its Padé approximant, on the named rows of w [18]; the others stay as they are."""
    one, m = pade_delay(delay_s), len(outputs)
    rows = [INPUTS.index(name) for name in outputs]
    pick = np.zeros((m, N_INPUTS))
    pick[range(m), rows] = 1.0
    d = np.eye(N_INPUTS)
    d[rows, rows] = one.d[0, 0]
    blocks = np.eye(m)
    return StateSpace(np.kron(blocks, one.a), np.kron(blocks, one.b) @ pick, pick.T @ np.kron(blocks, one.c), d)


def _check_names(names: tuple[str, ...], known: tuple[str, ...], what: str) -> None:
    for n, name in enumerate(names):
        if name not in known:
            raise PhysicsError(
                f"unknown {what} {name!r} of the controller", hint=f"{what}s are among {', '.join(known)}"
            )
        if name in names[:n]:
            raise PhysicsError(f"{what} {name!r} of the controller is named twice")
    if not names:
        raise PhysicsError(f"the controller has no {what}s")
