"""How the report and its figure tell the probability of verdicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.axes import Axes
from test_report_decision import LOOP, PASSED_DC, case, judged, sentence

from tedm_cli.figures.cases.chances import chances_figure
from tedm_cli.report.decision import cards_section, how_sure
from tedm_cli.report.document import Paragraph, Table, VerdictCard, plain
from tedm_cli.report.summary import summary_section
from tedm_cli.report.uncertain import uncertainty_facts, uncertainty_section
from tedm_cli.results.cases.chances import distribution_of, largest_sources
from tedm_cli.results.cases.deciding import deciding_pairs, without_repeats
from tedm_cli.results.cases.noise import CaseNoise
from tedm_cli.uncertainty.parameters import Parameter, Parameters
from tedm_cli.uncertainty.verdicts import PROBABILITIES, CaseUncertainty, Chance, Distribution, Draws, MeshComparison

PARAMETERS = Parameters.of(
    (
        Parameter("glass", "expansion", "MAT1 1", 2e-8, "uniform", "1/K", "a catalogue"),
        Parameter("struts", "modulus", "MAT1 2", 0.03, "normal", source="assumption (example)"),
        Parameter("walls", "modulus", "MAT1 3", 0.05, "normal", source="assumption (example)"),
    ),
    {("struts", "walls"): 0.5},
)
DRAWS = Draws(1000, 1, 10)
NEVER = Chance.of(np.zeros(1000, dtype=bool))


def chance(probability: float) -> Chance:
    return Chance.of(np.arange(1000) < round(1000 * probability))


def distribution(output: str, nominal: float, probability: float, bare: float = 0.0) -> Distribution:
    return Distribution(
        output, "lpf_readout_item", nominal, chance(probability), chance(bare), nominal, 0.1 * nominal,
        nominal * (0.5 + PROBABILITIES), np.array([0.1, 0.7]), np.array([0.2, 0.9]),
    )  # fmt: skip


def sure(of: CaseNoise, probability: float, mesh: MeshComparison | None = None) -> CaseNoise:
    """The case with probabilities of its verdicts."""
    verdicts = tuple(distribution(j.output, j.ratio, probability, 0.25 * probability) for j in of.judged)
    left = ("test mass positions: sensitivity.h5 has none",)
    both = chance(probability), chance(0.25 * probability)
    return replace(of, uncertainty=CaseUncertainty(PARAMETERS, left, DRAWS, verdicts, (), *both, mesh))


def tables(blocks: Sequence[object]) -> list[Table]:
    return [b for b in blocks if isinstance(b, Table)]


def texts(table: Table) -> list[list[str]]:
    return [[cell.text if isinstance(cell.text, str) else plain(cell.text) for cell in r.cells] for r in table.rows]


def test_the_decision_says_the_probability() -> None:
    cases = [sure(case("1", "likely", judged(3.0)), 0.974), sure(case("2", "likely", judged(1.2)), 0.6)]
    assert "3.00 times its limit in case 1 (violated with probability 0.974)" in sentence(cases)
    found = cards_section(cases, [PASSED_DC], LOOP, str)
    lead = next(plain(b.lead) for b in found.blocks if isinstance(b, VerdictCard) and b.state == "violated")
    assert "violated in 2 of 2 likely cases, with probability 0.974" in lead
    assert "2.85 to" not in lead


def test_what_is_met_says_how_probably_it_is_not() -> None:
    cases = [sure(case("1", "likely", judged(0.3)), 0.02), sure(case("2", "possible", judged(0.4)), 0.13)]
    assert "beyond its limit with probability 0.13 in case 2" in sentence(cases)
    assert "probability" not in sentence([case("1", "likely", judged(0.3))])
    never = replace(cases[0], uncertainty=replace(sure(cases[0], 0.0).uncertainty, any_violated=NEVER))  # type: ignore[type-var]
    assert "with probability below 0.004" in sentence([never])


def test_how_sure_ends_with_the_spread() -> None:
    of = sure(case("1", "likely", judged(2.0)), 0.9)
    told = how_sure(of, of.judged[0])
    assert told.endswith("with all that is uncertain 1.10 to 2.90 in 90 % of the draws, violated with probability 0.90")
    bare = case("1", "likely", judged(2.0))
    assert "draws" not in how_sure(bare, bare.judged[0])


def test_the_table_of_verdicts_has_a_column_where_something_is_uncertain() -> None:
    outputs = judged(2.0), judged(0.2, "A_TM1_y")
    for uncertain in (True, False):
        of = case("1", "likely", *outputs)
        cases = [sure(of, 0.9) if uncertain else of]
        section = summary_section(cases, [PASSED_DC], None, LOOP, str, True, [], "")
        table = tables(section.blocks)[0]
        assert any("Probability" in c.title for c in table.columns) == uncertain
        assert {len(r.cells) for r in table.rows if r.kind != "head"} == {len(table.columns)}
        words = [plain(c.text) if not isinstance(c.text, str) else c.text for r in table.rows for c in r.cells]
        assert ("0.90" in words) == uncertain
        names = [r[0] for r in texts(tables(section.blocks)[1])]
        assert ("What is uncertain" in names) == uncertain


def test_the_section_of_the_annex_has_every_verdict_parameter_and_what_is_left_out() -> None:
    mesh = MeshComparison("other/build", 2.0, 2.0, np.array([2.6]), np.array([1.8]))
    cases = [sure(case("1", "likely", judged(2.0)), 0.9, mesh), sure(case("2", "possible", judged(0.2)), 0.0)]
    section = uncertainty_section(cases, [])
    words = [plain(b.text) for b in section.blocks if isinstance(b, Paragraph)]
    assert "Left out: test mass positions: sensitivity.h5 has none." in words
    assert any("2.00 with this mesh, 2.60 with that one, 1.80 extrapolated" in w for w in words)
    verdicts, parameters = tables(section.blocks)
    rows = texts(verdicts)
    assert rows[1][1:7] == ["2.00", "1.10", "2.00", "2.90", "0.90", "0.23"]
    assert rows[1][7] == "struts + walls 0.70 (0.90), glass 0.10 (0.20)"
    assert rows[2][0] == "any of them"
    assert rows[4][5] == "< 0.004"
    assert [r[0] for r in texts(parameters)] == ["glass", "struts", "walls"]
    assert [r[2] for r in texts(parameters)] == ["± 2.0 × 10⁻⁸ 1/K", "σ 3.0 %", "σ 5.0 %"]
    assert "Correlated: struts + walls" in parameters.caption
    assert uncertainty_facts(cases)[0][1].startswith(
        "probabilities are over 3 parameters, 1,000 draws; the deviations of 2 of them are assumptions; left out"
    )
    assert uncertainty_facts([case("1", "likely", judged(2.0))]) == []


def test_outputs_that_say_the_same_have_the_distribution_of_the_first() -> None:
    of = sure(case("1", "likely", judged(2.0), judged(2.0, "B_TM1_x")), 0.9)
    (merged,) = without_repeats([of])
    assert [j.output for j in merged.judged] == ["A_TM1_x, B_TM1_x"]
    found = distribution_of(merged, merged.judged[0])
    assert found is not None
    assert found.output == "A_TM1_x"
    assert of.uncertainty is not None
    assert largest_sources(of.uncertainty, found) == [("struts + walls", 0.7, 0.9), ("glass", 0.1, 0.2)]
    beyond = replace(found, share_first=np.array([-0.01, 1.01]), share_total=np.array([0.01, 1.02]))
    told = [("struts + walls", 1.0, 1.0), ("glass", 0.0, 0.01)]
    assert largest_sources(of.uncertainty, beyond) == told, "estimates are beyond 0 and 1 by their error"


@pytest.fixture(scope="module")
def drawn() -> tuple[list[tuple[CaseNoise, object]], list[Axes]]:
    cases = [
        sure(case("1", "likely", judged(3.0), judged(0.4, "A_TM1_y", contribution=np.array([0.0, 1.0, 0.0]))), 0.9)
    ]
    pairs = deciding_pairs(cases)
    return pairs, chances_figure(pairs).axes  # type: ignore[return-value]


def test_the_figure_has_nominal_ratios_spreads_and_probabilities(
    drawn: tuple[list[tuple[CaseNoise, object]], list[Axes]],
) -> None:
    pairs, (ratios, _) = drawn
    marks = {float(line.get_xdata()[0]) for line in ratios.lines if line.get_marker() in ("o", "X")}  # type: ignore[index]
    assert marks == {3.0, 0.4}
    ends = {
        tuple(np.round(np.asarray(line.get_xdata(), dtype=float), 9))
        for line in ratios.lines
        if line.get_linewidth() == 5.0
    }
    assert ends == {(1.65, 4.35), (0.22, 0.58)}
    assert [t.get_text() for t in ratios.texts][: len(pairs)] == ["0.90", "0.90"]


def test_the_shares_in_the_figure_fill_the_bars(drawn: tuple[list[tuple[CaseNoise, object]], list[Axes]]) -> None:
    pairs, (_, shares) = drawn
    widths = np.array([p.get_width() for p in shares.patches]).reshape(len(pairs), -1)  # type: ignore[attr-defined]
    assert widths.sum(axis=1) == pytest.approx(1.0)
    assert widths[0] == pytest.approx([0.7, 0.1, 0.2])  # the largest first, then the other, then interactions
