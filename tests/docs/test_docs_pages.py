"""What the documents show is what happens: commands exist, sessions print what stands there, TOML is configuration."""

from __future__ import annotations

import re
import shlex
import tomllib
from pathlib import Path
from typing import Any

import pytest
from pages import ROOT, Block, Shown, blocks, command_lines, options_in_words, pages, session
from pages_run import agrees, begin, build_sample, changed, pages_with_sessions, read, told_anew
from shared_folder import shared

from tedm_cli.cli.commands import command_line
from tedm_cli.config.balance import BalanceConfig
from tedm_cli.config.base import validate
from tedm_cli.config.cases import CasesConfig
from tedm_cli.config.dynamics.loop import DynamicsConfig
from tedm_cli.config.imported import LawTable, SensitivityTable
from tedm_cli.config.loads import LoadsConfig
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.optics.tables import OpticsTables
from tedm_cli.config.project import ProjectTable
from tedm_cli.config.thermal.file import ThermalConfig
from tedm_cli.config.trade import TradeConfig
from tedm_cli.errors import ConfigError

#: Python that other tests run.
PYTHON_ELSEWHERE = {
    "README.md": "chain/test_chain_library_docs.py",
    "docs/reference/library.md": "chain/test_chain_library_docs.py",
    "docs/how-to/export.md": "borders/test_border_export_case.py",
}
OTHER_OPTIONS = {"--help"}  # of every command, and among the parameters of none
COMMANDS = command_line().commands
MINIMAL = ROOT / "sample_models" / "minimal"


# --- commands ---------------------------------------------------------------------------------------------------------


def objection(line: str) -> str:
    """What the command line says to these words, before any command runs; "" where it takes them."""
    words = shlex.split(line)
    if re.fullmatch("--(install|show)-completion", words[-1]):  # Typer's own, which acts at once, on the user's shell
        return "" if len(words) == 2 else "completion is of the whole program"
    try:
        command_line()(words[1:], prog_name="tedm", standalone_mode=False)
    except Exception as error:  # of Typer's own kinds, which differ between its versions
        told = getattr(error, "format_message", None)
        return str(told() if told else error)
    return ""


@pytest.fixture
def idle(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Commands do nothing, in a folder that is a project."""
    (tmp_path / "tedm.toml").touch()
    monkeypatch.chdir(tmp_path)
    for command in COMMANDS.values():
        monkeypatch.setattr(command, "callback", lambda **given: None)


# A synopsis is no command line, and docs/reference/commands.md is printed from the command line itself.
@pytest.mark.parametrize("page", [page for page in pages() if page != "docs/reference/commands.md"])
@pytest.mark.usefixtures("idle")
def test_commands_are_such(page: str) -> None:
    """Of every command its name, options and the kinds of their values; in a block also what it cannot do without."""
    wrong = []
    for where, line, is_whole in command_lines(page):
        fact = objection(line)
        if fact and (is_whole or not re.search("^Missing |requires an argument", fact)):
            wrong.append(f"{where}: `{line}`: {fact}")
    assert not wrong, "\n".join(wrong)


def test_commands_are_found() -> None:
    """Where they stand: behind $, in blocks, in words and tables, over the end of a line."""
    lines = [line for page in pages() for _, line, _ in command_lines(page)]
    over_the_end = "tedm simulate --problem FILE.json --json"
    assert {"tedm run-case 3", over_the_end, "tedm explain B_TM2_eta --distortion --top 5 --json"} <= set(lines)
    assert len(lines) > 130


@pytest.mark.parametrize("page", pages())
def test_options_named_alone_exist(page: str) -> None:
    known = {option for command in COMMANDS.values() for p in command.params for option in p.opts}
    assert [(where, o) for where, o in options_in_words(page) if o not in known | OTHER_OPTIONS] == []


@pytest.mark.parametrize(
    ("line", "fact"),
    [
        ("tedm runcase 3", "runcase"),
        ("tedm run-case 3 --fail", "--fail"),
        ("tedm plot --format gif", "gif"),
        ("tedm explain TM1_x --top many", "valid integer"),
        ("tedm check all", "all"),
        ("tedm export-case --formt mat", "--formt"),
        ("tedm show", "Missing"),
    ],
)
@pytest.mark.usefixtures("idle")
def test_a_wrong_command_is_seen(line: str, fact: str) -> None:
    assert fact in objection(line)


# --- sessions ---------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def sample(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return shared(tmp_path_factory, "docs_sample", build_sample)


@pytest.mark.slow
@pytest.mark.parametrize("page", pages_with_sessions())
def test_a_session_prints_what_stands_there(page: str, sample: Path, tmp_path: Path) -> None:
    differences = read(page, begin(page, sample, tmp_path / "page"))
    assert not differences, "python tests/docs/pages_run.py --update\n" + "\n".join(map(str, differences))


def test_lines_left_out() -> None:
    printed = ["a", "b", "solved in 0.3 s", "c 1e-13", "d"]
    assert agrees(("a", "...", "d"), printed)
    assert agrees(("a", "b", "solved ... 12.1 s", "c ...", "d"), printed)
    assert agrees(("...",), [])
    assert not agrees(("a", "d"), printed)
    assert not agrees(("a", "...", "c"), printed)
    assert not agrees(("a", "b", "solved in 12.1 m", "c ...", "d"), printed)
    assert not agrees((), printed)


def test_what_is_left_out_stays_so_when_a_page_is_made_anew() -> None:
    expected = ("head 1", "...", "area STRUT 5 %", "...", "total ...")
    printed = ["head 2", "x", "area BENCH 4 %", "area STRUT 6 %", "y", "total 9"]
    assert told_anew(expected, printed) == ["head 2", "...", "area STRUT 6 %", "...", "total ..."]
    assert told_anew(("old",), ["new", "lines"]) == ["new", "lines"]


def test_a_file_is_changed_as_shown() -> None:
    def shown(*lines: str) -> Block:
        return Block("page.md", 1, "", "diff", "file", lines)

    assert changed("a\nb\nc\n", shown("-b", "+B", "+B2", "-c", "+C")) == "a\nB\nB2\nC\n"
    assert changed("a\n", shown("+b")) == "a\nb\n"
    with pytest.raises(AssertionError, match="0 times"):
        changed("a\n", shown("-b", "+c"))


def test_a_part_of_a_file_is_none_to_be_written() -> None:
    def kind(language: str, *lines: str) -> str:
        return Block("page.md", 1, "", language, "file", lines).kind

    assert kind("markdown", "...", "a") == kind("text", "a", "...") == "part"
    assert kind("text", "a") == kind("python", "def a():", "...") == "file"
    assert kind("diff", "+a") == "change"


def test_a_session_is_read() -> None:
    block = Block("page.md", 7, "    ", "", "", ("$ one", "out", "$ two \\", "  more", "a", "b"))
    assert session(block) == [Shown("one", 8, ("out",)), Shown("two \\\n  more", 11, ("a", "b"))]


# --- TOML and Python --------------------------------------------------------------------------------------------------


TOML = [block for page in pages() for block in blocks(page) if block.is_toml]
WHOLE: list[tuple[type[Any], Path]] = [
    (ModelConfig, ROOT / "configs" / "model.toml"),
    (CasesConfig, MINIMAL / "cases.toml"),
    (OpticsTables, ROOT / "configs" / "optics.toml"),
    (ProjectTable, MINIMAL / "tedm.toml"),
    (DynamicsConfig, ROOT / "configs" / "dynamics.toml"),
    (TradeConfig, ROOT / "configs" / "trade" / "variants.toml"),
    (LoadsConfig, ROOT / "configs" / "loads.toml"),
    (ThermalConfig, ROOT / "tests" / "docs" / "thermal.toml"),
    (BalanceConfig, ROOT / "configs" / "balance.toml"),
]


def put_into(whole: dict[str, Any], piece: dict[str, Any]) -> dict[str, Any]:
    """A configuration with a piece of a page in it: tables are joined, all else is that of the piece."""
    joined = dict(whole)
    for key, value in piece.items():
        both = isinstance(value, dict) and isinstance(joined.get(key), dict)
        joined[key] = put_into(joined[key], value) if both else value
    return joined


def problems_of(piece: dict[str, Any]) -> list[tuple[str, str]]:
    """What keeps a piece from being one of a configuration file: the fewest problems in any of the files. What a
    piece leaves to the rest of its file is no problem."""
    if set(piece) & {"S_BW", "P"}:
        tables: list[tuple[type[Any], dict[str, Any]]] = [
            (SensitivityTable if name == "S_BW" else LawTable, table) for name, table in piece.items()
        ]
        return [problem for model, table in tables for problem in _problems(model, table)]
    case = {"case": [{"id": "1", "title": "its keys alone", **piece}]}
    found = [
        _problems(model, put_into(tomllib.loads(path.read_text(encoding="utf-8")), put))
        for model, path in WHOLE
        for put in (piece, *([case] if model is CasesConfig else []))
    ]
    return min(found, key=len)


def _problems(model: type[Any], data: dict[str, Any]) -> list[tuple[str, str]]:
    try:
        validate(model, data, where="page")
    except ConfigError as error:
        return [(place, fact) for place, fact in error.problems if not fact.startswith("missing")]
    return []


@pytest.mark.parametrize("block", TOML, ids=lambda block: block.where)
def test_toml_is_a_piece_of_a_configuration(block: Block) -> None:
    assert problems_of(tomllib.loads(block.text)) == []


def test_toml_is_found_and_its_slips_seen() -> None:
    assert {"docs/how-to/areas.md", "docs/how-to/optics.md", "docs/explanation/noise.md"} <= {b.page for b in TOML}
    assert len(TOML) >= 15
    assert problems_of({"areas": {"define": [{"name": "A", "porperty": 2}]}})
    assert problems_of({"series": [{"name": "cooldown", "file": "a.csv", "remove": "cubic"}]})
    assert problems_of({"S_BW": {"frame": "model"}})
    assert problems_of({"blocks": [{"area": ["A"]}]})


def test_python_is_run() -> None:
    """By a test elsewhere, or as a file of its page."""
    tests = ROOT / "tests"
    for page, module in PYTHON_ELSEWHERE.items():
        assert Path(page).name in (tests / module).read_text(encoding="utf-8"), f"{module} runs no block of {page}"
    for page in pages():
        found = blocks(page)
        commands = [s.command for b in found if b.kind == "session" for s in session(b)]
        for block in found:
            if block.language == "python" and page not in PYTHON_ELSEWHERE:
                runs = [c for c in commands if re.fullmatch(rf"python {re.escape(block.title)}( .*)?", c)]
                assert block.title, f"{block.where}: Python that nothing runs: give it a title"
                assert runs, f"{block.where}: no `$ python {block.title}` on the page"
