"""The first page: the verdict in a sentence, every judged output in a table, and the parameters that decide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.report.assumed_filter import TurnedByFilter, beyond_words, turned_by_filter
from tedm_cli.report.document import Block, Cell, FileLink, Paragraph, Row, Section, Strong, Table, Text, columns, row
from tedm_cli.report.uncertain import chance_cell, chance_words
from tedm_cli.report.verdicts import (
    NOT_JUDGED,
    C,
    J,
    Judgement,
    Titles,
    at_rest_rows,
    exceeding,
    judgement_rows,
    loop_judgements,
    noise_judgements,
    worst_first,
)
from tedm_cli.results.cases.chances import distribution_of, probability_words, uncertain_cases
from tedm_cli.results.cases.deciding import LIKELY, POSSIBLE, possible_of, worst_of
from tedm_cli.results.cases.noise import CaseNoise, JudgedOutput
from tedm_cli.results.dynamics.loop import ClosedLoop, LoopOutput, SimulatedCase
from tedm_cli.results.gravity.field import worst_at_rest
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import and_text, capital, clause, count, mhz_text, ratio_text, span
from tedm_cli.uncertainty.verdicts import CaseUncertainty

_PLURAL = {"modulus": "moduli", "density": "densities", "thickness": "thicknesses", "mesh": "meshes"}

Noise = list[Judgement[CaseNoise, JudgedOutput]]
Loop = list[Judgement[SimulatedCase, LoopOutput]]


def summary_section(
    cases: Sequence[CaseNoise],
    dc: Sequence[DcVerdict],
    loop: ClosedLoop | None,
    loop_words: Paragraph,
    titles: Titles,
    has_gravity: bool,
    remarks: Sequence[Text],
    model_view: str,
) -> Section:
    """The verdicts and what they rest on.

    `has_gravity`: whether there is a field at rest; `remarks`: what to know of the project before its verdicts are
    believed; `model_view`: a file beside the report that shows the model, or "".
    """
    noise, closed = worst_first(noise_judgements(cases)), worst_first(loop_judgements(loop))
    by_role = any(case.role == LIKELY for case in cases)
    blocks: list[Block] = [Paragraph(verdict_sentence(noise, dc, closed))]
    blocks += [Paragraph(remark) for remark in remarks]
    if not noise:
        blocks.append(Paragraph("The configuration has no requirement on noise: nothing is judged."))
    if has_gravity and not dc:
        blocks.append(Paragraph(NOT_JUDGED))
    if noise or closed or dc:
        blocks.append(_verdicts(noise, dc, closed, by_role, titles))
    if noise:
        blocks.append(_parameters(noise[0], cases))
    if not closed:
        blocks.append(loop_words)
    if model_view:
        blocks.append(Paragraph(("The model with its motions: ", FileLink(model_view, model_view), "."), quiet=True))
    return Section("verdict", "Decision", "Decision", tuple(blocks))


def verdict_sentence(noise: Noise, dc: Sequence[DcVerdict], closed: Loop) -> Text:
    """The whole verdict in one plain sentence, what fails first."""
    failing = [j for j in noise if j.state == "violated"]
    bad, outside = [j for j in closed if j.state == "violated"], exceeding(dc)
    said = []
    if failing:
        case, worst_noise = failing[0].decides
        title, ratio = output_title(failing[0].output), ratio_text(worst_noise.ratio)
        said.append(f"the {clause(title)} is {ratio} times its limit in case {case.id}{_chance(case, worst_noise)}")
    if outside:
        worst = worst_at_rest(dc)
        said.append(
            f"the field at rest exceeds its limits in {len(outside)} of"
            f" {count(len(dc), 'quantity', 'quantities')} (the worst is {ratio_text(worst.ratio)} times its limit)"
        )
    if bad:
        worst_ratio = ratio_text(max(j.decides[1].ratio for j in bad))
        said.append(
            f"in closed loop {len(bad)} of {count(len(closed), 'limit')} {'is' if len(bad) == 1 else 'are'} exceeded"
            f" (the worst {worst_ratio} times)"
        )
    at_risk = [_risk_words(j) for j in noise if j.state == "open"] + [
        _risk_words(j) for j in closed if j.state == "open"
    ]
    risk = at_risk[0] if at_risk else ""
    turned = turned_by_filter(noise)
    hangs = _filter_words(turned, noise) if turned else ""
    if said:
        also = f"; at risk besides: {risk}" if risk else ""
        return (Strong("The requirements are not met"), f": {and_text(said)}{also}.{hangs}")
    if risk:
        words = f": {risk}.{hangs}{_chance_words(noise)}"
        return (Strong("The requirements are met in the likely cases, and at risk in others"), words)
    if not (noise or closed or dc):
        return (Strong("Nothing is judged"), ": the project names no requirement.")
    ratios = [j.possible[1].ratio for j in noise] + [j.possible[1].ratio for j in closed] + [v.ratio for v in dc]
    if turned:
        return (
            Strong("All that is required is met with the assumed temperature filter, but not with every other"),
            f": the largest ratio to a limit is {ratio_text(max(ratios))} in the cases that can occur, and other"
            f" filters bring {beyond_words(turned)}.{_chance_words(noise)}",
        )
    return (
        Strong("All that is required is met"),
        f", in every case that can occur: the largest ratio to a limit is {ratio_text(max(ratios))}."
        f"{_chance_words(noise)}",
    )


def _chance(case: CaseNoise, j: JudgedOutput) -> str:
    """` (violated with probability 0.97)`, or ""."""
    d = distribution_of(case, j)
    return "" if d is None else f" (violated with {probability_words(d.violated)})"


def _chance_words(noise: Noise) -> str:
    """The largest probability that what is met at the nominal values is not, where there are probabilities."""
    found = [
        (d.violated.probability, case.id, judgement.output, d.violated)
        for judgement in noise
        for case, j in possible_of(judgement.pairs)
        if (d := distribution_of(case, j)) is not None
    ]
    if not found:
        return ""
    _, case_id, output, chance = max(found, key=lambda one: one[0])
    return (
        f" With all that is uncertain, the {clause(output_title(output))} is beyond its limit with"
        f" {probability_words(chance)} in case {case_id}, and no other with a larger one."
    )


def _filter_words(turned: Sequence[TurnedByFilter], noise: Noise) -> str:
    """That verdicts of a project which does not meet all hang on the filter."""
    first = next((t for t in turned if t.found is noise[0]), turned[0])
    return f" The assumed temperature filter decides here too: with others {first.words}."


def _risk_words(found: Judgement[C, J]) -> str:
    case, j = found.decides
    title = output_title(found.output)
    beyond = f"{ratio_text(j.ratio)} times it in case {case.id}"
    return f"the {clause(title)} is within its limit in the likely cases but {beyond}"


def _verdicts(noise: Noise, dc: Sequence[DcVerdict], closed: Loop, by_role: bool, titles: Titles) -> Table:
    rows: list[Row] = []
    uncertain = bool(uncertain_cases([case for found in noise for case, _ in found.pairs]))
    for head, more, part in (
        (
            "Noise by temperature",
            "each output by itself",
            judgement_rows(noise, titles, by_role, chance_cell if uncertain else None),
        ),
        (
            "Closed loop",
            "the same temperatures, and all other noise",
            judgement_rows(closed, titles, by_role),
        ),
        (
            "Field at rest",
            "static gravity, the same in every case; the worst quantity of each test mass, and of a difference",
            at_rest_rows(dc, by_role),
        ),
    ):
        if part:
            rows += [row(head, more, kind="head"), *part]
    titles_of = ["Output", "Requirement", "Verdict", "Ratio\n(1)", "Margin\n(1)", "At"]
    titles_of += ["Worst likely\ncase", "Worst of all\npossible cases"] if by_role else ["Worst case"]
    if uncertain:
        titles_of.append("Probability\nof violation")
        rows = [r if len(r.cells) == len(titles_of) or r.kind == "head" else _padded(r) for r in rows]
    text = "Every judged output. Ratio: largest safety factor × noise / limit over the band; margin: 1 / ratio." + (
        " At risk: met in the likely cases, violated in another that can occur." * by_role
        + " Probability: over all that is uncertain, in the case of the ratio." * uncertain
    )
    head_row = columns(*titles_of, text=(0, 1, 2, 5, 6, 7))
    return Table(head_row, tuple(rows), text, tight=True, key="verdicts")


def _padded(of: Row) -> Row:
    """A row without a probability: nothing of it is drawn."""
    return replace(of, cells=(*of.cells, Cell("")))


def _parameters(first: Judgement[CaseNoise, JudgedOutput], cases: Sequence[CaseNoise]) -> Table:
    """What the verdict rests on, and what it would be with other values: of the output that is told first."""
    case, j = first.decides
    factor, m = case.safety_factor, j.improvement
    rows = [
        row(
            "Temperature level",
            case.temperature,
            f"{ratio_text(m.all_factor)} of it in all areas would just be allowed",
        ),
    ]
    if j.filter_ratio is not None:
        orders, corners = (
            ", ".join(f"{v:g}" for v in axis) for axis in (case.filter_order, 1e3 * case.filter_corner_hz)
        )
        low, high = float(j.filter_ratio.min()), float(j.filter_ratio.max())
        rows.append(
            row(
                "Temperature filter",
                "order and corner of the low-pass are assumed",
                _span_cell(low, high, f" over orders {orders} and corners {corners} mHz"),
            )
        )
    rows.append(
        row(
            "Safety factor",
            f"{factor:g}, on noise amplitudes",
            Cell(
                f"{ratio_text(j.ratio / factor)} without it; {ratio_text(factor * m.all_factor)} would just be allowed"
            ),
        )
    )
    if case.uncertainty is not None:
        rows.append(row("What is uncertain", _uncertain(case.uncertainty), capital(chance_words(case, j))))
    others = [p for p in possible_of(first.pairs) if p[0].id != case.id]
    said = f"case {case.id}: {case.title[:1].lower()}{case.title[1:]}"
    bounds = span(j.bound_ratio["minimum"], j.bound_ratio["maximum"])
    by_role = [
        f"{ratio_text(worst_of(of_role)[1].ratio)} in the worst other {role} case ({worst_of(of_role)[0].id})"
        for role in (LIKELY, POSSIBLE)
        if (of_role := [p for p in others if p[0].role == role])
    ]
    rows.append(row("Correlation", said, "; ".join([*by_role, f"{bounds} over every correlation of the areas"])))
    if j.path is not None:
        rows.append(row("Read-out set", _sets(first.output), _other_sets(first, cases)))
    limit = next(q for q in case.limits if q.name == j.requirement)
    band = f"{limit.band_hz[0] * 1e3:g} to {limit.band_hz[1] * 1e3:g} mHz"
    rows.append(row("Band", band, f"binds at {mhz_text(j.binding_hz)}"))
    text = (
        f"The parameters that decide, and what the ratio {ratio_text(j.ratio)} of the {output_title(first.output)}"
        " would be with others, one changed at a time."
    )
    return Table(columns("Parameter", "Here", "With another value", text=(0, 1, 2)), tuple(rows), text, tight=True,
                 key="parameters")  # fmt: skip


def _uncertain(u: CaseUncertainty) -> str:
    """Parameters by what they are: `6 expansions, 2 levels`."""
    quantities = [p.quantity for p in u.parameters.items]
    return ", ".join(count(quantities.count(q), q, _PLURAL.get(q, "")) for q in dict.fromkeys(quantities))


def _span_cell(low: float, high: float, more: str) -> Cell:
    return Cell(span(low, high) + more, "violated" if low > 1.0 else "met" if high <= 1.0 else "open")


def _sets(outputs: str) -> str:
    """`A and B`: the sets whose read-outs are told as one."""
    sets = list(dict.fromkeys(label.split("_")[0] for label in outputs.split(", ")))
    return f"set{'s' * (len(sets) > 1)} {and_text(sets)}"


def _other_sets(first: Judgement[CaseNoise, JudgedOutput], cases: Sequence[CaseNoise]) -> str:
    names = first.output.split(", ")
    if len(names) > 1:
        return f"the same from {'both' if len(names) == 2 else 'all'}"
    stem = names[0].partition("_")[2]
    case, j = first.decides
    own = next(c for c in cases if c.id == case.id)
    others = [
        f"{ratio_text(o.ratio)} from set {o.output.partition('_')[0]}"
        for o in own.judged
        if o.requirement == j.requirement and o.output != j.output and o.output.partition("_")[2] == stem
    ]
    return capital(", ".join(others)) if others else "no other set is judged"
