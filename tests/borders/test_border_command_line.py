"""What all commands have in common: options, the words in their help, JSON, completion, and readers that leave."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import typer
from border_tools import ROOT, SMALL, Project, tedm
from test_border_streams import shell

from tedm_cli.chain.graph import Named, Step, chain_of
from tedm_cli.cli.commands import command_line
from tedm_cli.cli.completion import STAGES
from tedm_cli.cli.headings import HEADINGS
from tedm_cli.cli.options import DEFAULT_TOP, METAVARS
from tedm_cli.cli.printing.chain import plan_dict
from tedm_cli.config.project import load_project
from tedm_cli.stages.chain.plan import Plan
from tedm_cli.stages.chain.project_files import chain_files

COMMANDS: dict[str, Any] = {name: c for name, c in command_line().commands.items() if not c.hidden}
RANKED = {
    "audit-mesh",
    "balance",
    "build-adjoint",
    "build-loads",
    "build-optics",
    "explain",
    "map-temperatures",
    "run-case",
    "show",
    "simulate-thermal",
    "suggest-areas",
}


def options(name: str) -> dict[str, Any]:
    return {word: p for p in COMMANDS[name].params for word in p.opts if word.startswith("-")}


def takes_value(parameter: Any) -> bool:
    return parameter.param_type_name == "argument" or not (parameter.is_flag or parameter.count)


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_says_its_results_in_every_way(name: str) -> None:
    found = options(name)
    for words in ({"--json"}, {"-q", "--quiet"}, {"-v", "--verbose"}):
        assert words <= found.keys(), f"{name} has no {words - found.keys()}"
    for word in ("--json", "-q", "-v", "-c", "-d", "--top", "--fail-on-violation"):
        if word in found:  # the same words everywhere: they are defined once
            first = next(options(other)[word] for other in COMMANDS if word in options(other))
            assert (found[word].help, found[word].opts) == (first.help, first.opts)


@pytest.mark.parametrize("name", COMMANDS)
def test_values_have_one_word_each(name: str) -> None:
    for parameter in COMMANDS[name].params:
        if takes_value(parameter):
            choice = parameter.type_descriptor.is_choice
            assert choice or parameter.metavar in METAVARS, f"{name} {parameter.opts}: {parameter.metavar}"


def test_no_word_of_the_table_is_idle_and_an_option_has_one() -> None:
    used: dict[str, set[str]] = {}
    for command in COMMANDS.values():
        for parameter in command.params:
            if takes_value(parameter) and not parameter.type_descriptor.is_choice:
                used.setdefault(parameter.opts[-1], set()).add(parameter.metavar)
    assert set().union(*used.values()) == METAVARS.keys()
    assert {word for word, metavars in used.items() if len(metavars) > 1} == {"--output"}  # a file or a folder


def test_the_document_has_the_words() -> None:
    text = (ROOT / "docs" / "reference" / "command-line.md").read_text(encoding="utf-8")
    told = re.findall(r"`([A-Z]+)`", "\n".join(re.findall(r"(?m)^\| (`[A-Z]+`(?:, `[A-Z]+`)*) \|", text)))
    assert sorted(told) == sorted(METAVARS)
    assert all(f"`{name}`" in text for name in RANKED)


def test_top_is_where_tables_are_ranked() -> None:
    assert {name for name in COMMANDS if "--top" in options(name)} == RANKED
    assert {options(name)["--top"].default for name in RANKED} == {DEFAULT_TOP}


@pytest.mark.parametrize("name", ["", *COMMANDS])
def test_help_is_short_to_ask_for_and_wraps_well(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    words = [name] if name else []
    said = tedm(*words, "-h").ok().out
    assert said == tedm(*words, "--help").ok().out
    for line in said.splitlines():
        assert len(line) <= 80
        assert not re.search(r"\w-$", line), f"a word is torn: {line}"
        assert "<str>" not in line
        assert "<path>" not in line
    if not name:
        assert "..." not in re.sub(r"\[.*?\]\.\.\.|\[ARGS\]\.\.\.", "", said), "a line of the list is cut off"


def strict(text: str) -> Any:
    def refuse(word: str) -> None:
        raise AssertionError(f"{word} is no JSON")

    return json.loads(text, parse_constant=refuse)


JSON = [
    ("areas", []),
    ("write-deck", ["-o", "x.bdf"]),
    ("ingest", ["-o", "x.h5"]),
    ("build-distortion", ["-o", "x.h5"]),
    ("build-sensitivity", ["-o", "x.h5"]),
    ("self-gravity", ["--points", "points.csv", "--per-source"]),
    ("check-layout", []),
    ("build-optics", ["-o", "x.h5"]),
    ("build-adjoint", ["-o", "x.h5"]),
    ("explain", ["TM1_a_x"]),
    ("run-case", ["3", "-o", "x.h5"]),
    ("build-dynamics", ["-o", "x.h5"]),
    ("export", ["optics", "-o", "out"]),
    ("export-case", ["-o", "out"]),
    ("export-state-space", ["3", "-o", "out"]),
    ("export-extremal", ["3", "-o", "out"]),
    ("export-vtu", ["-o", "x.vtu"]),
    ("check", []),
    ("show", ["build/sensitivity.h5"]),
    ("show", ["build/case03.h5"]),
    ("run", ["-n"]),
]
NO_PROJECT = {"show"}
NO_CONFIG = {"check", "export", "export-case", "export-extremal", "export-vtu"}


@pytest.fixture(scope="module")
def built(chain: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    project = chain.copy(tmp_path_factory.mktemp("json") / "small")
    shutil.copy(SMALL / "ltp_small.bdf", project.folder)
    (project.folder / "points.csv").write_text("x_m,y_m,z_m,mass_kg\n0.3,0,0,1\n0,0.4,0,2\n")
    return project


@pytest.mark.parametrize(("name", "arguments"), JSON, ids=[" ".join((n, *a[:1])) for n, a in JSON])
def test_json_is_json(built: Project, name: str, arguments: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing but JSON on standard output, without NaN, and with -v the same and something on standard error."""
    monkeypatch.chdir(built.folder)
    project = [] if name in NO_PROJECT else ["-d", "build"]
    project = [*project, *([] if name in NO_PROJECT | NO_CONFIG else ["-c", "tedm.toml"])]
    if name == "self-gravity":
        project = ["-c", "tedm.toml"]
    done = tedm(name, *arguments, *project, "--json", "-v").ok()
    found = strict(done.out)
    assert found
    assert done.err
    if isinstance(found, dict) and "file" in found:
        assert Path(found["file"]).exists()


def test_what_is_written_for_a_program(
    built: Project, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """plot, report, view and init say their files; what draws is not run for it."""
    monkeypatch.chdir(built.folder)
    page = built.folder / "page.html"
    page.write_text("12345")
    monkeypatch.setattr("tedm_cli.stages.reporting.plot.plot", lambda *_: [page])
    monkeypatch.setattr("tedm_cli.stages.reporting.report.report", lambda *_: [page])
    for name in ("plot", "report"):
        assert strict(built.run(name, "--json").ok().out) == {"files": [{"file": str(page), "bytes": 5}]}
    begun = strict(tedm("init", built.folder / "new", "--json").ok().out)
    assert begun["from"] == "minimal"
    assert all(Path(file).is_file() for file in begun["files"])


def test_the_chain_for_a_program(built: Project) -> None:
    """What would be run has no exit code; what was run has that of each command."""
    found = strict(built.run("run", "build-optics", "-n", "--json").ok().out)
    assert not found["up_to_date"]
    assert {step["command"][0] for step in found["stale"]} <= {"ingest", "build-distortion", "build-optics"}
    assert all(step["why"] and step["exit_code"] is None for step in found["stale"])
    step = Step(("plot",), (Path("build/figures.stamp"),), ())
    for code in (0, 4):
        found = plan_dict("x", Plan((step,), {step: ("it is not there",)}, {}), Path("build"), {step: code})
        assert (found["up_to_date"], found["stale"][0]["exit_code"]) == (code == 0, code)


def test_names_of_the_project_are_completed(chain: Project, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """From its text files: nothing is said where there are none, or where they are broken."""
    monkeypatch.setenv("_TEDM_COMPLETE", "complete_bash")

    def complete(line: str, folder: Path) -> list[str]:
        monkeypatch.chdir(folder)
        monkeypatch.setenv("COMP_WORDS", line)
        monkeypatch.setenv("COMP_CWORD", str(line.count(" ")))
        done = tedm().ok()
        assert done.err == ""
        return done.out.split()

    folder = chain.folder
    assert complete("tedm build-o", folder) == ["build-optics"]
    assert {"3", "4b", "all"} <= set(complete("tedm run-case ", folder))
    assert complete("tedm explain TM2_omegadot_", folder) == [f"TM2_omegadot_{axis}" for axis in "xyz"]
    assert {"A_TM1_x", "B_TM2_eta", "lpf_readout_item"} <= set(complete("tedm explain ", folder))
    assert "IS1_EH_UP" in complete("tedm plot --area IS1_", folder)
    assert "build/case03.h5" in complete("tedm show build/c", folder)
    assert complete("tedm explain TM1_x --set ", folder) == ["A", "B"]
    assert complete("tedm run-case ", tmp_path) == []
    (tmp_path / "tedm.toml").write_text('title = "x"\ncases = "cases.toml"\n')
    (tmp_path / "cases.toml").write_text("[[case\n")
    assert complete("tedm run-case ", tmp_path) == []


def test_completion_can_be_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    # Typer looks for the shell among the processes above, where a run of tests in the background has none.
    monkeypatch.setenv("_TYPER_COMPLETE_TEST_DISABLE_SHELL_DETECTION", "1")
    done = shell('"$@"', "--show-completion", "bash")
    assert done.returncode == 0, done.stderr
    assert "complete -o default -F _tedm_completion tedm" in done.stdout


COMPLETED = "import sys; from tedm_cli.cli import completion; print([m for m in ('numpy', 'h5py') if m in sys.modules])"


def test_completion_reads_with_nothing_heavy() -> None:
    done = subprocess.run([sys.executable, "-c", COMPLETED], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_reader_who_leaves_keeps_no_work_from_being_done(chain: Project, tmp_path: Path) -> None:
    """What is printed is dropped; the file is whole, and the code is that of the command."""
    project = ["-c", chain.folder / "tedm.toml", "-d", chain.build]
    done = shell('"$@" | true', "run-case", "3", "-v", "--fail-on-violation", *project, "-o", tmp_path / "c.h5")
    assert done.returncode == 5
    assert done.stderr.splitlines()[1:] == ["error: requirements are violated in case 3"]
    done = shell('"$@" | head -1', "show", tmp_path / "c.h5")
    assert (done.returncode, done.stderr) == (0, "")
    assert re.fullmatch(r".*c\.h5: FAIL, 2 of 6 verdicts violated; worst: .*\n", done.stdout)


def test_every_command_stands_under_one_heading(monkeypatch: pytest.MonkeyPatch) -> None:
    """In `tedm --help`, each with all that it says of itself in one line, and in the page of the commands."""
    assert sorted(name for names in HEADINGS.values() for name in names) == sorted(COMMANDS)
    monkeypatch.setenv("COLUMNS", "80")
    sections = dict(re.findall(r"(?m)^(\w[^\n:]*):\n((?:  .*\n)+)", tedm("--help").ok().out))
    assert [heading for heading in sections if heading != "Options"] == list(HEADINGS)
    for heading, names in HEADINGS.items():
        listed = [line.split(maxsplit=1) for line in sections[heading].splitlines()]
        assert listed == [[name, " ".join(COMMANDS[name].help.split("\n\n")[0].split())] for name in names]


def test_a_command_without_a_heading_is_listed_all_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(HEADINGS, "Exports", ())
    assert re.search(r"(?m)^Others:\n  export  ", tedm("--help").ok().out)


def test_the_stages_are_told_in_the_order_of_the_chain(chain: Project) -> None:
    """`tedm run --help`, and what the shell completes after `tedm run`."""
    said = re.search(r"The stages, in order: (.*?)\.", " ".join(COMMANDS["run"].help.split()))
    assert said is not None
    assert tuple(said[1].split(", ")) == STAGES
    files = chain_files(load_project(chain.folder / "tedm.toml", chain.build))
    one = (Named("3", Path("run.h5")),)
    whole = replace(
        files,
        solved_here=True,
        loop=Path("dynamics.h5"),
        network=Path("thermal.h5"),
        other_loads=Path("loads.h5"),
        runs=one,
        series=one,
        simulations=one,
    )
    assert tuple(dict.fromkeys(step.stage for step in chain_of(whole))) == STAGES


EXAMPLES = [
    (name, line.split(maxsplit=1)[1])
    for name, command in COMMANDS.items()
    for line in (command.epilog or "").splitlines()
    if line.startswith("  tedm ")
]


@pytest.mark.parametrize(("name", "typed"), EXAMPLES, ids=[typed for _, typed in EXAMPLES])
def test_examples_are_what_a_command_takes(
    name: str, typed: str, chain: Project, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Their options, choices and numbers of arguments; and help and page show them as they are typed."""
    monkeypatch.chdir(chain.folder)
    first, *words = shlex.split(typed)
    assert first == name
    root = typer.Context(command_line(), info_name="tedm", **command_line().context_settings)
    COMMANDS[name].make_context(name, list(words), parent=root)  # an error where it does not take them
    assert f"\n    tedm {typed}\n" in tedm(name, "--help").ok().out
    assert f"\n    tedm {typed}\n" in (ROOT / "docs" / "reference" / "commands.md").read_text(encoding="utf-8")


def test_the_most_used_commands_have_examples() -> None:
    assert {"init", "run", "explain", "run-case", "simulate", "report", "export"} <= {name for name, _ in EXAMPLES}
