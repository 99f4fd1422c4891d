"""What several stages need: names of the files between them, provenance, and the area table of a file."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tedm_cli.config.project import Project
from tedm_cli.contracts import KINDS
from tedm_cli.errors import ConfigError, InputError, UsageError
from tedm_cli.gravity.masses import MassDistribution, PointMasses, lever_nodes, mass_distribution
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.noise.areas import AreaTable
from tedm_cli.provenance import ConfigFile, InputFile, Provenance, command_line, input_files
from tedm_cli.store import Reader, Writer

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

UNIT_LOADS, DISTORTION, SENSITIVITY, OPTICS = (
    "unit_loads.h5",
    "distortion.h5",
    "sensitivity.h5",
    "optics.h5",
)
SOLID_KG_M3 = (1e2, 3e4)  # no solid is lighter or heavier


def case_file_name(case_id: str) -> str:
    """`case03.h5` for case 3, `case4b.h5` for 4b."""
    return f"case{int(case_id):02d}.h5" if case_id.isdigit() else f"case{case_id}.h5"


def series_file_name(name: str) -> str:
    return f"series_{name}.h5"


def provenance(configs: Sequence[ConfigFile], inputs: Iterable[Path]) -> Provenance:
    """Origin of a file: `configs` as they were read, and the present contents of `inputs`."""
    paths = list(inputs)
    for path in paths:
        if not path.exists():
            kind = KINDS.get(path.stem)
            raise InputError("no such file", where=str(path), hint=f"make it with `{kind.made_by}`" if kind else "")
    return Provenance(tuple(configs), input_files(paths), command_line())


def require_same_input(name: str, *files: Reader) -> None:
    """Refuse files that were made from different contents of the input called `name`."""
    found: dict[str, Path] = {}
    for file in files:
        for item in file.provenance().inputs:
            if item.path.name == name:
                found.setdefault(item.sha256, file.path)
    if len(found) > 1:
        paths = " and ".join(str(p) for p in found.values())
        raise InputError(
            f"were made from different versions of {name}", where=paths, hint="rebuild them; see tedm check"
        )


def require_input(file: Reader, used: InputFile) -> None:
    """Refuse `file` when it was made from another version of the file `used` that this stage reads as well."""
    for item in file.provenance().inputs:
        if item.path.name == used.path.name and item.sha256 != used.sha256:
            raise InputError(
                f"is stale: made from another version of {used.path}",
                where=str(file.path),
                hint=f"rebuild it with `{file.kind.made_by}`",
            )


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
        density = tm.mass_kg / float(np.prod(tm.side_m))
        if not SOLID_KG_M3[0] <= density <= SOLID_KG_M3[1]:
            problems.append((f"test_mass[{i}]", f"side_m and mass_kg of {tm.name} make {density:.4g} kg/m3"))
    if problems:
        raise ConfigError(
            problems, where=where, hint="lengths must be in metres, masses in kilograms, in the basic frame"
        )


def _concentrated(unit: Reader) -> PointMasses:
    return PointMasses(
        name=[
            f"{card} {i}"
            for card, i in zip(
                unit.strings("/mass/concentrated_card"), unit.array("/mass/concentrated_id"), strict=True
            )
        ],
        mass=unit.array("/mass/concentrated"),
        node=unit.array("/mass/concentrated_node"),
        offset=unit.array("/mass/concentrated_lever"),
    )


def lever_nodes_of(unit: Reader) -> IntArray:
    """Rows of the grids in unit_loads.h5 from which something with mass is offset, ascending."""
    mass, offset, index, lever = (unit.array(f"/element/{c}") for c in ("mass", "node_offset", "node_index", "lever"))
    return lever_nodes(mass, offset, index, lever, _concentrated(unit))


def mass_of(unit: Reader, *, lumped: bool = False) -> MassDistribution:
    """The mass of the model in unit_loads.h5, spread over its elements or lumped to its grids."""
    return mass_distribution(
        unit.array("/grid/position"),
        element_id=unit.array("/element/id"),
        card=unit.strings("/element/type"),
        mass=unit.array("/element/mass"),
        node_offset=unit.array("/element/node_offset"),
        node_index=unit.array("/element/node_index"),
        lever=unit.array("/element/lever"),
        thickness=unit.array("/element/section"),
        points=_concentrated(unit),
        weight=unit.array("/element/weight"),
        lumped=lumped,
        grid_id=unit.array("/grid/id"),
    )


def read_areas(file: Reader) -> AreaTable:
    columns = {c: np.array(file.strings(f"/area/{c}")) for c in ("name", "group", "shield", "side")}
    return AreaTable(**columns, centroid_m=file.array("/area/centroid") if file.has("/area/centroid") else None)


def copy_areas(source: Reader, target: Writer) -> None:
    target.write("/area/id", source.array("/area/id"))
    for column in ("name", "group", "shield", "side"):
        target.write(f"/area/{column}", source.strings(f"/area/{column}"))


def out_path(project: Project, name: str, output: Path | None) -> Path:
    return output if output is not None else project.build_dir / name


def known_name(what: str, name: str, known: Sequence[str]) -> str:
    """`name`, where it is one of the `known`; else `UsageError` with the nearest of them, or all."""
    if name in known:
        return name
    folded = {k.casefold(): k for k in known}
    near = difflib.get_close_matches(name.casefold(), folded, n=1, cutoff=0.5)
    hint = f"did you mean {folded[near[0]]}?" if near else f"there are {', '.join(known)}"
    raise UsageError(f"no {what} is called {name!r}", hint=hint)
