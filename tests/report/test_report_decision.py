"""What is decided: roles of cases, what turns a verdict, and what is said to limit it and to bring it down."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.noise.areas import AreaTable
from tedm_cli.report.assumed_filter import turned_by_filter
from tedm_cli.report.decision import cards_section, field_words, limited_by
from tedm_cli.report.document import Paragraph, Table, VerdictCard, plain
from tedm_cli.report.evidence import change_section, share_text
from tedm_cli.report.proof import at_rest_section
from tedm_cli.report.remedy import remedy_section
from tedm_cli.report.summary import verdict_sentence
from tedm_cli.report.verdicts import noise_judgements, worst_first
from tedm_cli.results.cases.deciding import deciding, deciding_pairs, without_repeats
from tedm_cli.results.cases.noise import SILENCED, WAYS, CaseNoise, JudgedOutput, Limit, NamedImprovement

AREAS = AreaTable(
    name=np.array(["S1", "S2", "B1"]),
    group=np.array(["struts", "struts", "bench"]),
    shield=np.array(["outside", "outside", "inside"]),
    side=np.array(["mid", "mid", "mid"]),
)
FREQUENCY = np.array([1e-3, 1e-2])
LIMIT = Limit("lpf_readout_item", "a thesis", "m", (1e-3, 1e-2), np.ones(2))
PASSED_DC = DcVerdict("TM1", "a_x", "IS+LTP", 1e-10, -1e-9, 1e-9)
LOOP = Paragraph("The loop has not been closed.", quiet=True)
BOUNDS = ("minimum", "known_blocks_minimum", "known_blocks", "maximum_non_negative", "maximum")


def judged(ratio: float, output: str = "A_TM1_x", **more: object) -> JudgedOutput:
    """An output whose noise is `ratio` times the limit."""
    improvement = NamedImprovement(
        np.array([0, 1, 2]),
        {way: ratio * np.array([1.0, 0.6, 0.3]) for way in WAYS},
        {way: ["S1", "S2"] for way in WAYS},
        {"struts": 0.5 / ratio, "bench": np.nan},
        {"struts": 1e-3, "bench": 1e-4},
        1.0 / ratio,
    )
    values = {
        "output": output, "kind": "displacement", "unit": "m", "requirement": LIMIT.name, "ratio": ratio,
        "binding_hz": 3e-3, "passed": ratio <= 1.0, "asd": np.ones(2), "bound_low": np.zeros(2),
        "bound_high": np.ones(2), "bound_ratio": dict(zip(BOUNDS, (0.0, 0.1, 5.0, 6.0, 7.0), strict=True)),
        "distortion_ratio": 0.7,
        "filter_ratio": np.array([[0.5 * ratio, 2.0 * ratio]]), "contribution_hz": 3e-3, "band_hz": (1e-3, 1e-2),
        "contribution": np.array([1.0, -0.5, 0.1]), "share": np.array([0.9, 0.02, 0.08]),
        "band_share": np.array([0.9, 0.02, 0.08]), "path": {"M1": 1.2, "BS1": -0.2},
        "path_band": {"M1": 1.0, "BS1": 0.0}, "improvement": improvement, "realised": None,
    } | more  # fmt: skip
    return JudgedOutput(**values)  # type: ignore[arg-type]


def case(case_id: str, role: str, *outputs: JudgedOutput) -> CaseNoise:
    return CaseNoise(case_id, f"Title {case_id}", role, "", 2.0, "white", AREAS, np.array([0, 0, 1]), FREQUENCY,
                     outputs, (LIMIT,), np.array([2.0]), np.array([1e-3, 1e-2]))  # fmt: skip


def cards(cases: Sequence[CaseNoise], dc: DcVerdict = PASSED_DC) -> list[VerdictCard]:
    found = cards_section(cases, [dc], LOOP, str)
    return [b for b in found.blocks if isinstance(b, VerdictCard)]


def card(*cases: CaseNoise) -> VerdictCard:
    return next(b for b in cards(cases) if b.name == LIMIT.name)


def sentence(cases: Sequence[CaseNoise], dc: Sequence[DcVerdict] = (PASSED_DC,)) -> str:
    return plain(verdict_sentence(worst_first(noise_judgements(cases)), dc, []))


@pytest.mark.parametrize(
    ("ratios", "state", "word", "decides"),
    [
        ({"likely": 0.5, "possible": 0.6, "diagnostic": 9.0}, "met", "Met", "possible"),
        ({"likely": 0.5, "possible": 3.0, "diagnostic": 9.0}, "open", "At risk", "possible"),
        ({"likely": 1.5, "possible": 3.0, "diagnostic": 9.0}, "violated", "Violated", "likely"),
        ({"possible": 3.0, "diagnostic": 9.0}, "violated", "Violated", "possible"),
        ({"diagnostic": 9.0}, "violated", "Violated", "diagnostic"),
    ],
)
def test_roles_of_cases_decide(ratios: dict[str, float], state: str, word: str, decides: str) -> None:
    """Diagnostic cases decide only where there are no others; a likely violation outweighs a worse unlikely one."""
    cases = [case(role, role, judged(ratio)) for role, ratio in ratios.items()]
    found = card(*cases)
    assert (found.state, found.word) == (state, word)
    assert deciding([(c, c.judged[0]) for c in cases])[0].id == decides
    assert f"in case {decides} " in plain(found.lead)
    assert dict(found.facts).keys() >= {"All possible cases", "How sure", "Limited by"}
    assert ("Likely cases" in dict(found.facts)) == ("likely" in ratios)


def test_the_worst_card_comes_first() -> None:
    failed_dc = replace(PASSED_DC, value=3e-9)
    for dc in (PASSED_DC, failed_dc):
        assert [c.name for c in cards([case("1", "likely", judged(2.0))], dc)] == [LIMIT.name, "field at rest"]
    assert [c.name for c in cards([case("1", "likely", judged(0.2))], failed_dc)] == ["field at rest", LIMIT.name]


def test_a_field_that_nothing_limits_is_said_not_to_be_judged() -> None:
    likely = [case("1", "likely", judged(0.2))]
    found = cards_section(likely, [], LOOP, str)
    assert [b.name for b in found.blocks if isinstance(b, VerdictCard)] == [LIMIT.name]
    assert sentence(likely, []).startswith("All that is required is met")
    assert sentence([case("1", "likely")], []) == "Nothing is judged: the project names no requirement."
    section = at_rest_section([], [])
    assert len(section.blocks) == 1
    assert "is not judged" in plain(section.blocks[0].text)  # type: ignore[union-attr]
    assert remedy_section(likely, [], None, str, []).blocks[0] == Paragraph(
        "Nothing has to be done: all judged requirements are met in every case that can occur."
    )


@pytest.mark.parametrize(
    ("ratios", "said"),
    [
        ({"likely": 0.4, "possible": 0.5, "diagnostic": 9.0}, "All that is required is met, in every case that can"),
        (
            {"likely": 0.5, "possible": 0.7, "diagnostic": 9.0},
            "met with the assumed temperature filter, but not with every other: the largest ratio to a limit is 0.700"
            " in the cases that can occur, and other filters bring the read-out of x, test mass 1, set A, up to 1.40"
            " times its limit.",
        ),
        ({"likely": 0.5, "possible": 3.0}, "met in the likely cases, and at risk in others: the read-out of x"),
        ({"likely": 1.5, "possible": 3.0}, "are not met: the read-out of x, test mass 1, set A, is 1.50 times"),
        ({"possible": 3.0, "diagnostic": 9.0}, "is 3.00 times its limit in case possible."),
    ],
)  # fmt: skip
def test_the_verdict_in_a_sentence(ratios: dict[str, float], said: str) -> None:
    assert said in sentence([case(role, role, judged(ratio)) for role, ratio in ratios.items()])


@pytest.mark.parametrize(
    ("ratios", "span"),
    [
        ({"likely": 0.5}, None),
        ({"likely": 0.6}, "0.300 to 1.20"),
        ({"likely": 0.4, "possible": 0.7}, "0.350 to 1.40"),
        ({"likely": 0.4, "diagnostic": 0.7}, None),
        ({"likely": 0.4, "possible": 1.6}, "0.800 to 3.20"),
        ({"likely": 0.7, "possible": 4.0}, "2.00 to 8.00"),
        ({"likely": 0.4, "possible": 4.0}, None),
        ({"likely": 1.5, "possible": 9.0}, "0.750 to 3.00"),
        ({"likely": 4.0, "possible": 9.0}, None),
    ],
)
def test_a_verdict_that_another_filter_turns_is_told_in_the_sentence_and_in_what_to_do(
    ratios: dict[str, float], span: str | None
) -> None:
    """Filters halve and double each ratio: what is then met, violated or at risk otherwise is never told as certain."""
    cases = [case(role, role, judged(ratio)) for role, ratio in ratios.items()]
    blocks = remedy_section(cases, [PASSED_DC], None, str, []).blocks
    told = [plain(b.text) for b in blocks if isinstance(b, Paragraph)]
    action = [t for t in told if t.startswith("Measure the spectrum of the temperatures, or confirm the filter: ")]
    said = sentence(cases)
    if span is None:
        assert not action
        assert "filter" not in said
        return
    assert "temperature filter" in said
    assert span.rpartition(" ")[2] in said
    assert f"the read-out of x, test mass 1, set A, is {span} times its limit" in action[0]
    assert not any("in every case" in t and "filter" not in t for t in (said, *told))


def test_filters_are_those_of_all_cases_at_once_and_the_worst_output_is_told_first() -> None:
    """One filter meets a case and violates another, the other filter the reverse: no filter meets both."""
    one, other = (judged(1.4, filter_ratio=np.array([r])) for r in ([0.5, 1.5], [1.5, 0.5]))
    assert not turned_by_filter(noise_judgements([case("1", "likely", one), case("2", "likely", other)]))
    mild, bad, none = judged(0.6), judged(0.9, "B_TM2_x"), judged(0.95, "TM1_a_x", filter_ratio=None)
    found = turned_by_filter(noise_judgements([case("1", "likely", mild, bad, none)]))
    assert [(t.found.output, t.low, t.high) for t in found] == [("B_TM2_x", 0.45, 1.8), ("A_TM1_x", 0.3, 1.2)]


def test_the_sentence_counts_what_exceeds_and_names_the_worst() -> None:
    dc = [PASSED_DC, replace(PASSED_DC, value=3e-9), replace(PASSED_DC, value=2e-9)]
    text = sentence([case("1", "likely", judged(0.2))], dc)
    assert text == (
        "The requirements are not met: the field at rest exceeds its limits in 2 of 3 quantities (the worst is 3.00"
        " times its limit)."
    )
    assert field_words(dc).startswith("exceeds its limits in 2 of 3 quantities; the worst is the acceleration of test")
    assert field_words([PASSED_DC]).startswith("is within its limits in 1 quantity")


@pytest.mark.parametrize(
    ("ratio", "more", "said"),
    [
        (0.4, {}, "Every temperature filter tried agrees (0.200 to 0.800)"),
        (0.8, {}, "Some temperature filters would turn it (0.400 to 1.60)"),
        (1.5, {}, "Some temperature filters would turn it (0.750 to 3.00)"),
        (4.0, {}, "Every temperature filter tried agrees (2.00 to 8.00)"),
        (0.8, {"filter_ratio": None}, "The temperature has no low-pass to vary"),
        (0.8, {"bound_ratio": dict.fromkeys(BOUNDS, 0.9)}, "no correlation of the areas could violate it"),
        (0.8, {}, "other correlations could violate it (up to 7.00)"),
        (0.8, {"bound_ratio": dict(zip(BOUNDS, (0, 0.1, 0.9, 6, 7), strict=True))}, "between its blocks could violate"),
        (1.5, {}, "other correlations of the areas give 0 to 7.00"),
        (1.5, {"bound_ratio": dict(zip(BOUNDS, (0, 1.1, 5, 6, 7), strict=True))}, "between its blocks could meet it"),
        (1.5, {"bound_ratio": dict(zip(BOUNDS, (1.2, 1.3, 5, 6, 7), strict=True))}, "could meet it (at least 1.20)"),
        (1.5, {}, "without the safety factor it is 0.750, met"),
        (3.0, {}, "without the safety factor it is 1.50, still violated"),
    ],
)  # fmt: skip
def test_how_sure_a_verdict_is(ratio: float, more: dict[str, Any], said: str) -> None:
    assert said in plain(dict(card(case("1", "likely", judged(ratio, **more))).facts)["How sure"])


def test_what_limits() -> None:
    text = limited_by(case("1", "likely"), judged(2.0, path={"M1": 0.8, "BS1": 0.2}))
    assert "groups struts 92 %, bench 8 %" in text
    assert text.endswith("if the bench did not move as one, the ratio would be 0.700")
    assert "areas S1 90 %, B1 8 %; optical elements M1 80 %, BS1 20 %" in text


def test_terms_that_cancel_are_told_by_their_amplitudes_and_not_as_percentages() -> None:
    """Shares of 1200 % of a power are no shares."""
    j = judged(
        2.0,
        share=np.array([12.0, -11.5, 0.5]),
        contribution=np.array([1.2, -1.15, 0.05]),
        path={"M1": 1.2, "BS1": -0.2},
    )
    text = limited_by(case("1", "likely"), replace(j, contribution_hz=1e-2, asd=np.array([9.0, 0.1])))
    assert "two large terms, S1 the largest with 1.2 m/√Hz, cancel to 0.1 m/√Hz" in text
    assert "optical elements cancel each other, M1 and BS1 the largest" in text
    assert "120" not in text
    assert "1200" not in text
    assert (share_text(12.0, True), share_text(-11.5, True), share_text(0.5, False)) == (
        "+12.00 ×",
        "−11.50 ×",
        "50.0 %",
    )


def test_what_would_help() -> None:
    """Remedies come from the file: a group, silent areas, matched blocks."""
    together = plain(dict(card(case("1", "likely", judged(1.5))).facts)["What would help"])
    assert "others unchanged: struts to 0.333" in together
    assert "all groups together would need 0.667" in together
    assert "silencing 1 area (S1) is enough" in together
    assert "one common temperature of 1 block (S1) is enough" in together
    margin = plain(dict(card(case("1", "likely", judged(0.25))).facts)["Margin"])
    assert "4.00 times as large" in margin
    assert "safety factor of 8.00" in margin


@pytest.mark.parametrize(
    ("chosen", "ratios", "said"),
    [
        (["S1", "S2", "B1"], [4.0, 3.0, 0.5], "silencing 3 areas (S1; S2; B1) is enough"),
        (["S1", "S2", "B1"], [4.0, 3.0, 1.5], "silencing the 3 worst areas leaves 1.50"),
        (["S1"], [4.0, 1.5, 1.5], "silencing S1 leaves 1.50"),
        ([], [4.0, 4.0, 4.0], "silencing a single area does not lower it"),
    ],
)
def test_no_more_areas_are_silenced_than_help(chosen: list[str], ratios: list[float], said: str) -> None:
    """Ratios are told up to 10 areas, also where fewer areas help or are there."""
    j = judged(4.0)
    improvement = replace(
        j.improvement,
        count=np.array([0, 1, 10]),
        ratio=j.improvement.ratio | {SILENCED: np.array(ratios)},
        chosen=j.improvement.chosen | {SILENCED: chosen},
    )
    facts = card(case("1", "likely", replace(j, improvement=improvement))).facts
    text = plain(dict(facts)["What would help"]).replace(" (improvement", ";")
    assert f"; {said};" in text


def test_outputs_that_say_the_same_are_told_once() -> None:
    """In every case, or not at all."""
    same = [case(i, "likely", judged(2.0, "A"), judged(2.0 * (1 + 1e-9), "B"), judged(1.0, "C")) for i in "12"]
    assert [j.output for j in without_repeats(same)[0].judged] == ["A, B", "C"]
    assert [j.output for _, j in deciding_pairs(same)] == ["A, B", "C"]
    other = [same[0], case("2", "likely", judged(2.0, "A"), judged(2.5, "B"), judged(1.0, "C"))]
    assert [j.output for j in without_repeats(other)[0].judged] == ["A", "B", "C"]
    turned = judged(2.0, "B", contribution=np.array([1.0, 0.5, 0.1]))
    assert len(without_repeats([case("1", "likely", judged(2.0, "A"), turned)])[0].judged) == 2


def test_required_stability_names_levels() -> None:
    section = change_section([case("1", "likely", judged(2.0))], [], str)
    tables = [b for b in section.blocks if isinstance(b, Table)]
    rows = {r.cells[0].text: [c.text for c in r.cells[1:]] for r in tables[0].rows}
    assert rows["struts"] == ["2", "1.00 × 10⁻³", "0.250", "2.50 × 10⁻⁴"]
    assert rows["bench"][2] == "cannot alone"
    assert rows["all together"][2] == "0.500"
    improvement = [[c.text for c in r.cells] for r in tables[1].rows]
    assert improvement[0] == ["0", "2.00", "2.00", "", "2.00", ""]
    assert improvement[1] == ["1", "1.20", "1.20", "S1", "1.20", "S1"]
    assert improvement[2] == ["2", "0.600", "0.600", "S2", "0.600", "S2"]
