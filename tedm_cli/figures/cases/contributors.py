"""What the noise of one output is made of: shares of groups, areas and optical elements, with their signs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, MaxNLocator

from tedm_cli.arrays import FloatArray
from tedm_cli.figures.drawing.fit import line_count, widest, wrapped
from tedm_cli.figures.drawing.key import key
from tedm_cli.figures.drawing.style import (
    BLUE,
    LINE,
    SMALL,
    VERMILION,
    WIDTH,
    grid,
    heading,
    heading_lines,
    inches,
    style,
)
from tedm_cli.figures.drawing.titles import judged_title, labels_words, limit_words
from tedm_cli.noise.areas import AreaTable
from tedm_cli.results.cases.noise import CaseNoise, JudgedOutput
from tedm_cli.results.titles import outputs_title
from tedm_cli.results.wording import mhz_text, parts_noun

MOST = 10  # rows of a panel besides that of all others
_ROW, _GAP, _FOOT = 0.215, 0.38, 0.6  # inches
_NAMES = 2.6  # inches at most
_LEAST = 5e-4  # share that would be printed as zero
_OTHERS = "#9A9A9A"


def contributors_figure(case: CaseNoise, j: JudgedOutput) -> Figure:
    """A panel each for groups, areas and, where there are, disturbances and parts: the largest, and all others."""
    with style():
        column = "thermal node or area" if case.thermal else "thermal area"
        parts = [("by group", *_by_group(j, case.areas)), (f"by {column}", *_by_area(j, case.areas))]
        if (of := j.disturbances) is not None:
            at_hz, in_band = (dict(zip(of.names, s.tolist(), strict=True)) for s in (of.share, of.band_share))
            parts.append(("by disturbance", at_hz, in_band))
        if j.path is not None and j.path_band is not None:
            moves = parts_noun(j.path) == "optical elements"
            parts.append(("by optical element that moves" if moves else "by part", j.path, j.path_band))
        tables = [(title, ranked(at), in_band) for title, at, in_band in parts]
        names = [wrapped(name, _NAMES, SMALL) for _, table, _ in tables for name, _ in table]
        row = max(_ROW, 0.06 + LINE * max(map(line_count, names)))
        rows = [len(table) for _, table, _ in tables]
        title = judged_title(j.output, case.id)
        limit = limit_words(j.ratio, case.limits, j.requirement, j.contribution_hz)
        more = (
            f"{limit}{twins(case, j)} {labels_words(j.output, j.requirement)}\n"
            "Shares of a panel sum to 100 %. Negative: lowers the noise, because it cancels others."
        )
        top = heading_lines(title, more)[2] + 0.28
        legend = key(_samples(j), WIDTH - 0.3, sample=2.6)
        foot = _FOOT + legend.height
        figure = Figure(figsize=(WIDTH, top + row * sum(rows) + (len(tables) - 1) * _GAP + foot))
        left = 0.2 + widest(names, SMALL)
        panels = figure.subplots(len(tables), 1, squeeze=False, height_ratios=rows, sharex=True)[:, 0].tolist()
        inches(figure, left=left, right=0.2, top=top, bottom=foot)
        figure.subplots_adjust(hspace=_GAP * len(rows) / (row * sum(rows)))
        for axes, (name, table, in_band) in zip(panels, tables, strict=True):
            _bars(axes, table, in_band)
            axes.set_title(name, fontsize=9, pad=3)
        _scale(panels, [x for _, table, band in tables for name, at in table for x in (at, _of(band, name, table))])
        panels[-1].set_xlabel("share of the noise power (%)", fontsize=9)
        heading(figure, title, more=more)
        legend.draw(figure, 0.15, 0.08)
        return figure


def twins(case: CaseNoise, j: JudgedOutput) -> str:
    """A sentence on outputs with the same ratio that are made of other things, as those of a mirrored test mass are."""
    others = [output for output in case.worst_outputs(j.kind) if output != j.output]
    if j.output not in case.worst_outputs(j.kind) or not others:
        return ""
    return f" The {outputs_title(others)} {'have' if len(others) > 1 else 'has'} the same ratio."


def ranked(share: Mapping[str, float]) -> list[tuple[str, float]]:
    """The largest shares by size, and the sum of all others where there is something left of them."""
    order = sorted(share, key=lambda name: -abs(share[name]))  # stable: equals keep their order
    top = [name for name in order[:MOST] if abs(share[name]) >= _LEAST] or order[:1]
    rest = [name for name in order if name not in top]
    table = [(name, share[name]) for name in top]
    if rest:
        table.append((f"{len(rest)} other{'s' if len(rest) > 1 else ''}", sum(share[name] for name in rest)))
    return table


def _of(share: Mapping[str, float], name: str, table: Sequence[tuple[str, float]]) -> float:
    """The share of a row of the table; of all others where the row is theirs."""
    named = {n for n, _ in table}
    return share[name] if name in share else sum(s for n, s in share.items() if n not in named)


def _by_group(j: JudgedOutput, areas: AreaTable) -> tuple[dict[str, float], dict[str, float]]:
    of_area = areas.group_by_unit

    def sums(share: FloatArray) -> dict[str, float]:
        return {g: float(share[of_area == g].sum()) for g in dict.fromkeys(of_area.tolist())}

    return sums(j.share), sums(j.band_share)


def _by_area(j: JudgedOutput, areas: AreaTable) -> tuple[dict[str, float], dict[str, float]]:
    def named(share: FloatArray) -> dict[str, float]:
        return {name: float(s) for name, s in zip(areas.name, share, strict=True)}

    return named(j.share), named(j.band_share)


def _bars(axes: Axes, table: Sequence[tuple[str, float]], in_band: Mapping[str, float]) -> None:
    for row, (name, share) in enumerate(table):
        colour = _OTHERS if name not in in_band else BLUE if share >= 0 else VERMILION
        axes.barh([row], [100 * share], color=colour, hatch="" if share >= 0 else "////", edgecolor="black",
                  linewidth=0.6, height=0.7)  # fmt: skip
        band = _of(in_band, name, table)
        axes.plot([100 * band], [row], marker="D", markersize=4.2, color="white", markeredgecolor="black",
                  linestyle="none", zorder=4)  # fmt: skip
        low, high = min(share, band, 0.0), max(share, band, 0.0)
        axes.annotate(_percent(share), (100 * (high if share >= 0 else low), row),
                      xytext=(5 if share >= 0 else -5, 0), textcoords="offset points", fontsize=SMALL,
                      ha="left" if share >= 0 else "right", va="center_baseline")  # fmt: skip
    axes.set_yticks(range(len(table)), [wrapped(name, _NAMES, SMALL) for name, _ in table], fontsize=SMALL)
    axes.set_ylim(len(table) - 0.5, -0.5)
    axes.tick_params(axis="y", length=0)
    axes.axvline(0.0, color="black", linewidth=0.8)


def _percent(share: float) -> str:
    text = f"{100 * share:.{0 if abs(share) >= 1 else 1}f}"
    return "0.0" if float(text) == 0.0 else text.replace("-", "−")


def _scale(panels: Sequence[Axes], shares: Sequence[float]) -> None:
    """One scale for all panels, with room for the numbers beside the bars."""
    low, high = 100 * min(0.0, *shares), 100 * max(0.0, *shares)
    span = (high - low) or 1.0
    panels[0].set_xlim(low - (0.14 * span if low < 0 else 0.01 * span), high + 0.14 * span)
    for axes in panels:
        axes.xaxis.set_major_locator(MaxNLocator(7))
        axes.xaxis.set_major_formatter(FuncFormatter(lambda v, _: f"{v:g}".replace("-", "−")))
        axes.tick_params(axis="x", labelsize=SMALL)
        grid(axes)
        axes.grid(False, axis="y")


def _samples(j: JudgedOutput) -> list[Artist]:
    band = f"in the band, {j.band_hz[0] * 1e3:g} to {j.band_hz[1] * 1e3:g} mHz"
    return [
        Patch(facecolor=BLUE, edgecolor="black", label=f"at {mhz_text(j.contribution_hz)}"),
        Patch(facecolor=VERMILION, edgecolor="black", hatch="////", label="the same, negative"),
        Line2D([], [], marker="D", markersize=4.2, color="white", markeredgecolor="black", linestyle="none",
               label=band),
    ]  # fmt: skip
