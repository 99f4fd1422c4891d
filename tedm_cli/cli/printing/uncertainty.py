"""How sure the verdicts of a case are, as lines of text."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from tedm_cli.cli.printing.table import table
from tedm_cli.results.cases.chances import probability_text, shares_text
from tedm_cli.results.wording import count, ratio_text

if TYPE_CHECKING:
    from tedm_cli.uncertainty.verdicts import CaseUncertainty

_NEAR = 0.5  # a ratio that stays below in 99 of 100 draws is not told of, unless nothing is above


def uncertainty_lines(u: CaseUncertainty, everything: bool) -> list[str]:
    """What matters: verdicts that are near their limits, by which parameters, and whether any is violated."""
    lines = [
        f"uncertainty: {count(len(u.parameters), 'parameter')}, {u.draws.samples:,} draws, seed {u.draws.seed}",
        *(f"left out of the uncertainty: {what}" for what in u.left_out),
    ]
    told = [d for d in u.verdicts if everything or d.percentile(99) > _NEAR]
    told = told or sorted(u.verdicts, key=lambda d: -d.percentile(99))[:1]
    head = (
        "output",
        "requirement",
        "P(violated)",
        "factor 1",
        "5 %",
        "median",
        "95 %",
        "variance by (with interactions)",
    )
    cells = [
        (
            d.requirement,
            probability_text(d.violated),
            probability_text(d.violated_bare),
            *(ratio_text(d.percentile(percent)) for percent in (5, 50, 95)),
            shares_text(u, d),
        )
        for d in told
    ]
    alike: dict[tuple[str, ...], list[str]] = {}
    for d, row in zip(told, cells, strict=True):
        alike.setdefault(row, []).append(d.output)
    lines += table(head, [(", ".join(outputs), *row) for row, outputs in alike.items()], right=(2, 3, 4, 5, 6))
    if len(told) < len(u.verdicts):
        rest = count(len(u.verdicts) - len(told), "more verdict")
        lines.append(
            f"and {rest} with ratios below {_NEAR:g} in 99 of 100 draws"
            if told[0].percentile(99) > _NEAR
            else f"and {rest} below it"
        )
    both = " and ".join(
        f"{probability_text(c)}{f' ± {c.error:.1g}' if c.error else ''} with {factor}"
        for c, factor in ((u.any_violated, "the safety factor"), (u.any_violated_bare, "factor 1"))
    )
    lines.append(f"any of {count(len(u.verdicts), 'verdict')} violated: probability {both}")
    if u.mesh is not None:
        worst = int(np.argmax([d.nominal for d in u.verdicts]))
        there, none = (float(ratio[worst]) for ratio in (u.mesh.other_ratio, u.mesh.extrapolated_ratio))
        lines.append(
            f"mesh: elements of {u.mesh.other} have {u.mesh.refinement:.3g} times the size; ratio of"
            f" {u.verdicts[worst].output} {ratio_text(u.verdicts[worst].nominal)} here,"
            f" {ratio_text(there)} there, {ratio_text(none)} extrapolated (order {u.mesh.order:g})"
        )
    return lines
