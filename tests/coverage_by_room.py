"""Print how many lines of each room the tests have run, of the `.coverage` that `make coverage` leaves."""

from __future__ import annotations

import collections
from pathlib import Path

import coverage

PACKAGE = Path(__file__).parents[1] / "tedm_cli"


def main() -> None:
    data = coverage.Coverage()
    data.load()
    lines: collections.Counter[str] = collections.Counter()
    missed: collections.Counter[str] = collections.Counter()
    for file in PACKAGE.rglob("*.py"):
        inside = file.relative_to(PACKAGE).parts
        room = inside[0] + "/" if len(inside) > 1 else "files beside the rooms"
        _, statements, _, missing, _ = data.analysis2(str(file))
        lines[room] += len(statements)
        missed[room] += len(missing)
    lines["all"], missed["all"] = lines.total(), missed.total()
    print("| room | lines | not run | run |\n|---|---|---|---|")
    for room in [*sorted(lines.keys() - {"all"}), "all"]:
        run = 100.0 * (1.0 - missed[room] / max(lines[room], 1))
        print(f"| {room} | {lines[room]:,} | {missed[room]:,} | {run:.1f} % |")


if __name__ == "__main__":
    main()
