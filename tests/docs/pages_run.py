"""Do what a page shows, in a folder of its own, and compare what is printed; with --update write that into the pages.

    python tests/docs/pages_run.py            what differs, page by page
    python tests/docs/pages_run.py --update   ... and put into the pages

A page is a session: its files are written and its commands run in the order in which they stand there.

* A block of commands behind `$ ` with their output is run and compared line by line. `...` alone in a line stands for
  any lines, within a line for any text. Blocks of commands without `$ ` are not run.
* A fenced block with title="NAME" is the file NAME. As a `diff` it changes a file that is there: lines that begin with
  - are replaced by those with + behind them; lines with + alone are added at its end. As `text` or `markdown` with
  `...` alone in a line it is a part of a file that is there, and is compared like the output of a command.
"""

from __future__ import annotations

import contextlib
import difflib
import io
import os
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from unittest import mock

from pages import ROOT, Block, Shown, blocks, page_lines, pages, session

from tedm_cli.cli import main

#: Pages that begin in an empty folder. All others begin in the sample of `tedm init`, with its chain run.
EMPTY = {"docs/tutorial/your-model.md"}
_STAGES = (
    "make-rules",  # remembers what `tedm run` goes by
    "ingest",
    "build-distortion",
    "build-sensitivity",
    "build-optics",
    "run-case all",
    "build-dynamics",
    "simulate all",
)
#: Made last, and by no command of these pages read: `tedm run -n` looks at their times alone.
_DRAWN = ("figures.stamp", "report.html", "report.pdf", "report.md", "view.html")
_SHELL_SIGNS = re.compile(r"[|<>;&$*]")


def build_sample(folder: Path) -> None:
    """The sample of `tedm init` with the results of its chain; figures, report and page are empty files."""
    reader = Reader("", folder)
    for command in ("init .", *_STAGES):
        code, out = reader.do(f"tedm {command}")
        assert code == 0, out
    for name in _DRAWN:
        (folder / "build" / name).touch()


@dataclass
class Reader:
    """Who does what a page says. `folder` is where the page begins, `here` where its commands have led."""

    page: str
    folder: Path
    here: Path = field(init=False)

    def __post_init__(self) -> None:
        self.here = self.folder

    def write(self, block: Block) -> None:
        """Write the file of a block, or change one."""
        path = self.here / block.title
        if block.kind == "change":
            path.write_text(changed(path.read_text(encoding="utf-8"), block), encoding="utf-8")
            return
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(block.text, encoding="utf-8")

    def do(self, command: str) -> tuple[int, str]:
        """Exit code of a command, and what it prints on both streams; `tedm` and Python run in this process."""
        if _SHELL_SIGNS.search(command) or command.startswith("pip "):
            return self._in_a_shell(command)
        words = shlex.split(command, comments=True)
        if words[0] == "cd":
            self.here = (self.here / words[1]).resolve(strict=True)
            return 0, ""
        out = io.StringIO()
        code: object = 0
        if words[0] not in ("tedm", "python"):
            return self._in_a_shell(command)
        with (
            contextlib.chdir(self.here),
            mock.patch.object(sys, "argv", words[words[0] == "python" :]),
            contextlib.redirect_stdout(out),
            contextlib.redirect_stderr(out),
        ):
            try:
                main() if words[0] == "tedm" else runpy.run_path(words[1], run_name="__main__")
            except SystemExit as exc:
                code = exc.code or 0
        return (code if isinstance(code, int) else 1), out.getvalue()

    def _in_a_shell(self, command: str) -> tuple[int, str]:
        programs = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
        done = subprocess.run(
            ["bash", "-c", command],
            cwd=self.here,
            env={**os.environ, "PATH": programs},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            check=False,
        )
        return done.returncode, done.stdout

    def printed(self, shown: Shown) -> list[str]:
        """The lines that a command prints, with places seen from the folder of the page."""
        code, out = self.do(shown.command)
        out = out.replace(f"{self.folder}/", "")
        expected = any(line.startswith("error: ") for line in shown.expected)
        assert (code == 0) != expected, f"{self.page}:{shown.line}: {shown.command}: exit code {code}\n{out}"
        return [line.rstrip() for line in out.splitlines()]


def changed(text: str, block: Block) -> str:
    """The text of a file after the change that a block shows."""
    pieces: list[tuple[str, str]] = [("", "")]
    for line in block.lines:
        if line.startswith("-"):
            if pieces[-1][1]:
                pieces.append(("", ""))
            pieces[-1] = (pieces[-1][0] + line[1:] + "\n", "")
        elif line.startswith("+"):
            pieces[-1] = (pieces[-1][0], pieces[-1][1] + line[1:] + "\n")
        else:
            pieces.append(("", ""))
    for old, new in pieces:
        if old:
            assert text.count(old) == 1, f"{block.where}: {text.count(old)} times in {block.title}:\n{old}"
            text = text.replace(old, new)
        else:
            text += new
    return text


def agrees(expected: tuple[str, ...], printed: list[str]) -> bool:
    """Whether these lines were printed, `...` standing for what is left out."""
    pattern = ""
    for line in expected:
        if line.strip() == "...":
            pattern += r"(?:.*\n)*?"
        else:
            pattern += ".*".join(re.escape(known) for known in _timeless(line).split("...")) + r"\n"
    return re.fullmatch(pattern, "".join(f"{_timeless(line)}\n" for line in printed)) is not None


def _timeless(line: str) -> str:
    """Times and memory of this run are of no other."""
    return re.sub(r"\b\d+(\.\d+)? (s|GB|MB)\b", r"# \2", line)


def told_anew(expected: tuple[str, ...], printed: list[str]) -> list[str]:
    """What a page should show: all that was printed, or of each piece between `...` the lines most like it."""
    if "..." not in [line.strip() for line in expected]:
        return printed
    pieces: list[list[str]] = [[]]
    for line in expected:
        if line.strip() == "...":
            pieces.append([])
        else:
            pieces[-1].append(line)
    out: list[str] = []
    start = 0
    for number, piece in enumerate(pieces):
        if number:
            out.append("...")
        if not piece:
            continue
        last = len(printed) - len(piece)
        if number == 0:
            best = 0
        elif number == len(pieces) - 1:
            best = last
        else:
            best = max(range(start, last + 1), key=lambda at: _likeness(piece, printed[at : at + len(piece)]))
        out += [_kept(old, new) for old, new in zip(piece, printed[best : best + len(piece)], strict=True)]
        start = best + len(piece)
    return out


def _likeness(piece: list[str], lines: list[str]) -> float:
    return sum(difflib.SequenceMatcher(None, a, b, autojunk=False).ratio() for a, b in zip(piece, lines, strict=True))


def _kept(old: str, new: str) -> str:
    """The old line where it still stands for the new one."""
    return old if agrees((old,), [new]) else new


@dataclass(frozen=True)
class Difference:
    """A command whose output, or a file whose part, is not what its page says."""

    page: str
    indent: str
    shown: Shown
    printed: list[str]

    def __str__(self) -> str:
        lines = difflib.unified_diff(self.shown.expected, self.printed, "page", "printed", lineterm="")
        return "\n".join([f"{self.page}:{self.shown.line}: $ {self.shown.command}", *lines])


def read(page: str, folder: Path) -> list[Difference]:
    """Do all that a page shows; what it says otherwise."""
    reader, found = Reader(page, folder), []
    for block in blocks(page):
        if block.kind in ("file", "change"):
            reader.write(block)
        elif block.kind == "part":
            there = (reader.here / block.title).read_text(encoding="utf-8").splitlines()
            if not agrees(block.lines, there):
                found.append(Difference(page, block.indent, Shown(block.title, block.line, block.lines), there))
        elif block.kind == "session":
            for shown in session(block):
                printed = reader.printed(shown)
                if not agrees(shown.expected, printed):
                    found.append(Difference(page, block.indent, shown, printed))
    return found


def pages_with_sessions() -> list[str]:
    return [page for page in pages() if any(block.kind == "session" for block in blocks(page))]


def begin(page: str, sample: Path, folder: Path) -> Path:
    """The folder in which a page begins: empty, or a copy of the sample."""
    if page in EMPTY:
        folder.mkdir()
    else:
        shutil.copytree(sample, folder)
    return folder


def update(differences: list[Difference]) -> None:
    """Put what was printed into a page."""
    page = differences[0].page
    lines = page_lines(page)
    for d in reversed(differences):
        told = told_anew(d.shown.expected, d.printed)
        end = d.shown.line + len(d.shown.expected)
        lines[d.shown.line : end] = [(d.indent + line).rstrip() for line in told]
    (ROOT / page).write_text("\n".join(lines) + "\n", encoding="utf-8")


def all_pages(chosen: list[str], is_update: bool) -> int:
    """Compare pages, all that have sessions unless some are chosen; how many commands print something else."""
    count = 0
    with tempfile.TemporaryDirectory() as scratch:
        sample = Path(scratch).resolve() / "sample"
        todo = [page for page in pages_with_sessions() if not chosen or any(name in page for name in chosen)]
        if set(todo) - EMPTY:
            sample.mkdir()
            build_sample(sample)
        for number, page in enumerate(todo):
            folder = begin(page, sample, sample.parent / f"page{number}")
            differences = read(page, folder)
            count += len(differences)
            print(f"{page}: {len(differences)} commands print something else")
            print("".join(f"{d}\n" for d in differences), end="")
            if differences and is_update:
                update(differences)
    return count


if __name__ == "__main__":
    names = [name for name in sys.argv[1:] if name != "--update"]
    sys.exit(1 if all_pages(names, "--update" in sys.argv) and "--update" not in sys.argv else 0)
