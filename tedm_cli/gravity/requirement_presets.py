"""Limits of LISA Pathfinder on the field at rest (Montemurro 2004, section 4.2.3, and 4.3 with tables 4.2 to 4.4).

The spacecraft is divided into the inertial sensor of the test mass (IS), the rest of the LTP with the other inertial
sensor (LTP), and the rest of the satellite (S/C). Equations 4.7 to 4.12 limit the *difference* of force and torque
between the test masses, from all that acts at rest; tables 4.3 and 4.4 apportion the part of it that gravity may take
to the subsystems, and so limit differences as well (eq. 7.3 and 7.10 say so of the LTP). Stiffness is that of each
test mass by itself (eq. 4.5, table 4.2, eq. 7.19).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from tedm_cli.gravity.requirements import AtRestLimit

LPF = "lpf"
SUBSYSTEMS = ("IS", "LTP", "S/C")
REQUIRED = ("IS", "LTP")  # the spacecraft may be left out of a model

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

WHOLE = {
    "a_x": 1.3e-9,
    "a_y": 2.2e-9,
    "a_z": 3.7e-9,
    "omegadot_phi": 1.6e-8,
    "omegadot_eta": 2.3e-8,
    "omegadot_theta": 2.7e-8,
}
"""Equations 4.7 to 4.12: magnitude of the difference between the test masses, of all that acts, m/s² and rad/s²."""


@dataclass(frozen=True)
class AtRestPreset:
    """A preset as the report calls it, the subsystems that it apportions to, and those a divided model must have."""

    title: str
    subsystems: tuple[str, ...]
    required: tuple[str, ...]


PRESETS = {LPF: AtRestPreset("LISA Pathfinder, static self-gravity", SUBSYSTEMS, REQUIRED)}


def lpf_limits(
    known: Collection[str], test_masses: tuple[str, ...], *, is_difference: bool = True
) -> list[AtRestLimit]:
    """The limits of LISA Pathfinder on what is modelled.

    Parameters
    ----------
    known : subsystems of the model; those that are not of LISA Pathfinder have no allocation. Where there are none, the
        model is all of the LTP with its inertial sensors.
    test_masses : names; the difference is that of the second and the first.
    is_difference : as published. Otherwise tables 4.3 and 4.4 are applied to each test mass, which is not what they say
        but stricter where both are pulled alike; equations 4.7 to 4.12 are left out then.

    Returns
    -------
    By quantity: of each subsystem; of those together, against the sum of their allocations; and, of differences, of
    everything in the model against equations 4.7 to 4.12.
    """
    mine = tuple(name for name in SUBSYSTEMS if name in known)
    single = [(name,) for name in mine]
    together = [mine] if len(mine) > 1 else []
    sets = [*single, *together] if known else [REQUIRED]
    limits = []

    def add(quantity: str, of: tuple[str, ...], ends: tuple[float, float], source: str, difference: bool) -> None:
        where = f"Montemurro 2004, {source}"
        limits.append(AtRestLimit(LPF, quantity, of, *ends, test_masses, difference, where))

    for names in sets:
        ranges = [STIFFNESS[name] for name in names]
        add("gamma_xx", names, (sum(r[0] for r in ranges), sum(r[1] for r in ranges)), "table 4.2", False)
    for table, source in ((ACCELERATION, "table 4.3"), (ANGULAR_ACCELERATION, "table 4.4")):
        for quantity, by_subsystem in table.items():
            for names in sets:
                magnitude = sum(by_subsystem[name] for name in names)
                add(quantity, names, (-magnitude, magnitude), source, is_difference)
            if is_difference:
                add(quantity, (), (-WHOLE[quantity], WHOLE[quantity]), "eq. 4.7 to 4.12", True)
    return limits
