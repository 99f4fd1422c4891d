"""Names, units and order of the signals of the drag-free loop.

Coordinates p [15]: attitude of the spacecraft, then position (m) and rotation (rad) of each test mass relative to its
housing, in the nominal frame of the test mass. Inputs w [18]: force (N) and torque (N m) on the spacecraft in the
basic frame, then those that the spacecraft exerts on each test mass, in the test mass's frame. Disturbing accelerations
s [12] of the test masses, with their reaction on the spacecraft.
"""

from __future__ import annotations

N_COORDINATES, N_INPUTS, N_STRAY = 15, 18, 12
TEST_MASSES = ("TM1", "TM2")
_MOTION = ("x", "y", "z", "theta", "eta", "phi")
_WRENCH = ("Fx", "Fy", "Fz", "Lx", "Ly", "Lz")
_ACCELERATION = tuple(f"{quantity}_{axis}" for quantity in ("a", "omegadot") for axis in "xyz")

COORDINATES = ("SC_theta", "SC_eta", "SC_phi", *(f"{tm}_{m}" for tm in TEST_MASSES for m in _MOTION))
INPUTS = tuple(f"{body}_{w}" for body in ("SC", *TEST_MASSES) for w in _WRENCH)
STRAY = tuple(f"{tm}_{a}" for tm in TEST_MASSES for a in _ACCELERATION)
BODY_ACCELERATIONS = tuple(f"{body}_{a}" for body in ("SC", *TEST_MASSES) for a in _ACCELERATION)
HOUSING_ACCELERATIONS = tuple(f"H{i}_a_{axis}" for i in (1, 2) for axis in "xyz")
DELTA_G = ("delta_g", "delta_g_full", "delta_g_true")

#: Everything that may carry noise: forces and torques, read-out noise, disturbing accelerations.
DISTURBANCES = (*(f"w_{n}" for n in INPUTS), *(f"n_{n}" for n in COORDINATES), *(f"s_{n}" for n in STRAY))
OUTPUTS = (
    *COORDINATES,
    *(f"meas_{n}" for n in COORDINATES),
    *(f"u_{n}" for n in INPUTS),
    *BODY_ACCELERATIONS,
    *HOUSING_ACCELERATIONS,
    *DELTA_G,
)


def index(names: tuple[str, ...], *wanted: str) -> list[int]:
    """Places of the `wanted` names."""
    return [names.index(name) for name in wanted]


def motion_of(tm: int) -> slice:
    """Places in `COORDINATES` of the six motions of test mass `tm` (0 or 1)."""
    return slice(3 + 6 * tm, 9 + 6 * tm)


def wrench_on(tm: int) -> slice:
    """Places in `INPUTS` of force and torque on test mass `tm` (0 or 1)."""
    return slice(6 + 6 * tm, 12 + 6 * tm)


def unit(name: str) -> str:
    """SI unit of a coordinate, input, disturbance or output."""
    stem = name.removeprefix("meas_").removeprefix("n_")
    if stem in COORDINATES:
        return "rad" if stem.rpartition("_")[2] in ("theta", "eta", "phi") else "m"
    stem = name.removeprefix("u_").removeprefix("w_")
    if stem in INPUTS:
        return "N" if "F" in stem.rpartition("_")[2] else "N m"
    return "rad s^-2" if "omegadot" in name else "m s^-2"


def kind(name: str) -> str:
    """Quantity of an output, as requirements name it; forces and torques are judged by none."""
    return {
        "m": "displacement",
        "rad": "angle",
        "m s^-2": "acceleration",
        "rad s^-2": "angular_acceleration",
        "N": "force",
        "N m": "torque",
    }[unit(name)]
