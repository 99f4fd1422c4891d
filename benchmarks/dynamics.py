"""Closed-loop spectra of 36 sources and 78 areas in 75 outputs, against the same state space in python-control."""

from __future__ import annotations

import numpy as np

from benchmarks.timing import Result, timed


def closed_loop(frequencies: int = 4096, sources: int = 36, areas: int = 78) -> Result:
    """|H column|² of every source and area, [75, 114] at each frequency; the peer computes H alone."""
    import control

    from tedm_cli.dynamics.bodies import DynamicTestMass, Spacecraft
    from tedm_cli.dynamics.closed_loop import responses
    from tedm_cli.dynamics.controller import ScalarLoops, default_loops
    from tedm_cli.dynamics.plant import Plant
    from tedm_cli.dynamics.presets import SPACECRAFT_INERTIA_KG_M2, SPACECRAFT_MASS_KG
    from tedm_cli.dynamics.signals import DISTURBANCES
    from tedm_cli.dynamics.state_space import loop_system

    rng = np.random.default_rng(3)
    test_masses = [
        DynamicTestMass(name, 1.96, np.full(3, 6.9e-4), np.array([x, 0.0, 0.0]), np.eye(3))
        for name, x in (("TM1", -0.188), ("TM2", 0.188))
    ]
    spacecraft = Spacecraft(SPACECRAFT_MASS_KG, np.diag(SPACECRAFT_INERTIA_KG_M2), np.array([0.0, 0.0, -0.14]))
    plant = Plant(spacecraft, test_masses, 1e-6 * np.stack([np.eye(6), 1.1 * np.eye(6)]), np.zeros((12, 12)))
    controller = ScalarLoops(plant, default_loops())
    columns = np.concatenate(
        [np.eye(len(DISTURBANCES))[:, :sources], rng.normal(size=(len(DISTURBANCES), areas))], axis=1
    )
    f = np.geomspace(1e-4, 0.1, frequencies)
    system = loop_system(plant, controller).system
    peer = control.ss(system.a, system.b[:, : len(DISTURBANCES)] @ columns, system.c, system.d[:, :45] @ columns)

    def work() -> None:
        for _, h in responses(plant, controller, f):
            flat = h.reshape(-1, h.shape[2])
            (flat.real @ columns) ** 2 + (flat.imag @ columns) ** 2

    return timed(work, lambda: peer.frequency_response(2.0 * np.pi * f), runs=3)
