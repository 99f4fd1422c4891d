"""plot, the time series: of every configured series that has been run, the output of each quantity that is worst."""

from __future__ import annotations

from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.spec import FigureSpec
from tedm_cli.figures.thinning import piece_starts
from tedm_cli.files.build_folder import series_file_name
from tedm_cli.files.store import Reader
from tedm_cli.noise.requirements import AppliedRequirement, in_band
from tedm_cli.noise.spectral_estimate import Estimate
from tedm_cli.results.build_folder import Results, spectra_of
from tedm_cli.results.noise import Limit, SeriesNoise, SeriesOutput, first_largest

_BLOCK = 1 << 20  # samples read at a time
_LIMIT_POINTS = 200


def series_specs(results: Results) -> list[FigureSpec]:
    """A figure for each series, in the order of the configuration."""
    requirements = results.config.applied_requirements()
    confidence = {table.name: table.confidence for table in results.config.series}
    specs = []
    for name, file in results.series.items():
        used = results.series_files[name]
        specs.append(
            FigureSpec(
                series_file_name(name).replace(".h5", ".svg"),
                "series",
                f"Time series {file.string('/temperature/source')}, {file.string('/temperature/treatment')}: of each"
                f" quantity the output {'that is worst' if file.strings('/verdict/output') else 'of the largest rms'}."
                " Left: smallest and largest values, without the safety factor; right:"
                f" estimated amplitude spectral density times the safety factor"
                f" {file.number('/verdict/safety_factor'):g}, with its interval at {100 * confidence[name]:g} %.",
                (f"{used.path.name} {used.sha256}",),
                lambda file=file, name=name: _room().series_figure(  # type: ignore[misc]
                    read_series(file, requirements, confidence[name])
                ),
            )
        )
    return specs


def read_series(file: Reader, requirements: list[AppliedRequirement], confidence: float) -> SeriesNoise:
    """The worst output of each judged quantity; where nothing is judged, the one with the largest rms of each."""
    labels, kinds, units = (file.strings(f"/output/{c}") for c in ("label", "kind", "unit"))
    rms = file.array("/output/rms")
    verdicts = list(
        zip(
            file.strings("/verdict/output"),
            file.strings("/verdict/requirement"),
            (float(v) for v in file.array("/verdict/ratio")),
            (float(v) for v in file.array("/verdict/binding_frequency")),
            (bool(v) for v in file.array("/verdict/passed")),
            strict=True,
        )
    )
    shown: list[tuple[int, tuple[str, float, float, bool] | None]] = []
    judged = {kinds[labels.index(v[0])] for v in verdicts}
    for kind in dict.fromkeys(kinds):
        if kind in judged:
            of_kind = [v for v in verdicts if kinds[labels.index(v[0])] == kind]
            output, requirement, ratio, at, passed = first_largest(of_kind, [v[2] for v in of_kind])
            shown.append((labels.index(output), (requirement, ratio, at, passed)))
        elif not judged:
            of = [o for o, k in enumerate(kinds) if k == kind]
            shown.append((first_largest(of, [float(rms[o]) for o in of]), None))
    outputs = []
    for o, worst in shown:
        time, low, high = _extremes(file, labels[o])
        f, psd, nu = (file.array(p) for p in ("/frequency", f"/psd/{labels[o]}", "/degrees_of_freedom"))
        limit_hz, limits = _limits(labels[o], requirements)
        outputs.append(
            SeriesOutput(
                labels[o],
                kinds[o],
                units[o],
                float(rms[o]),
                time,
                low,
                high,
                spectra_of(Estimate(f, psd[None], nu), confidence)[0],
                limit_hz,
                limits,
                worst,
            )
        )
    return SeriesNoise(
        file.string("/temperature/source"),
        file.string("/temperature/treatment"),
        file.number("/verdict/safety_factor"),
        confidence,
        tuple(outputs),
    )


def _extremes(file: Reader, output: str) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Times [p], smallest and largest values of an output in equal pieces of its series, read in blocks."""
    data, time = file.dataset(f"/series/{output}"), file.dataset("/time")
    n = data.shape[0]
    start = piece_starts(n)
    low, high = np.empty(len(start)), np.empty(len(start))
    ends = np.append(start[1:], n)
    first = 0
    while first < len(start):
        last = max(first + 1, int(np.searchsorted(ends, start[first] + _BLOCK, side="right")))
        values = data[int(start[first]) : int(ends[last - 1])]
        cuts = start[first:last] - start[first]
        low[first:last], high[first:last] = np.minimum.reduceat(values, cuts), np.maximum.reduceat(values, cuts)
        first = last
    begin, end = (float(time[i : i + 1][0]) for i in (0, n - 1))
    middle = (start + ends - 1) / 2.0  # samples are equally far apart
    return begin + (end - begin) * middle / max(n - 1, 1), low, high


def _limits(output: str, requirements: list[AppliedRequirement]) -> tuple[FloatArray, tuple[Limit, ...]]:
    """Limits that judge an output, on a grid of frequencies that holds their kinks."""
    applied = [r.requirement for r in requirements if output in r.outputs]
    if not applied:
        return np.empty(0), ()
    held = [f for q in applied for f in q.grid_hz]
    grid = np.unique(np.append(np.geomspace(min(held), max(held), _LIMIT_POINTS), held))
    limits = []
    for q in applied:
        amplitude = np.full(len(grid), np.nan)
        inside = in_band(q, grid)
        amplitude[inside] = q.amplitude(grid[inside])
        limits.append(Limit(q.name, q.source, q.unit, q.band_hz, amplitude))
    return grid, tuple(limits)


def _room() -> Any:
    """Loaded only where something is drawn: the report reads figures that are there already."""
    from tedm_cli.figures import series

    return series
