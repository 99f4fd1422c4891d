"""Scalar control loops: their shape, delay and response, and the state space of both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.errors import PhysicsError

INTEGRAL, LEAD, ROLL_OFF = 15.0, 3.5, 10.0
#: Padé approximant (3, 3) of e^{-x}: coefficients of 1, x, x², x³ of the denominator; odd ones turn in the numerator.
_PADE = np.array([120.0, 60.0, 12.0, 1.0])
PADE_ORDER = len(_PADE) - 1


@dataclass(frozen=True, eq=False)
class StateSpace:
    """x' = A x + B u, y = C x + D u."""

    a: FloatArray
    b: FloatArray
    c: FloatArray
    d: FloatArray

    @classmethod
    def gain(cls, d: FloatArray) -> StateSpace:
        """A system without states."""
        outputs, inputs = d.shape
        return cls(np.zeros((0, 0)), np.zeros((0, inputs)), np.zeros((outputs, 0)), d)

    def after(self, first: StateSpace) -> StateSpace:
        """This system driven by the outputs of `first`."""
        a = scipy.linalg.block_diag(first.a, self.a)
        a[len(first.a) :, : len(first.a)] = self.b @ first.c
        b = np.concatenate([first.b, self.b @ first.d])
        return StateSpace(a, b, np.concatenate([self.d @ first.c, self.c], axis=1), self.d @ first.d)

    def response(self, s: ComplexArray) -> ComplexArray:
        """C (s - A)⁻¹ B + D at `s` [F], [F, outputs, inputs]."""
        matrix = s[:, None, None] * np.eye(len(self.a)) - self.a
        return np.asarray(self.c @ np.linalg.solve(matrix, self.b.astype(np.complex128)[None]) + self.d)


@dataclass(frozen=True)
class LoopShape:
    """C(s) = g (s + ω_c/i)(s + ω_c/l) / [s (1 + s/(r ω_c))²] with |C(i ω_c)| = ω_c².

    `integral` i, `lead` l and `roll_off` r.
    """

    integral: float = INTEGRAL
    lead: float = LEAD
    roll_off: float = ROLL_OFF


@dataclass(frozen=True)
class Loop:
    """One loop: acceleration demand v = C(s) e^{-sτ} e for the error e of the coordinate `name`.

    Raises
    ------
    PhysicsError : a transfer function of one's own with more zeros than poles, or without a leading coefficient.
    """

    name: str
    crossover_hz: float
    delay_s: float
    shape: LoopShape = LoopShape()
    #: Own transfer function in place of the shape: numerator and denominator, highest power first, 1/s².
    transfer: tuple[tuple[float, ...], tuple[float, ...]] | None = None

    def __post_init__(self) -> None:
        if self.transfer is None:
            return
        numerator, denominator = self.transfer
        if not denominator or denominator[0] == 0.0:
            raise PhysicsError(f"the denominator of loop {self.name} has no coefficient other than 0")
        if len(np.trim_zeros(numerator, "f")) > len(denominator):
            raise PhysicsError(
                f"the controller of loop {self.name} is improper: numerator of order {len(numerator) - 1}, denominator"
                f" of order {len(denominator) - 1}",
                hint="add a roll-off: a controller that differentiates amplifies noise without bound",
            )

    @property
    def coefficients(self) -> tuple[FloatArray, FloatArray]:
        """Numerator and denominator of C(s), highest power first."""
        if self.transfer is not None:
            return np.array(np.trim_zeros(self.transfer[0], "f") or (0.0,)), np.array(self.transfer[1])
        w, gain, shape = self._corner, self._gain, self.shape
        lag = 1.0 / (shape.roll_off * w)
        zeros = (w / shape.integral, w / shape.lead)
        return gain * np.array([1.0, sum(zeros), zeros[0] * zeros[1]]), np.array([lag**2, 2.0 * lag, 1.0, 0.0])

    @property
    def _corner(self) -> float:
        return 2.0 * np.pi * self.crossover_hz

    @property
    def _gain(self) -> float:
        """g, 1/s."""
        w, shape = self._corner, self.shape
        at = (1.0 + 1j / shape.roll_off) ** 2 * 1j * w / ((1j + 1.0 / shape.integral) * (1j + 1.0 / shape.lead))
        return float(abs(at))

    @property
    def delayed(self) -> tuple[FloatArray, FloatArray]:
        """Numerator and denominator of C(s) e^{-sτ}, the delay as its Padé approximant; highest power first."""
        scale = self.delay_s ** np.arange(len(_PADE))
        late = (_PADE * (-1.0) ** np.arange(len(_PADE)) * scale)[::-1], (_PADE * scale)[::-1]
        numerator, denominator = (np.convolve(*pair) for pair in zip(self.coefficients, late, strict=True))
        return np.asarray(numerator), np.asarray(denominator)

    def response(self, s: ComplexArray) -> ComplexArray:
        """C(s) e^{-sτ}, the delay as its Padé approximant, at `s` [F]."""
        return rational(*polynomials([self]), s)[:, 0]

    def state_space(self) -> StateSpace:
        """The same as a system of one input and one output."""
        controller = self._sections() if self.transfer is None else _companion(*self.coefficients)
        return pade_delay(self.delay_s).after(controller)

    def _sections(self) -> StateSpace:
        """Sections in series, each with its own pole: states of one size."""
        w, shape = self._corner, self.shape
        pole = shape.roll_off * w
        integral = _section(0.0, 1.0, w / shape.integral)
        lead = _section(-pole, pole, pole * (w / shape.lead - pole))
        roll_off = _section(-pole, 0.0, pole)
        gain = StateSpace.gain(np.array([[self._gain]]))
        return roll_off.after(lead).after(integral).after(gain)


def polynomials(loops: Sequence[Loop]) -> tuple[FloatArray, FloatArray]:
    """Numerators and denominators of all loops with their delays, [loops, n], lowest power first."""
    pairs = [loop.delayed for loop in loops]
    size = max(len(p) for pair in pairs for p in pair)
    numerators, denominators = (np.zeros((len(loops), size)) for _ in range(2))
    for n, (numerator, denominator) in enumerate(pairs):
        numerators[n, : len(numerator)], denominators[n, : len(denominator)] = numerator[::-1], denominator[::-1]
    return numerators, denominators


def rational(numerators: FloatArray, denominators: FloatArray, s: ComplexArray) -> ComplexArray:
    """Quotients of `polynomials` at `s` [F], [F, loops]."""
    powers = np.vander(s, numerators.shape[1], increasing=True)
    out: ComplexArray = (powers @ numerators.T) / (powers @ denominators.T)
    return out


def pade_response(s: ComplexArray, delay_s: float) -> ComplexArray:
    """The Padé approximant (3, 3) of e^{-sτ} at `s`; 6e-10 off at 0.1 Hz for τ = 0.4 s."""
    x = s * delay_s
    signs = (-1.0) ** np.arange(len(_PADE))
    out: ComplexArray = np.polyval((_PADE * signs)[::-1], x) / np.polyval(_PADE[::-1], x)
    return out


def pade_delay(delay_s: float) -> StateSpace:
    """The approximant as a system; no states without a delay."""
    if delay_s == 0.0:
        return StateSpace.gain(np.eye(1))
    signs = (-1.0) ** np.arange(len(_PADE))
    unit = _companion((_PADE * signs)[::-1], _PADE[::-1])  # in time over τ
    return StateSpace(unit.a / delay_s, unit.b / delay_s, unit.c, unit.d)


def _section(pole: float, direct: float, residue: float) -> StateSpace:
    """direct + residue / (s - pole), input and output scaled alike."""
    size = np.sqrt(abs(residue))
    return StateSpace(
        np.array([[pole]]), np.array([[size]]), np.array([[np.copysign(size, residue)]]), np.array([[direct]])
    )


def _companion(numerator: FloatArray, denominator: FloatArray) -> StateSpace:
    """Controllable form of a proper transfer function, highest power first."""
    order = len(denominator) - 1
    denominator, numerator = denominator / denominator[0], np.asarray(numerator) / denominator[0]
    padded = np.concatenate([np.zeros(order + 1 - len(numerator)), numerator])
    direct = padded[0]
    a = np.zeros((order, order))
    a[:-1, 1:] = np.eye(max(order - 1, 0))[: max(order - 1, 0)]
    a[-1] = -denominator[:0:-1]
    b = np.zeros((order, 1))
    if order:
        b[-1] = 1.0
    c = (padded[1:] - direct * denominator[1:])[::-1][None, :]
    return StateSpace(a, b, c, np.array([[direct]]))
