"""The loop of a project: its bodies, stiffness, controller and noise, from the configuration and the sensitivities."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.dynamics.controller_file import read_controller
from tedm_cli.config.dynamics.loop import DynamicsConfig, load_dynamics
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import SENSITIVITY as KIND
from tedm_cli.dynamics.bodies import DynamicTestMass
from tedm_cli.dynamics.controller import Controller, default_controller, default_loops
from tedm_cli.dynamics.loops import LoopShape
from tedm_cli.dynamics.plant import Plant
from tedm_cli.dynamics.signals import TEST_MASSES
from tedm_cli.dynamics.sources import NoiseSource
from tedm_cli.dynamics.stiffness import gravity_stiffness, mutual_stiffness
from tedm_cli.errors import ConfigError, TedmError
from tedm_cli.files.build_folder import SENSITIVITY_FILE
from tedm_cli.files.provenance import ConfigFile
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.gravity.field import OTHER_TEST_MASS
from tedm_cli.results.gravity.field import FieldAtRest, read_field

ELECTROSTATICS = "electrostatics"


@dataclass(frozen=True, eq=False)
class Loop:
    """What the dynamics of a project is made of.

    Parameters
    ----------
    config, file : the configuration, and its file where there is one.
    names : [2], of the test masses in the model; TM1 and TM2 in all labels of the dynamics.
    source_names : of `by_source` [2, n, 6, 6], the stiffness of each test mass among what moves with the spacecraft.
    at_rest : [12], accelerations at rest in the order of `signals.STRAY`.
    """

    config: DynamicsConfig
    file: ConfigFile | None
    names: tuple[str, ...]
    plant: Plant
    controller: Controller
    sources: tuple[NoiseSource, ...]
    source_names: tuple[str, ...]
    by_source: FloatArray
    at_rest: FloatArray

    @property
    def tables(self) -> list[Path]:
        """Files that the configuration names: spectra, and a controller of one's own."""
        folder = Path() if self.file is None else self.file.path.parent
        return [folder / name for name in self.config.file_names()]

    @property
    def where(self) -> str:
        """The configuration's file, for messages."""
        return "the default dynamics" if self.file is None else str(self.file.path)


def project_loop(project: Project) -> Loop:
    """The loop of a project, from its dynamics file and sensitivity.h5.

    Raises
    ------
    ConfigError : not two test masses; no optics; unknown sources or groups.
    PhysicsError : bodies or controllers that cannot be, named with the file they are in.
    """
    file, config = load_dynamics(project.dynamics)
    masses = len(load_model(project.model)[1].test_mass)
    if masses != len(TEST_MASSES):
        raise _not_two(project, masses)
    project.required_optics()
    where = "the default dynamics" if file is None else str(file.path)
    folder = Path() if project.dynamics is None else project.dynamics.parent
    with open_checked(project.build_dir / SENSITIVITY_FILE, KIND) as sensitivity:
        names = tuple(sensitivity.strings(KIND.TEST_MASS_NAME))
        if len(names) != len(TEST_MASSES):
            raise _not_two(project, len(names))
        test_masses = _test_masses(sensitivity)
        field = read_field(sensitivity)
    source_names, gravity, mutual = _stiffness(field)
    pulls = [q.sum(axis=1) for q in (field.acceleration, field.angular_acceleration)]
    at_rest = np.concatenate(pulls, axis=1).reshape(-1)
    try:
        spacecraft = config.spacecraft.spacecraft(test_masses)
        electrostatic = config.stiffness.matrix(gravity.sum(axis=1))
        by_source = np.concatenate([gravity, electrostatic[:, None]], axis=1)
        plant = Plant(spacecraft, test_masses, by_source.sum(axis=1), mutual)
        controller = _controller(config, plant, folder)
    except TedmError as error:
        error.where = error.where or where
        raise
    sources = config.noise.sources(spacecraft, test_masses, at_rest, folder, where)
    names_of = (*source_names, ELECTROSTATICS)
    return Loop(config, file, names, plant, controller, tuple(sources), names_of, by_source, at_rest)


def _not_two(project: Project, number: int) -> ConfigError:
    fact = f"drag-free dynamics is of two test masses; this project has {number or 'none'}"
    return ConfigError([("test_mass", fact)], where=str(project.model))


def _test_masses(file: Reader) -> list[DynamicTestMass]:
    mass, inertia = file.array(KIND.TEST_MASS_MASS), file.array(KIND.TEST_MASS_INERTIA)
    position, axes = file.array(KIND.TEST_MASS_POSITION), file.array(KIND.TEST_MASS_AXES)
    return [
        DynamicTestMass(name, float(mass[i]), inertia[i], position[i], axes[i]) for i, name in enumerate(TEST_MASSES)
    ]


def _stiffness(field: FieldAtRest) -> tuple[tuple[str, ...], FloatArray, FloatArray]:
    """Names and stiffness [2, n, 6, 6] of what moves with the spacecraft, and [12, 12] of the other test mass."""
    fixed = [i for i, name in enumerate(field.source) if name != OTHER_TEST_MASS]
    blocks = (field.stiffness[symbol].value[:, fixed] for symbol in ("Γ_lin", "Γ_ang", "Ω_lin", "Ω_ang"))
    gravity = gravity_stiffness(*blocks)
    mutual = mutual_stiffness(field.linearised.value, list(gravity.sum(axis=1)))
    return tuple(field.source[i] for i in fixed), gravity, mutual


def _controller(config: DynamicsConfig, plant: Plant, folder: Path) -> Controller:
    table = config.controller
    if table.file is not None:
        return read_controller(folder / table.file)
    shape = LoopShape(**table.shape.model_dump())
    loops = {loop.name: loop for loop in default_loops(shape=shape)}
    for own in table.loop:
        loops[own.name] = own.loop(loops[own.name], shape)
    return default_controller(plant, tuple(loops.values()))
