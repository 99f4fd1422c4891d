"""The file of one correlation case: written by `run-case`, read for figures and the report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import AnyArray, BoolArray, FloatArray, IntArray
from tedm_cli.contracts import CASE, Dataset
from tedm_cli.files.store import Reader, Writer
from tedm_cli.noise.areas import GRADIENTS, group_in_unit, unit_of_group
from tedm_cli.noise.bounds import BOUNDS
from tedm_cli.noise.case_run import CaseResult
from tedm_cli.noise.improvement import COUNTS
from tedm_cli.noise.requirements import REFERENCE_HZ, Requirement, in_band
from tedm_cli.noise.selection import listed
from tedm_cli.noise.spectral_estimate import Estimate
from tedm_cli.results.areas import read_areas, write_areas
from tedm_cli.results.cases.noise import (
    MATCHED,
    QUIETER,
    REALISATION_CONFIDENCE,
    SILENCED,
    WAYS,
    CaseNoise,
    JudgedOutput,
    Limit,
    NamedImprovement,
    Spectrum,
    spectra_of,
)
from tedm_cli.results.cases.uncertainty import read_uncertainty
from tedm_cli.results.thermal.case_shares import of_network, read_disturbances, write_disturbances
from tedm_cli.results.thermal.comparison import read_comparison
from tedm_cli.results.wording import parts_noun

_BOUND = {
    "maximum": CASE.BOUNDS_MAXIMUM,
    "maximum_non_negative": CASE.BOUNDS_MAXIMUM_NON_NEGATIVE,
    "known_blocks": CASE.BOUNDS_KNOWN_BLOCKS,
    "known_blocks_minimum": CASE.BOUNDS_KNOWN_BLOCKS_MINIMUM,
    "minimum": CASE.BOUNDS_MINIMUM,
}
_RATIO_BY_WAY = {
    SILENCED: CASE.IMPROVEMENT_SILENCED,
    QUIETER: CASE.IMPROVEMENT_QUIETER,
    MATCHED: CASE.IMPROVEMENT_MATCHED,
}


def write_case(writer: Writer, r: CaseResult, area_id: IntArray, requirements: Sequence[Requirement]) -> None:
    """Write the result of a case; `requirements` are all that were applied."""
    areas = r.areas
    write_areas(writer, areas, area_id)
    block = np.full(len(areas), -1)
    for number, members in enumerate(r.blocks):
        block[members] = number
    writer.write(CASE.CASE_ID, r.case.id)
    writer.write(CASE.CASE_TITLE, r.case.title)
    writer.write(CASE.CASE_ROLE, r.case.role)
    writer.write(CASE.CASE_REASON, r.case.reason)
    writer.write(CASE.CASE_SAFETY_FACTOR, r.safety_factor)
    writer.write(CASE.CASE_BLOCK, block)
    correlation = r.source.correlation_at(REFERENCE_HZ)
    matrix = correlation.matrix()
    writer.write(CASE.CORRELATION_REAL, np.ascontiguousarray(matrix.real))
    if np.iscomplexobj(matrix):
        writer.write(CASE.CORRELATION_IMAGINARY, np.ascontiguousarray(matrix.imag))
    writer.write(CASE.CORRELATION_DELAY, correlation.delay_s)
    if r.case.thermal:
        writer.write(CASE.CORRELATION_FREQUENCY, REFERENCE_HZ)
    writer.write(CASE.FREQUENCY, r.frequency_hz)
    writer.write(CASE.TEMPERATURE_SPECTRUM, r.temperature_set)
    writer.write(CASE.TEMPERATURE_ASD, r.temperature_asd)
    writer.write(CASE.TEMPERATURE_MODEL, r.source.words())
    writer.write(CASE.OUTPUT_LABEL, r.outputs.labels)
    writer.write(CASE.OUTPUT_UNIT, r.outputs.units)
    writer.write(CASE.OUTPUT_KIND, r.outputs.kinds)
    c = r.contributions
    for i, (label, unit) in enumerate(zip(r.outputs.labels, r.outputs.units, strict=True)):
        power = f"({unit})^2/Hz"
        writer.write(CASE.PSD.of(label), r.psd[i], units=power)
        for bound in BOUNDS:
            writer.write(_BOUND[bound].format(output=label), getattr(r.bounds, bound)[i], units=power)
        writer.write(CASE.CONTRIBUTION_AMPLITUDE.of(label), c.amplitude[i], units=f"{unit}/sqrt(Hz)")
    for bound in BOUNDS:
        writer.write(CASE.EXTREMAL.of(bound), c.extremal[bound])
    writer.write(CASE.CONTRIBUTION_FREQUENCY, c.frequency_hz)
    writer.write(CASE.CONTRIBUTION_SHARE, c.share)
    writer.write(CASE.CONTRIBUTION_BAND, c.band_hz)
    writer.write(CASE.CONTRIBUTION_BAND_SHARE, c.band_share)
    if c.path_share:
        writer.write(CASE.PATH_NAME, c.path_names)
    for label in c.path_share:
        writer.write(CASE.PATH_SHARE.of(label), c.path_share[label])
        writer.write(CASE.PATH_BAND_SHARE.of(label), c.path_band_share[label])
    if (effects := r.outputs.effects) is not None:
        writer.write(CASE.EFFECT_NAME, effects.names)
        for i, (label, unit) in enumerate(zip(r.outputs.labels, r.outputs.units, strict=True)):
            writer.write(CASE.EFFECT_ROW.of(label), effects.rows[:, i], units=f"{unit} per unit of the area")
    if (found := r.disturbances) is not None:
        write_disturbances(writer, found)
    _write_verdicts(writer, r)
    _write_requirements(writer, r, requirements)


def _write_verdicts(writer: Writer, r: CaseResult) -> None:
    n = len(r.verdicts)
    writer.write(CASE.VERDICT_REQUIREMENT, [v.requirement for v in r.verdicts])
    writer.write(CASE.VERDICT_OUTPUT, [v.output for v in r.verdicts])
    writer.write(CASE.VERDICT_RATIO, [v.ratio for v in r.verdicts])
    writer.write(CASE.VERDICT_BINDING_FREQUENCY, [v.binding_hz for v in r.verdicts])
    writer.write(CASE.VERDICT_PASSED, [int(v.passed) for v in r.verdicts])
    writer.write(CASE.VERDICT_ALLOWED_SAFETY_FACTOR, [v.safety_factor * v.margin for v in r.verdicts])
    writer.write(CASE.VERDICT_DISTORTION_RATIO, r.distortion_ratio)
    writer.write(CASE.BOUND_RATIO_BOUND, list(BOUNDS))
    writer.write(CASE.BOUND_RATIO_RATIO, r.bound_ratio)
    if r.filter_sensitivity is not None:
        writer.write(CASE.FILTER_SENSITIVITY_ORDER, r.filter_sensitivity.order)
        writer.write(CASE.FILTER_SENSITIVITY_CORNER, r.filter_sensitivity.corner_hz)
        writer.write(CASE.FILTER_SENSITIVITY_RATIO, r.filter_sensitivity.ratio)
    writer.write(CASE.IMPROVEMENT_COUNT, np.array(COUNTS))
    for path, ranked in (
        (CASE.IMPROVEMENT_AREA, [i.worst for i in r.improvements]),
        (CASE.IMPROVEMENT_MATCHED_BLOCK, [i.match for i in r.improvements]),
    ):
        writer.write(path, np.array(ranked, dtype=int).reshape(n, COUNTS[-1]))
    for path, ratios in (
        (CASE.IMPROVEMENT_SILENCED, [i.silenced for i in r.improvements]),
        (CASE.IMPROVEMENT_QUIETER, [i.quieter for i in r.improvements]),
        (CASE.IMPROVEMENT_MATCHED, [i.matched for i in r.improvements]),
    ):
        writer.write(path, np.array(ratios).reshape(n, len(COUNTS)))
    writer.write(CASE.IMPROVEMENT_GROUP, [group.removesuffix(GRADIENTS) for group in r.groups])
    writer.write(CASE.IMPROVEMENT_GROUP_UNIT, [unit_of_group(group) for group in r.groups])
    factors = np.array([i.group_factor for i in r.improvements]).reshape(n, len(r.groups))
    writer.write(CASE.IMPROVEMENT_GROUP_FACTOR, factors)
    writer.write(CASE.IMPROVEMENT_ALL_FACTOR, [v.margin for v in r.verdicts])


def _write_requirements(writer: Writer, r: CaseResult, requirements: Sequence[Requirement]) -> None:
    writer.write(CASE.REQUIREMENT_NAME, [q.name for q in requirements])
    writer.write(CASE.REQUIREMENT_SOURCE, [q.source for q in requirements])
    writer.write(CASE.REQUIREMENT_UNIT, [f"{q.unit}/sqrt(Hz)" for q in requirements])
    writer.write(CASE.REQUIREMENT_APPLIES_TO, [q.applies_to for q in requirements])
    writer.write(CASE.REQUIREMENT_BAND, np.array([q.band_hz for q in requirements]).reshape(-1, 2))
    f = r.frequency_hz
    amplitude = np.full((len(requirements), len(f)), np.nan)
    for i, q in enumerate(requirements):
        inside = in_band(q, f)
        amplitude[i, inside] = q.amplitude(f[inside])
    writer.write(CASE.REQUIREMENT_AMPLITUDE, amplitude, units="see /requirement/unit")


def read_case(file: Reader) -> CaseNoise:
    """Setting, judged outputs and limits of an open case file."""
    limits = tuple(
        Limit(name, source, unit.removesuffix("/sqrt(Hz)"), (float(band[0]), float(band[1])), amplitude)
        for name, source, unit, band, amplitude in zip(
            file.strings(CASE.REQUIREMENT_NAME),
            file.strings(CASE.REQUIREMENT_SOURCE),
            file.strings(CASE.REQUIREMENT_UNIT),
            file.array(CASE.REQUIREMENT_BAND),
            file.array(CASE.REQUIREMENT_AMPLITUDE),
            strict=True,
        )
    )
    has_filter = file.has(CASE.FILTER_SENSITIVITY_RATIO)
    return CaseNoise(
        id=file.string(CASE.CASE_ID),
        title=file.string(CASE.CASE_TITLE),
        role=file.string(CASE.CASE_ROLE),
        reason=file.string(CASE.CASE_REASON),
        safety_factor=file.number(CASE.CASE_SAFETY_FACTOR),
        temperature=file.string(CASE.TEMPERATURE_MODEL).replace("sqrt(Hz)", "√Hz"),
        areas=read_areas(file),
        block=file.array(CASE.CASE_BLOCK),
        frequency_hz=file.array(CASE.FREQUENCY),
        judged=_read_judged(file),
        limits=limits,
        filter_order=file.array(CASE.FILTER_SENSITIVITY_ORDER) if has_filter else np.empty(0),
        filter_corner_hz=file.array(CASE.FILTER_SENSITIVITY_CORNER) if has_filter else np.empty(0),
        uncertainty=read_uncertainty(file),
        thermal=of_network(file),
        comparison=read_comparison(file),
    )


def _read_judged(file: Reader) -> tuple[JudgedOutput, ...]:
    labels, kinds, units = (file.strings(p) for p in (CASE.OUTPUT_LABEL, CASE.OUTPUT_KIND, CASE.OUTPUT_UNIT))
    filter_ratio = file.array(CASE.FILTER_SENSITIVITY_RATIO) if file.has(CASE.FILTER_SENSITIVITY_RATIO) else None
    ratio, at, passed = (
        file.array(p) for p in (CASE.VERDICT_RATIO, CASE.VERDICT_BINDING_FREQUENCY, CASE.VERDICT_PASSED)
    )
    share, band_share = file.array(CASE.CONTRIBUTION_SHARE), file.array(CASE.CONTRIBUTION_BAND_SHARE)
    band = file.array(CASE.CONTRIBUTION_BAND)
    bounds, bound_ratio = file.strings(CASE.BOUND_RATIO_BOUND), file.array(CASE.BOUND_RATIO_RATIO)
    distortion = file.array(CASE.VERDICT_DISTORTION_RATIO)
    realised, disturbances = _read_realised(file), read_disturbances(file)
    judged = []
    pairs = zip(file.strings(CASE.VERDICT_OUTPUT), file.strings(CASE.VERDICT_REQUIREMENT), strict=True)
    for v, (output, requirement) in enumerate(pairs):
        o = labels.index(output)
        low, high = (np.sqrt(read_bound(file, b, [output])[0]) for b in ("minimum", "maximum"))
        judged.append(
            JudgedOutput(
                output=output,
                kind=kinds[o],
                unit=units[o],
                requirement=requirement,
                ratio=float(ratio[v]),
                binding_hz=float(at[v]),
                passed=bool(passed[v]),
                asd=np.sqrt(file.array(CASE.PSD.of(output))),
                bound_low=low,
                bound_high=high,
                bound_ratio=dict(zip(bounds, (float(r) for r in bound_ratio[v]), strict=True)),
                distortion_ratio=None if np.isnan(distortion[v]) else float(distortion[v]),
                filter_ratio=None if filter_ratio is None else filter_ratio[v],
                contribution_hz=float(file.array(CASE.CONTRIBUTION_FREQUENCY)[o]),
                band_hz=(float(band[o, 0]), float(band[o, 1])),
                contribution=file.array(CASE.CONTRIBUTION_AMPLITUDE.of(output)),
                share=share[o],
                band_share=band_share[o],
                path=_path_share(file, CASE.PATH_SHARE, output),
                path_band=_path_share(file, CASE.PATH_BAND_SHARE, output),
                improvement=_read_improvement(file, v, float(at[v])),
                realised=None if realised is None else realised[o],
                disturbances=None if disturbances is None else disturbances[v],
            )
        )
    return tuple(judged)


def _path_share(file: Reader, path: Dataset, output: str) -> dict[str, float] | None:
    """Shares of the parts of an output by name; not of those that are no part of it at all."""
    if not file.has(path.of(output)):
        return None
    names = file.strings(CASE.PATH_NAME)
    kept = file.array(CASE.PATH_SHARE.of(output)) != 0.0
    kept |= (file.array(CASE.PATH_BAND_SHARE.of(output)) != 0.0) | (parts_noun(names) != "parts")
    shares = file.array(path.of(output)).tolist()
    return {name: share for name, share, is_part in zip(names, shares, kept, strict=True) if is_part}


def _read_improvement(file: Reader, v: int, binding_hz: float) -> NamedImprovement:
    """What would bring verdict number `v` down."""
    names, block = np.array(file.strings(CASE.AREA_NAME)), file.array(CASE.CASE_BLOCK)
    worst = [str(names[i]) for i in file.array(CASE.IMPROVEMENT_AREA)[v] if i >= 0]
    attributes = [
        (text, np.array(file.strings(path)))
        for text, path in (("{} the thermal shield", CASE.AREA_SHIELD), ("of {}", CASE.AREA_GROUP))
    ]
    matched = file.array(CASE.IMPROVEMENT_MATCHED_BLOCK)[v]
    match = [block_name(names, attributes, block == b) for b in matched if b >= 0]
    named = zip(file.strings(CASE.IMPROVEMENT_GROUP), file.strings(CASE.IMPROVEMENT_GROUP_UNIT), strict=True)
    groups = [group_in_unit(group, unit) for group, unit in named]
    at = int(np.abs(file.array(CASE.FREQUENCY) - binding_hz).argmin())
    level = file.array(CASE.TEMPERATURE_ASD)[file.array(CASE.TEMPERATURE_SPECTRUM), at]
    level = np.where(block >= 0, level, np.nan)
    of_area = read_areas(file).group_by_unit
    return NamedImprovement(
        count=file.array(CASE.IMPROVEMENT_COUNT),
        ratio={way: file.array(path)[v] for way, path in _RATIO_BY_WAY.items()},
        chosen=dict(zip(WAYS, (worst, worst, match), strict=True)),
        group_factor=dict(zip(groups, (float(x) for x in file.array(CASE.IMPROVEMENT_GROUP_FACTOR)[v]), strict=True)),
        group_level={g: _common(level[of_area == g]) for g in groups},
        all_factor=float(file.array(CASE.IMPROVEMENT_ALL_FACTOR)[v]),
    )


def block_name(names: AnyArray, attributes: Sequence[tuple[str, AnyArray]], members: BoolArray) -> str:
    """A block in few words: `all 66 areas inside the thermal shield`, `all 26 areas of IS1`; else its first areas.

    `attributes`: text with {} for a value, and the values [k] of the areas.
    """
    if members.sum() > 1:
        for text, values in attributes:
            value = values[members][0]
            if (members == (values == value)).all():
                return f"all {members.sum()} areas {text.format(value)}"
    return listed(names[members].tolist())


def _common(values: FloatArray) -> float:
    """The one value of those that are not NaN; NaN where they differ."""
    held = np.unique(values[~np.isnan(values)])
    return float(held[0]) if len(held) and held[-1] <= held[0] * (1 + 1e-9) else np.nan


def _read_realised(file: Reader) -> list[Spectrum] | None:
    """Estimates from a realisation of all outputs over their exact spectra; 1 where there is no noise."""
    if not file.has(CASE.REALISATION_PSD):
        return None
    f, nu = file.array(CASE.REALISATION_FREQUENCY), file.array(CASE.REALISATION_DEGREES_OF_FREEDOM)
    psd, exact = file.array(CASE.REALISATION_PSD), file.array(CASE.REALISATION_EXACT)
    ratio = np.divide(psd, exact, out=np.ones_like(psd), where=exact > 0.0)
    return spectra_of(Estimate(f, ratio, nu), REALISATION_CONFIDENCE)


@dataclass(frozen=True, eq=False)
class CaseCorrelation:
    """How the temperatures of k areas move together in a case.

    matrix : [k, k], before delays; real, or complex where it has an imaginary part. delay_s : [k]. block : [k], the
    correlated block of each area, -1 for silent ones.
    """

    matrix: AnyArray
    delay_s: FloatArray
    block: IntArray


def read_correlation(file: Reader) -> CaseCorrelation:
    """Correlation of an open case file."""
    matrix = file.array(CASE.CORRELATION_REAL)
    if file.has(CASE.CORRELATION_IMAGINARY):
        matrix = matrix + 1j * file.array(CASE.CORRELATION_IMAGINARY)
    return CaseCorrelation(matrix, file.array(CASE.CORRELATION_DELAY), file.array(CASE.CASE_BLOCK))


@dataclass(frozen=True, eq=False)
class NoiseAt:
    """Amplitude spectral densities `asd` [n, F] of all n outputs of a case, unit/√Hz by output, without safety factor.

    Between the frequencies [F] they are straight lines in log-log.
    """

    frequency_hz: FloatArray
    label: list[str]
    unit: list[str]
    asd: FloatArray

    def at(self, output: int, frequency_hz: float) -> float:
        """The noise of an output at a frequency; NaN outside of the frequencies."""
        f, asd = self.frequency_hz, self.asd[output]
        if not f[0] * (1 - 1e-9) <= frequency_hz <= f[-1] * (1 + 1e-9):
            return np.nan
        if not (asd > 0.0).all():
            return float(np.interp(np.log(frequency_hz), np.log(f), asd))
        return float(np.exp(np.interp(np.log(frequency_hz), np.log(f), np.log(asd))))


def read_noise_at(file: Reader) -> NoiseAt:
    """The noise of all outputs of an open case file."""
    label = file.strings(CASE.OUTPUT_LABEL)
    return NoiseAt(file.array(CASE.FREQUENCY), label, file.strings(CASE.OUTPUT_UNIT), np.sqrt(read_psd(file, label)))


def read_psd(file: Reader, labels: Sequence[str]) -> FloatArray:
    """One-sided power spectral densities [n, F] of outputs of an open case file."""
    return np.array([file.array(CASE.PSD.of(label)) for label in labels])


def read_bound(file: Reader, bound: str, labels: Sequence[str]) -> FloatArray:
    """Largest or smallest one-sided PSDs [n, F] of outputs, one of `noise.bounds.BOUNDS`, of an open case file."""
    return np.array([file.array(_BOUND[bound].format(output=label)) for label in labels])
