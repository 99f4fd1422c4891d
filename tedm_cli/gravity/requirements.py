"""Limits on the field at rest, on a test mass or on the difference of two, and verdicts by them.

What is limited is the field of one subsystem of the satellite, of several together, or of everything in the model.
Contributions add linearly, so subsystems together are allowed the sum of what each of them is.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tedm_cli.arrays import FloatArray

ALL = "all"  # of subsystems: everything in the model

_GRADIENTS = ("gamma_xx", "gamma_xy", "gamma_xz", "gamma_yy", "gamma_yz", "gamma_zz")
AT_REST_UNITS = {
    **dict.fromkeys(_GRADIENTS, "1/s^2"),
    "a_x": "m/s^2",
    "a_y": "m/s^2",
    "a_z": "m/s^2",
    "omegadot_theta": "rad/s^2",
    "omegadot_eta": "rad/s^2",
    "omegadot_phi": "rad/s^2",
}
"""What can be judged, in the order of `dc_quantities`; theta, eta and phi turn about x, y and z."""


@dataclass(frozen=True)
class AtRestLimit:
    """One limit on the field at rest; SI units by `AT_REST_UNITS`.

    Parameters
    ----------
    requirement : name of what it belongs to; source : where it is from.
    quantity : one of `AT_REST_UNITS`.
    subsystems : those whose field it is, together; none for everything in the model.
    lower, upper : ends of the range, below and above 0.
    test_masses : names. Each of them is judged, or, where it `is_difference`, the second minus the first.
    """

    requirement: str
    quantity: str
    subsystems: tuple[str, ...]
    lower: float
    upper: float
    test_masses: tuple[str, ...]
    is_difference: bool
    source: str

    def is_of_all(self, subsystems: Collection[str], rest: str) -> bool:
        """Whether it limits the field of everything in a model with these subsystems, of which one may be the rest."""
        every = bool(rest) and set(self.subsystems) == set(subsystems)
        return not self.subsystems or not subsystems or every

    @property
    def places(self) -> list[tuple[str, str]]:
        """What is judged: (test mass, test mass whose value is taken off, or "")."""
        if self.is_difference:
            first, second = self.test_masses
            return [(second, first)]
        return [(name, "") for name in self.test_masses]


@dataclass(frozen=True)
class DcVerdict:
    """One quantity of the field at rest against its range; SI units by `AT_REST_UNITS`.

    Parameters
    ----------
    test_mass, minus : names; where there is a `minus`, what is judged is the difference of the two test masses.
    quantity : one of `AT_REST_UNITS`.
    subsystem : whose field it is: a name, several joined by +, or `ALL`.
    value, lower, upper : the quantity, and the ends of its range, below and above 0.
    requirement, source : name of the requirement, and where it is from.
    whole : whether the field is that of everything in the model, not of a part of it.
    """

    test_mass: str
    quantity: str
    subsystem: str
    value: float
    lower: float
    upper: float
    minus: str = ""
    requirement: str = ""
    source: str = ""
    whole: bool = True

    @property
    def place(self) -> str:
        """`TM1`, or `TM2-TM1` where their difference is judged."""
        return f"{self.test_mass}-{self.minus}" if self.minus else self.test_mass

    @property
    def unit(self) -> str:
        """Unit of value and range."""
        return AT_REST_UNITS[self.quantity]

    @property
    def limit(self) -> float:
        """The end of the range on the side of the value."""
        return self.upper if self.value >= 0.0 else self.lower

    @property
    def ratio(self) -> float:
        """Value over the limit on its side; at most 1 within the range."""
        return self.value / self.limit

    @property
    def passed(self) -> bool:
        """Whether the value is within the range."""
        return self.ratio <= 1.0


def dc_quantities(acceleration: ArrayLike, angular_acceleration: ArrayLike, gamma_lin: ArrayLike) -> FloatArray:
    """What can be judged, [12] in the order of `AT_REST_UNITS`, of a field in the frame of its test mass, SI."""
    gradient = np.asarray(gamma_lin, dtype=np.float64)[np.triu_indices(3)]
    return np.concatenate([gradient, np.asarray(acceleration), np.asarray(angular_acceleration)])


def axes_of(quantity: str) -> tuple[int, ...]:
    """The axes of the test mass that a quantity is told along: 0, 1, 2 for x, y, z."""
    end = quantity.rpartition("_")[2]
    turns = {"theta": (0,), "eta": (1,), "phi": (2,)}
    return turns[end] if end in turns else tuple(sorted({"xyz".index(letter) for letter in end}))


def narrowest(
    limits: Sequence[AtRestLimit], test_mass: str, subsystems: Collection[str] = (), rest: str = ""
) -> FloatArray:
    """Magnitude [12] to which the field of everything in the model is limited on a test mass; nan where it is not.

    The narrower end of the narrowest limit, of the test mass itself or of a difference that it is part of.
    """
    found = np.full(len(AT_REST_UNITS), np.nan)
    for limit in limits:
        if test_mass in limit.test_masses and limit.is_of_all(subsystems, rest):
            row = list(AT_REST_UNITS).index(limit.quantity)
            found[row] = np.fmin(found[row], min(-limit.lower, limit.upper))
    return found


def judge_at_rest(
    limits: Sequence[AtRestLimit], fields: Mapping[str, Mapping[str, FloatArray]], rest: str = ""
) -> list[DcVerdict]:
    """Verdicts on the static field, by test mass first and by limit then; differences come last.

    Parameters
    ----------
    limits : what is required.
    fields : by test mass and subsystem, [12] as `dc_quantities` has them; `ALL` is everything in the model.
    rest : the subsystem that holds whatever no other does, if there is one: all subsystems together are `ALL` then.
    """
    found = []
    for limit in limits:
        row = list(AT_REST_UNITS).index(limit.quantity)
        for test_mass, minus in limit.places:
            whole = limit.is_of_all(set(fields[test_mass]) - {ALL}, rest)
            names = (ALL,) if whole else limit.subsystems

            def value(of: str, names: Sequence[str] = names, row: int = row) -> float:
                return float(sum(fields[of][name][row] for name in names))

            found.append(
                DcVerdict(
                    test_mass,
                    limit.quantity,
                    "+".join(limit.subsystems) or ALL,
                    value(test_mass) - (value(minus) if minus else 0.0),
                    limit.lower,
                    limit.upper,
                    minus,
                    limit.requirement,
                    limit.source,
                    whole,
                )
            )
    order = {name: place for place, name in enumerate(fields)}
    return sorted(found, key=lambda v: (bool(v.minus), order[v.test_mass]))
