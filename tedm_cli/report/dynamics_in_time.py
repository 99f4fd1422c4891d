"""The closed loop in time in the report: how realisations stand to the exact spectra, and verdicts on series."""

from __future__ import annotations

from collections.abc import Sequence

from tedm_cli.report.document import Block, Cell, Facts, Figure, Heading, Paragraph, Table, columns, row
from tedm_cli.report.series import verdict_blocks
from tedm_cli.report.verdicts import Titles
from tedm_cli.results.cases.noise import REALISATION_CONFIDENCE
from tedm_cli.results.dynamics.in_time import LoopInTime
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import capital, percent, sci


def in_time_blocks(found: LoopInTime, figures: Sequence[Figure], titles: Titles) -> list[Block]:
    """Nothing where there is nothing in time; `figures`: one for each realisation, then one for each series."""
    blocks: list[Block] = []
    if found.realised:
        text = (
            "The noise of the loop and the temperatures of a case, realised as one time series. Mean: estimated power"
            " over what the exact spectra expect, over all frequencies. Held: part of all values whose"
            f" {percent(REALISATION_CONFIDENCE)} interval holds the expectation."
        )
        head = columns("Output", "Case", "Mean\n(1)", "Held", "Samples", text=(0, 1))
        rows = [
            row(
                Cell(capital(output_title(output)), label=output),
                r.case,
                f"{mean:.3f}",
                percent(r.held, 1),
                f"{r.samples:,} at {r.rate_hz:g} Hz",
            )
            for r in found.realised
            for output, mean in r.mean.items()
        ]
        blocks += [Heading("Realised in time"), Paragraph(text)]
        blocks.append(Table(head, tuple(rows), "Realisations of the closed loop against its exact spectra."))
        blocks += figures[: len(found.realised)]
    for (name, s), figure in zip(found.series.items(), figures[len(found.realised) :], strict=True):
        treatment = f"{s.treatment}; {s.samples:,} samples over {sci(s.span_s)} s"
        facts = (("Temperatures", f"{s.source}, without the noise of the loop"), ("Treatment", treatment))
        blocks += [Heading(f"Series {name} through the loop"), Facts(facts), figure]
        blocks += verdict_blocks(f"{name} through the loop", s, titles)
    return blocks
