"""What every simulation begins with: a loop that is current, the temperatures as it feels them, and what is judged."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tedm_cli.arrays import FloatArray
from tedm_cli.config.cases import CasesConfig, load_cases
from tedm_cli.config.project import Project
from tedm_cli.contracts import DYNAMICS as DYNAMICS_KIND
from tedm_cli.dynamics.judging import judged_labels
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.build_folder import DYNAMICS_FILE, OPTICS_FILE, SENSITIVITY_FILE, require_input
from tedm_cli.files.provenance import ConfigFile, input_files
from tedm_cli.files.store import open_checked
from tedm_cli.noise.requirements import AppliedRequirement, Requirement, frequency_grid
from tedm_cli.stages.dynamics.loop import Loop, project_loop
from tedm_cli.stages.dynamics.thermal import ThermalRows, own_effects, thermal_rows


@dataclass(frozen=True, eq=False)
class Prepared:
    """A project ready to be simulated.

    Parameters
    ----------
    configs, inputs : what a result is made with and from.
    frequency_hz : [F], the grid of the cases with the band edges of the loop's requirements.
    judged : (requirement, output) of every verdict.
    """

    config: CasesConfig
    configs: list[ConfigFile]
    inputs: list[Path]
    loop: Loop
    rows: ThermalRows
    requirements: list[AppliedRequirement]
    frequency_hz: FloatArray
    judged: list[tuple[Requirement, str]]

    @property
    def lowest_hz(self) -> float:
        """Lowest band edge of the requirements, or of the grid where there are none."""
        return min((r.requirement.band_hz[0] for r in self.requirements), default=float(self.frequency_hz[0]))


def prepare(project: Project) -> Prepared:
    """Check and read all that simulations share.

    Raises
    ------
    InputError : dynamics.h5 is missing or stale.
    ConfigError : requirements that do not fit, all at once.
    """
    file, config = load_cases(project.cases)
    loop = project_loop(project)
    rows = thermal_rows(project, loop.config.read_out.set)
    inputs = require_current_loop(project, loop)
    requirements = loop.config.applied_requirements(loop.plant.outputs)
    try:
        frequency = _frequencies(config, [r.requirement for r in requirements])
    except ConfigError as error:
        hint = f"widen [frequency], or narrow the requirements of {loop.where}"
        raise ConfigError(error.problems, where=str(project.cases), hint=hint) from error
    try:
        judged = judged_labels(requirements, frequency, loop.plant.outputs)
    except ConfigError as error:
        error.where = loop.where
        raise
    configs = [file, *([loop.file] if loop.file else [])]
    return Prepared(config, configs, inputs, loop, rows, requirements, frequency, judged)


def require_current_loop(project: Project, loop: Loop) -> list[Path]:
    """dynamics.h5 and what it is made from; refused where it is of others, or of another configuration, than now."""
    tables = own_effects(project)
    source, *made_from = [project.build_dir / name for name in (DYNAMICS_FILE, SENSITIVITY_FILE, OPTICS_FILE)]
    with open_checked(source, DYNAMICS_KIND) as file:
        for used in input_files([*made_from, *loop.tables, *tables]):
            require_input(file, used)
        known = {c.sha256 for c in file.provenance().configs}
        now = {loop.file.sha256} if loop.file else set()
        if known != now:
            raise InputError(
                f"is stale: not made from {loop.where} as it is now",
                where=str(source),
                hint="rebuild it with `tedm build-dynamics`, or `tedm run`",
            )
    return [source, *made_from, *tables]


def _frequencies(config: CasesConfig, requirements: Sequence[Requirement]) -> FloatArray:
    """The grid of the cases, with the band edges of the loop's requirements."""
    f = config.frequency
    bands = [r.grid_hz for r in requirements] + [(float(x),) for x in config.frequency_hz()[[0, -1]]]
    return frequency_grid(f.min_hz, f.max_hz, f.points, bands)
