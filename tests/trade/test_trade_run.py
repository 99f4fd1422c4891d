"""tedm trade: chains of variants side by side, what is run again, what fails, what is written, exit codes."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from border_tools import heed_interrupts, replace, snapshot, tedm
from trade_project import VARIANTS, Bricks

from tedm_cli.chain.graph import Step
from tedm_cli.config.project import load_project
from tedm_cli.contracts import CASE, LOADS, TRADE
from tedm_cli.files.store import open_checked
from tedm_cli.progress import silent
from tedm_cli.results.loads import read_loads
from tedm_cli.results.trade import Cell, read_trade
from tedm_cli.stages.chain.perform import Chain, Way, perform
from tedm_cli.stages.chain.plan import Plan, plan_chain
from tedm_cli.stages.chain.workers import Answer, Job

STEPS = ["ingest", "build-distortion", "build-sensitivity", "run-case 1"]


def begun(out: str) -> dict[str, list[str]]:
    """The steps that were begun, by variant."""
    found: dict[str, list[str]] = {}
    for name, step in re.findall(r"(?m)^(\w+): \[ *\d+/\d+\] ([^:]+):", out):
        found.setdefault(name, []).append(step)
    return found


def cells(bricks: Bricks) -> dict[str, dict[str, Cell]]:
    with open_checked(bricks.out / "trade.h5", TRADE) as file:
        trade = read_trade(file)
    names = [c.name for c in trade.criteria]
    return {v.name: dict(zip(names, row, strict=True)) for v, row in zip(trade.variants, trade.cells, strict=True)}


pytestmark = pytest.mark.usefixtures("in_this_process")


def test_values_are_those_of_the_variants(traded: Bricks) -> None:
    found = cells(traded)
    for name in ("base", "quiet", "away"):
        with open_checked(traded.variant(name) / "case01.h5", CASE) as file:
            ratio = float(file.array(CASE.VERDICT_RATIO)[0])
            share = file.array(CASE.CONTRIBUTION_SHARE)[file.strings(CASE.OUTPUT_LABEL).index("TM1_a_x")]
        cell = found[name]["noise"]
        assert cell.value == ratio
        assert cell.of.startswith("TM1_a_x, case 1, ")
        assert cell.passed == (ratio <= 1.0)
        assert cell.parts == pytest.approx({"LEFT": share[0] * ratio**2, "RIGHT": share[1] * ratio**2})
        assert sum(cell.parts.values()) == pytest.approx(ratio**2)
        assert found[name]["read-out"] == Cell(None, found[name]["read-out"].reason)
        assert found[name]["read-out"].reason.startswith("has no A_TM1_x (the project has no optics")
    values = {name: row["noise"].value or 0.0 for name, row in found.items()}
    assert values["quiet"] == pytest.approx(values["base"] / 10)
    assert values["away"] < values["base"]
    assert [row["mass"].value for row in found.values()] == pytest.approx([2700 * 0.2 * 0.1 * 0.1] * 3)


def test_only_what_the_criteria_need_is_run(traded: Bricks) -> None:
    for name in ("base", "quiet", "away"):
        made = {path.name for path in traded.variant(name).iterdir()}
        assert {"unit_loads.h5", "distortion.h5", "sensitivity.h5", "case01.h5"} <= made
        assert not made & {"case02.h5", "figures", "report.html"}
    assert {p.name for p in traded.out.iterdir()} == {
        *("variants", "figures", "trade.h5", "trade.html", "trade.pdf", "trade.md")
    }


def test_a_second_run_runs_nothing_and_writes_the_same(done: Bricks) -> None:
    done.run("-j", "2").ok()  # elsewhere than before: only what says so is written anew
    before = snapshot(done.out)
    outcome = done.run("-j", "2").ok()
    assert begun(outcome.out) == {}
    assert [f"{name}: up to date" in outcome.out for name in ("base", "quiet", "away")] == [True] * 3
    assert snapshot(done.out) == before
    tedm("check", "-d", done.out).ok()


def test_only_the_variant_that_has_changed_is_run_again(done: Bricks) -> None:
    replace(done.file, '"cases.temperature.inside_K" = 1e-5', '"cases.temperature.inside_K" = 1e-6')
    assert begun(done.run().ok().out) == {"quiet": ["run-case 1"]}
    replace(done.folder / "bricks" / "cases.toml", 'role = "likely"\n', "")
    assert begun(done.run().ok().out) == {name: ["run-case 1", "run-case 2"] for name in ("base", "quiet", "away")}
    assert cells(done)["base"]["noise"].value is not None


def test_a_variant_that_fails_does_not_keep_the_others(bricks: Bricks) -> None:
    """One whose results are no results, one whose configuration cannot be read; each says why, and the code is of the
    first."""
    broken = bricks.copy(bricks.folder / "broken").folder / "bricks"
    (broken / "cases.toml").write_text("safety_factor = 2\n[frequency\n", encoding="utf-8")
    more = '[[variant]]\nname = "no_results"\nproject = "bricks"\nset = { "model.model.op2" = ["model.bdf"] }\n'
    more += '[[variant]]\nname = "broken"\nproject = "broken/bricks"\n'
    base = VARIANTS.partition('[[variant]]\nname = "quiet"')[0]
    outcome = bricks.write(base + more).run()
    assert outcome.code == 4
    told = [line for line in outcome.err.splitlines() if line.startswith("error: variant ")]
    assert [line.split()[2] for line in told] == ["broken:", "no_results:"]
    assert "model.bdf" in told[1]
    assert "cases.toml" in told[0]
    assert "Pareto front: base" in outcome.out
    assert "no_results: failed: " in outcome.out
    found = cells(bricks)
    assert found["base"]["noise"].value is not None
    assert {cell.reason for name in ("no_results", "broken") for cell in found[name].values()} == {"its chain failed"}
    page = (bricks.out / "trade.md").read_text(encoding="utf-8")
    assert "### Without results" in page
    assert "model.bdf" in page


def test_a_refused_step_stops_its_own_chain_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also what could begin without it; two at once, of which the other is let end."""

    class Refusing:
        def __init__(self, program: object, number: int, *, alone: bool) -> None:
            self.number, self.jobs = number, list[Job]()

        def __enter__(self) -> Refusing:
            return self

        def __exit__(self, *_: object) -> None:
            assert self.jobs == []

        has_room = property(lambda self: len(self.jobs) < self.number)
        are_busy = property(lambda self: bool(self.jobs))

        def begin(self, job: Job, options: object) -> None:
            self.jobs.append(job)

        def wait(self) -> tuple[Job, Answer]:
            job = self.jobs.pop(0)
            return job, Answer(4 if (job.chain, job.command) == (0, ("a",)) else 0, "", "")

    monkeypatch.setattr("tedm_cli.stages.chain.perform.Workers", Refusing)
    steps = [Step((name,), (Path(name),), ()) for name in ("a", "b", "c")]
    chain = Chain(Plan(tuple(steps), dict.fromkeys(steps, ("new",)), {}), ())
    begun: list[tuple[int, str]] = []
    found = perform([chain, chain], Way((), None, 2), lambda n, s: begun.append((n, s.words)), lambda *_: None, silent)
    assert [answer.code if answer else 0 for answer in found] == [4, 0]
    assert begun == [(0, "a"), (0, "b"), (1, "a"), (1, "b"), (1, "c")]


def test_a_case_that_one_variant_lacks(bricks: Bricks) -> None:
    """Its cell is empty, and says why; it does not dominate the other by that, nor is it dominated."""
    cases = '{ id = "1", title = "alone", blocks = [{ areas = ["*"] }] }'
    other = f'[[variant]]\nname = "other"\nproject = "bricks"\nset = {{ "cases.case" = [{cases}] }}\n'
    base = VARIANTS.partition('[[variant]]\nname = "quiet"')[0]
    criteria = "".join(f'[[criterion]]\nname = "case {i}"\nkind = "noise_ratio"\ncase = "{i}"\n' for i in ("1", "2"))
    outcome = bricks.write(base + other, criteria).run("-v").ok()
    assert "other, case 2: has no case 2" in outcome.out
    assert "Pareto front: base, other" in outcome.out
    assert begun(outcome.out)["other"] == STEPS
    found = cells(bricks)
    assert found["other"]["case 2"] == Cell(None, "has no case 2")
    assert found["other"]["case 1"].value == found["base"]["case 1"].value
    assert "| other | case 2 | has no case 2 |" in (bricks.out / "trade.md").read_text(encoding="utf-8")


def test_no_variant_with_results(bricks: Bricks) -> None:
    (bricks.folder / "bricks" / "model.toml").unlink()
    outcome = bricks.run()
    assert outcome.code == 4
    assert "Pareto front: no variant can be compared" in outcome.out
    assert "none can be compared" in (bricks.out / "trade.md").read_text(encoding="utf-8")
    tedm("show", bricks.out / "trade.h5").ok()


def test_best_for_scripts(done: Bricks) -> None:
    done.run("--best", "quiet").ok()
    outcome = done.run("--best", "base")
    outcome.refused(5, "trade.h5: base is not on the Pareto front", hint="it is dominated by quiet")
    done.run("--best", "base", "--by", "mass").ok()
    done.run("--best", "base", "--by", "noise").refused(5, "base is not the best by 'noise'", hint="the best is quiet")
    done.run("--best", "base", "--by", "read-out").refused(5, "not the best by 'read-out'", hint="no variant has it")
    done.run("--best", "bas").refused(2, "no variant is called 'bas'", hint="did you mean base?")
    done.run("--best", "base", "--by", "nois").refused(2, "no criterion is called 'nois'", hint="did you mean noise?")
    done.run("--by", "noise").refused(2, "--by says by what a variant is to be the best")


def test_json_and_show(done: Bricks) -> None:
    found = json.loads(done.run("--json").ok().out)
    assert found["front"] == ["quiet", "away"] or found["front"] == ["quiet"]
    (base,) = [v for v in found["variants"] if v["name"] == "base"]
    assert base["values"]["read-out"]["value"] is None
    assert base["values"]["noise"]["value"] == cells(done)["base"]["noise"].value
    assert base["dominated_by"]
    shown = tedm("show", done.out / "trade.h5").ok().out
    assert "pareto_front: quiet" in shown
    assert re.search(r"(?m)^variant base: front [23]: noise .*; mass 5.4 kg$", shown)


def test_the_model_of_a_variant_may_be_made_by_a_program(bricks: Bricks) -> None:
    """Once; and again when the program, what it is told, or what it makes has changed. One that fails says why."""
    script = bricks.folder / "model.py"
    script.write_text(
        "import pathlib, shutil, sys\n"
        "if sys.argv[1] == 'none': sys.exit('there is no such mount')\n"
        "for name in ('model.bdf', 'areas.csv', 'unit_loads.bdf', 'unit_loads.op2'):\n"
        "    shutil.copy(pathlib.Path('bricks', name), pathlib.Path(sys.argv[2]).with_name(name))\n"
        "print(open('calls.txt', 'a').write('x'))\n"
    )
    names = '"model.model.bdf" = "{build_dir}/model.bdf", "model.model.areas_csv" = "{build_dir}/areas.csv"'
    solved = '"model.model.deck" = "{build_dir}/unit_loads.bdf", "model.model.op2" = ["{build_dir}/unit_loads.op2"]'
    text = "".join(
        f'[[variant]]\nname = "{mount}"\nproject = "bricks"\nset = {{ {names}, {solved} }}\n'
        f'script = {{ file = "model.py", arguments = ["{mount}", "{{build_dir}}/model.bdf"] }}\n'
        for mount in ("clamped", "none")
    )
    bricks.write(text)
    calls = bricks.folder / "calls.txt"
    outcome = bricks.run("-q")
    assert outcome.code == 4
    assert "variant clamped: model.py cannot make the model: nothing that a file names is run unless" in outcome.err
    assert not calls.exists()
    outcome = bricks.run("-q", "--scripts")
    assert outcome.code == 4
    assert "variant none: model.py cannot make the model: there is no such mount" in outcome.err
    assert calls.read_text() == "x"
    assert cells(bricks)["clamped"]["noise"].value is not None
    bricks.run("-q")
    assert cells(bricks)["clamped"]["noise"].value is not None, "it is made, and nothing has to run"
    script.write_text(script.read_text() + "# changed\n")
    bricks.run("-q")
    assert cells(bricks)["clamped"]["noise"].value is None
    bricks.run("-q", "--scripts")
    assert calls.read_text() == "xx"
    (bricks.variant("clamped") / "model.bdf").rename(bricks.variant("clamped") / "kept.bdf")
    bricks.run("-q", "--scripts")
    assert calls.read_text() == "xxx"


def test_killed_and_run_again(bricks: Bricks) -> None:
    """Two real processes, by a signal that leaves no time: what was made is kept, and only the rest is run."""
    command = [sys.executable, "-m", "tedm_cli.cli", "trade", str(bricks.file), "-d", str(bricks.out.parent), "-j", "2"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, start_new_session=True)
    assert process.stdout is not None
    told = ""
    while "build-distortion" not in told:
        told += process.stdout.readline()
    assert {"base", "quiet"} <= set(begun(told)), "side by side"
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate(timeout=60)
    assert not (bricks.out / "trade.h5").exists()
    outcome = bricks.run().ok()
    assert sum(map(len, begun(outcome.out).values())) < 3 * len(STEPS)
    assert all(row["noise"].value is not None for row in cells(bricks).values())
    assert not [path for path in bricks.out.rglob(".*.tmp")]


def test_an_interrupt_ends_all(bricks: Bricks) -> None:
    command = [sys.executable, "-m", "tedm_cli.cli", "trade", str(bricks.file), "-d", str(bricks.out.parent)]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=heed_interrupts
    ) as process:
        assert process.stdout is not None
        while "ingest" not in process.stdout.readline():
            pass
        time.sleep(0.2)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
    assert process.returncode == 130
    assert said == "error: interrupted; finished files are kept, the unfinished one is removed\n"


def test_the_folder_is_that_of_the_project(bricks: Bricks, monkeypatch: pytest.MonkeyPatch) -> None:
    project = bricks.folder / "bricks"
    variant, criterion = '[[variant]]\nname = "base"\nproject = "."\n', '[[criterion]]\nname = "mass"\nkind = "mass"\n'
    (project / "variants.toml").write_text(variant + criterion, encoding="utf-8")
    (project / "below").mkdir()
    monkeypatch.chdir(project / "below")
    assert begun(tedm("trade", "../variants.toml").ok().out) == {"base": ["ingest"]}, "a mass needs no more"
    assert (project / "build" / "trade" / "trade.html").is_file()


LOADS_TOML = '[[foot]]\nname = "FOOT"\neach_support = true\n[modes]\nnumber = 2\n'
OF_LOADS = """
[[criterion]]
name = "frequency"
kind = "first_frequency"

[[criterion]]
name = "pull"
kind = "transmission"
outputs = ["TM1_a_x"]
feet = ["FOOT_2", "FOOT_3"]

[[criterion]]
name = "bench"
kind = "transmission"

[[criterion]]
name = "no foot"
kind = "transmission"
outputs = ["TM1_a_x"]
feet = ["FOOT_9"]

[[criterion]]
name = "turned"
kind = "transmission"
outputs = ["TM1_a_x"]
motion = "rotation"
"""


def test_criteria_of_other_loads_run_build_loads_and_a_foot_that_is_not_there_fails_alone(bricks: Bricks) -> None:
    """One file of loads by what is held, one by a grid that no deck has; and a project without loads."""
    project = bricks.folder / "bricks"
    (project / "loads.toml").write_text(LOADS_TOML, encoding="utf-8")
    strange = LOADS_TOML.replace("each_support = true", "grid = 77")
    (project / "strange.toml").write_text(strange, encoding="utf-8")
    variants = "".join(
        f'[[variant]]\nname = "{name}"\nproject = "bricks"\n'
        + (f'set = {{ "project.loads" = "{file}" }}\n' if file else "")
        for name, file in (("base", "loads.toml"), ("strange", "strange.toml"), ("without", ""))
    )
    outcome = bricks.write(variants, OF_LOADS).run()
    assert outcome.code == 3
    assert begun(outcome.out)["base"] == ["ingest", "build-distortion", "build-sensitivity", "build-loads"]
    assert "error: variant strange: " in outcome.err
    assert "the deck has no grid 77; it holds 1, 2, 3, 4" in outcome.err
    found = cells(bricks)
    with open_checked(bricks.variant("base") / "loads.h5", LOADS) as file:
        loads = read_loads(file)
    row = loads.label.index("TM1_a_x")
    pulls = {
        f"TM1_a_x, {name}": abs(loads.by_distortion[row, k])
        for k, name in enumerate(loads.name)
        if loads.foot[k] in ("FOOT_2", "FOOT_3") and loads.unit[k] == "m"
    }
    assert len(pulls) == 6
    base = found["base"]
    assert loads.modes is not None
    assert base["frequency"].value == loads.modes.frequency_hz[0]
    assert base["pull"].value == max(pulls.values()) == pulls[base["pull"].of]
    assert base["bench"].reason.startswith("has no optical bench")
    assert base["no foot"].reason == "has no foot FOOT_9"
    assert base["turned"].reason == "has no rotation of a foot among its loads"
    assert {cell.reason for cell in found["strange"].values()} == {"its chain failed"}
    assert found["without"]["frequency"].reason.startswith("the project has no loads but temperatures")


def test_other_loads_run_only_where_they_are_asked_for(bricks: Bricks) -> None:
    project = bricks.folder / "bricks"
    (project / "loads.toml").write_text(LOADS_TOML, encoding="utf-8")
    (project / "tedm.toml").write_text('title = "two bricks"\nloads = "loads.toml"\n', encoding="utf-8")
    opened = load_project(project / "tedm.toml", bricks.folder / "build")
    assert "build-loads" not in [step.stage for step in plan_chain(opened, None).steps]
    asked = [step.stage for step in plan_chain(opened, "build-loads").steps]
    assert asked == ["ingest", "build-distortion", "build-sensitivity", "build-loads"]
