"""Masses of a model between its arrays and the file: mass properties, the solver's own, and parts of test masses."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from tedm_cli.arrays import BoolArray, FloatArray, IntArray
from tedm_cli.config.model.body import ModelParts
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.errors import ConfigError, InputError, PhysicsError
from tedm_cli.gravity.mass_properties import MassProperties, mass_properties
from tedm_cli.gravity.masses import ElementMasses, MassDistribution, PointMasses, mass_distribution
from tedm_cli.gravity.testmass import TestMass, to_test_mass_frame
from tedm_cli.nastran.geometry import ModelGeometry, id_list, lumped_masses, rows_of
from tedm_cli.nastran.masses.audit import WeightTable, weight_table
from tedm_cli.nastran.masses.elements import Elements

# Elements that are warped or distorted have their lumped mass elsewhere than its middle; of the mass, of the radius of
# gyration, and of the inertia.
_MASS, _CENTRE, _INERTIA = 1e-3, 1e-2, 2e-2


def distribution_of(geometry: ModelGeometry, *, lumped: bool = False) -> MassDistribution:
    """The mass of a model as the gravity sums will see it."""
    e, c = geometry.elements, geometry.concentrated
    return mass_distribution(
        geometry.position_m,
        ElementMasses(
            id=e.id,
            card=e.type,
            mass=e.mass_kg,
            node_offset=e.node_offset,
            node_index=e.node_index,
            lever=e.lever,
            section=e.section,
            weight=e.weight,
        ),
        PointMasses(
            name=[f"{card} {i}" for card, i in zip(c.card, c.id, strict=True)],
            mass=c.kg,
            node=c.node,
            offset=c.lever,
        ),
        lumped=lumped,
        grid_id=geometry.grid_id,
    )


def properties_of(geometry: ModelGeometry, *, lumped: bool = False) -> MassProperties:
    """Total mass, centre of gravity and inertia of a model, with what concentrated masses have about themselves."""
    own = geometry.concentrated.inertia.sum(axis=0)
    return mass_properties(distribution_of(geometry, lumped=lumped), own)


def check_weight_tables(results: Sequence[Path], geometry: ModelGeometry, wtmass: float) -> list[WeightTable]:
    """Compare the model with the grid point weight tables of its results.

    A solver lumps its masses to the grids or, with COUPMASS, spreads them: its inertia lies between that of the lumps
    and that of the spread mass. Solvers write the table before or after PARAM,WTMASS.

    Raises
    ------
    InputError : a table of another mass, centre of gravity or inertia.
    """

    def place_of(grid: int) -> FloatArray:
        if grid == 0:
            return np.zeros(3)
        rows = rows_of(geometry.grid_id, np.array([grid]), where=str(geometry.files[0]), what="PARAM,GRDPNT")
        return np.asarray(geometry.position_m[rows[0]])

    tables = [t for t in (weight_table(path, place_of, geometry.units) for path in results) if t is not None]
    if tables:
        spread, lumped = properties_of(geometry), properties_of(geometry, lumped=True)
        for table in tables:
            _compare(table, spread, lumped, wtmass)
    return tables


def _compare(table: WeightTable, spread: MassProperties, lumped: MassProperties, wtmass: float) -> None:
    factor = min((1.0, wtmass), key=lambda f: abs(f * table.mass.mean() - spread.mass_kg))
    where = str(table.file)
    hint = "are these the results of this deck? if so, check densities, non-structural masses and PARAM,WTMASS"
    mass = factor * table.mass
    if np.abs(mass - spread.mass_kg).max() > _MASS * spread.mass_kg:
        found = ", ".join(f"{m:.7g}" for m in mass)
        raise InputError(
            f"its grid point weight table has {found} kg (x, y, z), the deck {spread.mass_kg:.7g} kg",
            where=where,
            hint=hint,
        )
    gyration = float(np.sqrt(np.trace(spread.inertia_kg_m2) / 2.0 / spread.mass_kg))
    if np.abs(table.centre - spread.centre_m).max() > _CENTRE * gyration:
        theirs, ours = (", ".join(f"{v:.6g}" for v in p) for p in (table.centre, spread.centre_m))
        raise InputError(
            f"its grid point weight table has the centre of gravity at ({theirs}) m, the deck at ({ours}) m",
            where=where,
            hint=hint,
        )
    both = np.stack([spread.inertia_kg_m2, lumped.inertia_kg_m2])
    margin = _INERTIA * float(np.trace(lumped.inertia_kg_m2))
    inertia = factor * table.inertia
    if ((inertia < both.min(axis=0) - margin) | (inertia > both.max(axis=0) + margin)).any():
        theirs, ours = (", ".join(f"{v:.6g}" for v in np.diag(i)) for i in (inertia, spread.inertia_kg_m2))
        raise InputError(
            f"its grid point weight table has the moments of inertia ({theirs}) kg m2, the deck ({ours}) kg m2",
            where=where,
            hint=hint,
        )


def without_test_masses(geometry: ModelGeometry, config: ModelConfig, where: Path) -> tuple[ModelGeometry, FloatArray]:
    """Take away the mass of what stands for the test masses in a model; it, and what each had there [T], kg.

    An element goes with its id, its property, or when all of its grids are listed.

    Raises
    ------
    ConfigError : parts that the model does not have.
    """
    e, c = geometry.elements, geometry.concentrated
    element_kg, point_kg, removed = e.mass_kg.copy(), c.kg.copy(), []
    problems: list[tuple[str, str]] = []
    for number, test_mass in enumerate(config.test_mass):
        parts = test_mass.model_parts
        problems += _unknown(parts, geometry, f"test_mass[{number}].model_parts")
        gone, points = parts_of_test_mass(parts, geometry)
        removed.append(float(element_kg[gone].sum() + point_kg[points].sum()))
        element_kg[gone], point_kg[points] = 0.0, 0.0
    if problems:
        raise ConfigError(problems, where=str(where))
    if not any(removed):
        return geometry, np.zeros(len(removed))
    inertia = np.where((point_kg == c.kg)[:, None, None], c.inertia, 0.0)
    elements = dataclasses.replace(e, mass_kg=element_kg)
    concentrated = dataclasses.replace(c, kg=point_kg, inertia=inertia)
    lumped = lumped_masses(len(geometry.grid_id), elements, concentrated)
    kept = dataclasses.replace(geometry, elements=elements, concentrated=concentrated, lumped_kg=lumped)
    return kept, np.array(removed)


def parts_of_test_mass(parts: ModelParts, geometry: ModelGeometry) -> tuple[BoolArray, BoolArray]:
    """Elements [E] and concentrated masses [C] that stand for a test mass."""
    e, c = geometry.elements, geometry.concentrated
    grid = np.isin(geometry.grid_id, parts.grids)
    starts = np.minimum(e.node_offset[:-1], max(len(e.node_index) - 1, 0))
    inside = np.logical_and.reduceat(grid[e.node_index], starts) & (np.diff(e.node_offset) > 0)
    gone = np.isin(e.id, parts.elements) | np.isin(e.property_id, parts.properties) | inside
    return gone, np.isin(c.id, parts.elements) | grid[c.node]


def element_of_member(elements: Elements) -> IntArray:
    """The row of the element that each entry of `node_index` [M] is of."""
    return np.repeat(np.arange(len(elements.id)), np.diff(elements.node_offset))


def _unknown(parts: ModelParts, geometry: ModelGeometry, path: str) -> list[tuple[str, str]]:
    known: dict[str, IntArray] = {
        "elements": np.concatenate([geometry.elements.id, geometry.concentrated.id]),
        "properties": geometry.elements.property_id,
        "grids": geometry.grid_id,
    }
    out = []
    for kind, ids in known.items():
        absent = sorted(set(getattr(parts, kind)) - set(ids.tolist()))
        if absent:
            out.append((f"{path}.{kind}", f"the model has none of these: {id_list(absent)}"))
    return out


def check_grids_outside(test_masses: Sequence[TestMass], geometry: ModelGeometry) -> None:
    """Refuse grids that carry mass inside a test mass.

    Raises
    ------
    PhysicsError : such grids, by id.
    """
    heavy = geometry.lumped_kg > 0.0
    for tm in test_masses:
        local = to_test_mass_frame(tm, geometry.position_m[heavy])
        inside = geometry.grid_id[heavy][tm.body.contains(local)]
        if inside.size:
            raise PhysicsError(
                f"{inside.size} grids with mass are inside test mass {tm.name!r}: {id_list(inside)}",
                where=str(geometry.files[0]),
                hint="name the test mass's elements in its model_parts, or correct its position and size",
            )
