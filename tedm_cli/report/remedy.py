"""What to do: what would bring every verdict that is not met within its limit, told before any evidence."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.report.assumed_filter import filter_remedy, turned_by_filter
from tedm_cli.report.document import (
    Block,
    Cell,
    Figure,
    Heading,
    Link,
    Paragraph,
    Ref,
    Row,
    Section,
    Strong,
    Table,
    Text,
    columns,
    row,
)
from tedm_cli.report.dynamics import SECTION
from tedm_cli.report.evidence import factor_cell, few, improvement_key, ratio_cell
from tedm_cli.report.summary import Loop, Noise
from tedm_cli.report.verdicts import Judgement, Titles, exceeding, loop_judgements, noise_judgements, worst_first
from tedm_cli.results.cases.noise import MATCHED, QUIETER, SILENCED, CaseNoise, JudgedOutput, level_unit
from tedm_cli.results.dynamics.loop import ClosedLoop
from tedm_cli.results.gravity.field import worst_at_rest
from tedm_cli.results.titles import at_rest_title, by_subsystem, output_title
from tedm_cli.results.wording import (
    and_text,
    capital,
    clause,
    count,
    mhz_text,
    number_word,
    power_text,
    ratio_text,
    rounded_down,
    sci,
    unit_text,
)

_MEASURE = {
    SILENCED: "Areas without any noise",
    QUIETER: "The same areas with a tenth of their noise",
    MATCHED: "One common temperature of blocks",
}
ACTUATION = "actuation"
_TOLD = 3  # outputs whose remedy is told in sentences; those of all are in the table


def remedy_section(
    cases: Sequence[CaseNoise],
    dc: Sequence[DcVerdict],
    loop: ClosedLoop | None,
    titles: Titles,
    figures: Sequence[Figure],
) -> Section:
    """What would help, of all that is judged; `figures` show it for what fails first."""
    judged = worst_first(noise_judgements(cases))
    noise = [j for j in judged if j.state != "met"]
    closed = [j for j in worst_first(loop_judgements(loop)) if j.state != "met"]
    blocks: list[Block] = []
    if noise:
        blocks += [Heading("Temperatures"), *_temperatures(noise)]
    if outside := exceeding(dc):
        blocks += [Heading("Field at rest"), *_balance(outside, len(dc))]
    if closed:
        blocks += [Heading("Closed loop"), *_closed_loop(closed, bool(outside), titles)]
    by_filter = filter_remedy(turned_by_filter(judged))
    if not blocks:
        met = "all judged requirements are met in every case that can occur"
        blocks.append(
            Paragraph(
                f"Nothing has to be changed with the assumed temperature filter: {met}. Verdicts depend on this filter."
                if by_filter
                else f"Nothing has to be done: {met}."
            )
        )
    blocks += by_filter
    blocks += figures
    return Section("todo", "What to do", "What to do", tuple(blocks), new_page=True)


def _temperatures(noise: Noise) -> list[Block]:
    blocks: list[Block] = [Paragraph(_first_remedy(noise))]
    rows: list[Row] = []
    for found in noise:
        case, j = found.decides
        rows.append(
            row(
                capital(output_title(found.output)), f"{ratio_text(j.ratio)} × its limit in case {case.id}", kind="head"
            )
        )
        rows += measures(j)
    head = columns("Measure", "Where", "Ratio after\n(1)", "Enough?", text=(0, 1, 3))
    text = (
        "Ratio with each measure. Areas and blocks are those that help most, chosen one after the other; a"
        " common temperature: all areas of the blocks follow one fluctuation, each with its own amplitude."
    )
    return [*blocks, Table(head, tuple(rows), text, tight=True), _stability(noise)]


def _first_remedy(noise: Noise) -> Text:
    """The measure of the fewest changes that is enough for what fails first, in a sentence."""
    found = noise[0]
    _, j = found.decides
    title, m = output_title(found.output), j.improvement
    all_areas = f"{ratio_text(m.all_factor)} of the present temperature noise in all areas"
    words: Text
    if measure := _least(j):
        what, where, after = measure
        words = (
            Strong(f"{capital(what)} ({where})"),
            f": this brings the {clause(title)} from {ratio_text(j.ratio)} to {after} times its limit."
            f" Or allow no more than {all_areas}. ",
        )
    else:
        words = (
            Strong(f"Allow no more than {all_areas}"),
            f": no smaller measure that was tried brings the {clause(title)} within its limit. ",
        )
    return (
        *words,
        *map(_further_remedy, noise[1:_TOLD]),
        "Every area and block is in ",
        Ref(improvement_key(found.requirement, found.output)),
        ".",
    )


def _least(j: JudgedOutput) -> tuple[str, str, str] | None:
    """The measure of the fewest changes that is enough: what to do, where, and the ratio after; None where none is."""
    m = j.improvement
    enough = [(way, n) for way in _MEASURE if (n := m.enough(way))]
    if not enough:
        return None
    way, n = min(enough, key=lambda item: item[1])
    what = {
        SILENCED: f"silence {count(n, 'area')}",
        QUIETER: f"bring {count(n, 'area')} to a tenth of the noise",
        MATCHED: f"give {count(n, 'block')} one common temperature"
        if n > 1
        else "keep one block at the common temperature",
    }[way]
    return what, few(m.chosen[way][:n]), ratio_text(m.after(way, n))


def _further_remedy(found: Judgement[CaseNoise, JudgedOutput]) -> str:
    """The same for another output that fails or is at risk, in a sentence."""
    case, j = found.decides
    measure = _least(j)
    least = f"allow no more than {ratio_text(j.improvement.all_factor)} of the temperature noise in all areas"
    what = f"{measure[0]}, which leaves {measure[2]} times, or {least}" if measure else least
    return (
        f"For the {clause(output_title(found.output))} in case {case.id} ({ratio_text(j.ratio)} times its limit):"
        f" {what}. "
    )


def measures(j: JudgedOutput) -> list[Row]:
    """Every measure on one output: as few areas as are enough, or as many as were tried where none are."""
    m = j.improvement
    rows = []
    for way, name in _MEASURE.items():
        chosen = m.chosen[way]
        if not chosen:
            rows.append(row(name, "a single one does not lower it", ratio_cell(j.ratio), Cell("no", "violated")))
            continue
        n = m.enough(way) or min(int(m.count[-1]), len(chosen))
        after = m.after(way, n)
        where = f"{count(n, 'block' if way == MATCHED else 'area')}: {few(chosen[:n])}"
        rows.append(row(name, where, ratio_cell(after), _verdict(after)))
    alone = [f"{g} to {ratio_text(f)}" for g, f in m.group_factor.items() if np.isfinite(f) and f < 1.0]
    if alone:
        rows.append(row("One group alone, by this factor", "; ".join(alone), "1.00", Cell("yes", "met")))
    else:
        rows.append(row("One group alone", "none can meet it, however quiet", "", Cell("no", "violated")))
    every = f"temperature noise by the factor {ratio_text(m.all_factor)}"
    rows.append(row("All areas alike", every, "1.00", Cell("yes", "met")))
    return rows


def _verdict(ratio: float) -> Cell:
    return Cell("yes", "met") if ratio <= 1.0 else Cell("no", "violated")


def _stability(noise: Noise) -> Table:
    """Temperature noise of each group, and what would just be allowed of what fails: by itself, and with all alike."""
    rows: list[Row] = []
    groups = dict[str, float]()
    for found in [j for j in noise if j.state == "violated"] or noise:
        case, j = found.decides
        m, of_area = j.improvement, case.areas.group_by_unit
        groups |= m.group_factor
        title = f"{capital(output_title(found.output))}, case {case.id}"
        rows.append(row(title, f"at {mhz_text(j.binding_hz)}", kind="head"))
        for group, factor in m.group_factor.items():
            level = m.group_level[group]
            known = not np.isnan(level)
            alone = power_text(factor * level, 3) if np.isfinite(factor) and known else ""
            rows.append(
                row(
                    group,
                    f"{(of_area == group).sum()}",
                    power_text(level, 3) if known else "differ",
                    power_text(m.all_factor * level, 3) if known and np.isfinite(m.all_factor) else "",
                    factor_cell(factor),
                    alone,
                )
            )
    unit = level_unit(groups)
    head = columns(
        *("Group", "Areas", f"Now\n({unit})", f"Allowed with all\ngroups alike ({unit})"),
        *("Factor, this\ngroup alone (1)", f"Allowed, this group\nalone ({unit})"),
        text=(0,),
    )
    text = "Temperature stability that would just be allowed, at the frequency that binds."
    return Table(head, tuple(rows), text, tight=True, key="stability")


def _balance(outside: Sequence[DcVerdict], judged: int) -> list[Block]:
    """What compensation masses, or masses moved, must take up."""
    whole = [v for v in outside if v.whole]
    parts = [v for v in outside if not v.whole]
    shown = whole or parts
    rows = []
    for v in sorted(shown, key=lambda v: -v.ratio):
        nearest = v.upper if v.value > 0.0 else v.lower
        rows.append(
            row(
                capital(at_rest_title(v.quantity, v.place)),
                by_subsystem(v.subsystem),
                sci(v.value),
                sci(nearest),
                Cell(sci(v.value - nearest, 3), "violated"),
                unit_text(v.unit),
            )
        )
    words: list[str | Strong | Ref | Link] = [
        Strong("Balance the static field"),
        f" by compensation masses or by moving masses: it exceeds its limits in {len(outside)} of"
        f" {count(judged, 'quantity', 'quantities')}. The minimum to be compensated is in ",
        Ref("balance"),
        "; all quantities are in ",
        Ref("at rest"),
        ".",
    ]
    if whole and parts:
        worst = worst_at_rest(parts)
        words.append(
            f" {capital(number_word(len(parts)))} of them {'are' if len(parts) > 1 else 'is'} of a part of the model"
            f" (the worst is {ratio_text(worst.ratio)} times its limit): balance each part by itself, or share the"
            " allocations between them anew."
        )
    head = columns(*("Quantity", "By", "Value", "Limit", "To compensate", "Unit"), text=(0, 1, 5))
    caption = (
        "The field at rest that exceeds its limits"
        + (", everything in the model together," if whole else "")
        + " and the minimum to be compensated."
    )
    return [Paragraph(tuple(words)), Table(head, tuple(rows), caption, tight=True, key="balance")]


def _closed_loop(closed: Loop, unbalanced: bool, titles: Titles) -> list[Block]:
    """For each output the groups of sources that would do, and how quiet they had to be."""
    rows: list[Row] = []
    decisive: list[str] = []
    for found in closed:
        case, j = found.decides
        decisive += j.together
        rows.append(
            row(
                capital(output_title(found.output)),
                titles(found.requirement),
                f"case {case.id}",
                ratio_cell(j.ratio),
                and_text(j.together),
                rounded_down(j.together_factor),
                ratio_cell(j.together_silenced),
            )
        )
    names = list(dict.fromkeys(decisive))
    words: list[str | Strong | Ref | Link] = [
        Strong(f"Lower the noise of {and_text(names)}"),
        " by the factors in ",
        Ref("loop remedy"),
        ". ",
    ]
    if ACTUATION in names and unbalanced:
        words.append(
            "In the noise of LISA Pathfinder that is preset, actuation noise grows with the acceleration at rest that"
            " has to be held: balancing the field, above, lowers it too. "
        )
    words += ["Budgets are in ", Link("the evidence", SECTION), ", every group by itself in ", Ref("loop groups"), "."]
    head = columns(
        *("Output", "Requirement", "Case", "Ratio\n(1)", "Sources", "Allowed\nfactor (1)"),
        "Without\nthem (1)",
        text=(0, 1, 2, 4),
    )
    text = (
        "Groups of sources to quieten, none of which can be left out; the factor on the amplitudes of all of them that"
        " just meets the requirement; and the ratio without them."
    )
    return [Paragraph(tuple(words)), Table(head, tuple(rows), text, tight=True, key="loop remedy")]
