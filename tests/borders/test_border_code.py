"""No input is run: the code has no pickle, no evaluation of text and no shell, and starts processes in four places."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from border_tools import ROOT, tree

from tedm_cli.config.correlation.file import read_matrix
from tedm_cli.errors import InputError

SOURCES = {str(p.relative_to(ROOT / "tedm_cli")): p for p in sorted((ROOT / "tedm_cli").rglob("*.py"))}
#: Their files may hold code, and it is run when they are read.
PICKLING = {"pickle", "cPickle", "_pickle", "dill", "cloudpickle", "joblib", "shelve", "marshal", "copyreg", "yaml"}
EVALUATING = {"eval", "exec", "compile", "__import__", "execfile"}
SHELLS = {"system", "popen", "getoutput", "getstatusoutput", "create_subprocess_shell"}
PROCESSES = {"subprocess", "pty", "multiprocessing"}
#: The user's own Nastran (`solve --run`), the process that first reads an HDF5 file of another program, the script that
#: makes the model of a shipped sample (or of a variant, `trade --scripts`), and the processes in which `tedm run` and
#: `tedm trade` run commands.
STARTING = {"nastran/run.py", "files/trial.py", "stages/model_script.py", "stages/chain/workers.py"}
Finding = Callable[[ast.AST], str]


def found(problem: Finding) -> list[str]:
    """Where the sources have this problem."""
    return [
        f"{name}:{getattr(node, 'lineno', 0)}: {fact}"
        for name, path in SOURCES.items()
        for node in ast.walk(tree(path))
        if (fact := problem(node))
    ]


def imported(node: ast.AST) -> Iterator[str]:
    if isinstance(node, ast.Import):
        yield from (alias.name.partition(".")[0] for alias in node.names)
    elif isinstance(node, ast.ImportFrom) and not node.level:
        yield (node.module or "").partition(".")[0]


def called(node: ast.AST) -> str:
    """The last name of what is called."""
    if not isinstance(node, ast.Call):
        return ""
    return node.func.id if isinstance(node.func, ast.Name) else getattr(node.func, "attr", "")


def pickles(node: ast.AST) -> str:
    if names := PICKLING & set(imported(node)):
        return f"imports {', '.join(names)}"
    for keyword in node.keywords if isinstance(node, ast.Call) else []:
        if keyword.arg == "allow_pickle" and not (
            isinstance(keyword.value, ast.Constant) and keyword.value.value is False
        ):
            return "allow_pickle is not False"
    return "an object that loads pickles" if called(node) in ("read_pickle", "to_pickle", "Unpickler") else ""


def evaluates(node: ast.AST) -> str:
    """A call of the builtin by its name; methods of that name (`re.compile`) are others."""
    if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in EVALUATING):
        return ""
    harmless = node.func.id == "eval" and [ast.unparse(a) for a in node.args] == [
        "'0'"
    ]  # in interrupts.py, with reason
    return "" if harmless else f"{node.func.id}(...)"


def uses_a_shell(node: ast.AST) -> str:
    if called(node) in SHELLS:
        return called(node)
    for keyword in node.keywords if isinstance(node, ast.Call) else []:
        if keyword.arg == "shell":
            return "shell=..."
    return ""


@pytest.mark.parametrize("problem", [pickles, evaluates, uses_a_shell])
def test_nothing_of_an_input_is_run(problem: Finding) -> None:
    assert found(problem) == []


def test_processes_are_started_in_four_places() -> None:
    starting = {name for name, p in SOURCES.items() for node in ast.walk(tree(p)) if PROCESSES & set(imported(node))}
    assert starting == STARTING
    assert not found(
        lambda node: called(node) if called(node).startswith(("exec", "spawn", "posix_spawn", "fork")) else ""
    )


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("import pickle", pickles),
        ("from joblib import load", pickles),
        ("np.load(p, allow_pickle=True)", pickles),
        ("np.load(p, allow_pickle=flag)", pickles),
        ("pd.read_pickle(p)", pickles),
        ("eval(text)", evaluates),
        ("exec('0')", evaluates),
        ("os.system('ls')", uses_a_shell),
        ("subprocess.run(c, shell=True)", uses_a_shell),
    ],
)
def test_it_would_be_found(text: str, problem: Finding) -> None:
    assert [fact for node in ast.walk(ast.parse(text)) if (fact := problem(node))]


@pytest.mark.parametrize("text", ["re.compile('a')", "eval('0')", "np.load(p, allow_pickle=False)", "run(['ls'])"])
def test_nothing_else_is_found(text: str) -> None:
    assert not [
        1 for node in ast.walk(ast.parse(text)) for problem in (pickles, evaluates, uses_a_shell) if problem(node)
    ]


class Touching:
    """An object that makes a file where it is unpickled."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __reduce__(self) -> tuple[Callable[[Path], None], tuple[Path]]:
        return Path.touch, (self.path,)


def test_a_pickle_in_an_archive_is_refused_unread(tmp_path: Path) -> None:
    made = tmp_path / "made"
    held = np.empty(1, dtype=object)
    held[0] = Touching(made)
    np.savez(tmp_path / "r.npz", area=np.array(["A"]), R=held, allow_pickle=True)
    with np.load(tmp_path / "r.npz", allow_pickle=True) as archive:
        archive["R"]
    assert made.exists(), "it is a pickle that does something"
    made.unlink()
    with pytest.raises(InputError, match=r"r.npz: not a readable NPZ file of plain arrays: R.* holds object"):
        read_matrix(tmp_path / "r.npz")
    assert not made.exists()
