"""What the report decides: roles of cases, what turns a verdict, and what is said to limit it and to bring it down."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.noise.areas import AreaTable
from tedm_cli.report.decision import decision_section, limited_by, summary
from tedm_cli.report.document import Paragraph, Table, VerdictCard, plain
from tedm_cli.report.evidence import change_section, deciding_pairs
from tedm_cli.results.deciding import deciding, without_repeats
from tedm_cli.results.noise import SILENCED, WAYS, CaseNoise, JudgedOutput, Limit, NamedImprovement

AREAS = AreaTable(
    name=np.array(["S1", "S2", "B1"]),
    group=np.array(["struts", "struts", "bench"]),
    shield=np.array(["outside", "outside", "inside"]),
    side=np.array(["mid", "mid", "mid"]),
)
FREQUENCY = np.array([1e-3, 1e-2])
LIMIT = Limit("lpf_readout_item", "a thesis", "m", (1e-3, 1e-2), np.ones(2))
PASSED_DC = DcVerdict("TM1", "a_x", "IS+LTP", 1e-10, -1e-9, 1e-9)
FIGURES: dict[str, list[Any]] = {"verdict": [], "improvement": []}
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
    return CaseNoise(case_id, f"Title {case_id}", role, "", 2.0, "white", np.array([0, 0, 1]), FREQUENCY, outputs,
                     (LIMIT,), np.array([2.0]), np.array([1e-3, 1e-2]))  # fmt: skip


def card(*cases: CaseNoise) -> VerdictCard:
    found = decision_section(cases, AREAS, [PASSED_DC], LOOP, FIGURES)
    return next(b for b in found.blocks if isinstance(b, VerdictCard) and b.name == LIMIT.name)


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


def test_the_worst_card_comes_first_and_the_summary_names_all() -> None:
    cases = [case("1", "likely", judged(2.0))]
    failed_dc = replace(PASSED_DC, value=3e-9)
    for dc, names in ((PASSED_DC, [LIMIT.name, "field at rest"]), (failed_dc, [LIMIT.name, "field at rest"])):
        section = decision_section(cases, AREAS, [dc], LOOP, FIGURES)
        cards = [b for b in section.blocks if isinstance(b, VerdictCard)]
        assert [c.name for c in cards] == names
        assert all(name in plain(summary(section)) for name in names)
    section = decision_section([case("1", "likely", judged(0.2))], AREAS, [failed_dc], LOOP, FIGURES)
    assert next(b for b in section.blocks if isinstance(b, VerdictCard)).name == "field at rest"


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
    text = limited_by(judged(2.0), AREAS)
    assert "groups struts 92 %, bench 8 %" in text
    assert text.endswith("if the bench did not move as one, the ratio would be 0.700")
    assert "areas S1 90 %, B1 8 %; optical elements M1 120 %, BS1 −20 %" in text
    cancelling = judged(2.0, share=np.array([12.0, -11.5, 0.5]), path=None)
    assert "areas cancel each other, S1 alone is 1200 %" in limited_by(cancelling, AREAS)


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
    text = plain(dict(facts)["What would help"]).replace(". Table", ";")
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
    section = change_section([case("1", "likely", judged(2.0))], AREAS, FIGURES)
    tables = [b for b in section.blocks if isinstance(b, Table)]
    rows = {r.cells[0].text: [c.text for c in r.cells[1:]] for r in tables[0].rows}
    assert rows["struts"] == ["2", "1.00 × 10⁻³", "0.250", "2.50 × 10⁻⁴"]
    assert rows["bench"][2] == "cannot alone"
    assert rows["all together"][2] == "0.500"
    improvement = [[c.text for c in r.cells] for r in tables[1].rows]
    assert improvement[0] == ["0", "2.00", "2.00", "", "2.00", ""]
    assert improvement[1] == ["1", "1.20", "1.20", "S1", "1.20", "S1"]
    assert improvement[2] == ["2", "0.600", "0.600", "S2", "0.600", "S2"]
