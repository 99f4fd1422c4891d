"""All faults at their full number: `make faults`, or `python tests/faults --only kills`."""

from __future__ import annotations

import argparse
import os
import random
import sys
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from faults import COMMANDS, SIZES, Chain, at_once, fill, kill, kill_chain, kill_init

KILLS = 8  # per command, half of them over old files
MOMENTS = 7
PROCESSES, TIMES = 4, 3
PARTS = ("kills", "disk", "chains", "make", "stages", "run", "init")
OF_NO_CHAIN = {"make", "stages", "run", "init"}


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="tests/faults", description="Kill commands, fill the disk, run chains at once."
    )
    parser.add_argument("--only", choices=PARTS, action="append", help="one of them; may be repeated")
    parser.add_argument("--seed", type=int, default=1, help="of the moments at which commands are killed")
    options = parser.parse_args()
    parts, wrong = options.only or PARTS, 0
    with tempfile.TemporaryDirectory() as folder:
        if set(parts) - OF_NO_CHAIN:
            chain = Chain(Path(folder) / "small")
        for part in parts:
            begin = time.monotonic()
            tried, found = (
                whole(Path(folder), part)
                if part in OF_NO_CHAIN
                else {"kills": kills, "disk": disk, "chains": chains}[part](chain, options.seed)
            )
            for line in found:
                print(f"{part}: {line}")
            wrong += len(found)
            print(f"{tried}: {len(found)} wrong ({time.monotonic() - begin:.0f} s)", flush=True)
    sys.exit(wrong > 0)


def kills(chain: Chain, seed: int) -> tuple[str, list[str]]:
    moments, found = random.Random(seed), []
    for command in COMMANDS:
        for n in range(KILLS):
            share = moments.uniform(0.05, 0.95)
            if fact := kill(chain, command, share, had_files=n % 2 == 0):
                found.append(f"{command} at {share:.2f} of its time: {fact}")
    return f"{KILLS * len(COMMANDS)} kills over {len(COMMANDS)} commands", found


def disk(chain: Chain, _: int) -> tuple[str, list[str]]:
    tried = [(command, share) for command in COMMANDS for share in SIZES]
    found = [
        f"{command} at {share} of its size: {fact}" for command, share in tried if (fact := fill(chain, command, share))
    ]
    return f"{len(COMMANDS)} commands x {len(SIZES)} sizes of a full disk", found


def chains(chain: Chain, _: int) -> tuple[str, list[str]]:
    found = [fact for _ in range(TIMES) if (fact := at_once(chain, PROCESSES, COMMANDS))]
    return f"{PROCESSES} chains of {len(COMMANDS)} commands at once in one folder, {TIMES} times", found


def whole(folder: Path, part: str) -> tuple[str, list[str]]:
    """A whole chain, by Make or by `tedm run`, or a new project."""
    if part == "init":
        killed, fact = kill_init(folder / part, 2 * MOMENTS)
    else:
        killed, fact = kill_chain(folder / part, part, MOMENTS)
    name = {"make": "make all", "stages": "make stages", "run": "tedm run", "init": "tedm init"}[part]
    return f"{name} killed at {killed} moments", [fact] if fact else []


if __name__ == "__main__":
    main()
