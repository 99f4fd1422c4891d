"""What has to be run of a project's chain, and why."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from tedm_cli.chain.graph import FIGURES_STAMP, HALVES, SYMMETRY_PLANE, TIES, ChainFiles, Step, chain_of, leading_to
from tedm_cli.chain.stale import missing_inputs, stale_steps
from tedm_cli.config.project import Project
from tedm_cli.errors import InputError
from tedm_cli.files.seal import sha256_of
from tedm_cli.stages.chain.check import check_file
from tedm_cli.stages.chain.make_rules import changed
from tedm_cli.stages.chain.project_files import chain_files
from tedm_cli.stages.common import known_name

_LATER = 2**63  # ns: no file is newer


@dataclass(frozen=True)
class Plan:
    """The steps of the chain that were asked for, and those that have to run.

    Parameters
    ----------
    steps : all that were asked for, up to date or not.
    stale : why a step has to run, in the order of the chain.
    remembered : what the build folder remembers of the project (`ChainFiles.remembered`), to be written first.
    """

    steps: tuple[Step, ...]
    stale: Mapping[Step, tuple[str, ...]]
    remembered: Mapping[Path, str]


def plan_chain(project: Project, stage: str | None) -> Plan:
    """What has to run for the whole chain without what runs on request, or up to a stage; see `plan_steps`.

    Raises
    ------
    UsageError : the chain of this project has no such stage.
    ConfigError, InputError : what `chain_files` refuses; a file that is not there and that no stage makes.
    """
    files = chain_files(project)
    if stage is None:
        return plan_steps(files, lambda step: not step.on_request)
    known_name("stage", stage, list(dict.fromkeys(step.stage for step in chain_of(files))))
    return plan_steps(files, lambda step: step.stage == stage)


def plan_steps(files: ChainFiles, is_wanted: Callable[[Step], bool]) -> Plan:
    """What has to run for the wanted steps of a chain. Nothing is written.

    A step has to run where Make would run it: a file of its is not there, or older than one that it is made of. And
    where a file of its tells by the sums of its inputs, or by its version, that it was made of others.

    Raises
    ------
    InputError : a file that is not there and that no stage makes.
    """
    steps = leading_to(chain_of(files), is_wanted)
    remembered = files.remembered()
    differ = set(changed(remembered))
    sum_of = cache(sha256_of)

    def time_of(path: Path) -> int | None:
        return _LATER if path in differ else _time_of(path)

    def wrong(path: Path) -> list[str]:
        foreign = (*files.results, *files.adjoint_results)  # which may be HDF5 of another program
        is_ours = path.suffix == ".h5" and path not in foreign
        return check_file(path, sum_of).problems if is_ours else []

    missing = [path for path in missing_inputs(steps, time_of) if path not in remembered]
    if missing:
        where, *others = (str(path) for path in missing)
        more = f", nor {', '.join(others)}" if others else ""
        hint = "the configuration names it, and no stage of the chain makes it"
        if missing[0] in files.adjoint_results:
            hint += ": `tedm run build-optics` and `tedm write-deck --adjoint` make the deck that your Nastran solves"
        raise InputError(f"no such file{more}", where=where, hint=hint)
    found = stale_steps(steps, time_of, wrong)
    return Plan(steps, {step: _worded(reasons, files, differ) for step, reasons in found.items()}, remembered)


def _time_of(path: Path) -> int | None:
    try:
        return os.stat(path).st_mtime_ns
    except (FileNotFoundError, NotADirectoryError):
        return None


def _worded(reasons: tuple[str, ...], files: ChainFiles, differ: set[Path]) -> tuple[str, ...]:
    """Reasons with what a user knows in place of the files in which the chain remembers things.

    `differ`: those of these files whose texts are not those of the project any more.
    """
    remembered = files.remembered()
    changed = {
        HALVES: "the halves of the chain have changed",
        SYMMETRY_PLANE: "the symmetry plane has changed",
        TIES: "what compensation masses are tied to has changed",
    }
    words = {
        f"{files.code.name} is newer": "tedm itself is newer",
        f"{FIGURES_STAMP} is not there": "the figures are not there",
        f"{FIGURES_STAMP} is rebuilt": "the figures are drawn again",
        f"{FIGURES_STAMP} is newer": "the figures are newer",
    }
    for path in remembered:
        if not path.exists():  # where files are there, commands by themselves have made them
            said = "no `tedm run` has run here yet"
        elif path in differ:
            said = changed[path.name]
        else:  # of a copy whose files have the times at which they were copied
            said = "the times of the build folder have changed (cp -p keeps them in a copy)"
        words[f"{path.name} is newer"] = said
    return tuple(dict.fromkeys(words.get(reason, reason) for reason in reasons))
