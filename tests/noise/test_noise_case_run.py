import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad

from tedm_cli.errors import ConfigError, InputError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.case_run import run_case
from tedm_cli.noise.contributions import ReadOutParts, area_shares, path_shares, share_weights, sum_by
from tedm_cli.noise.correlation import Correlation, CorrelationCase, correlation, full_blocks
from tedm_cli.noise.correlation_check import correlation_factor
from tedm_cli.noise.outputs import Outputs
from tedm_cli.noise.propagation import OutputNoise, TemperatureNoise
from tedm_cli.noise.requirement_presets import PRESETS
from tedm_cli.noise.requirements import AppliedRequirement, Criteria
from tedm_cli.noise.selection import BlockSelector
from tedm_cli.noise.temperature import (
    ShapedSpectrum,
    Spectrum,
    TemperatureModel,
    WhiteSpectrum,
    thesis_model,
    white_model,
)

LABELS = ("TM1_a_x", "TM1_omegadot_x", "A_TM1_x")
KINDS = ("acceleration", "angular_acceleration", "displacement")
REQUIREMENTS = (
    AppliedRequirement(PRESETS["lpf_selfgravity_ltp"], ("TM1_a_x",)),
    AppliedRequirement(PRESETS["lpf_readout"], ("A_TM1_x",)),
    AppliedRequirement(PRESETS["lpf_readout_item"], ("A_TM1_x",)),
)


def rows_for(areas, seed=1):
    return np.random.default_rng(seed).normal(size=(3, len(areas))) * np.array([[1e-13], [1e-11], [1e-10]])


def run(areas, config, case_id, **changes):
    of_outputs = {"rows": rows_for(areas), "labels": LABELS, "kinds": KINDS}
    of_outputs |= {key: changes.pop(key) for key in (*of_outputs, "parts_of_read_outs") if key in changes}
    arguments = {
        "temperature": config.temperature.model(areas),
        "frequency_hz": config.frequency_hz(),
    } | changes
    requirements = arguments.pop("requirements", REQUIREMENTS)
    criteria = Criteria(tuple(requirements), arguments.pop("safety_factor", config.safety_factor))
    return run_case(config.case(case_id), Outputs(areas, **of_outputs), **arguments, criteria=criteria)


def alone(k):
    return full_blocks([np.array([i]) for i in range(k)], k)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(1, 8), f=st.floats(1e-4, 0.1))
def test_shares_are_the_derivative_of_the_power_with_area_amplitude(seed, k, f):
    """S is homogeneous of degree 2 in the amplitudes: ∂ln S/∂ln A_i is twice the share, and the shares sum to 1."""
    rng = np.random.default_rng(seed)
    mixing = rng.normal(size=(k, k)) * np.exp(2j * np.pi * rng.random((k, k)))
    mixing /= np.linalg.norm(mixing, axis=1, keepdims=True)
    factor = correlation_factor(mixing @ mixing.conj().T)
    delay_s = rng.uniform(0, 500, k) * rng.integers(2)
    whole = Correlation((np.arange(k),), factor, np.zeros(factor.shape[1], dtype=int), delay_s)
    shapes: list[Spectrum] = [WhiteSpectrum(1e-3), ShapedSpectrum(1e-3, order=1), ShapedSpectrum(1e-4, corner_hz=5e-3)]
    model = TemperatureModel.from_spectra([shapes[rng.integers(3)] for _ in range(k)])
    rows = rng.normal(size=(2, k))
    share = area_shares(OutputNoise(rows, TemperatureNoise(model, whole), np.array([f])))
    np.testing.assert_allclose(share.sum(axis=1), 1.0, atol=1e-14 * k * np.abs(share).max())

    def psd(change):
        louder = TemperatureModel(model.scale * (1 + change), model.shape_index, model.shapes)
        return TemperatureNoise(louder, Correlation.of_factor(factor, delay_s)).psd(rows, np.array([f]))[:, 0]

    for i in range(k):
        step = 1e-4 * (np.arange(k) == i)
        slope = (psd(step) - psd(-step)) / (4e-4 * psd(0 * step))  # central, exact for a quadratic
        np.testing.assert_allclose(slope, share[:, i], rtol=1e-6, atol=1e-9 * np.abs(share).max())


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(1, 8), f=st.floats(1e-4, 0.1))
def test_weights_turn_any_terms_into_their_shares(seed, k, f):
    """Against the shares of paths and of areas, which come from the factor of R and not from R."""
    rng = np.random.default_rng(seed)
    mixing = rng.normal(size=(k, k)) * np.exp(2j * np.pi * rng.random((k, k)))
    mixing /= np.linalg.norm(mixing, axis=1, keepdims=True)
    delay_s = rng.uniform(0, 500, k) * rng.integers(2)
    whole = Correlation((np.arange(k),), mixing, np.zeros(k, dtype=int), delay_s)
    shapes: list[Spectrum] = [WhiteSpectrum(1e-3), ShapedSpectrum(1e-3, order=1), ShapedSpectrum(1e-4, corner_hz=5e-3)]
    model = TemperatureModel.from_spectra([shapes[rng.integers(3)] for _ in range(k)])
    terms = rng.normal(size=(4, k))
    row, amplitude = terms.sum(axis=0), model.amplitudes(np.array([f]))[:, 0]
    weights = share_weights(row, amplitude, mixing @ mixing.conj().T, delay_s, f)
    wanted = path_shares(OutputNoise(terms, TemperatureNoise(model, whole), np.array([f])))
    by_area = area_shares(OutputNoise(row[None], TemperatureNoise(model, whole), np.array([f])))[0]
    room = max(1.0, np.abs(terms * weights).sum())
    np.testing.assert_allclose(terms @ weights, wanted, rtol=0, atol=1e-9 * room)
    np.testing.assert_allclose(row * weights, by_area, rtol=0, atol=1e-9 * room)


def test_weights_of_an_output_without_noise_are_nought():
    assert not share_weights(np.ones(2), np.ones(2), np.zeros((2, 2)), np.zeros(2), 1e-3).any()


def test_shares_by_hand():
    areas = AreaTable(
        np.array(["A", "B", "C"]), np.array(["g", "h", "g"]), np.array(["inside"] * 3), np.array(["mid"] * 3)
    )
    model = TemperatureModel.from_spectra([WhiteSpectrum(1.0)] * 3)
    case = CorrelationCase("x", "pair", (BlockSelector(areas=("A", "B")), BlockSelector(areas=("C",))))
    # h = 3, -1 in one block and 2 alone: S = (3 - 1)² + 2² = 8.
    share = area_shares(
        OutputNoise(np.array([[3.0, -1.0, 2.0]]), TemperatureNoise(model, correlation(case, areas)), np.array([1e-3]))
    )
    np.testing.assert_allclose(share, [[6 / 8, -2 / 8, 4 / 8]], rtol=1e-14)
    names, sums = sum_by(share, areas.group)
    assert names.tolist() == ["g", "h"]
    np.testing.assert_allclose(sums, [[10 / 8, -2 / 8]], rtol=1e-14)


def test_band_shares_integrate_the_powers():
    """Two uncorrelated areas, white and first order: the powers over the band by adaptive quadrature."""
    white, shaped = WhiteSpectrum(1e-4), ShapedSpectrum(1e-3, 1e-3, 1e-3, 1)
    model = TemperatureModel.from_spectra([white, shaped])
    f = np.geomspace(1e-3, 30e-3, 2001)
    share = area_shares(OutputNoise(np.array([[2.0, 1.0]]), TemperatureNoise(model, alone(2)), f))[0]
    power = [
        4e-8 * 29e-3,
        quad(lambda x: shaped.amplitude(np.array([x]))[0] ** 2, 1e-3, 30e-3, epsabs=0, epsrel=1e-10)[0],
    ]
    np.testing.assert_allclose(share, np.array(power) / sum(power), rtol=1e-5)


def test_an_output_without_noise_has_no_contributors():
    model = TemperatureModel.from_spectra([WhiteSpectrum(1e-4)] * 2)
    assert np.array_equal(
        area_shares(OutputNoise(np.zeros((1, 2)), TemperatureNoise(model, alone(2)), np.array([1e-3]))),
        np.zeros((1, 2)),
    )


@pytest.mark.parametrize("case_id", ["1", "2", "4b", "6", "10"])
def test_result_is_consistent(areas, config, case_id):
    result = run(areas, config, case_id)
    assert result.outputs.units == ("m s^-2", "rad s^-2", "m")
    for verdict in result.verdicts:
        o = LABELS.index(verdict.output)
        asd = np.sqrt(result.psd[o, result.frequency_hz == verdict.binding_hz][0])
        assert verdict.noise == asd
        assert verdict.ratio == pytest.approx(2.0 * asd / verdict.limit, rel=1e-14, abs=0)
    assert [v.requirement for v in result.verdicts] == ["lpf_selfgravity_ltp", "lpf_readout", "lpf_readout_item"]
    # Contributors are taken where the strictest of an output's requirements binds, at 1 mHz without any.
    where = result.contributions
    assert where.frequency_hz.tolist() == [result.verdicts[0].binding_hz, 1e-3, result.verdicts[2].binding_hz]
    assert where.band_hz.tolist() == [[1e-3, 30e-3], [1e-4, 0.1], [1e-3, 30e-3]]
    for share in (where.share, where.band_share, *where.by(areas.group)[1:], *where.by(areas.shield)[1:]):
        np.testing.assert_allclose(share.sum(axis=1), 1.0, rtol=1e-9)
    assert not where.amplitude[:, ~result.active].any()
    assert not where.share[:, ~result.active].any()
    # Signed contributions, summed per block and squared, are the PSD.
    for o in range(3):
        sums = [where.amplitude[o, index].sum() for index in result.blocks]
        at = np.argmin(np.abs(result.frequency_hz - where.frequency_hz[o]))
        assert np.sum(np.square(sums)) == pytest.approx(result.psd[o, at], rel=1e-9, abs=0)
    np.testing.assert_allclose(
        result.temperature_asd[result.temperature_set],
        result.source.temperature.amplitudes(result.frequency_hz),
        rtol=1e-14,
    )


def test_band_shares_are_over_the_band_of_the_requirement(areas, config):
    """White noise inside, shaped outside, each area alone: the powers h_i² integrated over 1 to 30 mHz."""
    mixed = TemperatureModel.by_shield(areas, outside=ShapedSpectrum(1e-3), inside=WhiteSpectrum(1e-4))
    result = run(areas, config, "2", temperature=mixed)
    f = result.frequency_hz
    for o, inside in ((0, (f >= 1e-3) & (f <= 30e-3)), (1, f > 0)):
        power = (rows_for(areas)[o, :, None] * mixed.amplitudes(f[inside])) ** 2
        integral = (0.5 * (power[:, 1:] + power[:, :-1]) * np.diff(f[inside])).sum(axis=1)
        np.testing.assert_allclose(result.contributions.band_share[o], integral / integral.sum(), rtol=1e-12)


def test_safety_factor_multiplies_amplitudes_of_verdicts_and_nothing_else(areas, config):
    once, twice = run(areas, config, "3", safety_factor=1.0), run(areas, config, "3", safety_factor=2.0)
    np.testing.assert_array_equal(once.psd, twice.psd)
    np.testing.assert_array_equal(once.bounds.maximum, twice.bounds.maximum)
    for a, b in zip(once.verdicts, twice.verdicts, strict=True):
        assert b.ratio == pytest.approx(2 * a.ratio, rel=1e-14, abs=0)
        assert b.binding_hz == a.binding_hz


def test_verdict_over_filter_orders_and_corners(areas, config):
    """With one shape for all areas the ratio scales as the worst shape over limit, whatever the case."""
    result = run(areas, config, "4")
    table = result.filter_sensitivity
    assert table is not None
    f = result.frequency_hz[(result.frequency_hz >= 1e-3) & (result.frequency_hz <= 30e-3)]
    for v, verdict in enumerate(result.verdicts):
        limit = PRESETS[verdict.requirement].amplitude(f)
        o = LABELS.index(verdict.output)
        at_1_mhz = 2 * np.sqrt(result.psd[o, result.frequency_hz == 1e-3][0])
        for p, order in enumerate(table.order):
            for q, corner in enumerate(table.corner_hz):
                worst = (ShapedSpectrum(1.0, 1e-3, corner, order).amplitude(f) / limit).max()
                assert table.ratio[v, p, q] == pytest.approx(at_1_mhz * worst, rel=1e-9, abs=0)
    own = table.ratio[:, table.order == 2.0, table.corner_hz == 1e-3].ravel()
    np.testing.assert_allclose(own, [v.ratio for v in result.verdicts], rtol=1e-12)


def test_white_noise_has_no_filter_to_vary(areas, config):
    assert run(areas, config, "4", temperature=white_model(areas)).filter_sensitivity is None


def test_requirements_that_do_not_fit_are_refused_together(areas, config):
    wrong = [
        AppliedRequirement(PRESETS["lpf_readout"], ("TM1_a_x", "C_TM1_x")),
        AppliedRequirement(PRESETS["lisa_oms"], ("A_TM1_x",)),
    ]
    with pytest.raises(ConfigError) as caught:
        run(areas, config, "1", requirements=wrong, frequency_hz=np.geomspace(1e-3, 30e-3, 50))
    paths, facts = zip(*caught.value.problems, strict=True)
    assert paths == ("requirement[0].outputs", "requirement[0].outputs", "requirement[1].outputs")
    assert "TM1_a_x: lpf_readout limits displacement (m), not acceleration (m s^-2)" in facts[0]
    assert "no output 'C_TM1_x'; did you mean A_TM1_x?; there are: TM1_a_x, TM1_omegadot_x, A_TM1_x" in facts[1]
    assert "band edge 0.0001 and 0.1 Hz is not among the frequencies" in facts[2]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rows": np.ones((3, 77))}, r"shape \(3, 77\)"),
        ({"rows": np.full((3, 78), np.nan)}, "TM1_a_x has values that are not finite"),
        ({"kinds": ("acceleration", "angle", "length")}, "'length'; known: acceleration"),
    ],
)
def test_sensitivities_that_do_not_fit_are_refused(areas, config, changes, message):
    with pytest.raises(InputError, match=message):
        run(areas, config, "1", **changes)


def test_common_heating_that_moves_nothing_is_silent_only_when_correlated(areas, config):
    """An output blind to a uniform temperature, with equal levels inside and out: case 1 is quiet, case 2 is not."""
    rows = rows_for(areas)
    rows -= rows.mean(axis=1, keepdims=True)
    equal = TemperatureModel.from_spectra([ShapedSpectrum(1e-4)] * len(areas))
    together, apart = (run(areas, config, i, rows=rows, temperature=equal).psd for i in ("1", "2"))
    assert np.all(together < 1e-28 * apart)
    assert thesis_model(areas).scale.max() > equal.scale.max()
    assert np.all(run(areas, config, "1", rows=rows).psd > 1e-6 * apart)


@pytest.mark.parametrize("case_id", ["1", "2", "4", "10b"])
def test_ratios_at_the_bounds_enclose_the_verdict(areas, config, case_id):
    row = rows_for(areas)[2]
    parts_of_read_outs = {"A_TM1_x": ReadOutParts(("M1", "M2"), np.stack([0.25 * row, 0.75 * row]), 0.5 * row)}
    result = run(areas, config, case_id, parts_of_read_outs=parts_of_read_outs)
    for v, verdict in enumerate(result.verdicts):
        lowest, low, high, _, highest = result.bound_ratio[v]
        assert lowest <= low * (1 + 1e-9)
        assert low <= verdict.ratio * (1 + 1e-9)
        assert verdict.ratio <= high * (1 + 1e-9)
        assert high <= highest * (1 + 1e-9)
        # The amplitudes of all groups together may grow by the margin.
        assert result.improvements[v].silenced[0] == pytest.approx(verdict.ratio, rel=1e-9, abs=0)
        changed = run(areas, config, case_id, rows=rows_for(areas) * verdict.margin)
        assert changed.verdicts[v].ratio == pytest.approx(1.0, rel=1e-9)
    for share in (result.contributions.path_share, result.contributions.path_band_share):
        np.testing.assert_allclose(share["A_TM1_x"], [0.25, 0.75], rtol=1e-9)
    for verdict, distortion in zip(result.verdicts, result.distortion_ratio, strict=True):
        expected = 0.5 * verdict.ratio if verdict.output == "A_TM1_x" else np.nan
        np.testing.assert_allclose(distortion, expected, rtol=1e-9)
