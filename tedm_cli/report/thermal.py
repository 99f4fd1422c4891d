"""The thermal network in the report: what it is, its steady state, and how disturbances reach nodes and outputs."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from tedm_cli.noise.temperature import REFERENCE_HZ
from tedm_cli.report.document import (
    Block,
    Facts,
    Figure,
    Folded,
    Heading,
    Paragraph,
    Section,
    Strong,
    Table,
    Text,
    columns,
    row,
)
from tedm_cli.report.verdicts import Titles
from tedm_cli.results.cases.deciding import DIAGNOSTIC
from tedm_cli.results.cases.noise import CaseNoise
from tedm_cli.results.thermal.disturbances import all_together, strictest_of
from tedm_cli.results.thermal.file import SteadyResults
from tedm_cli.results.thermal.groups import GroupGains, GroupTemperatures, SteadyNodes
from tedm_cli.results.thermal.network import ThermalNetwork
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import (
    and_text,
    capital,
    clause,
    count,
    mhz_text,
    power_text,
    rounded_down,
    sci,
    temperature_text,
)
from tedm_cli.thermal.low_pass import within

SECTION = "thermal"
_UNIT = {"temperature": "K/K", "power": "K/W"}
_LISTED = 40  # nodes in the table of those that are not on the model
_TITLE = "Thermal network"
_WHAT = (
    "A network of thermal nodes, joined by conduction and radiation. Its steady state comes from the constant powers"
    " and the temperatures of boundaries; about it the network is linear, and turns disturbances of boundaries and"
    " powers into the noise of nodes."
)
_TOLD = 4  # outputs that are told in a sentence


def thermal_cases(cases: Sequence[CaseNoise]) -> list[CaseNoise]:
    """The cases that take their noise from the network and judge something, but for diagnostic ones."""
    return [case for case in cases if case.thermal and case.judged and case.role != DIAGNOSTIC]


def stability_words(case: CaseNoise, titles: Titles) -> Text:
    """Which disturbance has the least room, or must become quieter; and all of them together."""
    found = [s for s in strictest_of(case) if not math.isinf(s.factor)]
    if not found:
        return "No judged output feels a disturbance."
    alone = [s for s in found if math.isnan(s.factor)]
    known = [s for s in found if math.isfinite(s.factor)]
    words: list[str | Strong] = []
    if alone:
        left = f"the {output_title(alone[0].output)} would stay beyond the limit of {titles(alone[0].requirement)}. "
        if not known:
            words += [Strong("No single disturbance is enough"), f": however quiet one became, {left}"]
        else:
            names = [s.name for s in alone[:_TOLD]]
            names += [count(len(alone) - _TOLD, "other")] * (len(alone) > _TOLD)
            words.append(f"However quiet {and_text(names)} became, alone, {left}")
    if known:
        first, last = known[0], known[-1]
        words += [
            Strong(f"{first.name} {_allowed(first.factor)} times its assumed noise"),
            f", the others unchanged, until the {clause(output_title(first.output))} is at the limit of"
            f" {titles(first.requirement)}",
            f"; {last.name} has most room, a factor {power_text(last.factor, 3)}" * (len(known) > 1),
            ". ",
        ]
    together = all_together(case)
    if math.isfinite(together.factor):
        words.append(f"All together {_allowed(together.factor)} times their assumed noise.")
    return tuple(words)


def _allowed(factor: float) -> str:
    return f"must have at most {rounded_down(factor)}" if factor < 1.0 else f"may have {power_text(factor, 3)}"


def thermal_section(network: ThermalNetwork, figures: Sequence[Figure]) -> Section:
    """In the annex: all that is known of the network."""

    def drawn(beginning: str) -> list[Figure]:
        return [f for f in figures if f.file.startswith(beginning)]

    found = network.results
    if found.steady is None:
        text = (
            f"The project has no thermal network. {capital(count(len(found.mapped), 'thermal node'))}"
            f" {'lies' if len(found.mapped) == 1 else 'lie'} on the model, and {count(found.outputs, 'output')} per"
            " kelvin of each are known."
        )
        return Section(SECTION, _TITLE, _TITLE, (Paragraph(text),))
    blocks: list[Block] = [Paragraph(_WHAT), Facts(tuple(_facts(network, found.steady)))]
    if network.groups is not None:
        blocks += [Paragraph(_groups_words(network.groups)), *drawn("steady_")]
    if network.on_grids is not None:
        low, high = map(temperature_text, network.on_grids)
        text = f"On the finite elements the steady state goes from {low} to {high}, a span of"
        span = sci(network.on_grids[1] - network.on_grids[0], 3)
        blocks += [Paragraph(f"{text} {span} K."), *drawn("temperature_map")]
    if network.off_model is not None and network.off_model.name and found.mapped:
        blocks.append(Folded("Nodes that are not on the model", (_off_model(network.off_model),)))
    if network.gains is not None:
        blocks += [
            Heading("From disturbances to nodes"),
            _disturbances(network),
            Paragraph(_gains_words(network.gains)),
            *drawn("thermal_gains"),
            Paragraph(_low_pass_words(network.gains, network.assumed)),
            *drawn("thermal_low_passes"),
        ]
    if by_case := [f for f in figures if f.file.startswith(("disturbances_", "required_", "disturbance_spectra_"))]:
        blocks += [Heading("From disturbances to outputs"), *by_case]
    return Section(SECTION, _TITLE, _TITLE, tuple(blocks))


def _facts(network: ThermalNetwork, s: SteadyResults) -> list[tuple[str, Text]]:
    found = network.results
    kinds = and_text([f"{n} {kind}" for kind, n in s.count.items() if n])
    balance = f"powers {sci(s.power_W)} W, boundaries take {sci(s.to_boundaries_W)} W"
    if s.solved:
        balance += f"; largest imbalance of {count(s.solved, 'node')} solved for {sci(s.imbalance_W, 2)} W"
    if s.given:
        balance += f"; of {count(s.given, 'node')} with a given temperature {sci(s.held_W, 3)} W ({s.held})"
    facts: list[tuple[str, Text]] = [
        ("Nodes", f"{count(sum(s.count.values()), 'node')} ({kinds})"),
        ("Conductors", f"{s.conductors:,}, {s.radiating:,} of them by radiation"),
        ("On the model", count(len(found.mapped), "node") if found.mapped else "no map"),
        ("Coldest node", f"{s.coldest[0]}, {temperature_text(s.coldest[1])}"),
        ("Warmest node", f"{s.hottest[0]}, {temperature_text(s.hottest[1])}"),
        ("Energy balance", balance),
    ]
    if found.frequencies is not None:
        number, low, high = found.frequencies
        many = f"{number:,} frequencies, {low * 1e3:.3g} to {mhz_text(high)}" if number > 1 else mhz_text(low)
        facts.append(("Gains", f"of {count(found.kept, 'node')} at {many}"))
    if (c := found.coherence) is not None:
        words = f"median {sci(c.median, 3)}, least {sci(c.least, 2)} ({and_text(c.pair)})"
        facts.append((f"Coherence of two nodes at {mhz_text(c.frequency_hz)}", words))
    return facts


def _groups_words(groups: GroupTemperatures) -> str:
    cold, hot = int(groups.mean.argmin()), int(groups.mean.argmax())
    if cold == hot:
        return f"The nodes are at {temperature_text(float(groups.mean[cold]))} in the mean."
    wide = int((groups.most - groups.least).argmax())
    return (
        f"By group, the nodes of {groups.group[cold]} are coldest in the mean,"
        f" {temperature_text(float(groups.mean[cold]))}, and those of {groups.group[hot]} warmest,"
        f" {temperature_text(float(groups.mean[hot]))}; within a group"
        f" temperatures differ by at most {sci(float(groups.most[wide] - groups.least[wide]), 3)} K"
        f" ({groups.group[wide]})."
    )


def _off_model(nodes: SteadyNodes) -> Table:
    n = len(nodes.name)
    half = _LISTED // 2
    listed = list(range(n)) if n <= _LISTED else [*range(half), *range(n - half, n)]
    rows = tuple(
        row(nodes.name[i], nodes.kind[i], f"{nodes.temperature[i]:.2f}", f"{nodes.temperature[i] - 273.15:.2f}")
        for i in listed
    )
    left = f" The {half} warmest and the {half} coldest of {n:,}." if n > _LISTED else ""
    caption = f"Nodes that are not on the model, the warmest first.{left}"
    return Table(columns("Node", "Kind", "Steady state\n(K)", "Steady state\n(°C)", text=(0, 1)), rows, caption)


def _disturbances(network: ThermalNetwork) -> Table:
    rows = []
    for of, level in zip(network.results.disturbances, network.level.tolist(), strict=True):
        node, gain = of.largest[0]
        rows.append(
            row(
                of.name,
                of.kind,
                of.spectrum,
                f"{sci(level, 3)} {_UNIT[of.kind].split('/')[1]}/√Hz",
                f"{sci(gain, 3)} {_UNIT[of.kind]}",
                node,
                "–" if of.order is None else f"{of.order.median:.2g}",
                "–" if of.corner_hz is None else f"{1e3 * of.corner_hz.median:.2g}",
            )
        )
    head = columns(
        *("Disturbance", "Kind", "Spectrum", f"Level at\n{mhz_text(network.level_hz)}", "Largest gain\nfor f → 0"),
        *("of", "Order\n(1)", "Corner\n(mHz)"),
        text=(0, 1, 2, 5),
    )
    caption = (
        "Disturbances of the network: temperatures of boundaries, and powers. Order and corner: median over the nodes"
        " of the low-pass 1/√(1 + (f/fc)²ⁿ) that fits the gain best."
    )
    return Table(head, tuple(rows), caption, tight=True)


def _gains_words(gains: GroupGains) -> str:
    """The largest and the smallest gain to a group of each kind, at the frequency nearest to 1 mHz."""
    at = int(np.argmin(np.abs(np.log(gains.frequency_hz / REFERENCE_HZ))))
    told = []
    for kind, unit in _UNIT.items():
        mine = gains.of_kind(kind)
        size = np.abs(gains.gain[at][:, mine])
        if not mine or not size.max() > 0.0:
            continue
        ends = []
        for word, value in (("largest", size.max()), ("smallest", size[size > 0.0].min())):
            g, d = (int(i[0]) for i in np.nonzero(size == value))
            which = f"{gains.group[g]} by {gains.disturbance[mine[d]]}"
            ends.append(f"the {word} is {power_text(float(value))} {unit} ({which})")
        told.append(f"of the gains from {kind}s to groups {and_text(ends)}")
    if not told:
        return "No group is disturbed."
    return f"At {mhz_text(float(gains.frequency_hz[at]))}, {'; '.join(told)}."


def _low_pass_words(gains: GroupGains, assumed: Sequence[tuple[float, float]]) -> str:
    """Orders and corners of the gains to groups, and on which side of those that are assumed they are."""
    sound = within(gains.low_pass.corner_hz, gains.frequency_hz)
    order, corner = gains.low_pass.order[sound], gains.low_pass.corner_hz[sound] * 1e3
    if not order.size:
        return "No gain to a group has a corner among the frequencies."
    words = (
        f"Of {count(sound.size, 'gain')} to groups, {order.size} {'has' if order.size == 1 else 'have'} a corner near"
        f" the frequencies: {np.median(corner):.2g} mHz in the median ({corner.min():.2g} to {corner.max():.2g} mHz),"
        f" at order {np.median(order):.2g} ({order.min():.2g} to {order.max():.2g})."
    )
    for n, fc in assumed:
        below, above = int((corner < fc * 1e3).sum()), int((order > n).sum())
        words += (
            f" The cases assume order {n:g} and {fc * 1e3:g} mHz: {below} of these corners are lower, and {above} of"
            " the orders are higher."
        )
    error = float(np.median(gains.low_pass.error[sound]))
    return f"{words} The root mean square of ln(fit / gain) is {error:.2g} in the median."
