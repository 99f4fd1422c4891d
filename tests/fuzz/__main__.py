"""A campaign of mutated inputs: `python tests/fuzz --kind op2 --first 0 --count 10000`."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from fuzz_hdf5 import MUTATIONS
from fuzz_hdf5_judge import Hdf5Judge
from fuzz_judge import KINDS, Judge
from fuzz_model import fuzz_case
from fuzz_users import READERS, Users, mutations_of


def main() -> None:
    parser = argparse.ArgumentParser(prog="tests/fuzz", description="Judge mutated decks, results and files.")
    parser.add_argument("--kind", choices=[*KINDS, "hdf5", "users", *READERS, "all"], default="all")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--only", help="one mutation by its name")
    parser.add_argument("--show", default="", help="also print the verdicts of these outcomes, with commas between")
    options = parser.parse_args()
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        kinds = {"all": [*KINDS, "hdf5"], "users": list(READERS)}.get(options.kind, [options.kind])
        inputs = Judge(fuzz_case(Path(folder) / "fuzz")) if kinds[0] in KINDS else None
        files = Hdf5Judge(Path(folder) / "hdf5") if "hdf5" in kinds else None
        users = Users(Path(folder) / "users") if kinds[0] in READERS else None
        for kind in kinds:
            begin, outcomes = time.monotonic(), Counter[tuple[str, str]]()
            names = list(mutations_of(kind) if kind in READERS else KINDS.get(kind, MUTATIONS))
            for number in range(options.first, options.first + options.count):
                if options.only and names[number % len(names)] != options.only:
                    continue
                if kind == "hdf5":
                    verdict = files.judge(number)
                else:
                    verdict = (inputs if kind in KINDS else users).judge(kind, number)
                outcomes[verdict.mutation, verdict.outcome] += 1
                if verdict.failed or verdict.outcome in options.show.split(","):
                    print(verdict, flush=True)
                failed += verdict.failed
            total = Counter[str]()
            for (_, outcome), count in outcomes.items():
                total[outcome] += count
            seconds = time.monotonic() - begin
            print(
                f"{kind}: {sum(total.values())} mutations in {seconds:.0f} s: {dict(total.most_common())}", flush=True
            )
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()
