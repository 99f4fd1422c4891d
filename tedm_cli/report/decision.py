"""Each requirement in detail: the verdict in every case, how sure it is, what limits it, what would help."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.report.document import Label, Link, Paragraph, Ref, Section, State, Strong, Text, VerdictCard
from tedm_cli.report.evidence import cancels, few, improvement_key
from tedm_cli.report.uncertain import chance_words, violated_words
from tedm_cli.report.verdicts import Titles, exceeding, state_of
from tedm_cli.results.cases.deciding import (
    LIKELY,
    Pair,
    by_requirement,
    deciding,
    possible_of,
    without_repeats,
    worst_of,
)
from tedm_cli.results.cases.noise import MATCHED, SILENCED, WAYS, CaseNoise, JudgedOutput, Limit
from tedm_cli.results.gravity.field import worst_at_rest
from tedm_cli.results.titles import at_rest_title, by_subsystem, output_title
from tedm_cli.results.wording import (
    and_text,
    capital,
    clause,
    count,
    mhz_text,
    number_word,
    parts_noun,
    percent,
    ratio_text,
    sci,
    span,
    the_bench,
    unit_text,
)

_NAMED = 3  # groups, areas and optical elements named in a sentence
_ORDER: tuple[State, ...] = ("violated", "open", "met")
_SMALL = 0.05  # shares of the power below this are not named
_LARGE = 0.1  # of the largest contribution: a term of this size is a large one


def cards_section(
    cases: Sequence[CaseNoise],
    dc: Sequence[DcVerdict],
    closed_loop: Paragraph,
    titles: Titles,
    benches: int = 1,
) -> Section:
    """A card for each requirement and one for the field at rest, where it is judged; the worst first.

    `closed_loop` is what is to be said of the drag-free loop here; `benches`: how many the read-outs are of.
    """
    cards = [_card(limit, pairs, titles, benches) for limit, pairs in by_requirement(without_repeats(cases))]
    if dc:
        cards.append(_field_card(dc))
    cards.sort(key=lambda card: _ORDER.index(card.state))
    return Section("requirements", "Each requirement", "Requirements", (*cards, closed_loop), new_page=True)


def _card(limit: Limit, pairs: Sequence[Pair], titles: Titles, benches: int) -> VerdictCard:
    likely = [p for p in pairs if p[0].role == LIKELY]
    possible = possible_of(pairs)
    case, j = deciding(pairs)
    state = state_of(pairs)
    word = {"met": "Met", "violated": "Violated", "open": "At risk"}[state]
    labels = ", ".join(dict.fromkeys(o.output for _, o in pairs))
    title = titles(limit.name)
    lead: Text = (
        Strong(title),
        " ",
        Label(limit.name if title != limit.name else ""),
        f" for {output_title(labels)} ",
        Label(labels),
        " is ",
        _where(state, likely, possible),
        f"{violated_words(case, j)}: the {clause(output_title(j.output))} reaches {ratio_text(j.ratio)} times the limit"
        f" at {mhz_text(j.binding_hz)} in case {case.id}"
        f" ({case.title[:1].lower()}{case.title[1:]}), with a safety factor of {case.safety_factor:g} on amplitudes.",
    )
    facts: list[tuple[str, Text]] = []
    if likely:
        facts.append(("Likely cases", _by_case(likely)))
    facts += [
        ("All possible cases", _by_case(possible)),
        ("How sure", (f"{how_sure(case, j)} (", Ref("sure"), ").")),
        ("Limited by", limited_by(case, j, benches)),
        ("What would help" if not j.passed else "Margin", _improvement(case, j, limit.name)),
    ]
    return VerdictCard(state, word, title, lead, tuple(facts))


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


def how_sure(case: CaseNoise, j: JudgedOutput) -> str:
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
    if chance := chance_words(case, j):
        said.append(chance)
    text = "; ".join(said)
    return capital(text)


def limited_by(case: CaseNoise, j: JudgedOutput, benches: int = 1) -> str:
    """Groups, areas and optical elements with the largest parts of the power, or that large terms cancel."""
    areas = case.areas
    of_area = areas.group_by_unit
    groups = {name: float(j.share[of_area == name].sum()) for name in dict.fromkeys(of_area.tolist())}
    single = dict(zip(areas.name, j.share.tolist(), strict=True))
    said = [_parts("groups", groups)]
    said.append(cancelling(case, j) or _parts("areas", single))
    if j.path is not None:
        said.append(_parts(parts_noun(j.path), j.path))
    if j.distortion_ratio is not None:
        said.append(f"if {the_bench(benches)} did not move as one, the ratio would be {ratio_text(j.distortion_ratio)}")
    return f"Noise power at {mhz_text(j.contribution_hz)}: {'; '.join(said)}"


def cancelling(case: CaseNoise, j: JudgedOutput) -> str:
    """`twelve large terms cancel to 8.92 × 10⁻¹³ m/√Hz`, where areas of a block go against each other; else ""."""
    if not cancels(j.share):
        return ""
    areas = case.areas
    size = np.abs(j.contribution)
    large = int((size >= _LARGE * size.max()).sum())
    total = float(j.asd[int(np.abs(case.frequency_hz - j.contribution_hz).argmin())])
    unit = f"{unit_text(j.unit)}/√Hz"
    if large == 1:
        largest = areas.name[int(size.argmax())]
        return (
            f"{largest}, {sci(float(size.max()), 3)} {unit}, is cancelled by many small terms to {sci(total, 3)} {unit}"
        )
    return (
        f"{number_word(large)} large terms, {areas.name[int(size.argmax())]} the largest with"
        f" {sci(float(size.max()), 3)}"
        f" {unit}, cancel to {sci(total, 3)} {unit}"
    )


def _parts(what: str, shares: dict[str, float]) -> str:
    """The largest of the parts; where they cancel each other a share says nothing, and their names have to do."""
    order = sorted(shares, key=lambda name: -abs(shares[name]))[:_NAMED]
    if cancels(np.array(list(shares.values()))):
        return f"{what} cancel each other, {and_text([n for n in order if abs(shares[n]) >= _SMALL])} the largest"
    shown = [f"{name} {percent(shares[name])}" for name in order if abs(shares[name]) >= _SMALL]
    return f"{what} {', '.join(shown) or f'none above {percent(_SMALL)}'}"


def _improvement(case: CaseNoise, j: JudgedOutput, requirement: str) -> Text:
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
        if enough := m.enough(way):
            what = count(enough, "block" if way == MATCHED else "area")
            said.append(f"{verb} {what} ({few(chosen[:enough])}) is enough")
        elif way == SILENCED and chosen:
            most = min(int(m.count[-1]), len(chosen))  # fewer where no other would help
            what = f"the {most} worst areas" if most > 1 else chosen[0]
            said.append(f"{verb} {what} leaves {ratio_text(float(m.ratio[way][-1]))}")
        elif way == SILENCED:
            said.append("silencing a single area does not lower it")
    text = "; ".join(said)
    return (f"{capital(text)} (", Ref(improvement_key(requirement, j.output)), ").")


def _field_card(dc: Sequence[DcVerdict]) -> VerdictCard:
    outside = exceeding(dc)
    lead: Text = ("the ", Link("field at rest", "field-at-rest"), " ", field_words(dc))
    return VerdictCard("violated" if outside else "met", "Violated" if outside else "Met", "field at rest", lead)


def field_words(dc: Sequence[DcVerdict]) -> str:
    """How the field at rest stands to its limits."""
    whole, outside, worst = [v for v in dc if v.whole], exceeding(dc), worst_at_rest(dc)
    together = (
        f" ({len(exceeding(whole))} of {len(whole)} for everything in the model together)"
        if 0 < len(whole) < len(dc) and outside
        else ""
    )
    how = (
        f"exceeds its limits in {len(outside)} of {count(len(dc), 'quantity', 'quantities')}{together}"
        if outside
        else f"is within its limits in {'all ' * (len(dc) > 1)}{count(len(dc), 'quantity', 'quantities')}"
    )
    return (
        f"{how}; the worst is the {at_rest_title(worst.quantity, worst.place)} by {by_subsystem(worst.subsystem)},"
        f" {sci(worst.value)} {unit_text(worst.unit)}, which is {ratio_text(worst.ratio)} times its limit."
    )
