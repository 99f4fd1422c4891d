"""The closed loop in the report: verdicts on its outputs, what would help, and how stable it is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.dynamics.signals import DELTA_G, TEST_MASSES
from tedm_cli.report.document import (
    Block,
    Facts,
    Figure,
    Folded,
    Heading,
    Link,
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
from tedm_cli.report.evidence import factor_cell, ratio_cell
from tedm_cli.results.deciding import DIAGNOSTIC, deciding, worst_of
from tedm_cli.results.dynamics import ClosedLoop, LoopOutput, LoopStability, SimulatedCase
from tedm_cli.results.dynamics_in_time import IN_TIME
from tedm_cli.results.wording import and_text, capital, count, mhz_text, percent, ratio_text, sci

SECTION = "loop"
_NAMED = 3  # groups named of each verdict
_LEAST = 0.01  # shares below this are not named
_MARGINS = "loop_margins.svg"

Pair = tuple[SimulatedCase, LoopOutput]


def closed_loop_words(found: ClosedLoop | None, test_masses: int, ids: Sequence[str]) -> Paragraph:
    """The closed loop in one sentence: Δg where it is judged, or else the worst output; or why there is none.

    `ids` are all cases of the configuration.
    """
    if test_masses != len(TEST_MASSES):
        masses = count(test_masses, "test mass", "test masses")
        return Paragraph(f"The drag-free loop is of two test masses; with {masses} none is closed.", quiet=True)
    if found is None:
        words = "The dynamics of the drag-free loop has not been run (`tedm build-dynamics`, then `tedm simulate all`)."
        return Paragraph(words, quiet=True)
    pair = _told(found)
    if pair is None:
        return Paragraph(("No output of the ", Link("closed loop", SECTION), " is judged."), quiet=True)
    case, j = pair
    name = "Δg" if j.output == DELTA_G[0] else f"Δg ({j.output})" if j.output in DELTA_G else j.output
    made_of = j.largest(1, 0.0)[0]
    missing = _missing(found, ids)
    text: Text = (
        "In ",
        Link("closed loop", SECTION),
        f" {name} is ",
        Strong(f"{ratio_text(j.ratio)} times its requirement"),
        f" {j.requirement} in case {case.id}, at {mhz_text(j.binding_hz)}; {made_of[0]} makes"
        f" {percent(made_of[1])} of its power" + (f"; not simulated: {_cases(missing)}." if missing else "."),
    )
    return Paragraph(text)


def _told(found: ClosedLoop) -> Pair | None:
    """The verdict on Δg that decides; where Δg is not judged, the worst of those that do."""
    delta_g = found.deciding_delta_g()
    pairs = [deciding(pairs) for pairs in found.pairs().values()]
    return delta_g or (worst_of(pairs) if pairs else None)


def _missing(found: ClosedLoop, ids: Sequence[str]) -> list[str]:
    done = {case.id for case in found.cases}
    return [i for i in ids if i not in done]


def _cases(ids: Sequence[str]) -> str:
    return f"case{'s' if len(ids) > 1 else ''} {and_text(ids)}"


def closed_loop_section(found: ClosedLoop, ids: Sequence[str], figures: dict[str, list[Figure]]) -> Section:
    """Verdicts on the outputs of the loop, what would help, and its margins; `ids` are all cases there could be."""
    first = found.cases[0]
    facts: list[tuple[str, Text]] = [
        ("Controller", found.stability.origin),
        ("Read-outs heard", f"set {first.read_out_set}"),
        ("Temperature noise", first.temperature),
        ("Safety factor", f"{first.safety_factor:g}, on noise amplitudes"),
    ]
    if missing := _missing(found, ids):
        facts.append(("Not simulated", _cases(missing)))
    blocks: list[Block] = [
        Paragraph(
            "The outputs of the drag-free loop with all of its noise: the temperatures of a case push the test masses"
            " and shift what the controller hears at once, beside the sources of the loop itself. Ratio: largest safety"
            " factor × noise / requirement over the band; margin: the factor on all noise that just meets it. Made of:"
            " parts of the noise power at the frequency that binds, by group of sources; the temperatures are called"
            " thermal. Every requirement in the case that decides: the worst likely one where that violates it, or else"
            " the worst of all that can occur."
        ),
        Facts(tuple(facts)),
    ]
    pairs = found.pairs()
    drawn = figures["closed loop"]
    if pairs:
        possible = any(case.role != DIAGNOSTIC for case in found.cases)
        decided = [deciding(of_one) for of_one in pairs.values()]
        blocks += [_table([_row(case.id, j) for case, j in decided], "Case")]
        blocks += [figure for figure in drawn if figure.file != _MARGINS]
        blocks += _help(decided)
        if possible:
            blocks.append(Folded("Every verdict in closed loop, without diagnostic cases", (_every(pairs),)))
    else:
        blocks.append(Paragraph("No requirement applies to an output of the loop."))
    blocks += in_time_blocks(found.in_time, figures.get(IN_TIME, []))
    blocks += [
        Heading("Margins of the loops"),
        *(figure for figure in drawn if figure.file == _MARGINS),
        *_margins(found.stability),
    ]
    return Section(SECTION, "Evidence: closed loop", "Closed loop", tuple(blocks))


def _row(cases: str, j: LoopOutput) -> Row:
    margin = ratio_text(1.0 / j.ratio) if j.ratio > 0.0 else "any"
    made_of = ", ".join(f"{group} {percent(share)}" for group, share in j.largest(_NAMED, _LEAST))
    verdict, ratio = verdict_cell(j.passed), ratio_cell(j.ratio)
    return row(j.output, j.requirement, cases, verdict, ratio, margin, mhz_text(j.binding_hz), made_of)


def _table(rows: Sequence[Row], cases: str) -> Table:
    titles = ("Output", "Requirement", cases, "Verdict", "Ratio\n(1)", "Margin\n(1)", "Binds at", "Made of")
    return Table(columns(*titles, text=(0, 1, 2, 3, 7)), tuple(rows), tight=True)


def _every(pairs: dict[tuple[str, str], list[Pair]]) -> Table:
    """All that can occur, cases of which the same is to be said in one row; diagnostic cases are left out."""
    rows = []
    for of_one in pairs.values():
        alike: dict[Row, list[Pair]] = {}
        for case, j in of_one:
            if case.role != DIAGNOSTIC:
                alike.setdefault(_row("", j), []).append((case, j))
        rows += [_row(", ".join(case.id for case, _ in same), same[0][1]) for same in alike.values()]
    return _table(rows, "Cases")


def _help(decided: Sequence[Pair]) -> list[Block]:
    """Of each requirement that is violated in the case that decides: its groups, and how quiet each had to be alone."""
    rows: list[Row] = []
    for case, j in decided:
        if j.passed:
            continue
        title = f"{j.output}, case {case.id}: {ratio_text(j.ratio)} × {j.requirement}"
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
        "For every requirement that is violated: the ratio without one group of sources, and the factor on its"
        " amplitude, the others unchanged, that just meets the requirement. Where no group can do it alone: those that"
        " are needed together, none of which can be left out, and the factor on the amplitudes of all of them."
    )
    head = columns("Group", "Share", "Ratio without\n(1)", "Factor\n(1)", text=(0,))
    return [Heading("What would help"), Paragraph(text), Table(head, tuple(rows))]


def _margins(stability: LoopStability) -> list[Block]:
    text = (
        f"Each loop with the others closed. {stability.poles} poles, the slowest at {sci(stability.slowest_rad_s, 3)}"
        " rad/s. Gain and reduction: how much more and less gain is borne. Peak: largest 1 / |1 + L|."
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
    return [Paragraph(text), Table(columns(*titles, text=(0,)), tuple(rows))]


def _decibel(value: float) -> str:
    return f"{value:+.1f}".replace("-", "−") if np.isfinite(value) else "any"
