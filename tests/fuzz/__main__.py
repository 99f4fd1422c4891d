"""Mutated inputs judged: `python tests/fuzz --seed 7 --count 10000`, or `--kind op2 --first 0 --count 1000`."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

sys.path += [str(Path(__file__).parents[1] / name) for name in ("", "borders", "thermal")]  # of several rooms
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy: each process has a core of its own

from fuzz_campaign import FAMILIES, WEIGHTS, Judges, campaign
from fuzz_hdf5 import MUTATIONS
from fuzz_judge import KINDS
from fuzz_users import READERS, mutations_of

GROUPS = {"all": list(WEIGHTS), "hdf5": list(FAMILIES["HDF5"]), "users": list(READERS)}


def main() -> None:
    parser = argparse.ArgumentParser(prog="tests/fuzz", description="Judge mutated decks, results and files.")
    parser.add_argument("--seed", type=int, help="a campaign over all kinds by weight, two processes at once")
    parser.add_argument("--log", type=Path, help="file for the mutants of a campaign that are not fine")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--kind", choices=[*WEIGHTS, *GROUPS], default="all", help="without --seed: one kind or group")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=1000, help="of a campaign in all; without --seed of each kind")
    parser.add_argument("--only", help="one mutation by its name")
    parser.add_argument("--show", default="", help="also print the verdicts of these outcomes, with commas between")
    options = parser.parse_args()
    if options.seed is not None:
        sys.exit(campaign(options.seed, options.count, options.processes, options.log, sys.stdout) > 0)
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        judges = Judges(Path(folder))
        for kind in GROUPS.get(options.kind, [options.kind]):
            judge = judges.of(kind).judge
            begin, outcomes = time.monotonic(), Counter[str]()
            names = list(KINDS[kind] if kind in KINDS else mutations_of(kind) if kind in READERS else MUTATIONS)
            for number in range(options.first, options.first + options.count):
                if options.only and names[number % len(names)] != options.only:
                    continue
                verdict = judge(kind, number)
                outcomes[verdict.outcome] += 1
                if verdict.failed or verdict.outcome in options.show.split(","):
                    print(verdict, flush=True)
                failed += verdict.failed
            seconds = time.monotonic() - begin
            print(f"{kind}: {outcomes.total()} mutants in {seconds:.0f} s: {dict(outcomes.most_common())}", flush=True)
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
