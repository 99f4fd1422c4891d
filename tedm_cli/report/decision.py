"""What a reader must know first: the verdict on each requirement, how sure it is, what limits it, what would help."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.noise.areas import AreaTable
from tedm_cli.report.document import Block, Facts, Figure, Link, Paragraph, Section, State, Strong, Text, VerdictCard
from tedm_cli.results.deciding import (
    DIAGNOSTIC,
    LIKELY,
    POSSIBLE,
    Pair,
    by_requirement,
    deciding,
    possible_of,
    worst_of,
)
from tedm_cli.results.field import symbol, worst_at_rest
from tedm_cli.results.noise import MATCHED, SILENCED, WAYS, CaseNoise, JudgedOutput, Limit
from tedm_cli.results.wording import and_text, count, mhz_text, percent, ratio_text, sci, span, unit_text

_NAMED = 3  # groups, areas and optical elements named in a sentence
_ORDER: tuple[State, ...] = ("violated", "open", "met")
_CANCELLED = 1.5  # sum of the sizes of shares from which on areas are said to cancel
_SMALL = 0.05  # shares of the power below this are not named


def decision_section(
    cases: Sequence[CaseNoise],
    areas: AreaTable,
    dc: Sequence[DcVerdict],
    closed_loop: Paragraph,
    figures: dict[str, list[Figure]],
) -> Section:
    """A card for each requirement and one for the field at rest, the worst first, then what they rest on.

    `closed_loop` is what is to be said of the drag-free loop here.
    """
    cards = [_card(limit, pairs, areas) for limit, pairs in by_requirement(cases)]
    nothing = [] if cards else [Paragraph("The configuration names no requirement on noise: none is judged.")]
    cards.append(_field_card(dc))
    cards.sort(key=lambda card: _ORDER.index(card.state))
    blocks: tuple[Block, ...] = (*nothing, *cards, closed_loop, *figures["verdict"], Facts(tuple(_setting(cases))))
    return Section("verdict", "Decision", "Decision", blocks)


def summary(section: Section) -> Text:
    """The verdicts in one line."""
    cards = [block for block in section.blocks if isinstance(block, VerdictCard)]
    said = []
    for state in _ORDER:
        names = [card.name for card in cards if card.state == state]
        if names:
            said.append(f"{next(c.word for c in cards if c.state == state).lower()}: {', '.join(names)}")
    return ("In short, ", Strong("; ".join(said)), ".")


def _card(limit: Limit, pairs: Sequence[Pair], areas: AreaTable) -> VerdictCard:
    likely = [p for p in pairs if p[0].role == LIKELY]
    possible = possible_of(pairs)
    case, j = deciding(pairs)
    state: State = "met" if j.passed else "violated" if case.role == LIKELY or not likely else "open"
    word = {"met": "Met", "violated": "Violated", "open": "At risk"}[state]
    outputs = ", ".join(dict.fromkeys(o.output for _, o in pairs))
    lead: Text = (
        Strong(limit.name),
        f" ({outputs}) is ",
        _where(state, likely, possible),
        f": {j.output} reaches {ratio_text(j.ratio)} times the limit at {mhz_text(j.binding_hz)} in case {case.id}"
        f" ({case.title[:1].lower()}{case.title[1:]}), with a safety factor of {case.safety_factor:g} on amplitudes.",
    )
    facts: list[tuple[str, Text]] = []
    if likely:
        facts.append(("Likely cases", _by_case(likely)))
    facts += [
        ("All possible cases", _by_case(possible)),
        ("How sure", _how_sure(case, j)),
        ("Limited by", limited_by(j, areas)),
        ("What would help" if not j.passed else "Margin", _improvement(case, j)),
    ]
    return VerdictCard(state, word, limit.name, lead, tuple(facts))


def _where(state: State, likely: Sequence[Pair], possible: Sequence[Pair]) -> str:
    cases = _cases(possible)
    failing = [c for c in cases if any(not j.passed for k, j in possible if k.id == c)]
    if state == "met":
        return f"met in all {count(len(cases), 'case')} that can occur" if len(cases) > 1 else "met"
    if state == "open":
        return f"met in the likely cases ({and_text(_cases(likely))}), violated in others ({and_text(failing)})"
    bad = [c for c in _cases(likely) if any(not j.passed for k, j in likely if k.id == c)]
    return (
        f"violated in {len(bad)} of {count(len(_cases(likely)), 'likely case')}"
        if likely
        else f"violated in {len(failing)} of {count(len(cases), 'case')}"
    )


def _cases(pairs: Sequence[Pair]) -> list[str]:
    return list(dict.fromkeys(c.id for c, _ in pairs))


def _by_case(pairs: Sequence[Pair]) -> Text:
    """The largest ratio of each case; those above 1 stand out."""
    pieces: list[str | Strong] = []
    for case_id in _cases(pairs):
        _, j = worst_of([p for p in pairs if p[0].id == case_id])
        text = f"case {case_id}: {ratio_text(j.ratio)}"
        pieces += [", " if pieces else "", text if j.passed else Strong(f"{text} FAIL")]
    return tuple(pieces)


def _how_sure(case: CaseNoise, j: JudgedOutput) -> Text:
    """Would other temperature filters, correlations or safety factors turn the verdict?"""
    said = []
    if j.filter_ratio is not None:
        low, high = float(j.filter_ratio.min()), float(j.filter_ratio.max())
        turned = not (high <= 1.0 if j.passed else low > 1.0)
        tried = "some temperature filters would turn it" if turned else "every temperature filter tried agrees"
        said.append(f"{tried} ({span(low, high)})")
    else:
        said.append("the temperature has no low-pass to vary")
    bounds = j.bound_ratio
    between = bounds["known_blocks_minimum"], bounds["known_blocks"]
    if j.passed:
        if bounds["maximum"] <= 1.0:
            said.append(f"no correlation of the areas could violate it (at most {ratio_text(bounds['maximum'])})")
        elif between[1] <= 1.0:
            said.append(
                f"no correlation between its blocks could violate it (at most {ratio_text(between[1])}), but one inside"
                f" of them could (up to {ratio_text(bounds['maximum'])})"
            )
        else:
            said.append(f"other correlations could violate it (up to {ratio_text(bounds['maximum'])})")
    elif bounds["minimum"] > 1.0:
        said.append(f"no correlation of the areas could meet it (at least {ratio_text(bounds['minimum'])})")
    elif between[0] > 1.0:
        said.append(
            f"no correlation between its blocks could meet it (at least {ratio_text(between[0])}), only one inside of"
            " them"
        )
    else:
        said.append(f"other correlations of the areas give {span(bounds['minimum'], bounds['maximum'])}")
    bare = j.ratio / case.safety_factor
    if case.safety_factor != 1.0 and not j.passed:
        said.append(f"without the safety factor it is {ratio_text(bare)}, {'met' if bare <= 1.0 else 'still violated'}")
    text = "; ".join(said)
    return (f"{text[:1].upper()}{text[1:]}. ", Link("Table", "sure"))


def limited_by(j: JudgedOutput, areas: AreaTable) -> str:
    """Groups, areas and optical elements with the largest parts of the power at the binding frequency."""
    groups = {name: float(j.share[areas.group == name].sum()) for name in dict.fromkeys(areas.group)}
    single = dict(zip(areas.name, j.share.tolist(), strict=True))
    said = [f"groups {_largest(groups)}"]
    if np.abs(j.share).sum() > _CANCELLED:
        largest = max(single, key=lambda name: abs(single[name]))
        said.append(f"areas cancel each other, {largest} alone is {percent(single[largest])}")
    else:
        said.append(f"areas {_largest(single)}")
    if j.path is not None:
        said.append(f"optical elements {_largest(j.path)}")
    if j.distortion_ratio is not None:
        said.append(f"if the bench did not move as one, the ratio would be {ratio_text(j.distortion_ratio)}")
    text = "; ".join(said)
    return f"Shares of the power at {mhz_text(j.contribution_hz)} (negative ones cancel): {text}"


def _largest(shares: dict[str, float]) -> str:
    order = sorted(shares, key=lambda name: -abs(shares[name]))[:_NAMED]
    shown = [f"{name} {percent(shares[name])}" for name in order if abs(shares[name]) >= _SMALL]
    return ", ".join(shown) or f"none above {percent(_SMALL)}"


def _improvement(case: CaseNoise, j: JudgedOutput) -> Text:
    m = j.improvement
    if j.passed:
        return (
            f"temperature noise {ratio_text(m.all_factor)} times as large in all groups, or a safety factor of"
            f" {ratio_text(case.safety_factor * m.all_factor)}, would just be allowed"
        )
    alone = {g: f for g, f in m.group_factor.items() if np.isfinite(f) and f < 1.0}
    said = []
    if alone:
        parts = [f"{g} to {ratio_text(f)}" for g, f in sorted(alone.items(), key=lambda item: -item[1])[:_NAMED]]
        said.append(f"temperature noise of one group lowered by this factor, the others unchanged: {', '.join(parts)}")
    else:
        said.append("no group alone can meet it")
    said.append(f"all groups together would need {ratio_text(m.all_factor)} of their temperature noise")
    for way, (verb, _) in WAYS.items():
        chosen = m.chosen[way]
        enough = next((min(int(n), len(chosen)) for n, r in zip(m.count, m.ratio[way], strict=True) if r <= 1.0), 0)
        if enough:
            what = count(enough, "block" if way == MATCHED else "area")
            said.append(f"{verb} {what} ({_few(chosen[:enough])}) is enough")
        elif way == SILENCED and chosen:
            most = min(int(m.count[-1]), len(chosen))  # fewer where no other would help
            what = f"the {most} worst areas" if most > 1 else chosen[0]
            said.append(f"{verb} {what} leaves {ratio_text(float(m.ratio[way][-1]))}")
        elif way == SILENCED:
            said.append("silencing a single area does not lower it")
    text = "; ".join(said)
    return (f"{text[:1].upper()}{text[1:]}. ", Link("Table", "change"))


def _few(names: Sequence[str]) -> str:
    return "; ".join(names[:_NAMED]) + (f" and {len(names) - _NAMED} more" if len(names) > _NAMED else "")


def _field_card(dc: Sequence[DcVerdict]) -> VerdictCard:
    whole = [v for v in dc if v.whole]
    worst = worst_at_rest(dc)
    met = all(v.passed for v in dc)
    told = [
        sum(bool(v.passed) == met for v in which) for which in (dc, whole)
    ]  # those within where all are, else those not
    together = (
        f" ({told[1]} of {len(whole)} for inertial sensor and rest of the LTP together)" if len(whole) < len(dc) else ""
    )
    lead: Text = (
        "the ",
        Link("field at rest", "field"),
        f" is {'within' if met else 'outside'} its allocation in {told[0]} of"
        f" {count(len(dc), 'quantity', 'quantities')}{together}; the worst is"
        f" {symbol(worst.quantity)} of {worst.test_mass} by {worst.subsystem}, {sci(worst.value)}"
        f" {unit_text(worst.unit)}, which is {ratio_text(worst.ratio)} times its limit (nominal frame of the test"
        " mass).",
    )
    return VerdictCard("met" if met else "violated", "Met" if met else "Violated", "field at rest", lead)


def _setting(cases: Sequence[CaseNoise]) -> list[tuple[str, Text]]:
    first = cases[0]
    factor = f"{first.safety_factor:g}, on noise amplitudes wherever they are compared to a requirement"
    facts: list[tuple[str, Text]] = [("Temperature noise", first.temperature), ("Safety factor", factor)]
    if first.filter_order.size:
        orders = ", ".join(f"{v:g}" for v in first.filter_order)
        corners = ", ".join(f"{v * 1e3:g}" for v in first.filter_corner_hz)
        facts.append(
            (
                "Assumption",
                "order and corner of the low-pass temperature filter are assumed, and verdicts depend on them; tried as"
                f" well: every order of {orders} with every corner of {corners} mHz, levels held at the reference"
                " frequency",
            )
        )
    roles = {role: [c.id for c in cases if c.role == role] for role in (LIKELY, POSSIBLE, DIAGNOSTIC)}
    if roles[LIKELY] or roles[DIAGNOSTIC]:
        said = [f"{role}: {', '.join(ids)}" for role, ids in roles.items() if ids]
        facts.append(("Cases", f"{'; '.join(said)} (diagnostic ones isolate a part and decide nothing)"))
    for limit, _ in by_requirement(cases):
        band = f"{limit.band_hz[0] * 1e3:g} to {limit.band_hz[1] * 1e3:g} mHz"
        facts.append((limit.name, f"{limit.source}; {unit_text(limit.unit)}/√Hz, {band}"))
    return facts
