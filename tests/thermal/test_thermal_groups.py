"""Groups of thermal nodes: their mean gains, phases, low-passes and temperatures, from files and by NumPy."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from thermal_models import at, linear, network
from thermal_project import ThermalProject

from tedm_cli.arrays import ComplexArray, FloatArray
from tedm_cli.contracts import THERMAL
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.thermal import groups as thermal_groups
from tedm_cli.results.thermal.groups import (
    GroupGains,
    has_mapped_temperatures,
    read_group_gains,
    read_group_temperatures,
    read_off_model,
)
from tedm_cli.results.thermal.network import read_thermal_network
from tedm_cli.thermal.low_pass import fitted
from tedm_cli.thermal.transfer import transfer

OTHERS = AreaTable(*(np.array([word]) for word in ("STRUT", "struts", "outside", "mid")))  # no node is in it


@pytest.fixture
def project(tmp_path: Path) -> ThermalProject:
    """SHIELD, OB, BOX and JOINT as three groups: the shield is in two parts, one of them the joint."""
    made = ThermalProject(tmp_path / "network")
    for name in ("nodes.csv", "conductors.csv"):
        path = made.folder / name
        path.write_text(path.read_text().replace("SHIELD", "SH_IN").replace("JOINT", "SH_X").replace("BOX", "SH_BOX"))
    for name in ("powers.csv", "thermal.toml"):
        path = made.folder / name
        path.write_text(path.read_text().replace("BOX", "SH_BOX"))
    made.run("build-thermal").ok()
    return made


@pytest.fixture
def file(project: ThermalProject) -> Iterator[Reader]:
    with open_checked(project.folder / "build" / "thermal.h5", THERMAL) as opened:
        yield opened


def test_gains_and_noise_of_a_group_are_of_its_mean_by_heat_capacity(file: Reader) -> None:
    found = read_group_gains(file, OTHERS)
    assert found is not None
    assert found.group == ("SH", "OB")
    assert found.nodes == (3, 1)
    assert found.kind == ("temperature", "power")
    names = file.strings(THERMAL.NODE_FREE_NAME)
    h, s = file.array(THERMAL.TRANSFER), file.array(THERMAL.PSD)
    weight = np.zeros((2, 4))
    weight[0, [names.index(n) for n in ("SH_IN", "SH_BOX", "SH_X")]] = np.array([2000.0, 800.0, 0.0]) / 2800.0
    weight[1, names.index("OB")] = 1.0
    np.testing.assert_allclose(found.gain, np.einsum("gn,fnu->fgu", weight, h), rtol=1e-12)
    noise = np.sqrt(np.einsum("gn,fnm,gm->fg", weight, s, weight).real)
    np.testing.assert_allclose(found.noise, noise, rtol=1e-10)
    assert found.low_pass.order.shape == (2, 2)
    own, corner = file.array(THERMAL.FILTER_ORDER), file.array(THERMAL.FILTER_CORNER)
    ob = names.index("OB")
    for ends in (found.least, found.most):
        np.testing.assert_array_equal(ends[:, 1], [own[ob], corner[ob]])


def test_gains_are_the_same_in_parts(file: Reader, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = read_group_gains(file, OTHERS)
    monkeypatch.setattr(thermal_groups, "_BLOCK", 1)
    parts = read_group_gains(file, OTHERS)
    assert whole is not None
    assert parts is not None
    np.testing.assert_allclose(parts.gain, whole.gain, rtol=1e-14)


def test_the_smallest_of_many_groups_are_one(file: Reader, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(thermal_groups, "MOST_GROUPS", 2)
    found = read_group_temperatures(file, OTHERS)  # SC, SPACE, SH and OB
    assert found is not None
    assert set(found.group) == {"OB", "3 other groups"}
    assert found.nodes[found.group.index("3 other groups")] == 5


def test_temperatures_of_groups_are_the_ends_and_the_mean(file: Reader) -> None:
    found = read_group_temperatures(file, OTHERS)
    assert found is not None
    temperature = dict(zip(file.strings(THERMAL.NODE_NAME), file.array(THERMAL.STEADY_K), strict=True))
    of = [temperature[n] for n in ("SH_IN", "SH_BOX", "SH_X")]
    shield = found.group.index("SH")
    assert (found.least[shield], found.most[shield]) == (min(of), max(of))
    assert found.mean[shield] == pytest.approx(np.mean(of), rel=1e-14)
    assert not found.on_model.any()
    off = read_off_model(file)
    assert set(off.name) == set(temperature)
    assert list(off.temperature) == sorted(temperature.values(), reverse=True)
    assert not has_mapped_temperatures(file)
    whole = read_thermal_network(file, OTHERS, [(2.0, 1e-3)])
    assert whole.on_grids is None
    assert whole.level_hz == 1e-3
    assert whole.level[0] == pytest.approx(1e-3)


def chain_gains(low_hz: float) -> tuple[FloatArray, ComplexArray]:
    """Gains from one end of a chain of five nodes to each of them, from a frequency on."""
    names = [f"N{i}" for i in range(5)]
    net = network(
        [("B", "boundary", 0.0), *((name, "diffusive", 300.0) for name in names)],
        [(a, b, 0.2, 0.0) for a, b in zip(["B", *names[:-1]], names, strict=True)],
    )
    f = np.geomspace(low_hz, 0.1, round(60 * np.log10(0.1 / low_hz)) + 1)
    return f, transfer(linear(net, {"B": 293.0}, [at("temperature", "B")]), f)


def gains_of(f: FloatArray, gain: ComplexArray) -> GroupGains:
    ends = np.zeros((2, *gain.shape[1:]))
    noise = np.abs(gain[:, :, 0])
    names = tuple(f"g{i}" for i in range(gain.shape[1]))
    return GroupGains(names, (1,) * len(names), ("d",), ("temperature",), f, gain, fitted(gain, f), noise,
                      fitted(noise.astype(complex), f), ends, ends, 0, gain.size)  # fmt: skip


@pytest.mark.parametrize("cut_hz", [1e-4, 1e-3, 1e-2])
def test_phase_goes_round_as_often_as_from_low_frequencies(cut_hz: float) -> None:
    """Where the frequencies begin far above the corner, the phase is that which has been followed from f → 0."""
    f, gain = chain_gains(1e-7)
    true = np.degrees(np.unwrap(np.angle(gain), axis=0))
    assert np.abs(true[0]).max() < 1.0
    kept = f >= cut_hz
    found = gains_of(f[kept], gain[kept]).phase_deg
    np.testing.assert_allclose(found, true[kept], atol=1e-6)
    assert found.min() < -400.0
    if cut_hz == 1e-2:
        assert found[0].min() < -200.0, "it begins beyond half a turn"


def test_fit_has_the_level_of_the_gain() -> None:
    f, gain = chain_gains(1e-5)
    found = gains_of(f, gain)
    logs = np.log(found.fit / np.abs(gain))
    np.testing.assert_allclose(logs.mean(axis=0), 0.0, atol=1e-12)
    np.testing.assert_allclose(np.sqrt((logs**2).mean(axis=0)), found.low_pass.error, rtol=0.05)
    silent = dataclasses.replace(found, gain=np.zeros_like(gain), low_pass=fitted(np.zeros_like(gain), f))
    assert np.isnan(silent.fit).all()
    assert np.isfinite(silent.phase_deg).all()
