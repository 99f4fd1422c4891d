"""The closed loop in the report: verdicts on its outputs, what would help, and how stable it is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.report.document import (
    Block,
    Cell,
    Facts,
    Figure,
    Heading,
    Paragraph,
    Row,
    Section,
    Strong,
    Table,
    Text,
    columns,
    row,
    verdict_cell,
)
from tedm_cli.report.dynamics_in_time import in_time_blocks
from tedm_cli.report.evidence import cancels, factor_cell, ratio_cell, share_text
from tedm_cli.report.verdicts import Titles
from tedm_cli.results.cases.deciding import DIAGNOSTIC, deciding
from tedm_cli.results.cases.noise import temperature_words
from tedm_cli.results.dynamics.loop import ClosedLoop, LoopOutput, LoopStability, SimulatedCase
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import and_text, capital, clause, mhz_text, percent, ratio_text, sci

SECTION = "loop"
_NAMED = 3  # groups named of each verdict
_LEAST = 0.01  # shares below this are not named
_MARGINS = "loop_margins.svg"

Pair = tuple[SimulatedCase, LoopOutput]


def closed_loop_words(found: ClosedLoop | None, no_loop: str, ids: Sequence[str], titles: Titles) -> Paragraph:
    """The closed loop in one sentence: Δg where it is judged, or else the worst output; or why there is none.

    `no_loop`: why there can be none, or ""; `ids` are all cases of the configuration.
    """
    if no_loop:
        return Paragraph(no_loop, quiet=True)
    if found is None:
        words = "The dynamics of the drag-free loop has not been run (`tedm build-dynamics`, then `tedm simulate all`)."
        return Paragraph(words, quiet=True)
    pair = found.told_first()
    if pair is None:
        return Paragraph("No output of the closed loop is judged.", quiet=True)
    case, j = pair
    made_of = j.largest(1, 0.0)[0]
    missing = _missing(found, ids)
    title = titles(j.requirement)
    text: Text = (
        f"In closed loop the {clause(output_title(j.output))} is ",
        Strong(f"{ratio_text(j.ratio)} times its limit"),
        f" ({title}) in case {case.id}, at {mhz_text(j.binding_hz)}; {made_of[0]} makes"
        f" {percent(made_of[1])} of its power" + (f"; not simulated: {_cases(missing)}." if missing else "."),
    )
    return Paragraph(text)


def _missing(found: ClosedLoop, ids: Sequence[str]) -> list[str]:
    done = {case.id for case in found.cases}
    return [i for i in ids if i not in done]


def _cases(ids: Sequence[str]) -> str:
    return f"case{'s' if len(ids) > 1 else ''} {and_text(ids)}"


def closed_loop_section(found: ClosedLoop, words: Paragraph, figures: Sequence[Figure], titles: Titles) -> Section:
    """Verdicts on the outputs of the loop, each in the case that decides it."""
    blocks: list[Block] = [
        words,
        Paragraph(
            "All noise of the drag-free loop together. The temperatures (thermal) push the test masses and disturb the"
            " read-outs that the controller uses; the other sources are those of the loop itself. Made of: parts of the"
            " noise power at the binding frequency."
        ),
    ]
    if pairs := found.pairs():
        rows = [_row(case.id, j, titles) for case, j in map(deciding, pairs.values())]
        blocks.append(_table(rows, "Case", "Outputs of the closed loop, in the case that decides each."))
    else:
        blocks.append(Paragraph("No requirement applies to an output of the loop."))
    return Section(SECTION, "Evidence: closed loop", "Closed loop", (*blocks, *figures))


def loop_detail_section(
    found: ClosedLoop, ids: Sequence[str], figures: Sequence[Figure], in_time: Sequence[Figure], titles: Titles
) -> Section:
    """All else of the closed loop: setting, verdicts, what would help, budgets, the loop in time, margins.

    `ids`: all cases there are; `in_time`: figures of realisations and series.
    """
    first = found.cases[0]
    facts: list[tuple[str, Text]] = [
        ("Controller", found.stability.origin),
        ("Read-outs heard", f"set {first.read_out_set}"),
        ("Temperature noise", temperature_words({c.id: c.temperature for c in found.cases})),
        ("Safety factor", f"{first.safety_factor:g}, on noise amplitudes"),
    ]
    if missing := _missing(found, ids):
        facts.append(("Not simulated", _cases(missing)))
    blocks: list[Block] = [Facts(tuple(facts))]
    pairs = found.pairs()
    if pairs:
        if any(case.role != DIAGNOSTIC for case in found.cases):
            blocks.append(_every(pairs, titles))
        blocks += _help([deciding(of_one) for of_one in pairs.values()], titles)
    blocks += _by_disturbances(found.cases, titles)
    blocks += [figure for figure in figures if figure.file != _MARGINS]
    blocks += in_time_blocks(found.in_time, in_time, titles)
    blocks += [
        Heading("Margins of the loops"),
        *(figure for figure in figures if figure.file == _MARGINS),
        *_margins(found.stability),
    ]
    return Section("loop-details", "Closed loop", "Closed loop", tuple(blocks))


def _row(cases: str, j: LoopOutput, titles: Titles, label: str = "") -> Row:
    margin = ratio_text(1.0 / j.ratio) if j.ratio > 0.0 else "any"
    made_of = ", ".join(f"{group} {percent(share)}" for group, share in j.largest(_NAMED, _LEAST))
    verdict, ratio = verdict_cell(j.passed), ratio_cell(j.ratio)
    named = Cell(capital(output_title(j.output)), label=label), titles(j.requirement)
    return row(*named, cases, verdict, ratio, margin, mhz_text(j.binding_hz), made_of)


def _table(rows: Sequence[Row], cases: str, caption: str) -> Table:
    titles = ("Output", "Requirement", cases, "Verdict", "Ratio\n(1)", "Margin\n(1)", "Binds at", "Made of")
    return Table(columns(*titles, text=(0, 1, 2, 3, 7)), tuple(rows), caption, tight=True)


def _every(pairs: dict[tuple[str, str], list[Pair]], titles: Titles) -> Table:
    """All that can occur, cases of which the same is to be said in one row; diagnostic cases are left out."""
    rows = []
    for of_one in pairs.values():
        alike: dict[Row, list[Pair]] = {}
        for case, j in of_one:
            if case.role != DIAGNOSTIC:
                alike.setdefault(_row("", j, titles, j.output), []).append((case, j))
        for same in alike.values():
            j = same[0][1]
            rows.append(_row(", ".join(case.id for case, _ in same), j, titles, j.output))
    return _table(rows, "Cases", "Every verdict in closed loop, without diagnostic cases.")


def _help(decided: Sequence[Pair], titles: Titles) -> list[Block]:
    """Of each requirement that is violated in the case that decides: its groups, and how quiet each had to be alone."""
    rows: list[Row] = []
    for case, j in decided:
        if j.passed:
            continue
        title = (
            f"{capital(output_title(j.output))}, case {case.id}: {ratio_text(j.ratio)} × the limit of"
            f" {titles(j.requirement)}"
        )
        rows.append(row(title, kind="head"))
        rows += [
            row(group, percent(share, 1), ratio_cell(j.silenced[group]), factor_cell(j.factor[group]))
            for group, share in j.largest(len(j.share), _LEAST)
        ]
        if len(j.together) > 1:
            together = sum(j.share[group] for group in j.together)
            cells = (percent(together, 1), ratio_cell(j.together_silenced), factor_cell(j.together_factor))
            rows.append(row(f"{and_text(j.together)} together", *cells))
    if not rows:
        return []
    text = (
        "What would help where a requirement is violated in closed loop: the ratio without one group of sources, and"
        " the factor on its amplitude, the others unchanged, that just meets the requirement. Where no group can do it"
        " alone: those that are needed together, none of which can be left out, and the factor on all their amplitudes."
    )
    head = columns("Group", "Share", "Ratio without\n(1)", "Factor\n(1)", text=(0,))
    return [Table(head, tuple(rows), text, key="loop groups")]


def _by_disturbances(cases: Sequence[SimulatedCase], titles: Titles) -> list[Block]:
    """Of cases of the thermal network: a table of each output in which temperatures are heard, or a word of none."""
    blocks: list[Block] = []
    for case in cases:
        judged = [j for j in case.judged if j.disturbance_share]
        heard = [j for j in judged if sum(j.disturbance_share.values()) >= _LEAST]
        blocks += [_by_disturbance(case, j, titles) for j in heard]
        if judged and not heard:
            most = max(sum(j.disturbance_share.values()) for j in judged)
            part = percent(most, 1) if most >= 1e-3 else "a thousandth"
            blocks.append(
                Paragraph(
                    f"In case {case.id} the disturbances of the thermal network make at most {part} of the noise of any"
                    " output that is judged."
                )
            )
    return blocks


def _by_disturbance(case: SimulatedCase, j: LoopOutput, titles: Titles) -> Table:
    """Of a case of the thermal network: parts of its disturbances, and what each may be."""
    share = j.disturbance_share
    cancelled = cancels(np.array(list(share.values())))
    rows = [
        row(name, share_text(share[name], cancelled), factor_cell(j.disturbance_factor[name]))
        for name in sorted(share, key=lambda name: -abs(share[name]))
    ]
    text = (
        f"{capital(output_title(j.output))}, case {case.id} in closed loop, by disturbance of the thermal network: part"
        f" of all noise at {mhz_text(j.binding_hz)}. Level: the factor on this disturbance, all else unchanged, that"
        f" just meets the limit of {titles(j.requirement)}."
    )
    return Table(columns("Disturbance", "Share", "Level", text=(0,)), tuple(rows), text)


def _margins(stability: LoopStability) -> list[Block]:
    text = (
        f"Each loop with the others closed. {stability.poles} poles, the slowest at {sci(stability.slowest_rad_s, 3)}"
        " rad/s. Gain and reduction: how far the gain may rise and fall. Peak: largest 1 / |1 + L|."
    )
    rows: list[Row] = []
    for family, loops in stability.families().items():
        rows.append(row(capital(family), kind="head"))
        rows += [
            row(
                x.name,
                mhz_text(x.crossover_hz) if x.crosses else "none",
                f"{x.phase_deg:.1f}" if np.isfinite(x.phase_deg) else "any",
                _decibel(x.gain_db),
                _decibel(x.reduction_db),
                f"{x.peak_sensitivity:.2f}",
            )
            for x in loops
        ]
    titles = ("Loop", "Crossover", "Phase\n(°)", "Gain\n(dB)", "Reduction\n(dB)", "Peak\n(1)")
    return [Paragraph(text), Table(columns(*titles, text=(0,)), tuple(rows), "Margins of every loop.")]


def _decibel(value: float) -> str:
    return f"{value:+.1f}".replace("-", "−") if np.isfinite(value) else "any"
