"""Budgets of 36 sources and 78 areas in 75 outputs of the closed loop, against H alone of python-control."""

from __future__ import annotations

import numpy as np

from benchmarks.timing import Result, timed


def closed_loop(frequencies: int = 4096, sources: int = 36, areas: int = 78) -> Result:
    """PSDs by source and of all areas, each alone, at every frequency; the peer computes H alone, [75, 114]."""
    import control

    from tedm_cli.dynamics.bodies import DynamicTestMass, Spacecraft
    from tedm_cli.dynamics.budget import budget
    from tedm_cli.dynamics.controller import ScalarLoops, default_loops
    from tedm_cli.dynamics.plant import Plant
    from tedm_cli.dynamics.presets import SPACECRAFT_INERTIA_KG_M2, SPACECRAFT_MASS_KG
    from tedm_cli.dynamics.signals import DELTA_G, DISTURBANCES
    from tedm_cli.dynamics.sources import NoiseSource, PowerLaw
    from tedm_cli.dynamics.sources import columns as gains_of
    from tedm_cli.dynamics.state_space import loop_system
    from tedm_cli.dynamics.thermal_input import ThermalInput

    rng = np.random.default_rng(3)
    test_masses = [
        DynamicTestMass(name, 1.96, np.full(3, 6.9e-4), np.array([x, 0.0, 0.0]), np.eye(3))
        for name, x in (("TM1", -0.188), ("TM2", 0.188))
    ]
    spacecraft = Spacecraft(SPACECRAFT_MASS_KG, np.diag(SPACECRAFT_INERTIA_KG_M2), np.array([0.0, 0.0, -0.14]))
    plant = Plant(spacecraft, test_masses, 1e-6 * np.stack([np.eye(6), 1.1 * np.eye(6)]), np.zeros((12, 12)))
    controller = ScalarLoops(plant, default_loops())
    noise = [NoiseSource(name, "one", {name: 1.0}, PowerLaw(1.0)) for name in DISTURBANCES[:sources]]
    f = np.geomspace(1e-4, 0.1, frequencies)
    read_out, acceleration = rng.normal(size=(15, areas)), rng.normal(size=(12, areas))
    thermal = ThermalInput(acceleration, read_out, np.eye(areas), np.ones((areas, frequencies)))
    system = loop_system(plant, controller).system
    columns = np.concatenate([gains_of(noise), thermal.columns], axis=1)
    peer = control.ss(system.a, system.b[:, : len(DISTURBANCES)] @ columns, system.c, system.d[:, :45] @ columns)
    return timed(
        lambda: budget(plant, controller, noise, thermal, f, areas_of=DELTA_G),
        lambda: peer.frequency_response(2.0 * np.pi * f),
        runs=3,
    )
