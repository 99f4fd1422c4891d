"""A case of the thermal network in the loop: against dense cross-spectra, and as the areas that it can become."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from dynamics_models import controlled, example_plant, random_thermal

from tedm_cli.dynamics.budget import Budget, budget
from tedm_cli.dynamics.closed_loop import responses
from tedm_cli.dynamics.judging import judge_outputs, judged_labels
from tedm_cli.dynamics.signals import OUTPUTS
from tedm_cli.dynamics.thermal_input import NetworkInput, ThermalInput
from tedm_cli.noise.correlation_check import correlation_factor
from tedm_cli.noise.requirements import AppliedRequirement, tabulated

F = np.geomspace(1e-4, 1e-1, 25)
K = 6
R = np.array([[1.0, 0.6, 0.0], [0.6, 1.0, 0.0], [0.0, 0.0, 1.0]])
NAMES = ("panel", "bus", "photodiodes")
LABELS = ("delta_g", "TM1_x", "TM2_a_x")


@pytest.fixture(scope="module")
def network() -> NetworkInput:
    rng = np.random.default_rng(5)
    gain = rng.normal(size=(K, len(F), 3)) + 1j * rng.normal(size=(K, len(F), 3))
    of = random_thermal(K, F)
    return NetworkInput(
        of.acceleration, of.read_out, 1e-4 * gain / (1 + F[:, None] / 1e-3), NAMES, correlation_factor(R)
    )


@pytest.fixture(scope="module")
def found(network: NetworkInput) -> Budget:
    plant = example_plant()
    return budget(plant, controlled(plant), [], network, F, areas_of=LABELS)


def test_all_outputs_by_dense_cross_spectra(network: NetworkInput, found: Budget) -> None:
    """H V D R Dᴴ Vᴴ Hᴴ, the full matrix of what drives the loop, frequency by frequency."""
    plant = example_plant()
    power, gravity = np.empty((len(F), len(OUTPUTS))), np.empty((len(F), len(OUTPUTS)))
    read_out_alone = replace(network, read_out=np.zeros_like(network.read_out)).columns
    for here, response in responses(plant, controlled(plant), F, None):
        for f, h in zip(range(*here.indices(len(F))), response, strict=True):
            temperatures = network.drive[:, f] @ R @ network.drive[:, f].conj().T
            for out, v in ((power, network.columns), (gravity, read_out_alone)):
                out[f] = np.diag(h @ (v @ temperatures @ v.T) @ h.conj().T).real
    for one, other in ((found.total, power), (found.gravity, gravity)):
        size = other.max(axis=0) + 1e-300
        np.testing.assert_allclose(one / size, other / size, rtol=1e-10, atol=1e-13)


def test_nodes_and_disturbances_sum_to_it(found: Budget) -> None:
    for label in LABELS:
        thermal = found.thermal[:, found.labels.index(label)]
        np.testing.assert_allclose(found.area[label].sum(axis=1), thermal, rtol=1e-10)
        np.testing.assert_allclose(found.disturbance[label].parts().sum(axis=1), thermal, rtol=1e-10)


def test_an_uncorrelated_disturbance_is_what_it_makes_alone(network: NetworkInput) -> None:
    plant = example_plant()
    alike = replace(network, factor=np.eye(3))
    parts = budget(plant, controlled(plant), [], alike, F, LABELS, areas_of=LABELS).disturbance
    for d in range(3):
        only = replace(alike, drive=np.where(np.arange(3) == d, network.drive, 0.0))
        alone = budget(plant, controlled(plant), [], only, F, LABELS)
        for o, label in enumerate(LABELS):
            np.testing.assert_allclose(parts[label].parts()[:, d], alone.thermal[:, o], rtol=1e-10)


def test_plain_gains_are_areas(network: NetworkInput) -> None:
    """A disturbance for each node, of gain 1: uncorrelated areas, with all their parts."""
    plant, areas = example_plant(), random_thermal(K, F)
    drive = np.eye(K)[:, None, :] * areas.amplitude[:, :, None]
    plain = NetworkInput(areas.acceleration, areas.read_out, drive.astype(complex), tuple("abcdef"), np.eye(K))
    one, other = (budget(plant, controlled(plant), [], t, F, LABELS, areas_of=LABELS) for t in (plain, areas))
    np.testing.assert_allclose(one.total, other.total, rtol=1e-12)
    np.testing.assert_allclose(one.incoherent, other.incoherent, rtol=1e-12)
    for label in LABELS:
        np.testing.assert_allclose(one.area[label], other.area[label], rtol=1e-9, atol=1e-12 * other.thermal.max())
        np.testing.assert_allclose(one.disturbance[label].parts(), one.area[label], rtol=1e-9)
    assert other.disturbance == {}
    assert isinstance(areas, ThermalInput)


def test_level_of_a_disturbance_that_just_meets_it(network: NetworkInput) -> None:
    """Scaled by its factor, beside noise of the loop and the other disturbances, the worst ratio is 1."""
    plant = example_plant()
    control = controlled(plant)
    quiet = budget(plant, control, [], network, F, areas_of=("delta_g",))
    o = quiet.labels.index("delta_g")
    loop = 0.3 * quiet.total[:, o].max()  # of the loop, by hand: independent of the temperatures
    total = quiet.total.copy()
    total[:, o] += loop
    limit = 1.2 * np.sqrt(total[:, o].max())
    requirement = tabulated("own", "acceleration", F, np.full(len(F), limit))
    applied = [AppliedRequirement(replace(requirement, applies_to="differential"), ("delta_g",))]
    (j,) = judge_outputs(replace(quiet, total=total), [], judged_labels(applied, F), F, 1.0)
    assert j.disturbance_share is not None
    assert j.disturbance_factor is not None
    heat = quiet.thermal[np.abs(F - j.verdict.binding_hz).argmin(), o]
    assert j.disturbance_share.sum() == pytest.approx(heat / (heat + loop), rel=1e-10)
    for d, factor in enumerate(j.disturbance_factor):
        louder = replace(network, drive=network.drive * np.where(np.arange(3) == d, factor, 1.0))
        power = budget(plant, control, [], louder, F, ("delta_g",)).total[:, 0] + loop
        assert factor > 1.0
        assert np.sqrt(power.max()) / limit == pytest.approx(1.0, rel=1e-9)
