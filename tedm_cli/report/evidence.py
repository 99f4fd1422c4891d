"""Why the verdicts are what they are, how sure they are, and what would change them: the tables behind the decision."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.noise.areas import AreaTable
from tedm_cli.report.document import Block, Cell, Columns, Figure, Heading, Paragraph, Row, Section, Table, columns, row
from tedm_cli.report.verdicts import Titles
from tedm_cli.results.cases.deciding import deciding_pairs, without_repeats
from tedm_cli.results.cases.noise import MATCHED, WAYS, CaseNoise, JudgedOutput, level_unit
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import (
    capital,
    count,
    mhz_text,
    parts_noun,
    percent,
    power_text,
    ratio_text,
    sci,
    span,
    unit_text,
)

_TOP = 5  # areas and optical elements listed for each judged output
_NAMED = 3  # areas named in a sentence
_CANCELLED = 1.5  # sum of the sizes of shares from which on terms are said to cancel
_WHOLE = 1.005  # a share above this is no part of a whole


def cancels(share: FloatArray) -> bool:
    """Whether shares of a power go against each other so far that a percentage says nothing."""
    return bool(np.abs(share).sum() > _CANCELLED or share.max(initial=0.0) > _WHOLE)


def few(names: Sequence[str]) -> str:
    """The first of many names."""
    return "; ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")


def improvement_key(requirement: str, output: str) -> str:
    """What a reference to the improvement of one output by area names."""
    return f"improvement {requirement} {output}"


def why_section(cases: Sequence[CaseNoise], figures: Sequence[Figure], titles: Titles) -> Section:
    """For each judged output, in the case that decides it: the areas, groups and elements its noise comes from."""
    tables: list[Block] = []
    for case, j in deciding_pairs(cases):
        text = (
            f"{capital(output_title(j.output))} ({j.output}), case {case.id}: what makes {ratio_text(j.ratio)} times"
            f" the limit of {titles(j.requirement)} at {mhz_text(j.contribution_hz)}."
        )
        tables.append(Columns(tuple(_parts(j, case.areas)), text))
    for case in without_repeats(cases):
        tables += [_by_disturbance(j, case.id, titles) for j in case.judged if j.disturbances is not None]
    text = (
        "Each judged output in the case that decides its verdict: the worst of the likely ones where they violate it,"
        " or else the worst of all that can occur. Share: part of the noise power, at the binding frequency and over"
        " the requirement's band. The shares of an output sum to the whole; inside a correlated block they carry a"
        " sign. Where large terms cancel, a share is given as a multiple of the whole (×) instead of a percentage."
        " Contribution: sensitivity × temperature noise at the binding frequency, without the safety factor."
    )
    return Section("contributors", "What the noise comes from", "Contributors", (Paragraph(text), *figures, *tables))


def _parts(j: JudgedOutput, areas: AreaTable) -> list[Table]:
    of_area = areas.group_by_unit
    groups = list(dict.fromkeys(of_area.tolist()))
    member = np.array([of_area == name for name in groups], dtype=float)
    at, band = member @ j.share, member @ j.band_share
    of_path = [] if j.path is None else list(j.path.values())
    cancelled = any(cancels(np.array(x)) for x in (j.share, at, of_path))

    def cells(share: float, band: float) -> tuple[str, str]:
        return share_text(share, cancelled), share_text(band, cancelled)

    order = np.argsort(-np.abs(j.share), kind="stable")[:_TOP]
    by_area = [
        row(areas.name[i], f"{of_area[i]}, {areas.shield[i]}", sci(float(j.contribution[i]), 3),
            *cells(float(j.share[i]), float(j.band_share[i])))
        for i in order
    ]  # fmt: skip
    head = columns(
        *("Area", "Group", f"Contribution\n({unit_text(j.unit)}/√Hz)", "Share", "Share in band"), text=(0, 1)
    )
    tables = [Table(head, tuple(by_area))]
    ranked = np.argsort(-np.abs(at), kind="stable")
    size = member.sum(axis=1).astype(int)
    rows = [row(groups[g], f"{size[g]}", *cells(float(at[g]), float(band[g]))) for g in ranked.tolist()]
    head = columns("Group", "Areas", "Share", "Share in band", text=(0,))
    tables.append(Table(head, tuple(rows)))
    if j.path is not None and j.path_band is not None:
        path, in_band = j.path, j.path_band
        names = sorted(path, key=lambda name: -abs(path[name]))[:_TOP]
        head = columns(capital(parts_noun(path).removesuffix("s")), "Share", "Share in band", text=(0,))
        tables.append(Table(head, tuple(row(n, *cells(path[n], in_band[n])) for n in names)))
    return tables


def _by_disturbance(j: JudgedOutput, case_id: str, titles: Titles) -> Table:
    """Shares of the disturbances of the thermal network, and what each may be."""
    assert j.disturbances is not None
    of = j.disturbances
    cancelled = cancels(of.share)
    rows = [
        row(of.names[d], share_text(float(of.share[d]), cancelled), share_text(float(of.band_share[d]), cancelled),
            factor_cell(float(of.level_factor[d])))
        for d in np.argsort(-np.abs(of.share), kind="stable").tolist()
    ]  # fmt: skip
    text = (
        f"{capital(output_title(j.output))} ({j.output}), case {case_id}, by disturbance of the thermal network. Level:"
        f" the factor on this disturbance, the others unchanged, that just meets the limit of {titles(j.requirement)}."
    )
    return Table(columns("Disturbance", "Share", "Share in band", "Level", text=(0,)), tuple(rows), text)


def share_text(share: float, cancelled: bool) -> str:
    """A share of a power: a percentage, or a multiple of the whole where terms cancel."""
    return f"{share:+.2f} ×".replace("-", "−") if cancelled else percent(share, 1)


def sure_section(cases: Sequence[CaseNoise], figures: Sequence[Figure]) -> Section:
    """The ratio of every verdict for other temperature filters, correlations and safety factors."""
    orders = next((case.filter_order for case in cases if len(case.filter_order)), cases[0].filter_order)
    head = columns(
        "Output",
        "Ratio",
        *(f"Order {n:g}" for n in orders),
        *("Any correlation\nbetween blocks", "No negative\ncorrelation", "Any\ncorrelation"),
        *("Factor 1", "Allowed\nfactor"),
        text=(0,),
    )
    rows: list[Row] = []
    for case in without_repeats(cases):
        if case.judged:
            rows.append(case_head(case))
        for j in case.judged:
            filters = (
                [""] * len(orders)
                if j.filter_ratio is None
                else [_ratio_span(float(q.min()), float(q.max())) for q in j.filter_ratio]
            )
            b = j.bound_ratio
            bounds = [
                _ratio_span(b["known_blocks_minimum"], b["known_blocks"]),
                ratio_cell(b["maximum_non_negative"]),
                _ratio_span(b["minimum"], b["maximum"]),
            ]
            factor = case.safety_factor
            allowed = ratio_text(factor * j.improvement.all_factor)
            rows.append(
                row(
                    capital(output_title(j.output)),
                    ratio_cell(j.ratio),
                    *filters,
                    *bounds,
                    ratio_cell(j.ratio / factor),
                    allowed,
                )
            )
    text = (
        "Verdicts depend on assumptions. The table shows each ratio of noise to requirement with other assumptions, one"
        " changed at a time. Order: of the temperature filter, from the smallest to the largest ratio over the corners"
        " tried. Correlations: exact bounds over all correlations of the active areas; between blocks: unchanged inside"
        " the blocks, any correlation between them; without a negative one: the largest ratio if no correlation is"
        " negative. Factor 1: without the safety factor; allowed factor: the safety factor at which the ratio is 1."
    )
    caption = "Every ratio under other assumptions, one changed at a time."
    table = [Table(head, tuple(rows), caption, tight=True, key="sure")] if rows else []
    return Section("assumptions-changed", "Other assumptions", "Other assumptions", (Paragraph(text), *figures, *table))


def ratio_cell(value: float) -> Cell:
    """A ratio to a requirement; above 1 it is violated."""
    return Cell(ratio_text(value), "violated" if value > 1.0 else "met")


def _ratio_span(low: float, high: float) -> Cell:
    return Cell(span(low, high), "violated" if low > 1.0 else "met" if high <= 1.0 else "open")


def change_section(cases: Sequence[CaseNoise], figures: Sequence[Figure], titles: Titles) -> Section:
    """For each verdict, in the case that decides it: what quieter or better matched areas would make of it."""
    blocks: list[Block] = []
    for case, j in deciding_pairs(cases):
        of = f"{capital(output_title(j.output))}, case {case.id}"
        blocks += [
            Heading(f"{of}: {ratio_text(j.ratio)} × the limit of {titles(j.requirement)}"),
            _by_group(j, case.areas, f"{of}: required temperature stability."),
            _by_area(j, f"{of}: improvement by area."),
        ]
    text = (
        "Required temperature stability: the factor on the temperature amplitudes of one group, the others unchanged,"
        " that just meets the requirement; below 1 the group must be quieter, above 1 it may be noisier. Improvement:"
        " the ratio when the worst areas are silent or have a tenth of their noise, and when the best blocks are"
        " matched, that is when all their areas follow one common fluctuation, each with its own amplitude, and the"
        " other blocks stay as they are. Areas and blocks are chosen one after the other; an area that stands alone is"
        " a block."
    )
    return Section("change", "What would change it", "Improvement", (Paragraph(text), *figures, *blocks))


def _by_group(j: JudgedOutput, areas: AreaTable, caption: str) -> Table:
    rows = []
    of_area = areas.group_by_unit
    for group, factor in j.improvement.group_factor.items():
        level = j.improvement.group_level[group]
        shown = power_text(factor * level, 3) if np.isfinite(factor) and not np.isnan(level) else ""
        now = "differ" if np.isnan(level) else power_text(level, 3)
        rows.append(row(group, f"{(of_area == group).sum()}", now, factor_cell(factor), shown))
    everything = ratio_text(j.improvement.all_factor) if np.isfinite(j.improvement.all_factor) else "not felt"
    rows.append(row("all together", f"{len(areas)}", "", everything, "", kind="sum"))
    at = mhz_text(j.binding_hz)
    unit = level_unit(j.improvement.group_factor)
    head = columns("Group", "Areas", f"Now at {at}\n({unit})", "Factor\n(1)", f"Allowed\n({unit})", text=(0,))
    return Table(head, tuple(rows), caption)


def factor_cell(factor: float) -> Cell:
    """The factor on one group's amplitude that just meets a requirement; infinite: not felt, NaN: not by it alone."""
    if np.isinf(factor):
        return Cell("not felt")
    if np.isnan(factor):
        return Cell("cannot alone", "violated")
    return Cell(ratio_text(factor), "violated" if factor < 1.0 else "met")


def _by_area(j: JudgedOutput, caption: str) -> Table:
    """Ratios with more and more areas improved; silent and quieter areas are the same ones."""
    m = j.improvement
    families = [[way for way in WAYS if way != MATCHED], [MATCHED]]
    rows = []
    before = 0
    for i, n in enumerate(m.count.tolist()):
        cells: list[str | Cell] = [f"{n}"]
        for ways in families:
            cells += [ratio_cell(float(m.ratio[way][i])) for way in ways]
            cells.append("; ".join(m.chosen[ways[0]][before:n]) or ("" if n == 0 else "no other helps"))
        before = n
        rows.append(row(*cells))
    titles = [
        t
        for ways in families
        for t in (
            *(f"Ratio,\n{WAYS[way][1]}" for way in ways),
            f"these {'blocks' if ways == [MATCHED] else 'areas'}\nand those above",
        )
    ]
    words = tuple(1 + i for i, title in enumerate(titles) if not title.startswith("Ratio"))
    key = improvement_key(j.requirement, j.output)
    return Table(columns("Number", *titles, text=words), tuple(rows), caption, tight=True, key=key)


def case_head(case: CaseNoise) -> Row:
    """A case as the head of its rows."""
    role = "" if case.role == "possible" else f"{case.role}; "
    size = f"{role}{int(case.active.sum())} of {len(case.active)} areas, {count(case.blocks, 'block')}"
    return row(f"Case {case.id}", case.title, size, kind="head")
