"""The kinds of criteria: what each is, which keys narrow it down, and what is better."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

RATIO_PARTS = "part of ratio²"


@dataclass(frozen=True)
class CriterionKind:
    """What a criterion of this kind is.

    Parameters
    ----------
    words : what its value is. unit : of the value; None where it is the unit of the output.
    keys : keys of the configuration that narrow it down; `needed`, those it cannot be without.
    limit : what it is judged by, unless the configuration gives a limit; None: it is not judged.
    parts : what its value is the sum of; empty where it has no parts.
    goal : what is better, unless the configuration says otherwise.
    """

    words: str
    keys: tuple[str, ...] = ()
    needed: tuple[str, ...] = ()
    unit: str | None = "1"
    limit: float | None = None
    parts: str = ""
    goal: Literal["min", "max"] = "min"


_NOISE = ("case", "outputs", "requirement")
_AT_REST = ("quantities", "subsystem", "requirement")
KINDS = {
    "noise_ratio": CriterionKind(
        "largest ratio of noise to requirement, safety factor included",
        (*_NOISE, "contributors"),
        limit=1.0,
        parts=RATIO_PARTS,
    ),
    "distortion_ratio": CriterionKind(
        "the same of read-outs by distortion alone, as if the bench did not move as one", _NOISE, limit=1.0
    ),
    "bound_ratio": CriterionKind("the same at the worst correlation of the areas", _NOISE, limit=1.0),
    "noise": CriterionKind(
        "largest amplitude spectral density at one frequency, without the safety factor",
        ("case", "outputs", "frequency_hz"),
        ("outputs",),
        unit=None,
    ),
    "closed_loop_ratio": CriterionKind(
        "largest ratio of noise to requirement in closed loop, of Δg unless outputs are named",
        _NOISE,
        limit=1.0,
        parts=RATIO_PARTS,
    ),
    "closed_loop_thermal_ratio": CriterionKind(
        "the same in closed loop by the temperatures alone, without all other noise", _NOISE, limit=1.0
    ),
    "probability": CriterionKind("probability that a requirement is violated", ("case", "outputs")),
    "rest_ratio": CriterionKind(
        "largest ratio of the field at rest to its limit", _AT_REST, limit=1.0, parts="part of the ratio"
    ),
    "rest_violations": CriterionKind("number of limits at rest that are violated", _AT_REST, limit=0.0),
    "mass": CriterionKind("mass of the finite-element model", unit="kg", parts="kg"),
    "compensation_mass": CriterionKind("mass of the compensation masses", unit="kg", parts="kg"),
    "first_frequency": CriterionKind("lowest natural frequency", unit="Hz", goal="max"),
    "transmission": CriterionKind(
        "largest distortion by the motion of a foot: of an optical bench, or of outputs that are named, without the"
        " motion as one",
        ("motion", "feet", "outputs"),
        unit=None,
    ),
}
"""By the name that the configuration has for it."""
