"""What is exported of a case file: spectra as tables over frequency, matrices over outputs and areas."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import CASE
from tedm_cli.files.store import Reader
from tedm_cli.matrix_files.named import NamedMatrix
from tedm_cli.results.areas import read_areas
from tedm_cli.results.cases.file import read_bound, read_correlation, read_psd


def case_notes(file: Reader) -> list[str]:
    """What the numbers are, in words."""
    return [
        f"tedm: noise of correlation case {file.string(CASE.CASE_ID)}: {file.string(CASE.CASE_TITLE)}",
        "PSDs and ASDs are one-sided, of the noise itself: the safety factor is in the verdicts only.",
        f"safety factor on amplitudes in the verdicts: {file.number(CASE.CASE_SAFETY_FACTOR):g}",
        f"temperatures: {file.string(CASE.TEMPERATURE_MODEL)}",
    ]


def case_matrices(file: Reader) -> list[NamedMatrix]:
    """Tables and matrices of an open case file."""
    labels, units = file.strings(CASE.OUTPUT_LABEL), file.strings(CASE.OUTPUT_UNIT)
    psd = read_psd(file, labels)
    power, amplitude = [f"({u})^2/Hz" for u in units], [f"{u}/sqrt(Hz)" for u in units]
    return [
        _over_frequency(file, "psd", psd, labels, power, "one-sided power spectral densities of the outputs"),
        _over_frequency(
            file, "asd", np.sqrt(psd), labels, amplitude, "amplitude spectral densities of the outputs, sqrt of psd"
        ),
        *(
            _over_frequency(
                file,
                f"bound_{bound}",
                read_bound(file, bound, labels),
                labels,
                power,
                f"{meaning}, one-sided PSDs",
            )
            for bound, meaning in _BOUNDS.items()
        ),
        _over_frequency(
            file,
            "requirement_asd",
            file.array(CASE.REQUIREMENT_AMPLITUDE),
            file.strings(CASE.REQUIREMENT_NAME),
            file.strings(CASE.REQUIREMENT_UNIT),
            "amplitude spectral densities that the requirements allow; NaN outside their bands",
        ),
        *_temperatures(file),
        *_contributions(file, labels, amplitude),
        _verdicts(file),
    ]


_BOUNDS = {
    "maximum": "largest over all correlations of the active areas",
    "maximum_non_negative": "largest over all correlations without a negative entry",
    "known_blocks": "largest when only the correlation between the blocks is unknown",
    "known_blocks_minimum": "smallest when only the correlation between the blocks is unknown",
    "minimum": "smallest over all correlations of the active areas",
}


def _over_frequency(
    file: Reader, name: str, values: FloatArray, labels: Sequence[str], units: Sequence[str], description: str
) -> NamedMatrix:
    """A table of `values` [n, F] with the frequency in its first column."""
    frequency = file.array(CASE.FREQUENCY)
    table = np.vstack([frequency, values.reshape(-1, len(frequency))]).T
    return NamedMatrix(name, table, [], ["frequency", *labels], [], ["Hz", *units], description)


def _temperatures(file: Reader) -> list[NamedMatrix]:
    table = read_areas(file)
    areas = table.name.tolist()
    spectrum, correlation = file.array(CASE.TEMPERATURE_SPECTRUM), read_correlation(file)
    ones = ["1"] * len(areas)
    at = f" at {file.number(CASE.CORRELATION_FREQUENCY):g} Hz" if file.has(CASE.CORRELATION_FREQUENCY) else ""
    matrices = [
        _over_frequency(
            file,
            "temperature_asd",
            file.array(CASE.TEMPERATURE_ASD)[spectrum],
            areas,
            [f"{unit}/sqrt(Hz)" for unit in table.unit],
            "one-sided amplitude spectral densities of the areas' temperatures (of silent areas too"
            f"{', but zero of gradients without a spectrum' if table.gradient.any() else ''})",
        ),
        NamedMatrix(
            "areas",
            np.stack([file.array(CASE.AREA_ID), correlation.block, correlation.delay_s], axis=1),
            areas,
            ["id", "block", "delay"],
            [],
            ["1", "1", "s"],
            "thermal areas: number, correlated block (-1: silent in this case), delay",
        ),
        NamedMatrix("R", correlation.matrix.real, areas, areas, ones, ones, f"correlation before delays{at}"),
    ]
    if np.iscomplexobj(correlation.matrix):
        matrices.append(
            NamedMatrix("R_imaginary", correlation.matrix.imag, areas, areas, ones, ones, "imaginary part of R")
        )
    return matrices


def _contributions(file: Reader, labels: list[str], amplitude: Sequence[str]) -> list[NamedMatrix]:
    areas = file.strings(CASE.AREA_NAME)
    at = np.column_stack([file.array(CASE.CONTRIBUTION_FREQUENCY), file.array(CASE.CONTRIBUTION_BAND)])
    signed = np.array([file.array(CASE.CONTRIBUTION_AMPLITUDE.of(label)) for label in labels])
    by_area, by_output = ["1"] * len(areas), ["1"] * len(labels)
    matrices = [
        NamedMatrix(
            "contribution_frequency",
            at,
            labels,
            ["frequency", "band_low", "band_high"],
            [],
            ["Hz"] * 3,
            "frequency of contribution and share, and band of band_share",
        ),
        NamedMatrix(
            "contribution",
            signed,
            labels,
            areas,
            amplitude,
            by_area,
            "signed amplitude of each area at contribution_frequency: sensitivity times ASD of its temperature",
        ),
        NamedMatrix(
            "share",
            file.array(CASE.CONTRIBUTION_SHARE),
            labels,
            areas,
            by_output,
            by_area,
            "share of each area in the PSD at contribution_frequency; a row sums to 1",
        ),
        NamedMatrix(
            "band_share",
            file.array(CASE.CONTRIBUTION_BAND_SHARE),
            labels,
            areas,
            by_output,
            by_area,
            "share of each area in the power in the band; a row sums to 1",
        ),
    ]
    if file.has(CASE.PATH_NAME):
        names = file.strings(CASE.PATH_NAME)
        held = [label for label in labels if file.has(CASE.PATH_SHARE.of(label))]
        for name, parts, where in (
            ("share", [file.array(CASE.PATH_SHARE.of(label)) for label in held], "at contribution_frequency"),
            ("band_share", [file.array(CASE.PATH_BAND_SHARE.of(label)) for label in held], "in the band"),
        ):
            meaning = f"share of each optical element, or other part, in the power {where}"
            matrices.append(
                NamedMatrix(
                    f"element_{name}", np.array(parts), held, names, ["1"] * len(held), ["1"] * len(names), meaning
                )
            )
    return matrices


def _verdicts(file: Reader) -> NamedMatrix:
    """One row per requirement and output."""
    rows = [
        f"{requirement} {output}"
        for requirement, output in zip(
            file.strings(CASE.VERDICT_REQUIREMENT), file.strings(CASE.VERDICT_OUTPUT), strict=True
        )
    ]
    columns = {
        "ratio": file.array(CASE.VERDICT_RATIO),
        "binding_frequency": file.array(CASE.VERDICT_BINDING_FREQUENCY),
        "passed": file.array(CASE.VERDICT_PASSED),
        "allowed_safety_factor": file.array(CASE.VERDICT_ALLOWED_SAFETY_FACTOR),
    }
    units = ["1", "Hz", "1", "1"]
    bounds = file.strings(CASE.BOUND_RATIO_BOUND)
    values = np.column_stack([*columns.values(), file.array(CASE.BOUND_RATIO_RATIO)])
    return NamedMatrix(
        "verdict",
        values,
        rows,
        [*columns, *(f"ratio_{b}" for b in bounds)],
        [],
        [*units, *(["1"] * len(bounds))],
        "largest ratio of safety factor x ASD to requirement, where, passed (1) or not (0), factor that just passes,"
        " and the ratio at every bound",
    )
