"""Which halves of the chain a project has: self-gravity on test masses, the read-out of an optical layout, or both."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tedm_cli.config.model.file import ModelConfig, load_model
from tedm_cli.config.project import NO_OPTICS, Project
from tedm_cli.errors import ConfigError
from tedm_cli.noise.requirements import AppliedRequirement

NO_TEST_MASSES = "the project has no test masses: its model names none in [[test_mass]]"
READ_OUT_KINDS = ("displacement", "angle")  # all other outputs are accelerations


@dataclass(frozen=True)
class Halves:
    """`gravity`: the model has test masses; `read_out`: there is an optical layout. One of them at least."""

    gravity: bool
    read_out: bool

    def require_judgeable(self, requirements: Sequence[AppliedRequirement], *, where: Path) -> None:
        """Refuse requirements on outputs of the half that the project has not.

        They are not passed over: a verdict that all is met would be silent about them.

        Raises
        ------
        ConfigError : all such requirements of the cases file `where`.
        """
        problems = []
        for number, applied in enumerate(requirements):
            is_read_out = applied.requirement.kind in READ_OUT_KINDS
            if not (self.read_out if is_read_out else self.gravity):
                what, why = ("read-outs", NO_OPTICS) if is_read_out else ("accelerations", NO_TEST_MASSES)
                fact = f"{applied.requirement.name} judges {what} ({', '.join(applied.outputs)}), and {why}"
                problems.append((f"requirement[{number}]", fact))
        if problems:
            hint = "take these requirements out, or give the project what they judge"
            raise ConfigError(problems, where=str(where), hint=hint)


def halves_of(project: Project, model: ModelConfig | None = None) -> Halves:
    """What the configuration says there is; `model` where it has been read already.

    Raises
    ------
    ConfigError : neither test masses nor optics.
    """
    config = model if model is not None else load_model(project.model)[1]
    found = Halves(bool(config.test_mass), project.optics is not None)
    if not (found.gravity or found.read_out):
        raise ConfigError(
            [("", f"{NO_TEST_MASSES}, and no optics; there is nothing to compute")],
            where=str(project.file.path),
            hint='describe test masses in [[test_mass]] of the model, or name a layout: optics = "optics.toml"',
        )
    return found
