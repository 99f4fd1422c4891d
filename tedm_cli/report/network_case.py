"""The case of the thermal network beside the assumed ones: its verdicts, causes, temperatures and correlation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.report.document import Block, Cell, Figure, Link, Paragraph, Ref, Row, Section, State, Table, columns, row
from tedm_cli.report.evidence import cancels, factor_cell, ratio_cell, share_text
from tedm_cli.report.thermal import SECTION, stability_words, thermal_cases
from tedm_cli.report.verdicts import Titles
from tedm_cli.results.cases.deciding import LIKELY, Pair, deciding_pairs, possible_of, without_repeats, worst_of
from tedm_cli.results.cases.noise import CaseNoise, JudgedOutput
from tedm_cli.results.thermal.comparison import Comparison
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import and_text, capital, count, mhz_text, power_text, ratio_text

_CAUSES = 3  # disturbances named of each output
_BY_GROUP = "correlation by group"


def network_case_section(cases: Sequence[CaseNoise], figures: Sequence[Figure], titles: Titles) -> list[Section]:
    """What the thermal network says, beside the cases that assume temperatures and correlations; [] without it.

    figures : of each case of `thermal_cases` the shares of its disturbances, and their required stability.
    """
    drawn = {case.id: figures[2 * i : 2 * i + 2] for i, case in enumerate(thermal_cases(cases))}
    network, others, deciding = _split(cases)
    blocks: list[Block] = []
    for case in network:
        assert case.comparison is not None
        blocks.append(Paragraph((f"{_told(case, others, deciding)} ", Link("What the network is", SECTION), ".")))
        if case.judged:
            blocks += [_beside(case, others, titles), *drawn.get(case.id, ())[:1]]
            blocks += [Paragraph(stability_words(case, titles)), *drawn.get(case.id, ())[1:]]
            blocks.append(_required(case, case.comparison))
        if case.comparison.resemblance is not None:
            blocks += [*_resemblance(case, case.comparison, others), _levels(case, case.comparison)]
    title = "Evidence: the thermal network beside the assumed cases"
    return [Section("network-case", title, "Network and cases", tuple(blocks))] if blocks else []


def network_correlation_section(cases: Sequence[CaseNoise]) -> list[Section]:
    """Its correlation by groups of areas, against the blocks of the assumed cases; [] without it."""
    found = [_by_group(case, case.comparison) for case in cases if case.comparison is not None]
    blocks = tuple(table for tables in found for table in tables)
    title = "Correlation of the thermal network"
    return [Section("network-correlation", title, "Network correlation", blocks)] if blocks else []


def _split(cases: Sequence[CaseNoise]) -> tuple[list[CaseNoise], list[CaseNoise], set[str]]:
    """Cases of the network and the others, outputs that say the same as one; ids of the cases that decide."""
    merged = without_repeats(cases)
    network = [case for case in merged if case.comparison is not None]
    deciding = {case.id for case, _ in deciding_pairs(cases)} if network else set()
    return network, [case for case in merged if case.comparison is None], deciding


def _told(case: CaseNoise, others: Sequence[CaseNoise], deciding: set[str]) -> str:
    assert case.comparison is not None
    causes, own = case.comparison.disturbance, set(case.areas.name.tolist())
    own &= set(causes)
    parts = [count(len(case.areas) - len(own), "node") + " on the model", count(len(causes) - len(own), "disturbance")]
    if own:
        parts.append(count(len(own), "area") + " with a spectrum of its own each")
    said = [
        f"Case {case.id} takes temperatures and their correlation from the thermal network ({', '.join(parts)}), not"
        " from assumed levels and blocks."
    ]
    if not case.judged:
        return said[0]
    said.append("A verdict hangs on it." if case.id in deciding else "No verdict hangs on it.")
    bad = [j for j in case.judged if not j.passed]
    if bad:
        said.append(f"It violates {count(len(bad), 'limit')} of {len(case.judged)}.")
    else:
        said.append("It meets every limit.")
    _, worst = worst_of([(case, j) for j in case.judged])
    words = f"Its largest ratio is {ratio_text(worst.ratio)}"
    if (other := _worst_other(worst, others)) is not None:
        words += f" ({ratio_text(other[1].ratio)} in case {other[0].id})"
    most = ratio_text(worst.bound_ratio["maximum"])
    said.append(
        f"{words}: {output_title(worst.output)}. With the temperatures of the network and any correlation it would be"
        f" {most} at most."
    )
    return " ".join(said)


def _worst_other(j: JudgedOutput, others: Sequence[CaseNoise]) -> Pair | None:
    """The same output in the worst of the likely cases that assume, or of all that can occur where none is likely."""
    pairs = [(c, k) for c in others for k in c.judged if (k.output, k.requirement) == (j.output, j.requirement)]
    if not pairs:
        return None
    likely = [p for p in pairs if p[0].role == LIKELY]
    return worst_of(likely or possible_of(pairs))


def _beside(case: CaseNoise, others: Sequence[CaseNoise], titles: Titles) -> Table:
    """Each verdict beside that of the case that assumes."""
    by_role = any(c.role == LIKELY for c in others)
    rows: list[Row] = []
    for j in case.judged:
        other = _worst_other(j, others)
        assumed = "" if other is None else Cell(f"{ratio_text(other[1].ratio)} (case {other[0].id})", _state(other[1]))
        rows.append(
            row(
                Cell(capital(output_title(j.output)), label=j.output),
                titles(j.requirement),
                ratio_cell(j.ratio),
                mhz_text(j.binding_hz),
                assumed,
                ratio_cell(j.bound_ratio["maximum"]),
                _causes(j),
            )
        )
    head = columns(
        *("Output", "Requirement", f"Case {case.id}\n(1)", "At", "Worst likely\ncase" if by_role else "Worst case"),
        *("Any\ncorrelation", "Made mostly by"),
        text=(0, 1, 3, 4, 6),
    )
    text = (
        f"Ratios of case {case.id} beside those of the cases that assume; any correlation: the largest ratio with the"
        " temperatures of the network. Shares by disturbance are of the power at this frequency; all are in the annex."
    )
    return Table(head, tuple(rows), text, tight=True, key="network beside")


def _state(j: JudgedOutput) -> State:
    return "met" if j.passed else "violated"


def _causes(j: JudgedOutput) -> str:
    assert j.disturbances is not None
    of = j.disturbances
    cancelled = cancels(of.share)
    first = np.argsort(-np.abs(of.share), kind="stable")[:_CAUSES]
    return ", ".join(f"{of.names[d]} {share_text(float(of.share[d]), cancelled)}" for d in first.tolist())


def _required(case: CaseNoise, of: Comparison) -> Table:
    """The level of each disturbance that just meets all limits, the others as they are."""
    rows: list[tuple[float, Row]] = []
    for d, name in enumerate(of.disturbance):
        factor, j = min(
            ((float(j.disturbances.level_factor[d]), j) for j in case.judged if j.disturbances is not None),
            key=lambda one: -1.0 if np.isnan(one[0]) else one[0],
        )
        level, felt = float(of.level_at(j.binding_hz)[d]), bool(np.isfinite(factor))
        rows.append(
            (
                -1.0 if np.isnan(factor) else factor,
                row(
                    name,
                    mhz_text(j.binding_hz),
                    power_text(level, 3),
                    factor_cell(factor),
                    power_text(level * factor, 3) if felt else "",
                    f"{of.unit[d]}/√Hz",
                    "" if np.isinf(factor) else capital(output_title(j.output)),
                ),
            )
        )
    rows.sort(key=lambda one: one[0])
    head = columns("Disturbance", "At", "Level", "Factor\n(1)", "Allowed", "Unit", "Decided by", text=(0, 1, 5, 6))
    text = (
        f"Required stability of each disturbance of case {case.id}: the factor on its level that just meets every"
        " limit, the others unchanged, and this level; below 1 it must be quieter."
    )
    return Table(head, tuple(r for _, r in rows), text, tight=True, key="network stability")


def _resemblance(case: CaseNoise, of: Comparison, others: Sequence[CaseNoise]) -> list[Paragraph | Table]:
    """Which assumed case has the correlation that is most like it."""
    r = of.resemblance
    assert r is not None
    found, known = of.by_case, {c.id: c for c in others}
    first = r.cases[0]
    likely = [f"{i} by {far:.2f}" for i, far in found.items() if i in known and known[i].role == LIKELY and i != first]
    words = f"Of the correlations that are assumed, that of case {first}"
    words += f" ({known[first].title[:1].lower()}{known[first].title[1:]})" if first in known else ""
    words += f" is most like it: it differs by {found[first]:.2f}"
    if likely:
        words += f", the likely case{'s' * (len(likely) > 1)} {and_text(likely)}"
    low, high = (f"{float(of_groups(r.coherence)):.2f}" for of_groups in (np.nanmin, np.nanmax))
    words += (
        " (root mean square over all pairs of nodes, at 1 mHz; 0: the same). The mean size of the correlation of two"
        f" nodes is {low} to {high}, by their groups: "
    )
    rows = tuple(
        row(i, known[i].title if i in known else "", known[i].role if i in known else "", f"{far:.2f}")
        for i, far in found.items()
    )
    text = f"How far the correlations that cases assume are from that of case {case.id}, the most alike first."
    head = columns("Case", "Correlation", "Role", "Differs by\n(1)", text=(0, 1, 2))
    return [Paragraph((words, Ref(_BY_GROUP), ".")), Table(head, rows, text, tight=True, key="network resemblance")]


def _levels(case: CaseNoise, of: Comparison) -> Table:
    """Temperatures of the nodes by group, beside those that are assumed."""
    r = of.resemblance
    assert r is not None
    rows = tuple(
        row(group, power_text(float(a), 3), power_text(float(b), 3), ratio_text(float(a / b)) if b > 0.0 else "")
        for group, a, b in zip(r.groups, r.asd, r.assumed_asd, strict=True)
    )
    text = (
        f"Temperatures at 1 mHz, root mean square over the thermal nodes of each group: case {case.id}, and what the"
        " other cases assume. A node belongs to the area that most of it is in."
    )
    head = columns("Group", f"Case {case.id}\n(K/√Hz)", "Assumed\n(K/√Hz)", "Ratio\n(1)", text=(0,))
    return Table(head, rows, text, tight=True, key="network levels")


def _by_group(case: CaseNoise, of: Comparison) -> list[Paragraph | Table]:
    """Means of the correlation over pairs of nodes, by their groups."""
    r = of.resemblance
    if r is None:
        return []
    rows = []
    for one, first in enumerate(r.groups):
        for other in range(one, len(r.groups)):
            if np.isnan(r.coherence[one, other]):
                continue
            numbers = (r.coherence[one, other], r.computed[one, other], *r.assumed[:, one, other])
            cells = [f"{float(v) + 0.0:.2f}".replace("-", "−") for v in numbers]
            rows.append(row(first, "itself" if one == other else r.groups[other], *cells))
    text = (
        f"Correlation of temperatures at 1 mHz, mean over pairs of nodes by their groups: its size and its real part in"
        f" case {case.id}, and what the other cases assume for the areas of the same nodes, the most alike first."
    )
    head = columns(
        *("Group", "with", f"Case {case.id},\nsize", f"Case {case.id},\nreal part", *(f"Case {i}" for i in r.cases)),
        text=(0, 1),
    )
    said = (
        "A case of blocks has 1 within a block and 0 between blocks. A small real part beside a large size: the two"
        " follow a common cause with a delay between them."
    )
    return [Paragraph(said), Table(head, tuple(rows), text, tight=True, key=_BY_GROUP)]
