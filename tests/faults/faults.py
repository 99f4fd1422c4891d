"""Faults from outside while commands write: kills, a full disk, several at once; whole chains killed and begun again.

Every run is of the small sample with all its files made, whose bytes are known: the same inputs give the same bytes. So
whatever happens to a command, every file is there as it was, or, where it was not, whole or not at all.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import math
import os
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path += [str(Path(__file__).parents[1] / name) for name in ("", "borders", "fuzz", "thermal")]

from border_tools import CONFIGS, ROOT, SMALL, heed_interrupts
from fuzz_hdf5_judge import DYNAMICS, SERIES
from fuzz_users_project import small_chain

from tedm_cli.cli import main

#: In the order of the chain.
COMMANDS = (
    "write-deck", "solve", "ingest", "build-distortion", "build-sensitivity", "build-optics", "build-adjoint",
    "build-loads", "write-deck --adjoint", "write-deck --loads", "run-case 3", "run-series warm", "build-dynamics",
    "simulate 3", "build-thermal", "balance", "reduce --interface 850001 --part 800101", "export --format npz",
    "export-case 3 --format csv", "export-vtu", "view", "map-temperatures tau.csv -o grids.h5",
    "simulate-thermal --duration 2e6 -o nodes.h5", "build-sensitivity --partial unit_loads.op2", "merge -o merged",
)  # fmt: skip
NO_CONFIG = ("export", "export-case", "export-vtu")
SIZES = (0.02, 0.5, 0.999)  # of the largest file of a command: there the disk is full
Snapshot = dict[str, str]


@dataclass(frozen=True)
class Ended:
    """How a process ended: its exit code, or minus the signal; and what it said on stderr."""

    code: int
    said: str


def in_process(action: Callable[[], None], until: float = math.inf) -> Ended:
    """Run `action` in a forked process; kill it after `until` seconds."""
    child, stream = start(action)
    if until < math.inf:
        time.sleep(until)
        os.kill(child, signal.SIGKILL)
    return end(child, stream)


def start(action: Callable[[], None]) -> tuple[int, int]:
    """Run `action` in a forked process: its number, and where what it says on stderr can be read."""
    ours, theirs = os.pipe()
    child = os.fork()
    if child == 0:
        code = 99
        try:
            os.close(ours)
            heed_interrupts()
            err = io.StringIO()
            with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(err):
                try:
                    action()
                    code = 0
                except SystemExit as exc:
                    code = exc.code if isinstance(exc.code, int) else int(exc.code is not None)
            os.write(theirs, err.getvalue().encode()[:60_000])
        finally:
            os._exit(code)
    os.close(theirs)
    return child, ours


def end(child: int, stream: int) -> Ended:
    """Wait for a process of `start`."""
    with os.fdopen(stream, "rb") as said:
        text = said.read().decode()
    return Ended(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), text)


class Chain:
    """The small sample in a folder, every command run once; what each writes, and how long it takes."""

    def __init__(self, folder: Path, commands: tuple[str, ...] = COMMANDS) -> None:
        self.folder, self.build, self.commands = folder, folder / "build", commands
        rows = "".join(f"{2.0 * n},{293.0 + 0.01 * math.sin(0.3 * n):.6f}\n" for n in range(900))
        small_chain(folder, SERIES, DYNAMICS)
        (folder / "series.csv").write_text("time_s,all\n" + rows)
        for command in commands:
            self.act(command)
        self.targets: dict[str, list[str]] = {}
        self.seconds: dict[str, float] = {}
        for command in commands:
            before, begun = self.stamps(), time.monotonic()
            assert self.run(command) == Ended(0, ""), command
            self.seconds[command] = time.monotonic() - begun
            after = self.stamps()
            self.targets[command] = [name for name in after if after[name] != before.get(name)]
            assert self.targets[command], command
        self.sound = self.snapshot()

    def act(self, command: str) -> None:
        name, *words = [
            str(self.folder / w) if w.endswith((".csv", ".h5", ".op2", "merged")) else w for w in command.split()
        ]
        project = [] if name in NO_CONFIG else ["-c", str(self.folder / "tedm.toml")]
        sys.argv = ["tedm", name, *words, *project, "-d", str(self.build), "-q"]
        try:
            with contextlib.redirect_stdout(io.StringIO()):
                main()
        except SystemExit as exc:
            if exc.code:
                raise

    def run(self, command: str, until: float = math.inf) -> Ended:
        return in_process(lambda: self.act(command), until)

    def stamps(self) -> dict[str, int]:
        return {str(p.relative_to(self.folder)): p.stat().st_mtime_ns for p in self.files()}

    def snapshot(self) -> Snapshot:
        """SHA-256 of every file."""
        return {str(p.relative_to(self.folder)): hashlib.sha256(p.read_bytes()).hexdigest() for p in self.files()}

    def files(self) -> Iterator[Path]:
        """All but temporaries, whose names begin with a dot."""
        return (p for p in sorted(self.folder.rglob("*")) if p.is_file() and p.name[0] != ".")

    def temporaries(self) -> list[str]:
        return [p.name for p in self.folder.rglob(".*")]


def kill(chain: Chain, command: str, share: float, *, had_files: bool) -> str:
    """Kill a command after this share of its time, over its old files or without; what is wrong then and later."""
    targets = chain.targets[command]
    for name in targets if not had_files else []:
        (chain.folder / name).unlink()
    chain.run(command, share * chain.seconds[command])
    after = chain.snapshot()
    lost = sorted(set(chain.sound) - set(after) - set(targets if not had_files else []))
    half = sorted(name for name in after if after[name] != chain.sound.get(name))
    again = chain.run(command)
    left = chain.temporaries()
    wrong = [
        *([f"lost {', '.join(lost)}"] if lost else []),
        *([f"half {', '.join(half)}"] if half else []),
        *([f"then refused: {again.said}"] if again.code else []),
        *([f"temporaries left: {', '.join(left)}"] if left else []),
        *(["then other bytes"] if chain.snapshot() != chain.sound else []),
    ]
    return "; ".join(wrong)


def fill(chain: Chain, command: str, share: float) -> str:
    """Let the disk be full at this share of a command's largest file (EFBIG in place of ENOSPC); what is wrong then."""
    size = int(share * max((chain.folder / name).stat().st_size for name in chain.targets[command]))

    def act() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))
        chain.act(command)

    ended = in_process(act)
    lines = ended.said.splitlines()
    wrong = [
        *([f"exit code {ended.code}"] if ended.code != 4 else []),
        *([f"said {ended.said!r}"] if len(lines) != 1 or "no room left" not in ended.said else []),
        *([f"temporaries left: {', '.join(chain.temporaries())}"] if chain.temporaries() else []),
        *(["other files"] if chain.snapshot() != chain.sound else []),
    ]
    return "; ".join(wrong)


def at_once(chain: Chain, processes: int, commands: tuple[str, ...]) -> str:
    """Run a chain several times at once in one folder; what is wrong then, and of which command."""

    def act() -> None:
        failed = [(c, ended) for c in commands if (ended := chain.run(c)).code]
        sys.stderr.write("; ".join(f"{c} ended with {ended.code}: {ended.said.strip()}" for c, ended in failed))
        sys.exit(bool(failed))

    children = [start(act) for _ in range(processes)]
    found = [end(*child) for child in children]
    wrong = [
        *(f"chain {n}: {e.said or f'exit code {e.code}'}" for n, e in enumerate(found, 1) if e.code),
        *([f"temporaries left: {', '.join(chain.temporaries())}"] if chain.temporaries() else []),
        *(["other bytes"] if chain.snapshot() != chain.sound else []),
    ]
    return "; ".join(wrong)


# --- whole chains: make all, make stages, tedm run -------------------------------------------------------------------


class Making:
    """`make all`, `make stages` or `tedm run` of the small sample with three cases, in a folder of its own."""

    def __init__(self, folder: Path, program: str) -> None:
        self.program = program
        self.configs, self.build = folder / "configs", folder / "build"
        self.configs.mkdir(parents=True)
        for name in ("model.toml", "ltp_small.bdf", "ltp_small_areas.csv", "unit_loads.bdf", "unit_loads.op2"):
            shutil.copy(SMALL / name, self.configs)
        shutil.copy(CONFIGS / "optics.toml", self.configs)
        text = (CONFIGS / "cases.toml").read_text(encoding="utf-8")
        (self.configs / "cases.toml").write_text("\n[[case]]".join(text.split("\n[[case]]")[:4]), encoding="utf-8")
        (self.configs / "tedm.toml").write_text('title = "small sample"\n')

    def make(self, until: float = math.inf) -> Ended:
        """Run it, and kill it with all that it started after `until` seconds."""
        variables = [f"CONFIGS={self.configs}", f"BUILD={self.build}", f"VENV={sys.prefix}"]
        options = ["-c", str(self.configs / "tedm.toml"), "-d", str(self.build)]
        programs = {
            "make": ["make", "--no-print-directory", "all", *variables],
            "stages": ["make", "-j2", "--no-print-directory", "stages", *variables],
            "run": [sys.executable, "-m", "tedm_cli.cli", "run", "-j", "2", *options],
        }
        child = subprocess.Popen(
            programs[self.program],
            cwd=ROOT,
            env={k: v for k, v in os.environ.items() if not k.startswith(("MAKE", "MFLAGS"))},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
            start_new_session=True,
        )
        try:
            _, said = child.communicate(timeout=None if until == math.inf else until)
        except subprocess.TimeoutExpired:
            os.killpg(child.pid, signal.SIGKILL)
            _, said = child.communicate()
        return Ended(child.returncode, said)

    def snapshot(self) -> Snapshot:
        found = sorted(p for p in self.build.rglob("*") if p.is_file())
        return {str(p.relative_to(self.build)): hashlib.sha256(p.read_bytes()).hexdigest() for p in found}


def kill_chain(folder: Path, program: str, moments: int) -> tuple[int, str]:
    """Build once, then once more, killed again and again; how often it was killed, and what is wrong at the end."""
    making = Making(folder, program)
    begun = time.monotonic()
    first = making.make()
    seconds = time.monotonic() - begun
    if first.code:
        return 0, f"{program}: {first.said}"
    whole = making.snapshot()
    shutil.rmtree(making.build)
    killed = 0
    while killed < moments:
        ended = making.make(seconds / (moments + 1) * (1.0 + 0.1 * (killed % 3)))
        if ended.code != -signal.SIGKILL:
            return killed, f"ended with {ended.code} before it was killed: {ended.said}"
        half = [n for n, found in making.snapshot().items() if Path(n).name[0] != "." and found != whole.get(n)]
        if half:
            return killed + 1, f"half or other: {', '.join(half)}"
        killed += 1
    last = making.make()
    if last.code:
        return killed, f"then refused: {last.said}"
    found = making.snapshot()
    differ = sorted(n for n in {*found, *whole} if found.get(n) != whole.get(n))
    return killed, f"then other files: {', '.join(differ)}" if differ else ""


# --- a new project ---------------------------------------------------------------------------------------------------


def kill_init(folder: Path, moments: int) -> tuple[int, str]:
    """Begin a project, killed over the whole time that it takes, in a new or an empty folder; what is wrong then."""

    def act(target: Path) -> None:
        sys.argv = ["tedm", "init", str(target), "--from", "lisa", "-q"]
        try:
            main()
        except SystemExit as exc:
            if exc.code:
                raise

    def files(target: Path) -> list[Path]:
        return [p for p in target.rglob("*") if p.is_file()]

    def snapshot(target: Path) -> Snapshot:
        return {str(p.relative_to(target)): hashlib.sha256(p.read_bytes()).hexdigest() for p in files(target)}

    begun = time.monotonic()
    if (first := in_process(lambda: act(folder / "whole"))).code:
        return 0, f"init: {first.said}"
    seconds, whole = time.monotonic() - begun, snapshot(folder / "whole")
    for n in range(moments):
        target = folder / f"killed{n}"
        if n % 2:
            target.mkdir()
        in_process(lambda place=target: act(place), seconds * (n + 0.5) / moments)  # type: ignore[misc]
        if (target / "tedm.toml").exists():  # it was done
            found = snapshot(target)
        else:
            again = in_process(lambda place=target: act(place))  # type: ignore[misc]
            if again.code:
                return n, f"then refused: {again.said}"
            found = snapshot(target)
        found = {name: digest for name, digest in found.items() if not name.startswith(".tedm-init.")}
        if found != whole:
            return n, f"then other files: {', '.join(sorted(set(found) ^ set(whole)))}"
    return moments, ""
