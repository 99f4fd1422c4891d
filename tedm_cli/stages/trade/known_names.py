"""Names in the criteria of a trade against what its variants have: what none of them has is a slip."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from pathlib import Path

from tedm_cli.config.cases import CasesConfig, load_cases
from tedm_cli.config.dynamics.loop import load_dynamics
from tedm_cli.config.project import Project
from tedm_cli.config.trade import CriterionTable, TradeConfig
from tedm_cli.errors import ConfigError, TedmError
from tedm_cli.noise.requirements import AppliedRequirement

_LOOP = ("closed_loop_ratio", "closed_loop_thermal_ratio")
_JUDGED = ("noise_ratio", "distortion_ratio", "bound_ratio", "probability")


def require_known(path: Path, config: TradeConfig, projects: Sequence[Project]) -> None:
    """Refuse cases, outputs and requirements that no variant has; those that only some lack are empty there.

    Raises
    ------
    ConfigError : all of them at once, each with the nearest name that there is.
    """
    cases = [found for project in projects if (found := _cases(project)) is not None]
    if not cases:
        return  # each variant says why it cannot be read
    loops = [found for project in projects for found in _of_loop(project)]
    applied = [a for one in cases for a in one.applied_requirements()]
    problems: list[tuple[str, str]] = []
    for number, criterion in enumerate(config.criteria):
        at = f"criterion[{number}]"
        if criterion.case is not None:
            ids = [i for one in cases for i in (one.ids_of_areas if criterion.kind in _LOOP else one.ids)]
            problems += _unknown(f"{at}.case", "case", [criterion.case], ids)
        if criterion.kind in (*_LOOP, *_JUDGED):
            problems += _judged(at, criterion, loops if criterion.kind in _LOOP else applied)
    if problems:
        raise ConfigError(problems, where=str(path))


def _judged(at: str, criterion: CriterionTable, applied: Sequence[AppliedRequirement]) -> list[tuple[str, str]]:
    """What is wrong with the requirement and the outputs of a criterion on what is judged."""
    names = [a.requirement.name for a in applied]
    problems = _unknown(
        f"{at}.requirement", "requirement", [criterion.requirement] if criterion.requirement else [], names
    )
    outputs = [o for a in applied if criterion.requirement in (None, a.requirement.name) for o in a.outputs]
    return problems or _unknown(f"{at}.outputs", "judged output", criterion.outputs or [], outputs)


def _unknown(at: str, what: str, wanted: Iterable[str], known: Iterable[str]) -> list[tuple[str, str]]:
    there = list(dict.fromkeys(known))
    return [(at, f"no variant has a {what} {name!r}; {_hint(name, there)}") for name in wanted if name not in there]


def _hint(name: str, known: Sequence[str]) -> str:
    near = difflib.get_close_matches(name, known, n=1)
    return f"did you mean {near[0]}?" if near else f"there are {', '.join(known) or 'none'}"


def _cases(project: Project) -> CasesConfig | None:
    try:
        return load_cases(project.cases)[1]
    except TedmError:
        return None


def _of_loop(project: Project) -> list[AppliedRequirement]:
    try:
        return load_dynamics(project.dynamics)[1].applied_requirements()
    except TedmError:
        return []
