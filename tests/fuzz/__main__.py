"""A campaign of mutated inputs: `python tests/fuzz --kind op2 --first 0 --count 10000`."""

from __future__ import annotations

import argparse
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from fuzz_judge import KINDS, Judge
from fuzz_model import fuzz_case
from fuzz_users import READERS, Users, mutations_of


def main() -> None:
    parser = argparse.ArgumentParser(prog="tests/fuzz", description="Judge mutated decks and results.")
    parser.add_argument("--kind", choices=[*KINDS, "users", *READERS, "all"], default="all")
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--only", help="one mutation by its name")
    parser.add_argument("--show", default="", help="also print the verdicts of these outcomes, with commas between")
    options = parser.parse_args()
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        kinds = {"all": list(KINDS), "users": list(READERS)}.get(options.kind, [options.kind])
        judge = Users(Path(folder)) if kinds[0] in READERS else Judge(fuzz_case(Path(folder) / "fuzz"))
        for kind in kinds:
            begin, outcomes = time.monotonic(), Counter[tuple[str, str]]()
            names = list(mutations_of(kind) if kind in READERS else KINDS[kind])
            for number in range(options.first, options.first + options.count):
                if options.only and names[number % len(names)] != options.only:
                    continue
                verdict = judge.judge(kind, number)
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
