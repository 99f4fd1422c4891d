"""The matrices and notes of a case in state-space form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.matrix_files.named import NamedMatrix
from tedm_cli.noise.shaping.models import AnyModel
from tedm_cli.noise.shaping.state_space import StateSpace

CONTINUOUS = (
    "x' = A x + B w, y = C x + D w, time in s.",
    "w: independent white noises, each of one-sided PSD 1/Hz, which is a two-sided PSD of 1/2 per Hz:",
    "E[w(t) w(t')'] = I delta(t - t')/2, so A P + P A' + B B'/2 = 0 for the covariance P = X0 X0' of x.",
    "Then the one-sided PSD of y is the sum over the columns of |C (2 pi i f - A)^-1 B + D|^2.",
    "Simulink, Band-Limited White Noise: Noise power 0.5 (its power is the two-sided PSD), any Sample time Ts that is",
    "short against the time constants of A, a seed for each w. By hand: sqrt(1/(2 Ts)) randn, held over Ts. MATLAB:",
    "covar(ss(A, B, C, D), 0.5).",
)


@dataclass(frozen=True, eq=False)
class Labels:
    """Names and units of outputs and areas."""

    outputs: list[str]
    output_units: list[str]
    areas: list[str]
    area_units: list[str]


def state_space_matrices(
    model: AnyModel, labels: Labels, *, temperatures: bool, rate_hz: float | None, band: NamedMatrix
) -> list[NamedMatrix]:
    """A, B, C, D, with `temperatures` C_T and D_T, X0, the same of the sampled form with `rate_hz`, G, and `band`."""
    states, continuous = model.state_names, model.continuous()
    noises = [f"w{j + 1}" for j in range(model.noises)]
    matrices = _matrices(continuous, labels, states, noises, "", temperatures, "white noise")
    if rate_hz is not None:
        found = model.discrete(rate_hz)
        numbers = [f"e{i + 1}" for i in range(found.b.shape[1])]
        matrices += _matrices(found, labels, states, numbers, "_d", temperatures, "standard normal numbers")
        matrices.append(NamedMatrix("rate", np.array([[rate_hz]]), [], ["rate"], [], ["Hz"], "samples per second"))
    root = NamedMatrix(
        "X0",
        continuous.x0,
        states,
        states,
        ["1"] * len(states),
        ["1"] * len(states),
        "factor of the stationary covariance of x: x(0) = X0 times standard normal numbers starts stationary",
    )
    gain = NamedMatrix(
        "G",
        model.gain,
        labels.outputs,
        labels.areas,
        labels.output_units,
        labels.area_units,
        "static gain: output per unit of an area's temperature",
    )
    return [*matrices, root, gain, band]


def _matrices(
    s: StateSpace, labels: Labels, states: list[str], noises: list[str], suffix: str, temperatures: bool, driven: str
) -> list[NamedMatrix]:
    rate = "1" if suffix else "1/s"
    form = "sampled: x[k+1] = A_d x[k] + B_d e[k], y[k] = C_d x[k] + D_d e[k]" if suffix else "continuous"
    one_x, one_w = ["1"] * len(states), ["1"] * len(noises)
    kelvin = labels.area_units
    rows = [
        ("A", s.a, states, states, [rate] * len(states), one_x, "states by states"),
        ("B", s.b, states, noises, [rate] * len(states), one_w, f"states by {driven}"),
        ("C", s.c, labels.outputs, states, labels.output_units, one_x, "outputs by states"),
        ("D", s.d, labels.outputs, noises, labels.output_units, one_w, f"outputs by {driven}"),
    ]
    if temperatures:
        rows += [
            ("C_T", s.temperature_c, labels.areas, states, kelvin, one_x, "temperatures of the areas by states"),
            ("D_T", s.temperature_d, labels.areas, noises, kelvin, one_w, f"temperatures of the areas by {driven}"),
        ]
    return [NamedMatrix(f"{name}{suffix}", v, r, c, ru, cu, f"{what} ({form})") for name, v, r, c, ru, cu, what in rows]


def sampled_notes(rate_hz: float, direct: bool) -> list[str]:
    """What the sampled form is."""
    notes = [
        f"Sampled at {rate_hz:g} Hz: x[k+1] = A_d x[k] + B_d e[k], y[k] = C_d x[k] + D_d e[k], e independent standard",
        "normal numbers (no factor). Its covariance is exactly that of the continuous system; what the spectrum holds",
        "above half the rate is folded down.",
    ]
    if direct:
        notes.append(
            "Some filters feed white noise through, which has no value at a time: their outputs are means over the"
            " sample interval, which takes sinc(f/rate)^2 off the power of what is not white."
        )
    return notes
