"""What is run of a chain, as lines of text."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from tedm_cli.chain.graph import REPORT, VIEW, Step
from tedm_cli.results.wording import count
from tedm_cli.stages.chain.plan import Plan

_OF_SAMPLE = {
    "minimal": (
        "note: the mesh of this sample is coarse, for speed: the warning that many of its areas get less than 80 % of"
        " their step is about this mesh, and its numbers describe no mission",
    )
}
_SHOWN = 3  # reasons on a line


def plan_lines(plan: Plan) -> list[str]:
    """What would be run, and why."""
    width = max(len(step.words) for step in plan.stale)
    lines = [f"{step.words:{width}}  {_why(reasons)}" for step, reasons in plan.stale.items()]
    return [*lines, f"{len(plan.stale)} of {count(len(plan.steps), 'step', 'steps')} to run"]


def plan_dict(title: str, plan: Plan, build_dir: Path, codes: Mapping[Step, int]) -> dict[str, Any]:
    """For a program: the steps that were not up to date, why, and the exit codes of those that were run."""
    return {
        "project": title,
        "build_dir": build_dir,
        "steps": len(plan.steps),
        "up_to_date": all(codes.get(step) == 0 for step in plan.stale),
        "stale": [
            {
                "command": list(step.command),
                "why": list(reasons),
                "files": list(step.outputs),
                "exit_code": codes.get(step),
            }
            for step, reasons in plan.stale.items()
        ],
    }


def begun_lines(folder: Path, names: Sequence[str], sample: str) -> list[str]:
    """The files of a new project, what to know of the sample, and how to go on."""
    go = "" if folder == Path() else f"cd {shlex.quote(str(folder))}; "
    return [f"{folder}: {', '.join(names)}", *_OF_SAMPLE.get(sample, ()), f"now: {go}tedm run"]


def begun_dict(folder: Path, sample: str, names: Sequence[str]) -> dict[str, Any]:
    return {"folder": folder, "from": sample, "files": [folder / name for name in names]}


def step_line(number: int, plan: Plan, step: Step) -> str:
    total = str(len(plan.stale))
    return f"[{number:{len(total)}}/{total}] {step.words}: {_why(plan.stale[step])}"


def up_to_date_line(plan: Plan, build_dir: Path) -> str:
    return f"{build_dir}: all is up to date ({count(len(plan.steps), 'step', 'steps')})"


def noted_lines(lines: Sequence[str]) -> list[str]:
    """Of what a stage prints, what is to be known whether or not all of it is wanted."""
    return [f"  {line}" for line in lines if line.startswith(("warning: ", "note: "))]


def ended_line(plan: Plan, build_dir: Path) -> str:
    """The pages to open, where they have been made."""
    made = [str(path) for step in plan.stale for path in step.outputs if path.name in (REPORT, VIEW)]
    return f"open {' and '.join(made)}" if made else up_to_date_line(plan, build_dir)


def _why(reasons: Sequence[str]) -> str:
    more = len(reasons) - _SHOWN
    return ", ".join([*reasons[:_SHOWN], *([f"and {more} more"] if more > 0 else [])])
