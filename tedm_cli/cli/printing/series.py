"""Time series, measured, simulated or realised, as lines of text and as plain dictionaries."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from tedm_cli.cli.printing.table import table
from tedm_cli.cli.printing.titles import legend_lines

if TYPE_CHECKING:
    from tedm_cli.arrays import FloatArray
    from tedm_cli.stages.noise.realisation import Realised
    from tedm_cli.stages.series_result import SeriesResult


def series_lines(r: SeriesResult, parts: Mapping[str, FloatArray] = MappingProxyType({})) -> list[str]:
    """Root mean squares, verdicts, and how sure the spectra are; `parts`: further columns [n] of root mean squares."""
    span = (r.samples - 1) * r.step_s
    lines = [
        f"series {r.name}: {r.source} ({r.path})",
        f"{r.samples:,} samples of {r.step_s:.6g} s (Nyquist frequency {0.5 / r.step_s:.3g} Hz) over {span:.6g} s;"
        f" {r.treatment}",
        *table(
            ("output", "rms", "peak", *parts, "unit"),
            [
                (n, *(f"{x:.3g}" for x in numbers), u)
                for n, u, *numbers in zip(r.labels, r.units, r.rms, r.peak, *parts.values(), strict=True)
            ],
            right=tuple(range(1, 3 + len(parts))),
        ),
        _sure(r),
    ]
    if r.verdicts:
        rows = [
            (
                v.worst.output,
                v.worst.requirement,
                f"{v.band_rms:.3g}",
                f"{v.band_limit:.3g}",
                f"{v.worst.noise:.3g}",
                f"{v.worst.limit:.3g}",
                f"{v.worst.ratio:.3g}",
                f"{v.worst.binding_hz * 1e3:.3g}",
                "-".join(f"{1e3 * f:.3g}" for f in v.judged_hz),
                ("pass" if v.worst.passed else "FAIL") + " in part" * (not v.whole),
            )
            for v in r.verdicts
        ]
        head = (
            *("output", "requirement", "band rms", "limit rms", "noise", "limit", "ratio", "at mHz", "judged mHz"),
            "verdict",
        )
        lines += table(head, rows, right=tuple(range(2, 9)))
        lines.append(
            f"ratio = safety factor {r.safety_factor:g} x noise / limit, at its largest, in amplitude spectral density;"
            " the scatter of the estimate is in it"
        )
        lines += legend_lines((v.worst.output, v.worst.requirement) for v in r.verdicts)
    else:
        lines.append("nothing judged: neither a pass nor a violation")
    return lines + [f"not judged: {fact}" for fact in r.unjudged]


def _sure(r: SeriesResult) -> str:
    nu = r.estimate.degrees_of_freedom
    if not len(nu):
        return "the series is too short for a spectrum"
    low, high = (float(v[nu.argmin()]) ** 0.5 for v in r.estimate.interval(r.confidence))
    return (
        f"spectra: {r.estimate.frequency_hz[0]:.3g} to {r.estimate.frequency_hz[-1]:.3g} Hz, amplitudes within a factor"
        f" {low:.3g} to {high:.3g} ({r.confidence:.0%} confidence, {nu.min():.3g} degrees of freedom)"
    )


def series_dict(r: SeriesResult) -> dict[str, Any]:
    """What a program needs of a series."""
    return {
        "series": r.name,
        "source": str(r.source),
        "file": str(r.path),
        "samples": r.samples,
        "step_s": r.step_s,
        "treatment": r.treatment,
        "safety_factor": r.safety_factor,
        "outputs": [
            {"output": n, "rms": float(a), "peak": float(p), "unit": u}
            for n, a, p, u in zip(r.labels, r.rms, r.peak, r.units, strict=True)
        ],
        "passed": all(v.worst.passed for v in r.verdicts) if r.verdicts else None,
        "verdicts": [
            {
                "output": v.worst.output,
                "requirement": v.worst.requirement,
                "ratio": v.worst.ratio,
                "binding_hz": v.worst.binding_hz,
                "noise": v.worst.noise,
                "limit": v.worst.limit,
                "band_rms": v.band_rms,
                "band_limit": v.band_limit,
                "passed": v.worst.passed,
                "judged_hz": v.judged_hz,
                "band_hz": v.band_hz,
                "whole_band": v.whole,
            }
            for v in r.verdicts
        ],
        "not_judged": r.unjudged,
    }


def realisation_line(r: Realised) -> str:
    """How a realisation stands to the exact spectra, over all outputs and frequencies."""
    import numpy as np

    ratio = r.ratio[~np.isnan(r.ratio).any(axis=1)]
    if not ratio.size:
        return f"realisation: {r.samples:,} samples, seed {r.seed}: no output has noise"
    low, high = r.estimate.interval(0.95)
    held = float(np.mean((ratio * low <= 1.0) & (ratio * high >= 1.0)))
    means = ratio.mean(axis=1)
    spacing = ", log-spaced spectra" if r.method == "log" else ""
    return (
        f"realisation: {r.samples:,} samples at {r.rate_hz:g} Hz, seed {r.seed}{spacing}; PSD over its expectation,"
        f" mean of an output {means.min():.4f} to {means.max():.4f}; {held:.1%} of all values hold it in their 95 %"
        " interval"
    )
