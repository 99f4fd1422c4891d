"""Static self-gravity requirements of LISA Pathfinder by subsystem (Montemurro 2004, section 4.3, tables 4.2 to 4.4).

The spacecraft is divided into the inertial sensor of the test mass (IS), the rest of the LTP with the other inertial
sensor (LTP), and the rest of the satellite (S/C). Contributions add linearly, so the limit of two subsystems together
is the sum of theirs. A model of the LTP says nothing of the S/C.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tedm_cli.arrays import FloatArray

MODELLED = "IS+LTP"

AT_REST_UNITS = {
    "gamma_xx": "1/s^2",
    "a_x": "m/s^2",
    "a_y": "m/s^2",
    "a_z": "m/s^2",
    "omegadot_theta": "rad/s^2",
    "omegadot_eta": "rad/s^2",
    "omegadot_phi": "rad/s^2",
}
"""The judged quantities in the order of `dc_quantities`; theta, eta and phi turn about x, y and z."""

STIFFNESS = {"IS": (-1e-7, 2e-7), "LTP": (-2e-7, 3e-7), "S/C": (-2e-7, 3e-7)}
"""Table 4.2 at low frequency: range of the force gradient along the sensitive axis, 1/s²."""

ACCELERATION = {
    "a_x": {"IS": 0.35e-9, "LTP": 0.40e-9, "S/C": 0.35e-9},
    "a_y": {"IS": 0.55e-9, "LTP": 0.60e-9, "S/C": 0.55e-9},
    "a_z": {"IS": 1.1e-9, "LTP": 1.1e-9, "S/C": 1.0e-9},
}
"""Table 4.3: magnitude of the DC force per mass, m/s²."""

ANGULAR_ACCELERATION = {
    "omegadot_theta": {"IS": 9.0e-9, "LTP": 7.0e-9, "S/C": 7.0e-9},
    "omegadot_eta": {"IS": 8.0e-9, "LTP": 5.0e-9, "S/C": 5.0e-9},
    "omegadot_phi": {"IS": 6.0e-9, "LTP": 4.0e-9, "S/C": 4.0e-9},
}
"""Table 4.4: magnitude of the DC torque per moment of inertia, rad/s²."""


@dataclass(frozen=True)
class DcVerdict:
    """One quantity of one subsystem on one test mass against its range; SI units by `AT_REST_UNITS`."""

    test_mass: str
    quantity: str
    subsystem: str
    value: float
    lower: float
    upper: float

    @property
    def unit(self) -> str:
        """Unit of value and range."""
        return AT_REST_UNITS[self.quantity]

    @property
    def whole(self) -> bool:
        """Whether it is of all that is modelled, not of a part of it."""
        return self.subsystem == MODELLED

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


def allocation(quantity: str, *subsystems: str) -> tuple[float, float]:
    """Lower and upper limit of a quantity for one subsystem, or for several together."""
    ranges = []
    for name in subsystems:
        if quantity == "gamma_xx":
            ranges.append(STIFFNESS[name])
        else:
            magnitude = (ACCELERATION | ANGULAR_ACCELERATION)[quantity][name]
            ranges.append((-magnitude, magnitude))
    return sum(low for low, _ in ranges), sum(high for _, high in ranges)


def dc_quantities(acceleration: ArrayLike, angular_acceleration: ArrayLike, gamma_lin: ArrayLike) -> FloatArray:
    """The judged quantities, [7] in the order of `AT_REST_UNITS`, of a field in the frame of its test mass, SI."""
    gamma_xx = np.asarray(gamma_lin, dtype=np.float64)[0, 0]
    return np.concatenate([[gamma_xx], np.asarray(acceleration), np.asarray(angular_acceleration)])


def judge_at_rest(test_mass: str, total: FloatArray, inertial_sensor: FloatArray | None) -> list[DcVerdict]:
    """Verdicts on the static field of a model of the LTP.

    Parameters
    ----------
    test_mass : name of the test mass.
    total : [7], quantities of everything in the model (see `dc_quantities`).
    inertial_sensor : [7], those of the inertial sensor of this test mass; what is left of `total` is the LTP. Where it
        is not known, only both together are judged.

    Returns
    -------
    By quantity: IS, LTP (where known), and both together against the sum of their allocations.
    """
    verdicts = []
    for row, quantity in enumerate(AT_REST_UNITS):
        parts = (
            [] if inertial_sensor is None else [("IS", inertial_sensor[row]), ("LTP", (total - inertial_sensor)[row])]
        )
        for subsystem, value in [*parts, (MODELLED, total[row])]:
            lower, upper = allocation(quantity, *subsystem.split("+"))
            verdicts.append(DcVerdict(test_mass, quantity, subsystem, float(value), lower, upper))
    return verdicts
