"""How probable the verdicts are, with all that is configured to be uncertain of the model and the temperatures."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.report.document import Block, Cell, Figure, Paragraph, Row, Section, State, Table, columns, row
from tedm_cli.report.evidence import case_head, ratio_cell
from tedm_cli.results.cases.chances import (
    deviation_text,
    distribution_in,
    distribution_of,
    probability_text,
    probability_words,
    shares_text,
    spread_words,
    uncertain_cases,
)
from tedm_cli.results.cases.deciding import without_repeats
from tedm_cli.results.cases.noise import CaseNoise, JudgedOutput
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import and_text, capital, count, ratio_text
from tedm_cli.uncertainty.parameters import Parameter
from tedm_cli.uncertainty.verdicts import CaseUncertainty, Chance

_SURE = 0.05  # a probability between this and its complement leaves a verdict open


def chance_words(case: CaseNoise, j: JudgedOutput) -> str:
    """`with all that is uncertain 4.1 to 9.2 in 90 % of the draws, violated with probability 0.97`; or ""."""
    d = distribution_of(case, j)
    if d is None:
        return ""
    return f"with all that is uncertain {spread_words(d)}, violated with {probability_words(d.violated)}"


def violated_words(case: CaseNoise, j: JudgedOutput) -> str:
    """`, with probability 0.97`, of a violation in one case; or ""."""
    d = distribution_of(case, j)
    return "" if d is None else f", with {probability_words(d.violated)}"


def chance_cell(case: CaseNoise, j: JudgedOutput) -> Cell:
    """The probability that a requirement is violated in a case."""
    d = distribution_of(case, j)
    return Cell("") if d is None else _cell(d.violated)


def _cell(chance: Chance) -> Cell:
    p = chance.probability
    state: State = "violated" if p > 1.0 - _SURE else "met" if p < _SURE else "open"
    return Cell(probability_text(chance), state)


def uncertainty_section(cases: Sequence[CaseNoise], figures: Sequence[Figure]) -> Section:
    """Every case's verdicts with their probabilities, what is uncertain, and what could not be drawn."""
    told = uncertain_cases(without_repeats(cases))
    u = told[0][1]
    number = len(_parameters_of(told))
    text = (
        f"{capital(count(number, 'parameter'))} of the model and the temperatures"
        f" {'is' if number == 1 else 'are'} drawn {u.draws.samples:,} times together, and each draw gives"
        " every ratio of noise to requirement. The verdicts themselves are at the nominal values. Expansions and"
        " temperature levels act exactly; moduli, densities, thicknesses and positions to first order. Violated: the"
        " share of draws in which the ratio is above 1, with the safety factor, and with a factor of 1 in its place: a"
        " safety factor stands for what is unknown, so with it the known uncertainty is counted on top. Variance by:"
        " part of the ratio's variance by a parameter alone, and with its interactions in parentheses; parameters that"
        " are correlated count as one."
    )
    blocks: list[Block] = [Paragraph(text)]
    blocks += [Paragraph(f"Left out: {what}.") for what in dict.fromkeys(w for _, u in told for w in u.left_out)]
    blocks += figures
    blocks.append(_verdicts(told))
    blocks.append(_parameters(told))
    blocks += [Paragraph(words) for words in dict.fromkeys(_mesh_words(*one) for one in told) if words]
    return Section("uncertainty", "Probability of the verdicts", "Uncertainty", tuple(blocks))


def _verdicts(told: Sequence[tuple[CaseNoise, CaseUncertainty]]) -> Table:
    rows: list[Row] = []
    for case, u in told:
        rows.append(case_head(case))
        for j in case.judged:
            d = distribution_in(u, j)
            rows.append(
                row(
                    capital(output_title(j.output)),
                    ratio_cell(j.ratio),
                    *(ratio_cell(d.percentile(p)) for p in (5, 50, 95)),
                    _cell(d.violated),
                    _cell(d.violated_bare),
                    shares_text(u, d),
                )
            )
        any_of = [_cell(u.any_violated), _cell(u.any_violated_bare)]
        rows.append(row("any of them", *[""] * 4, *any_of, "", kind="sum"))
    head = columns(
        "Output", "Ratio", "5 %", "Median", "95 %", "Violated", "Factor 1", "Variance by", text=(0, 7)
    )  # fmt: skip
    caption = "Distribution of every ratio over the draws, and the probability that its requirement is violated."
    return Table(head, tuple(rows), caption, tight=True, key="uncertainty")


def _parameters_of(told: Sequence[tuple[CaseNoise, CaseUncertainty]]) -> dict[str, Parameter]:
    """The parameters of all cases by name; a case of the thermal network has its own."""
    return {p.name: p for _, u in told for p in u.parameters.items}


def _parameters(told: Sequence[tuple[CaseNoise, CaseUncertainty]]) -> Table:
    rows = [
        row(
            p.name,
            f"{p.quantity}: {p.of}" if p.of else p.quantity,
            deviation_text(p),
            p.distribution,
            p.source,
        )
        for p in _parameters_of(told).values()
    ]
    joined = list(
        dict.fromkeys(
            name for _, u in told for number, name in enumerate(u.sources) if (u.parameters.block == number).sum() > 1
        )
    )
    correlated = f" Correlated: {and_text(joined)}." if joined else ""
    caption = (
        "What is uncertain. ±: half the width of a uniform distribution; σ: one standard deviation, of the logarithm"
        f" where the distribution is lognormal.{correlated}"
    )
    head = columns("Parameter", "Of", "Deviation", "Distribution", "Source", text=(0, 1, 2, 3, 4))
    return Table(head, tuple(rows), caption, tight=True, key="uncertain parameters")


def _mesh_words(case: CaseNoise, u: CaseUncertainty) -> str:
    if u.mesh is None:
        return ""
    worst = int(np.argmax([d.nominal for d in u.verdicts]))
    d, there, none = u.verdicts[worst], u.mesh.other_ratio[worst], u.mesh.extrapolated_ratio[worst]
    return (
        f"Mesh: the elements of {u.mesh.other} have {u.mesh.refinement:.3g} times the size. Case {case.id}, the"
        f" {output_title(d.output)}: {ratio_text(d.nominal)} with this mesh, {ratio_text(float(there))} with that one,"
        f" {ratio_text(float(none))} extrapolated to elements without size (order {u.mesh.order:g})."
    )


def uncertainty_facts(cases: Sequence[CaseNoise]) -> list[tuple[str, str]]:
    """What the probabilities take for granted, for the list of assumptions."""
    told = uncertain_cases(cases)
    if not told:
        return []
    u = told[0][1]
    items = _parameters_of(told).values()
    assumed = sum("assum" in p.source.lower() for p in items)
    words = f"probabilities are over {count(len(items), 'parameter')}, {u.draws.samples:,} draws"
    if assumed:
        words += f"; the deviations of {assumed} of them are assumptions"
    left = [f"left out: {what}" for what in dict.fromkeys(what for _, of in told for what in of.left_out)]
    return [("Uncertainty", "; ".join([words, *left]))]
