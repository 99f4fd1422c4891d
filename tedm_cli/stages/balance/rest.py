"""What the balance is made against: the field at rest of everything but its blocks, and the limits on it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.model.at_rest import members, rest_of
from tedm_cli.config.model.compensation import compensation_file, compensation_masses
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.project import Project
from tedm_cli.contracts import SENSITIVITY
from tedm_cli.errors import ConfigError
from tedm_cli.files.build_folder import require_configuration, require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.files.store import Reader
from tedm_cli.gravity.compensation import CompensationMass, field_of_compensation_masses
from tedm_cli.gravity.field import COMPENSATION, SelfGravity
from tedm_cli.gravity.requirements import ALL, AtRestLimit, DcVerdict, judge_at_rest
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.results.gravity.at_rest import BY_AREA, Fields, by_group, fields_at_rest, of_field

_QUANTITIES = (SENSITIVITY.DC_ACCELERATION, SENSITIVITY.DC_ANGULAR_ACCELERATION, SENSITIVITY.STIFFNESS_GAMMA_LIN)
_OF_AREAS = (
    SENSITIVITY.AREA_CONTRIBUTION_ACCELERATION,
    SENSITIVITY.AREA_CONTRIBUTION_ANGULAR_ACCELERATION,
    SENSITIVITY.AREA_CONTRIBUTION_GAMMA_LIN,
)


@dataclass(frozen=True, eq=False)
class Rest:
    """The field [12] of everything else by test mass and subsystem, and what limits the sum.

    kept : compensation masses of the model that are in it; csv : those of them that its CSV has.
    """

    config: ModelConfig
    test_masses: list[TestMass]
    limits: list[AtRestLimit]
    fields: Fields
    kept: list[CompensationMass]
    csv: list[CompensationMass]

    @property
    def before(self) -> list[DcVerdict]:
        """The field of everything else against its limits."""
        return self._judged(self.fields)

    @cached_property
    def _functionals(self) -> dict[tuple[int, str], FloatArray]:
        return {}

    def functional(self, test_mass: int, group: str) -> FloatArray:
        """What a field [12] on a test mass adds to the value of each verdict [r], of something in a group: [r, 12]."""
        key = test_mass, group
        if key not in self._functionals:
            name, nothing, columns = self.test_masses[test_mass].name, np.zeros(12), []
            for unit in np.eye(12):
                fields = {tm: dict.fromkeys(of, nothing) for tm, of in self.fields.items()}
                for subsystem in (ALL, *self.subsystems_of(group, name)):
                    fields[name][subsystem] = unit
                columns.append([v.value for v in self._judged(fields)])
            self._functionals[key] = np.array(columns).T
        return self._functionals[key]

    def effect(self, blocks: Sequence[CompensationMass], fields: Sequence[Sequence[SelfGravity]]) -> FloatArray:
        """What blocks add to the value of each verdict [r]; their `fields` by [test mass][block]."""
        found = np.zeros(len(self.before))
        for t, own in enumerate(fields):
            for block, field in zip(blocks, own, strict=True):
                found += self.functional(t, block.group) @ of_field(field)
        return found

    def verdicts(self, blocks: Sequence[CompensationMass], fields: Sequence[Sequence[SelfGravity]]) -> list[DcVerdict]:
        """The field with blocks against its limits."""
        total = {tm: dict(of) for tm, of in self.fields.items()}
        for tm, own in zip(self.test_masses, fields, strict=True):
            for block, field in zip(blocks, own, strict=True):
                for name in (ALL, *self.subsystems_of(block.group, tm.name)):
                    total[tm.name][name] = total[tm.name][name] + of_field(field)
        return self._judged(total)

    def _judged(self, fields: Fields) -> list[DcVerdict]:
        return judge_at_rest(self.limits, fields, rest_of(self.config.gravity.subsystems))

    def subsystems_of(self, group: str, test_mass: str) -> list[str]:
        """The subsystem that a group counts to ("": compensation masses); none where the model has no subsystems."""
        subsystems = self.config.gravity.subsystems
        own = [n for n, of in subsystems.items() if (group or COMPENSATION) in members(of, test_mass)]
        rest = rest_of(subsystems)
        return own or ([rest] if rest else [])


def field_of_each(
    config: ModelConfig, test_masses: Sequence[TestMass], blocks: Sequence[CompensationMass]
) -> list[list[SelfGravity]]:
    """The field of each block, [test mass][block], as build-sensitivity computes it."""
    gravity = config.gravity
    g, tolerance = gravity.gravitational_constant_m3_kg_s2, gravity.compensation_tolerance
    return [
        [how.field for how in field_of_compensation_masses(tm, blocks, g, tolerance=tolerance)[2]] for tm in test_masses
    ]


def read_rest(
    project: Project, config: ModelConfig, file: Reader, subsystems: Sequence[str] | None, *, keep: bool, where: Path
) -> Rest:
    """The field in sensitivity.h5, with the compensation masses of the model or without.

    Raises
    ------
    InputError : the file was made from another configuration, or other compensation masses.
    ConfigError : the model limits nothing at rest, or none of the `subsystems`, which the file `where` names.
    """
    require_configuration(file, project.model)
    csv = compensation_file(project, config)
    for used in input_files([] if csv is None else [csv]):
        require_input(file, used)
    limits = _limits(project, config, subsystems, where)
    test_masses, there = config.test_masses(), compensation_masses(project, config)
    in_csv = there[: len(there) - len(config.compensation_mass)]
    names = file.strings(SENSITIVITY.SOURCE_NAME)
    used_sources = [i for i, name in enumerate(names) if keep or name != COMPENSATION]
    pulls = {name: file.array(path)[:, used_sources] for name, path in zip(BY_AREA, _QUANTITIES, strict=True)}
    by_area = {name: file.array(path) for name, path in zip(BY_AREA, _OF_AREAS, strict=True)}
    kept = there if keep else []
    grouped = by_group(kept, field_of_each(config, test_masses, kept)) if any(b.group for b in kept) else {}
    sources, groups = [names[i] for i in used_sources], file.strings(SENSITIVITY.AREA_GROUP)
    fields = fields_at_rest(config, sources, pulls, by_area, groups, grouped)
    return Rest(config, test_masses, limits, fields, kept, in_csv if keep else [])


def _limits(project: Project, config: ModelConfig, subsystems: Sequence[str] | None, where: Path) -> list[AtRestLimit]:
    limits = config.limits_at_rest()
    if not limits:
        fact = "the model limits nothing at rest: there is nothing to balance it for"
        hint = 'add [[requirement_at_rest]] with name = "lpf", or limits of your own'
        raise ConfigError([("requirement_at_rest", fact)], where=str(project.model), hint=hint)
    if subsystems is None:
        return limits
    named = ["+".join(limit.subsystems) or ALL for limit in limits]
    if unknown := [name for name in subsystems if name not in named]:
        fact = f"no limit is on {unknown[0]!r}; there are limits on: {', '.join(dict.fromkeys(named))}"
        raise ConfigError([("subsystems", fact)], where=str(where))
    return [limit for limit, name in zip(limits, named, strict=True) if name in subsystems]
