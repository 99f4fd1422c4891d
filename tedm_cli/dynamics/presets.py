"""LISA Pathfinder's numbers: spacecraft, stiffness and noise of every source, each with where it is from."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.dynamics.bodies import DynamicTestMass, Spacecraft
from tedm_cli.dynamics.signals import STRAY, TEST_MASSES
from tedm_cli.dynamics.sources import NoiseSource, PowerLaw, SpectrumTable

LTPDA = "LTPDA ltp_parameters, after the external interface document of the drag-free control"
SPACECRAFT_MASS_KG = 422.7
SPACECRAFT_INERTIA_KG_M2 = (202.5, 209.7, 191.7)
#: From the middle of the test masses to the centre of mass: along the line from test mass 2 to 1, across, and along z.
CENTRE_FROM_MIDDLE_M = (0.005, 0.006, -0.1393)
#: Stiffness of a test mass by its own motion, gravity and electrostatics together, x y z θ η φ, 1/s²; destabilising.
TOTAL_STIFFNESS_S2 = (1.9e-6, 2.8e-6, 4.7e-6, 5.5e-6, 5.3e-6, 4.0e-6)
ACTUATION_STABILITY = 5e-6  # δ: relative amplitude noise of the actuation, per √Hz; assumed


def lpf_spacecraft(test_masses: Sequence[DynamicTestMass]) -> Spacecraft:
    """LISA Pathfinder's spacecraft around test masses at their own places: its axis from test mass 2 to 1 is theirs."""
    first, second = (tm.position_m for tm in test_masses)
    along = first - second
    along = along / np.linalg.norm(along)
    up = np.array([0.0, 0.0, 1.0])
    across = np.cross(up, along)
    centre = (first + second) / 2.0 + np.stack([along, across, up], axis=1) @ np.array(CENTRE_FROM_MIDDLE_M)
    return Spacecraft(SPACECRAFT_MASS_KG, np.diag(SPACECRAFT_INERTIA_KG_M2), centre)


def lpf_sources(
    test_masses: Sequence[DynamicTestMass], at_rest: FloatArray, actuation_stability: float = ACTUATION_STABILITY
) -> list[NoiseSource]:
    """All noise sources but temperature.

    Parameters
    ----------
    at_rest : [12] accelerations of the test masses at rest, in the order of `signals.STRAY`: what the actuation holds.
    actuation_stability : δ, per √Hz; the force noise is 2 δ times the force that is held (Montemurro 2004, 4.2.3).
    """
    out = [
        NoiseSource(
            "optical_x1", "optical", {"n_TM1_x": 1.0, "n_TM2_x": 1.0}, PowerLaw(35e-15), "PRL 116, 231101 (2016)"
        ),
        NoiseSource("optical_x12", "optical", {"n_TM2_x": 1.0}, PowerLaw(35e-15), "PRL 116, 231101 (2016)"),
    ]
    for tm in TEST_MASSES:
        out += [
            _read_out("optical", f"{tm}_{dof}", PowerLaw(1e-10), "PRD 106, 082001 (2022), best angle")
            for dof in ("eta", "phi")
        ]
        capacitive = "PRD 96, 062004 (2017); the power of the tail is assumed"
        out += [_read_out("capacitive", f"{tm}_{dof}", PowerLaw(1.8e-9, 1e-3, 1.0), capacitive) for dof in ("y", "z")]
        out.append(_read_out("capacitive", f"{tm}_theta", PowerLaw(130e-9, 1e-3, 1.0), capacitive))
    out += [_read_out("star_tracker", f"SC_{dof}", PowerLaw(1e-5), "assumed") for dof in ("theta", "eta", "phi")]
    out += [
        NoiseSource(
            f"thruster_{axis}",
            "thruster",
            {f"w_SC_{axis}": 1.0},
            PowerLaw(0.24e-6),
            "0.17 µN each, PRD 99, 122003 (2019); six of them on arms of 1 m assumed",
        )
        for axis in ("Fx", "Fy", "Fz", "Lx", "Ly", "Lz")
    ]
    out.append(NoiseSource("sun_Fz", "sun", {"w_SC_Fz": 1.0}, PowerLaw(10e-9, 1e-3, 1.0), "assumed"))
    out += _actuation(test_masses, at_rest, actuation_stability)
    for name in STRAY:
        level, origin = (1.23e-15, "Δg of PRL 120, 061101 (2018)") if "_a_" in name else (1e-13, "assumed")
        out.append(NoiseSource(f"stray_{name}", "stray", {f"s_{name}": 1.0}, PowerLaw(level, 0.63e-3, 2.0), origin))
    return out


def thruster_sources(
    position_m: FloatArray, direction: FloatArray, spectra: Sequence[PowerLaw | SpectrumTable], centre_m: FloatArray
) -> list[NoiseSource]:
    """One source per thruster at `position_m` [t, 3] that pushes along `direction` [t, 3], basic frame, N/√Hz."""
    out = []
    for n, (at, towards, spectrum) in enumerate(zip(position_m, direction, spectra, strict=True), start=1):
        force = towards / np.linalg.norm(towards)
        wrench = np.concatenate([force, np.cross(at - centre_m, force)])
        gains = {f"w_SC_{a}": float(g) for a, g in zip(("Fx", "Fy", "Fz", "Lx", "Ly", "Lz"), wrench, strict=True)}
        out.append(NoiseSource(f"thruster_{n}", "thruster", gains, spectrum, "configured"))
    return out


def held_at_rest(at_rest: FloatArray) -> FloatArray:
    """[12]: what the actuation holds of the accelerations at rest, in the order of `signals.STRAY`.

    In x only the difference, on test mass 2; in y and z half the difference on each; rotations each their own. What
    both test masses have in common moves the spacecraft.
    """
    held = at_rest.copy()
    held[0], held[6] = 0.0, at_rest[6] - at_rest[0]
    for axis in (1, 2):
        half = (at_rest[6 + axis] - at_rest[axis]) / 2.0
        held[axis], held[6 + axis] = -half, half
    return held


def _actuation(test_masses: Sequence[DynamicTestMass], at_rest: FloatArray, stability: float) -> list[NoiseSource]:
    out = []
    wrench = [f"{tm}_{w}" for tm in TEST_MASSES for w in ("Fx", "Fy", "Fz", "Lx", "Ly", "Lz")]
    held = held_at_rest(at_rest).reshape(2, 6)
    forces = np.concatenate([tm.generalised_mass @ a for tm, a in zip(test_masses, held, strict=True)])
    for name, force in zip(wrench, forces, strict=True):
        level = 2.0 * stability * abs(float(force))
        if level > 0.0:
            origin = f"2 δ × the acceleration held, Montemurro 2004, 4.2.3; δ = {stability:g} assumed"
            spectrum = PowerLaw(level, 1e-3, 1.0)
            out.append(NoiseSource(f"actuation_{name}", "actuation", {f"w_{name}": 1.0}, spectrum, origin))
    return out


def _read_out(group: str, coordinate: str, spectrum: PowerLaw, origin: str) -> NoiseSource:
    return NoiseSource(f"{group}_{coordinate}", group, {f"n_{coordinate}": 1.0}, spectrum, origin)
