"""Loops for the tests: the worked example, and a satellite with nothing aligned."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tedm_cli.arrays import FloatArray
from tedm_cli.dynamics.bodies import DynamicTestMass, Spacecraft
from tedm_cli.dynamics.controller import ScalarLoops, default_loops
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.signals import COORDINATES, STRAY
from tedm_cli.dynamics.thermal_input import ThermalInput

EXAMPLE = Path(__file__).with_name("worked_example.json")


@cache
def example() -> dict[str, Any]:
    """The worked example: a problem, and its results computed with 50 digits."""
    data: dict[str, Any] = json.loads(EXAMPLE.read_text())
    return data


def example_plant() -> Plant:
    d = example()
    sc = d["spacecraft"]
    return Plant(
        Spacecraft(sc["mass_kg"], np.array(sc["inertia_kg_m2"]), np.array(sc["centre_of_mass_m"])),
        [
            DynamicTestMass(
                t["name"], t["mass_kg"], np.array(t["inertia_kg_m2"]), np.array(t["position_m"]), np.array(t["axes"])
            )
            for t in d["test_mass"]
        ],
        np.array(d["stiffness"]["fixed"]),
        np.array(d["stiffness"]["mutual"]),
    )


def controlled(plant: Plant) -> ScalarLoops:
    """The default controller."""
    return ScalarLoops(plant, default_loops())


def askew_plant(seed: int = 0, stiffness: float = 3e-6, turn: float = 0.3) -> Plant:
    """A satellite and two different test masses, all with products of inertia, turned, and full stiffness."""
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(40, 3))
    inertia = 180.0 * (np.trace(points.T @ points) * np.eye(3) - points.T @ points) / (points**2).sum()
    masses = []
    for name, x in (("TM1", -0.19), ("TM2", 0.18)):
        side = rng.uniform(0.04, 0.06, 3)
        mass = rng.uniform(1.5, 2.5)
        turned = Rotation.from_rotvec(turn * rng.normal(size=3)).as_matrix()
        moments = turned @ np.diag(mass / 12.0 * ((side**2).sum() - side**2)) @ turned.T
        moments = (moments + moments.T) / 2.0
        axes = Rotation.from_rotvec(turn * rng.normal(size=3)).as_matrix()
        masses.append(DynamicTestMass(name, mass, moments, np.array([x, *rng.normal(0, 0.01, 2)]), axes))
    fixed = stiffness * rng.normal(size=(2, 6, 6)) * np.outer([1, 1, 1, 30, 30, 30], [1, 1, 1, 0.03, 0.03, 0.03])
    mutual = 1e-3 * stiffness * rng.normal(size=(12, 12))
    return Plant(Spacecraft(420.0, inertia, rng.normal(0, 0.05, 3)), masses, fixed, mutual)


def random_thermal(k: int, frequency_hz: FloatArray, seed: int = 0) -> ThermalInput:
    """k uncorrelated areas with sensitivities like those of a bench."""
    rng = np.random.default_rng(seed)
    read_out = np.zeros((len(COORDINATES), k))
    for name in ("TM1_x", "TM1_eta", "TM1_phi", "TM2_x", "TM2_eta", "TM2_phi"):
        read_out[COORDINATES.index(name)] = 1e-7 * rng.normal(size=k)
    acceleration = 1e-13 * rng.normal(size=(len(STRAY), k))
    amplitude = 1e-4 * np.ones((k, len(frequency_hz)))
    return ThermalInput(acceleration, read_out, np.eye(k), amplitude)
