"""What the report says of the closed loop: its verdicts, margins and remedies, and why there may be none."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from report_project import sketch

from tedm_cli.config.project import Project
from tedm_cli.report.document import Block, Folded, Paragraph, Section, Table, plain
from tedm_cli.report.dynamics import closed_loop_section, closed_loop_words, loop_detail_section
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.dynamics.loop import AT_READ_OUTS, ClosedLoop, LoopOutput, SimulatedCase, read_closed_loop
from tedm_cli.results.titles import output_title, requirement_title
from tedm_cli.results.wording import capital, percent, ratio_text
from tedm_cli.stages.chain.check import check_folder
from tedm_cli.stages.dynamics.build import build_dynamics
from tedm_cli.stages.reporting.report import report
from tedm_cli.stages.reporting.show import show_dict

IDS = ["1", "2", "4b"]


@pytest.fixture(scope="module")
def closed(finished: Project) -> ClosedLoop:
    with open_results(finished) as results:
        found = read_closed_loop(results.dynamics, results.simulations)
    assert found is not None
    return found


def words(found: ClosedLoop | None, no_loop: str = "") -> str:
    return plain(closed_loop_words(found, no_loop, IDS, title).text)


def title(name: str) -> str:
    return requirement_title(name, {})


def section(found: ClosedLoop) -> Section:
    return closed_loop_section(found, Paragraph("words"), [], title)


def details(found: ClosedLoop) -> Section:
    return loop_detail_section(found, IDS, [], [], title)


def tables(blocks: tuple[Block, ...]) -> Iterator[Table]:
    for block in blocks:
        if isinstance(block, Table):
            yield block
        elif isinstance(block, Folded):
            yield from tables(block.blocks)


def texts(table: Table) -> list[list[str]]:
    return [[cell.text for cell in row.cells] for row in table.rows]


def with_judged(found: ClosedLoop, number: int, **changes: object) -> ClosedLoop:
    """The loop with the outputs of one case changed."""
    cases = list(found.cases)
    judged = tuple(replace(j, **changes) for j in cases[number].judged)  # type: ignore[arg-type]
    cases[number] = replace(cases[number], judged=judged)
    return replace(found, cases=tuple(cases))


def in_role(found: ClosedLoop, *roles: str) -> ClosedLoop:
    return replace(found, cases=tuple(replace(c, role=r) for c, r in zip(found.cases, roles, strict=True)))


def test_the_decision_says_what_delta_g_is_in_closed_loop(closed: ClosedLoop) -> None:
    said = words(closed)
    pairs = [(c, j) for c in closed.cases for j in c.judged if j.output == "delta_g"]
    _, j = max(pairs, key=lambda p: p[1].ratio)
    group = max(j.share, key=lambda name: j.share[name])
    assert said.startswith(f"In closed loop the {output_title('delta_g')} is {ratio_text(j.ratio)} times its limit (")
    assert f"({title(j.requirement)}) in case " in said
    assert said.endswith(f"; {group} makes {percent(j.share[group])} of its power.")


def test_a_likely_violation_is_told_before_a_worse_one(closed: ClosedLoop) -> None:
    bad = with_judged(with_judged(closed, 0, ratio=3.0, passed=False), 1, ratio=9.0, passed=False)
    for roles, told in ((("likely", "possible"), "3.00"), (("possible", "possible"), "9.00")):
        said = words(in_role(bad, *roles, "diagnostic"))
        assert f") is {told} times" in said


def test_why_there_is_no_closed_loop(closed: ClosedLoop) -> None:
    assert words(None, "With 1 test mass there is no loop.") == "With 1 test mass there is no loop."
    assert "`tedm build-dynamics`" in words(None)
    unjudged = replace(closed, cases=tuple(replace(c, judged=()) for c in closed.cases))
    assert "No output of the closed loop is judged" in words(unjudged)
    assert list(tables(section(unjudged).blocks)) == []
    assert len(list(tables(details(unjudged).blocks))) == 1  # the margins are there


def test_cases_that_are_missing_are_named(closed: ClosedLoop) -> None:
    some = replace(closed, cases=closed.cases[:1])
    assert words(some).endswith("; not simulated: cases 2 and 4b.")


def test_without_delta_g_the_worst_output_is_told(closed: ClosedLoop) -> None:
    cases = [replace(c, judged=tuple(j for j in c.judged if j.output != "delta_g")) for c in closed.cases]
    worst = max((j for c in cases for j in c.judged), key=lambda j: j.ratio)
    said = words(replace(closed, cases=tuple(cases)))
    assert said.startswith(f"In closed loop the {output_title(worst.output)} is {ratio_text(worst.ratio)} times")


def test_every_output_is_in_the_table_of_what_decides(closed: ClosedLoop) -> None:
    first = texts(next(tables(section(closed).blocks)))
    judged: dict[tuple[str, str], list[tuple[SimulatedCase, LoopOutput]]] = closed.pairs()
    for r, ((output, requirement), pairs) in zip(first, judged.items(), strict=True):
        assert (r[0], r[1]) == (capital(output_title(output)), title(requirement))
        j = next(j for c, j in pairs if c.id == r[2])
        assert r[3] == ("pass" if j.passed else "FAIL")
        assert r[4] == ratio_text(j.ratio)
        assert float(r[5]) * j.ratio == pytest.approx(1.0, rel=6e-3)
        assert r[7].startswith(max(j.share, key=lambda name: j.share[name]))


def test_cases_of_which_the_same_is_said_share_a_row_and_diagnostic_ones_have_none(closed: ClosedLoop) -> None:
    same = replace(closed, cases=tuple(replace(closed.cases[0], id=i) for i in IDS))
    every = texts(next(tables(details(same).blocks)))
    assert {r[2] for r in every} == {"1, 2, 4b"}
    apart = in_role(with_judged(same, 1, ratio=7.0), "likely", "possible", "diagnostic")
    every = texts(next(tables(details(apart).blocks)))
    assert [r[2] for r in every] == ["1", "2"] * len(closed.cases[0].judged)


def test_what_would_help_is_told_of_what_is_violated_alone(closed: ClosedLoop) -> None:
    bad = replace(closed, cases=(closed.cases[0],))
    shares = {"thruster": 0.9, "stray": 0.095, "thermal": 0.005}
    one = replace(
        bad.cases[0].judged[0],
        passed=False,
        ratio=3.0,
        share=shares,
        silenced={"thruster": 0.9, "stray": 2.9, "thermal": 2.99},
        factor={"thruster": 0.3, "stray": np.nan, "thermal": np.inf},
        together=("thruster",),
    )
    met = [replace(j, passed=True, ratio=0.5) for j in bad.cases[0].judged[1:]]
    bad = replace(bad, cases=(replace(bad.cases[0], judged=(one, *met)),))
    help_table = list(tables(details(bad).blocks))[1]
    assert texts(help_table)[1:] == [
        ["thruster", "90.0 %", "0.900", "0.300"],
        ["stray", "9.5 %", "2.90", "cannot alone"],
    ]
    assert help_table.rows[0].kind == "head"


def test_groups_that_are_needed_together_have_a_row(closed: ClosedLoop) -> None:
    one = replace(
        closed.cases[0].judged[0],
        passed=False,
        ratio=3.0,
        share={"thruster": 0.9, "stray": 0.095, "thermal": 0.005},
        silenced={"thruster": 1.2, "stray": 2.9, "thermal": 2.99},
        factor={"thruster": np.nan, "stray": np.nan, "thermal": np.inf},
        together=("thruster", "stray"),
        together_factor=0.25,
        together_silenced=0.08,
    )
    bad = replace(closed, cases=(replace(closed.cases[0], judged=(one,)),))
    (rows,) = [texts(t) for t in tables(details(bad).blocks) if t.key == "loop groups"]
    assert rows[-1] == ["thruster and stray together", "99.5 %", "0.0800", "0.250"]


def test_margins_of_the_loops(closed: ClosedLoop) -> None:
    margins = list(tables(details(closed).blocks))[-1]
    rows = {r[0]: r for r in texts(margins) if len(r) > 1}
    assert set(rows) == {x.name for x in closed.stability.loops}
    for x in closed.stability.loops:
        assert float(rows[x.name][2]) == pytest.approx(x.phase_deg, abs=0.05)
    bare = [replace(x, family=AT_READ_OUTS, crossover_hz=np.nan, gain_db=np.inf) for x in closed.stability.loops]
    own = replace(closed, stability=replace(closed.stability, loops=tuple(bare)))
    found = texts(list(tables(details(own).blocks))[-1])
    assert found[0] == ["Broken at the read-outs"]
    assert {(r[1], r[3]) for r in found[1:]} == {("none", "any")}


def test_the_section_is_in_every_format_with_its_figures(copy: Project) -> None:
    sketch(copy)
    before = {path.name: path.read_bytes() for path in report(copy, None)}
    for ending in ("html", "md"):
        text, annex = before[f"report.{ending}"].decode(), before[f"report_annex.{ending}"].decode()
        assert "Evidence: closed loop" in text
        assert "lpf_jitter" in text
        assert "simulation4b.h5" in annex
    assert "(figures/loop_margins.svg)" in before["report_annex.md"].decode()
    assert "(figures/budget_delta_g_case01.svg)" in before["report.md"].decode()
    assert before["report.pdf"].startswith(b"%PDF")
    assert {path.name: path.read_bytes() for path in report(copy, None)} == before


def test_a_report_without_the_loop_says_so(copy: Project) -> None:
    (copy.build_dir / "dynamics.h5").unlink()
    sketch(copy)
    text = "".join(path.read_text(encoding="utf-8") for path in report(copy, None, ["md"]))
    assert "has not been run" in text
    assert "closed loop" not in text.lower()


def test_show_and_check_know_every_file_of_the_folder(finished: Project, closed: ClosedLoop) -> None:
    """`docs/explanation/dynamics.md` says that `show` lists the noise sources with where they are from."""
    shown = {path.name: show_dict(path) for path in sorted(finished.build_dir.glob("*.h5"))}
    assert {d["kind"] for d in shown.values()} >= {"dynamics", "simulation", "case"}
    assert all(d["main"] for d in shown.values())
    loop = shown["dynamics.h5"]["main"]
    assert loop["smallest_phase_margin_deg"] == min(x.phase_deg for x in closed.stability.loops)
    assert {name for name in loop if name.startswith("noise ")} == {
        f"noise {name}" for name in closed.cases[0].judged[0].source_share
    }
    assert "PRL 116, 231101 (2016)" in loop["noise optical_x1"]
    verdicts = shown["simulation01.h5"]["main"]
    assert set(verdicts) == {f"{output} {requirement}" for output, requirement in closed.pairs()}
    found = {c.path.name: (c.kind, c.problems) for c in check_folder(finished.build_dir)}
    assert found["dynamics.h5"] == ("dynamics", [])
    assert found["simulation4b.h5"] == ("simulation", [])


def test_check_finds_a_loop_and_simulations_stale(copy: Project) -> None:
    """What is made from a loop of another configuration is stale, though nothing else has changed."""
    file = copy.build_dir.parent / "dynamics.toml"
    file.write_text("[read_out]\nset = 'A'\n", encoding="utf-8")
    build_dynamics(replace(copy, dynamics=file), None)
    file.write_text("[read_out]\nset = 'B'\n", encoding="utf-8")
    found = {c.path.name: c.problems for c in check_folder(copy.build_dir)}
    assert [problem for problem in found["dynamics.h5"] if "dynamics.toml" in problem]
    assert [problem for problem in found["simulation01.h5"] if "dynamics.h5" in problem]
    assert found["case01.h5"] == []
