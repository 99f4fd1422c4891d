"""The file of one correlation case: written by `run-case`, read for figures and the report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import AnyArray, FloatArray, IntArray
from tedm_cli.files.store import Reader, Writer
from tedm_cli.noise.bounds import BOUNDS
from tedm_cli.noise.case_run import CaseResult
from tedm_cli.noise.improvement import COUNTS
from tedm_cli.noise.requirements import Requirement, in_band
from tedm_cli.noise.selection import listed
from tedm_cli.noise.spectral_estimate import Estimate
from tedm_cli.results.areas import write_areas
from tedm_cli.results.noise import (
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
    TemperatureSpectra,
    spectra_of,
)

_BOUND = {
    "maximum": "/bounds/maximum/{output}",
    "maximum_non_negative": "/bounds/maximum_non_negative/{output}",
    "known_blocks": "/bounds/known_blocks/{output}",
    "known_blocks_minimum": "/bounds/known_blocks_minimum/{output}",
    "minimum": "/bounds/minimum/{output}",
}
_RATIO_BY_WAY = {
    SILENCED: "/improvement/silenced",
    QUIETER: "/improvement/quieter",
    MATCHED: "/improvement/matched",
}


def write_case(writer: Writer, r: CaseResult, area_id: IntArray, requirements: Sequence[Requirement]) -> None:
    """Write the result of a case; `requirements` are all that were applied."""
    areas = r.areas
    write_areas(writer, areas, area_id)
    block = np.full(len(areas), -1)
    for number, members in enumerate(r.blocks):
        block[members] = number
    writer.write("/case/id", r.case.id)
    writer.write("/case/title", r.case.title)
    writer.write("/case/role", r.case.role)
    writer.write("/case/reason", r.case.reason)
    writer.write("/case/safety_factor", r.safety_factor)
    writer.write("/case/block", block)
    matrix = r.source.correlation.matrix()
    writer.write("/correlation/real", np.ascontiguousarray(matrix.real))
    if np.iscomplexobj(matrix):
        writer.write("/correlation/imaginary", np.ascontiguousarray(matrix.imag))
    writer.write("/correlation/delay", r.source.correlation.delay_s)
    writer.write("/frequency", r.frequency_hz)
    writer.write("/temperature/spectrum", r.temperature_set)
    writer.write("/temperature/asd", r.temperature_asd)
    writer.write("/temperature/model", r.source.temperature.words())
    writer.write("/output/label", r.outputs.labels)
    writer.write("/output/unit", r.outputs.units)
    writer.write("/output/kind", r.outputs.kinds)
    c = r.contributions
    for i, (label, unit) in enumerate(zip(r.outputs.labels, r.outputs.units, strict=True)):
        power = f"({unit})^2/Hz"
        writer.write(f"/psd/{label}", r.psd[i], units=power)
        for bound in BOUNDS:
            writer.write(_BOUND[bound].format(output=label), getattr(r.bounds, bound)[i], units=power)
        writer.write(f"/contribution/amplitude/{label}", c.amplitude[i], units=f"{unit}/sqrt(Hz)")
    for bound in BOUNDS:
        writer.write(f"/extremal/{bound}", c.extremal[bound])
    writer.write("/contribution/frequency", c.frequency_hz)
    writer.write("/contribution/share", c.share)
    writer.write("/contribution/band", c.band_hz)
    writer.write("/contribution/band_share", c.band_share)
    if c.path_share:
        writer.write("/path/name", c.path_names)
    for label in c.path_share:
        writer.write(f"/path/share/{label}", c.path_share[label])
        writer.write(f"/path/band_share/{label}", c.path_band_share[label])
    _write_verdicts(writer, r)
    _write_requirements(writer, r, requirements)


def _write_verdicts(writer: Writer, r: CaseResult) -> None:
    n = len(r.verdicts)
    writer.write("/verdict/requirement", [v.requirement for v in r.verdicts])
    writer.write("/verdict/output", [v.output for v in r.verdicts])
    writer.write("/verdict/ratio", [v.ratio for v in r.verdicts])
    writer.write("/verdict/binding_frequency", [v.binding_hz for v in r.verdicts])
    writer.write("/verdict/passed", [int(v.passed) for v in r.verdicts])
    writer.write("/verdict/allowed_safety_factor", [v.safety_factor * v.margin for v in r.verdicts])
    writer.write("/verdict/distortion_ratio", r.distortion_ratio)
    writer.write("/bound_ratio/bound", list(BOUNDS))
    writer.write("/bound_ratio/ratio", r.bound_ratio)
    if r.filter_sensitivity is not None:
        writer.write("/filter_sensitivity/order", r.filter_sensitivity.order)
        writer.write("/filter_sensitivity/corner", r.filter_sensitivity.corner_hz)
        writer.write("/filter_sensitivity/ratio", r.filter_sensitivity.ratio)
    writer.write("/improvement/count", np.array(COUNTS))
    for path, ranked in (
        ("/improvement/area", [i.worst for i in r.improvements]),
        ("/improvement/matched_block", [i.match for i in r.improvements]),
    ):
        writer.write(path, np.array(ranked, dtype=int).reshape(n, COUNTS[-1]))
    for path, ratios in (
        ("/improvement/silenced", [i.silenced for i in r.improvements]),
        ("/improvement/quieter", [i.quieter for i in r.improvements]),
        ("/improvement/matched", [i.matched for i in r.improvements]),
    ):
        writer.write(path, np.array(ratios).reshape(n, len(COUNTS)))
    writer.write("/stability/group", r.groups)
    factors = np.array([i.group_factor for i in r.improvements]).reshape(n, len(r.groups))
    writer.write("/stability/factor", factors)
    writer.write("/stability/all", [v.margin for v in r.verdicts])


def _write_requirements(writer: Writer, r: CaseResult, requirements: Sequence[Requirement]) -> None:
    writer.write("/requirement/name", [q.name for q in requirements])
    writer.write("/requirement/source", [q.source for q in requirements])
    writer.write("/requirement/unit", [f"{q.unit}/sqrt(Hz)" for q in requirements])
    writer.write("/requirement/applies_to", [q.applies_to for q in requirements])
    writer.write("/requirement/band", np.array([q.band_hz for q in requirements]).reshape(-1, 2))
    f = r.frequency_hz
    amplitude = np.full((len(requirements), len(f)), np.nan)
    for i, q in enumerate(requirements):
        inside = in_band(q, f)
        amplitude[i, inside] = q.amplitude(f[inside])
    writer.write("/requirement/amplitude", amplitude, units="see /requirement/unit")


def read_case(file: Reader) -> CaseNoise:
    """Setting, judged outputs and limits of an open case file."""
    limits = tuple(
        Limit(name, source, unit.removesuffix("/sqrt(Hz)"), (float(band[0]), float(band[1])), amplitude)
        for name, source, unit, band, amplitude in zip(
            file.strings("/requirement/name"),
            file.strings("/requirement/source"),
            file.strings("/requirement/unit"),
            file.array("/requirement/band"),
            file.array("/requirement/amplitude"),
            strict=True,
        )
    )
    has_filter = file.has("/filter_sensitivity/ratio")
    return CaseNoise(
        id=file.string("/case/id"),
        title=file.string("/case/title"),
        role=file.string("/case/role"),
        reason=file.string("/case/reason"),
        safety_factor=file.number("/case/safety_factor"),
        temperature=file.string("/temperature/model").replace("sqrt(Hz)", "√Hz"),
        block=file.array("/case/block"),
        frequency_hz=file.array("/frequency"),
        judged=_read_judged(file),
        limits=limits,
        filter_order=file.array("/filter_sensitivity/order") if has_filter else np.empty(0),
        filter_corner_hz=file.array("/filter_sensitivity/corner") if has_filter else np.empty(0),
    )


def _read_judged(file: Reader) -> tuple[JudgedOutput, ...]:
    labels, kinds, units = (file.strings(p) for p in ("/output/label", "/output/kind", "/output/unit"))
    filter_ratio = file.array("/filter_sensitivity/ratio") if file.has("/filter_sensitivity/ratio") else None
    ratio, at, passed = (file.array(p) for p in ("/verdict/ratio", "/verdict/binding_frequency", "/verdict/passed"))
    share, band_share = file.array("/contribution/share"), file.array("/contribution/band_share")
    band = file.array("/contribution/band")
    bounds, bound_ratio = file.strings("/bound_ratio/bound"), file.array("/bound_ratio/ratio")
    distortion = file.array("/verdict/distortion_ratio")
    realised = _read_realised(file)
    judged = []
    pairs = zip(file.strings("/verdict/output"), file.strings("/verdict/requirement"), strict=True)
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
                asd=np.sqrt(file.array(f"/psd/{output}")),
                bound_low=low,
                bound_high=high,
                bound_ratio=dict(zip(bounds, (float(r) for r in bound_ratio[v]), strict=True)),
                distortion_ratio=None if np.isnan(distortion[v]) else float(distortion[v]),
                filter_ratio=None if filter_ratio is None else filter_ratio[v],
                contribution_hz=float(file.array("/contribution/frequency")[o]),
                band_hz=(float(band[o, 0]), float(band[o, 1])),
                contribution=file.array(f"/contribution/amplitude/{output}"),
                share=share[o],
                band_share=band_share[o],
                path=_path_share(file, f"/path/share/{output}"),
                path_band=_path_share(file, f"/path/band_share/{output}"),
                improvement=_read_improvement(file, v, float(at[v])),
                realised=None if realised is None else realised[o],
            )
        )
    return tuple(judged)


def _path_share(file: Reader, path: str) -> dict[str, float] | None:
    if not file.has(path):
        return None
    return dict(zip(file.strings("/path/name"), (float(s) for s in file.array(path)), strict=True))


def _read_improvement(file: Reader, v: int, binding_hz: float) -> NamedImprovement:
    """What would bring verdict number `v` down."""
    names, block = np.array(file.strings("/area/name")), file.array("/case/block")
    worst = [str(names[i]) for i in file.array("/improvement/area")[v] if i >= 0]
    match = [listed(names[block == b].tolist()) for b in file.array("/improvement/matched_block")[v] if b >= 0]
    groups = file.strings("/stability/group")
    at = int(np.abs(file.array("/frequency") - binding_hz).argmin())
    level = file.array("/temperature/asd")[file.array("/temperature/spectrum"), at]
    level = np.where(block >= 0, level, np.nan)
    of_area = np.array(file.strings("/area/group"))
    return NamedImprovement(
        count=file.array("/improvement/count"),
        ratio={way: file.array(path)[v] for way, path in _RATIO_BY_WAY.items()},
        chosen=dict(zip(WAYS, (worst, worst, match), strict=True)),
        group_factor=dict(zip(groups, (float(x) for x in file.array("/stability/factor")[v]), strict=True)),
        group_level={g: _common(level[of_area == g]) for g in groups},
        all_factor=float(file.array("/stability/all")[v]),
    )


def _common(values: FloatArray) -> float:
    """The one value of those that are not NaN; NaN where they differ."""
    held = np.unique(values[~np.isnan(values)])
    return float(held[0]) if len(held) and held[-1] <= held[0] * (1 + 1e-9) else np.nan


def _read_realised(file: Reader) -> list[Spectrum] | None:
    """Estimates from a realisation of all outputs over their exact spectra; 1 where there is no noise."""
    if not file.has("/realisation/psd"):
        return None
    f, nu = file.array("/realisation/frequency"), file.array("/realisation/degrees_of_freedom")
    psd, exact = file.array("/realisation/psd"), file.array("/realisation/exact")
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
    matrix = file.array("/correlation/real")
    if file.has("/correlation/imaginary"):
        matrix = matrix + 1j * file.array("/correlation/imaginary")
    return CaseCorrelation(matrix, file.array("/correlation/delay"), file.array("/case/block"))


def read_psd(file: Reader, labels: Sequence[str]) -> FloatArray:
    """One-sided power spectral densities [n, F] of outputs of an open case file."""
    return np.array([file.array(f"/psd/{label}") for label in labels])


def read_bound(file: Reader, bound: str, labels: Sequence[str]) -> FloatArray:
    """Largest or smallest one-sided PSDs [n, F] of outputs, one of `noise.bounds.BOUNDS`, of an open case file."""
    return np.array([file.array(_BOUND[bound].format(output=label)) for label in labels])


def read_temperature(file: Reader) -> TemperatureSpectra:
    """Distinct spectra of a case file; each is named by the shield sides and the number of its areas."""
    index = file.array("/temperature/spectrum")
    shield = np.array(file.strings("/area/shield"))
    asd = file.array("/temperature/asd")
    names = []
    for q in range(len(asd)):
        sides, counts = np.unique(shield[index == q], return_counts=True)
        parts = [f"{side} the thermal shield ({n} areas)" for side, n in zip(sides, counts, strict=True)]
        names.append(", ".join(parts) or "no area")
    return TemperatureSpectra(file.array("/frequency"), asd, names)
