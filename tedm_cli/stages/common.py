"""What several wings need: test masses that fit the structure, the area table of a file, names that are known."""

from __future__ import annotations

import difflib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.model.compensation import compensation_file
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.project import Project
from tedm_cli.contracts import AreaDatasets, AreaPlaces
from tedm_cli.errors import ConfigError, UsageError
from tedm_cli.files.build_folder import UNIT_LOADS_FILE
from tedm_cli.files.store import Reader, Writer
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.results.areas import read_areas, write_areas

SOLID_KG_M3 = (1e2, 3e4)  # no solid is lighter or heavier


def check_test_masses(test_masses: Sequence[TestMass], position: FloatArray, *, where: str) -> None:
    """Refuse test masses that the structure with grids at `position` [N,3] (m) cannot hold: slips of units or frames.

    Raises
    ------
    ConfigError : a test mass further from the structure than this is long, or with the density of no solid.
    """
    low, high = position.min(axis=0), position.max(axis=0)
    size = float(np.linalg.norm(high - low))
    problems = []
    for i, tm in enumerate(test_masses):
        away = float(np.linalg.norm(np.maximum(0.0, np.maximum(low - tm.position_m, tm.position_m - high))))
        if away > size:
            problems.append(
                (f"test_mass[{i}].position_m", f"{tm.name} is {away:.4g} m away from a model of {size:.4g} m")
            )
        density = tm.mass_kg / tm.body.volume_m3
        if not SOLID_KG_M3[0] <= density <= SOLID_KG_M3[1]:
            problems.append((f"test_mass[{i}]", f"size and mass of {tm.name} make {density:.4g} kg/m3"))
    if problems:
        raise ConfigError(
            problems, where=where, hint="lengths must be in metres, masses in kilograms, in the basic frame"
        )


def copy_areas(source: Reader, target: Writer) -> None:
    """The areas of one file as those of another."""
    write_areas(target, read_areas(source), source.array(AreaDatasets.AREA_ID))


def copy_places(source: Reader, target: Writer) -> None:
    """Where the areas of one file are, and their symmetry plane, as those of another."""
    for path in (AreaPlaces.AREA_CENTROID, AreaPlaces.PLANE_POINT, AreaPlaces.PLANE_NORMAL):
        target.write(path, source.array(path))
    target.write(AreaPlaces.PLANE_ORIGIN, source.string(AreaPlaces.PLANE_ORIGIN))


def out_path(project: Project, name: str, output: Path | None) -> Path:
    return output if output is not None else project.build_dir / name


def gravity_files(project: Project, config: ModelConfig) -> list[Path]:
    """Files beside the model's configuration that the pull on the test masses depends on."""
    blocks = compensation_file(project, config)
    return list(dict.fromkeys([*([] if blocks is None else [blocks]), *map(project.resolve, config.body_files())]))


def refuse_own_place(project: Project, results: Sequence[Path]) -> None:
    """Refuse results of Nastran where `ingest` writes: its HDF5 of a deck `unit_loads.bdf` has that very name.

    Raises
    ------
    ConfigError : the name, and another one.
    """
    ours = project.build_dir / UNIT_LOADS_FILE
    if any(path.resolve() == ours.resolve() for path in results):
        raise ConfigError(
            [("model.op2", f"names {ours}, where ingest writes its own file")],
            where=str(project.model),
            hint=f"call the results otherwise, for example {ours.stem}.msc.h5",
        )


def known_name(what: str, name: str, known: Sequence[str]) -> str:
    """`name`, where it is one of the `known`; else `UsageError` with the nearest of them, or all."""
    if name in known:
        return name
    folded = {k.casefold(): k for k in known}
    near = difflib.get_close_matches(name.casefold(), folded, n=1, cutoff=0.5)
    hint = f"did you mean {folded[near[0]]}?" if near else f"there are {', '.join(known)}"
    raise UsageError(f"no {what} is called {name!r}", hint=hint)
