"""Noise of a thermal network: a dense reference, and the correlation cases that it becomes where gains are plain."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest

from tedm_cli.errors import InputError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.bounds import correlation_bounds
from tedm_cli.noise.case_contributions import contributions
from tedm_cli.noise.contributions import area_shares, path_shares
from tedm_cli.noise.correlation import full_blocks
from tedm_cli.noise.correlation_check import correlation_factor
from tedm_cli.noise.disturbances import OutputsByClass, disturbance_contributions
from tedm_cli.noise.improvement import improvement
from tedm_cli.noise.network import NetworkNoise, NetworkOutputs
from tedm_cli.noise.outputs import Outputs
from tedm_cli.noise.propagation import OutputNoise, TemperatureNoise
from tedm_cli.noise.requirements import judge, tabulated
from tedm_cli.noise.resemblance import deviation, resemblance
from tedm_cli.noise.temperature import ShapedSpectrum, TemperatureModel
from tedm_cli.uncertainty.parameters import LEVEL, NORMAL, Parameter, Parameters
from tedm_cli.uncertainty.response import Effects, Ratio

F = np.geomspace(1e-4, 1e-1, 31)
K, U = 7, 3
R = np.array([[1.0, 0.6, 0.0], [0.6, 1.0, 0.0], [0.0, 0.0, 1.0]])


def noise(driven: np.ndarray, correlation: np.ndarray, blocks: list | None = None) -> NetworkNoise:
    """One block of all columns, or `blocks` with one disturbance each."""
    whole = [np.arange(len(driven))] if blocks is None else blocks
    factor = correlation_factor(correlation) if blocks is None else np.eye(len(blocks))
    column = np.zeros(factor.shape[1], dtype=int) if blocks is None else np.arange(len(blocks))
    names = tuple(f"d{i}" for i in range(driven.shape[2]))
    still = np.zeros(len(driven), dtype=bool)
    return NetworkNoise(driven.astype(complex), F, names, factor, tuple(whole), column, still, "network")


@pytest.fixture
def network() -> NetworkNoise:
    rng = np.random.default_rng(3)
    gain = rng.normal(size=(K, len(F), U)) + 1j * rng.normal(size=(K, len(F), U))
    return noise(gain * 1e-4 / (1 + F[:, None] / 1e-3), R)


@pytest.fixture
def rows() -> np.ndarray:
    return np.random.default_rng(4).normal(size=(4, K))


def test_spectra_by_a_dense_reference(network: NetworkNoise, rows: np.ndarray) -> None:
    """S_y = g D R Dᴴ gᵀ, of all frequencies and of some."""
    out = NetworkOutputs(rows, network, F)
    wanted = np.array([rows @ d @ R @ d.conj().T @ rows.T for d in network.driven.transpose(1, 0, 2)])
    np.testing.assert_allclose(out.cross_spectra(), wanted, rtol=1e-12, atol=1e-12 * np.abs(wanted).max())
    psd = np.einsum("foo->of", wanted).real
    np.testing.assert_allclose(out.psd(), psd, rtol=1e-12)
    np.testing.assert_allclose(out.at(F[[4, 9]]).of(rows[1:2]).psd(), psd[1:2, [4, 9]], rtol=1e-12)
    components = out.components()
    np.testing.assert_allclose(np.einsum("amf,bmf->fab", components, components.conj()), wanted, rtol=1e-9, atol=1e-20)


def test_what_comes_of_an_output_is_the_same_beside_others(network: NetworkNoise, rows: np.ndarray) -> None:
    whole = NetworkOutputs(rows, network, F).psd()
    np.testing.assert_array_equal(NetworkOutputs(rows[2:3], network, F).psd()[0], whole[2])


def test_no_frequency_is_made_up(network: NetworkNoise, rows: np.ndarray) -> None:
    with pytest.raises(InputError, match=r"not known at 0\.00123 Hz"):
        NetworkOutputs(rows, network, np.array([F[0], 1.23e-3])).psd()


def test_areas_and_disturbances_add_up(network: NetworkNoise, rows: np.ndarray) -> None:
    """At one frequency to the PSD, over several to the power; one at a time where nothing is correlated."""
    for f in (F[[7]], F):
        out = NetworkOutputs(rows, network, f)
        power = out.psd()[:, 0] if len(f) == 1 else (0.5 * (out.psd()[:, 1:] + out.psd()[:, :-1])) @ np.diff(f)
        np.testing.assert_allclose(out.area_powers().sum(axis=1), power, rtol=1e-12)
        np.testing.assert_allclose(out.disturbance_powers().sum(axis=1), power, rtol=1e-12)
    alone = noise(network.driven, np.eye(U))
    parts = NetworkOutputs(rows, alone, F[[7]]).disturbance_powers()
    for d in range(U):
        only = noise(np.where(np.arange(U) == d, network.driven, 0.0), np.eye(U))
        np.testing.assert_allclose(parts[:, d], NetworkOutputs(rows, only, F[[7]]).psd()[:, 0], rtol=1e-12)


def test_a_correlated_disturbance_may_cancel() -> None:
    """Two that act alike with opposite sign, and nearly as one: the smaller takes away."""
    driven = np.zeros((1, len(F), 2))
    driven[0] = [1.0, -0.5]
    out = NetworkOutputs(np.ones((1, 1)), noise(driven, np.array([[1.0, 0.9], [0.9, 1.0]])), F[[0]])
    np.testing.assert_allclose(out.disturbance_powers()[0], [1.0 - 0.45, 0.25 - 0.45], rtol=1e-12)


def test_areas_by_finite_differences(network: NetworkNoise, rows: np.ndarray) -> None:
    """An area's part is half the derivative of the PSD by the logarithm of its amplitude."""
    f, step = F[[11]], 1e-6
    parts = NetworkOutputs(rows, network, f).area_powers()
    for i in range(K):
        more, less = (np.where(np.arange(K) == i, rows * (1 + s), rows) for s in (step, -step))
        slope = (NetworkOutputs(more, network, f).psd() - NetworkOutputs(less, network, f).psd())[:, 0] / (2 * step)
        np.testing.assert_allclose(parts[:, i], slope / 2, rtol=1e-6, atol=1e-9 * np.abs(parts).max())


def test_bounds_enclose_and_are_reached(network: NetworkNoise, rows: np.ndarray) -> None:
    out = NetworkOutputs(rows, network, F)
    bounds, psd = correlation_bounds(out), out.psd()
    assert (bounds.minimum <= psd * (1 + 1e-12)).all()
    assert (psd <= bounds.maximum * (1 + 1e-12)).all()
    amplitude = network.amplitudes(F)
    np.testing.assert_allclose(bounds.maximum, (np.abs(rows) @ amplitude) ** 2, rtol=1e-12)
    np.testing.assert_allclose(bounds.known_blocks, psd, rtol=1e-12)  # one block: nothing is unknown between
    np.testing.assert_allclose(amplitude**2, np.einsum("kfu,uv,kfv->kf", network.driven, R, network.driven.conj()).real)
    matrix = network.correlation_at(F[5]).matrix()
    np.testing.assert_allclose(np.diag(matrix).real, 1.0, rtol=1e-12)


def plain(kind: str) -> tuple[NetworkNoise, TemperatureNoise]:
    """Gains of 1 from one boundary, or from a boundary of each column: cases 1 and 2 of the same spectrum."""
    spectrum = ShapedSpectrum(2e-4)
    model = TemperatureModel.from_spectra([spectrum] * K)
    asd = spectrum.amplitude(F)
    if kind == "common":
        return noise(np.ones((K, 1, 1)) * asd[None, :, None], np.eye(1)), TemperatureNoise(
            model, full_blocks([np.arange(K)], K)
        )
    blocks = [np.array([i]) for i in range(K)]
    return noise(np.eye(K)[:, None, :] * asd[None, :, None], np.eye(K), blocks), TemperatureNoise(
        model, full_blocks(blocks, K)
    )


@pytest.mark.parametrize("kind", ["common", "separate"])
def test_plain_gains_are_the_correlation_case(kind: str, rows: np.ndarray) -> None:
    """Everything that a case is asked for, from either source of noise."""
    network, areas = plain(kind)
    one, other = NetworkOutputs(rows, network, F), OutputNoise(rows, areas, F)
    np.testing.assert_allclose(one.psd(), other.psd(), rtol=1e-12)
    np.testing.assert_allclose(one.cross_spectra(), other.cross_spectra(), rtol=1e-9, atol=1e-20)
    found, wanted = correlation_bounds(one), correlation_bounds(other)
    for field in fields(found):
        np.testing.assert_allclose(getattr(found, field.name), getattr(wanted, field.name), rtol=1e-9, atol=1e-22)
    for f in (F[[3]], F):
        np.testing.assert_allclose(area_shares(one.at(f)), area_shares(other.at(f)), rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(path_shares(one.at(f)), path_shares(other.at(f)), rtol=1e-9, atol=1e-12)
    limit = np.full(len(F), 0.3 * np.sqrt(other.psd()[0].max()))
    groups = [np.arange(K) < 3, np.arange(K) >= 3]
    better, as_good = (improvement(n.of(rows[:1]), 4, limit, groups) for n in (one, other))
    for field in fields(better):
        np.testing.assert_allclose(getattr(better, field.name), getattr(as_good, field.name), rtol=1e-9, atol=1e-12)


def test_silenced_areas_are_propagation_without_them(network: NetworkNoise, rows: np.ndarray) -> None:
    out = NetworkOutputs(rows[:1], network, F)
    limit = np.full(len(F), 1e-5)
    found = improvement(out, 4, limit, [np.ones(K, dtype=bool)])
    without = rows[:1].copy()
    without[0, found.worst[:2]] = 0.0
    assert found.silenced[2] == pytest.approx((np.sqrt(NetworkOutputs(without, network, F).psd()[0]) / limit).max())
    silent = np.where(np.eye(K, dtype=bool), 0.0, rows[0])
    best = NetworkOutputs(silent, network, F[[4]]).psd()[:, 0].argmin()
    assert found.worst[0] == best


def test_level_of_a_disturbance_that_just_meets_it(network: NetworkNoise, rows: np.ndarray) -> None:
    """Scaled by its factor, and the others unchanged, the worst ratio is 1."""
    out = NetworkOutputs(rows[:1], network, F)
    limit = np.full(len(F), 1.3 * np.sqrt(out.psd()[0].max()))
    requirement = tabulated("own", "displacement", F, limit)
    areas = AreaTable(np.array([f"n{i}" for i in range(K)]), *(np.array([v] * K) for v in ("g", "inside", "mid")))
    outputs = Outputs(areas, rows[:1], ("x",), ("displacement",))
    verdict = judge(np.sqrt(out.psd()[0]), F, requirement, 1.0, kind="displacement", output="x")
    judged = [(requirement, 0)]
    found = disturbance_contributions(out, contributions(out, outputs, judged, [verdict]), judged, 1.0)
    np.testing.assert_allclose(found.share.sum(axis=1), 1.0, rtol=1e-12)
    np.testing.assert_allclose(found.band_share.sum(axis=1), 1.0, rtol=1e-12)
    for d, factor in enumerate(found.level_factor[0]):
        assert factor > 1.0
        louder = replace(network, driven=network.driven * np.where(np.arange(U) == d, factor, 1.0))
        ratio = np.sqrt(NetworkOutputs(rows[:1], louder, F).psd()[0]) / requirement.amplitude(F)
        assert ratio.max() == pytest.approx(1.0, rel=1e-9)


def test_correlation_is_of_its_frequency(network: NetworkNoise) -> None:
    """C_ij / √(C_ii C_jj) there, and another one elsewhere."""
    for number in (3, 20):
        d = network.driven[:, number]
        spectra = d @ R @ d.conj().T
        size = np.sqrt(np.diag(spectra).real)
        found = network.correlation_at(float(F[number])).matrix()
        np.testing.assert_allclose(found, spectra / np.outer(size, size), atol=1e-12)


def test_the_assumed_case_that_is_most_like_it() -> None:
    """Root mean square over pairs, by hand: nodes 0 and 1 in one area, 2 in another."""
    area = np.array([0, 0, 1])
    found = np.array([[1.0, 0.9, 0.5j], [0.9, 1.0, 0.0], [-0.5j, 0.0, 1.0]])
    together, apart = full_blocks([np.arange(2)], 2), full_blocks([np.array([0]), np.array([1])], 2)
    assert deviation(found, area, together, 1e-3) == pytest.approx(np.sqrt((0.01 + 1.25 + 1.0) / 3))
    assert deviation(found, area, apart, 1e-3) == pytest.approx(np.sqrt((0.01 + 0.25 + 0.0) / 3))
    silent = full_blocks([np.array([0])], 2)
    assert np.isnan(deviation(found, area, silent, 1e-3))
    cases = {"a": together, "b": apart, "c": silent}
    level, assumed = np.array([3.0, 4.0, 7.0]), np.array([1.0, 1.0, 2.0])
    r = resemblance(found, area, cases, 1e-3, ["left", "left", "right"], level, assumed)
    assert r is not None
    assert (r.cases, r.groups) == (("b", "a"), ("left", "right"))
    np.testing.assert_allclose(r.deviation, np.sqrt([0.26 / 3, 2.26 / 3]))
    np.testing.assert_allclose(r.coherence, [[0.9, 0.25], [0.25, np.nan]])
    np.testing.assert_allclose(r.computed, [[0.9, 0.0], [0.0, np.nan]])
    np.testing.assert_allclose(r.assumed[0], [[1.0, 0.0], [0.0, np.nan]])
    np.testing.assert_allclose(r.assumed[1], [[1.0, 1.0], [1.0, np.nan]])
    np.testing.assert_allclose(r.asd, [np.sqrt(12.5), 7.0])
    np.testing.assert_allclose(r.assumed_asd, [1.0, 2.0])
    assert resemblance(found, area, {"c": silent}, 1e-3, ["left"] * 3, level, assumed) is None


def test_levels_of_disturbances_as_a_propagation_of_levels(network: NetworkNoise, rows: np.ndarray) -> None:
    """The ratio at any deviations, by classes of disturbances, is that of the network with its disturbances scaled."""
    acts = np.array([[True, True, False], [False, True, False]])  # two parameters on three disturbances
    levels, class_of = np.unique(acts.T, axis=0, return_inverse=True)
    class_of = class_of.reshape(-1)
    items = tuple(Parameter(name, LEVEL, "", 0.3, NORMAL) for name in ("one", "other"))
    wide = np.tile(rows, (1, len(levels)))
    effects = Effects(Parameters.of(items), np.zeros((2, *wide.shape)), np.repeat(levels.T, K, axis=1))
    limit = np.linspace(1e-5, 3e-5, len(F))
    x = np.array([[0.0, 0.0], [0.4, -0.2], [-0.9, 1.3]])
    for o in range(len(rows)):
        found = Ratio(effects.response(wide[o], o), OutputsByClass(wide, network, class_of, F), F, limit).of(x)
        for ratio, (one, other) in zip(found, x, strict=True):
            factor = np.array([1 + one, (1 + one) * (1 + other), 1.0])
            scaled = NetworkOutputs(rows[[o]], replace(network, driven=network.driven * factor), F).psd()[0]
            assert ratio == pytest.approx((np.sqrt(scaled) / limit).max(), rel=1e-10)
    together = OutputsByClass(wide, network, class_of, F).cross_spectra()
    np.testing.assert_allclose(together, NetworkOutputs(rows, network, F).cross_spectra(), rtol=1e-10, atol=1e-22)
