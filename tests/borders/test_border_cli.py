"""The command line itself: quick to start, and documented in full."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pytest
import typer.main
from border_tools import Project, tedm

from tedm_cli import __version__
from tedm_cli.cli import main
from tedm_cli.cli.commands import app

GROUP = typer.main.get_command(app)
COMMANDS = sorted(name for name, command in GROUP.commands.items() if not command.hidden)  # type: ignore[attr-defined]
HEAVY = ("numpy", "scipy", "h5py", "pyNastran", "matplotlib", "pydantic", "rich", "jinja2", "sklearn")


def test_start_imports_nothing_heavy() -> None:
    code = f"import sys, tedm_cli.cli; print([m for m in {HEAVY!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("arguments", [[], ["--help"]])
def test_help_lists_the_commands(arguments: list[str]) -> None:
    out = tedm(*arguments).ok().out
    for name in COMMANDS:
        assert f"  {name} " in out
    assert "make-rules" not in out


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_and_option_is_documented(name: str) -> None:
    command = GROUP.commands[name]  # type: ignore[attr-defined]
    assert command.help
    first = command.help.splitlines()[0]
    assert first.endswith(".")
    out = tedm(name, "--help").ok().out
    assert first in " ".join(out.split())
    for parameter in command.params:
        assert parameter.name == "help" or parameter.help, f"{name} {parameter.opts}"
        if parameter.opts[0].startswith("-"):
            assert parameter.opts[0] in out


def test_version() -> None:
    assert tedm("--version").ok().out == f"tedm {__version__}\n"


def test_windows_is_told_where_it_runs(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """Before anything is imported that needs what Windows lacks."""
    monkeypatch.delattr(signal, "SIGALRM")
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    error, hint = capsys.readouterr().err.splitlines()
    assert error.startswith("error: tedm needs")
    assert "WSL 2" in hint


def test_a_reader_that_leaves_early(chain: Project) -> None:
    """`tedm show file | head -1` ends without a word on stderr."""
    command = [sys.executable, "-m", "tedm_cli.cli", "show", str(chain.build / "case03.h5")]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdout.close()
        assert process.stderr.read() == ""


def test_internal_faults_are_told_apart(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def fault(_: Path) -> None:
        raise ZeroDivisionError("by nought")

    monkeypatch.setattr("tedm_cli.stages.chain.check.check_folder", fault)
    outcome = tedm("check", "-d", tmp_path)
    assert outcome.code == 1
    assert outcome.err.startswith("error: internal fault: ZeroDivisionError: by nought\nhint: ")


def test_tracebacks_only_when_asked_for(tiny: Project) -> None:
    tiny.deck.unlink()
    assert "Traceback" not in tiny.run("ingest", "-v").err
    assert "Traceback" in tiny.run("ingest", "-vv").err
    assert "Traceback" not in tiny.run("ingest").err


def test_quiet(small: Project) -> None:
    assert small.run("build-optics", "-q").ok().out == ""
