"""What was read of a deck and its results, as lines of text and for programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tedm_cli.cli.printing.areas import mean_step_dict, mean_step_lines, plane_line
from tedm_cli.deck_units import SI

if TYPE_CHECKING:
    from tedm_cli.deck_units import DeckUnits
    from tedm_cli.nastran.loads.unit_loads import UnitLoad
    from tedm_cli.stages.model.ingest import IngestSummary
    from tedm_cli.stages.model.read import MassSummary

_ROUNDING = 1e-9  # components this far below the largest of their quantity are printed as 0
_COARSE = 1e-4  # relative error of a temperature step in single precision that is worth a word


def ingest_lines(done: IngestSummary) -> list[str]:
    """Size of the model, its masses, and what is to be known of the results."""
    return [
        f"{done.path}: {done.grids:,} grids, {done.elements:,} elements, {done.areas} thermal areas"
        + (f", {done.gradients} of them under a gradient" if done.gradients else "")
        + f", displacements in {done.precision} precision",
        *unit_lines(done.units),
        plane_line(done.plane),
        *_mass_lines(done.masses),
        *([] if done.has_uniform else ["no uniform load: superposition will not be checked"]),
        *_partial_lines(done.partial),
        *mean_step_lines(done.mean_step),
        *(f"note: {note}" for note in done.notes),
        *step_lines(done.coarsest),
    ]


def ingest_dict(done: IngestSummary) -> dict[str, Any]:
    """What a program needs."""
    p, s = done.masses.properties, done.masses.sample
    return {
        "file": done.path,
        "grids": done.grids,
        "elements": done.elements,
        "areas": done.areas,
        "gradient_areas": done.gradients,
        "precision": done.precision,
        "units": done.units.name,
        "temperature": done.units.temperature,
        "symmetry_plane": {
            "point_m": done.plane.plane.point_m,
            "normal": done.plane.plane.normal,
            "origin": done.plane.origin,
        },
        "mass_kg": p.mass_kg,
        "centre_of_gravity_m": p.centre_m,
        "inertia_kg_m2": p.inertia_kg_m2,
        "masses_compared": {"elements": s.elements, "largest_relative_difference": s.largest},
        "weight_tables": done.masses.weight_tables,
        "test_masses_left_out_kg": done.masses.test_mass_kg,
        "has_uniform_load": done.has_uniform,
        "elements_without_some_midside_nodes": done.partial,
        "mean_step": mean_step_dict(done.mean_step),
        "notes": done.notes,
    }


def _mass_lines(masses: MassSummary) -> list[str]:
    """Mass, centre of gravity and inertia of the structure, and what they were checked against."""
    p, s = masses.properties, masses.sample
    least = _ROUNDING * float(abs(p.inertia_kg_m2).max())
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = (
        (f"{v:.6g}" if abs(v) > least else "0" for v in row) for row in p.inertia_kg_m2
    )
    size = float(p.inertia_kg_m2.trace() / p.mass_kg) ** 0.5
    x, y, z = (f"{v:.6g}" if abs(v) > _ROUNDING * size else "0" for v in p.centre_m)
    lines = [
        f"mass {p.mass_kg:.9g} kg, centre of gravity ({x}, {y}, {z}) m in the basic frame",
        f"inertia about it: xx {xx}, yy {yy}, zz {zz}, xy {xy}, xz {xz}, yz {yz} kg m2",
        f"masses of {s.elements:,} elements agree with pyNastran's, by card and property, to {s.largest:.1e}"
        + (f" ({s.worst})" if s.largest > _ROUNDING else ""),
    ]
    lines += [f"the grid point weight table of {path} agrees" for path in masses.weight_tables]
    return lines + [f"left out: {kg:.6g} kg that stand for {name}" for name, kg in masses.test_mass_kg.items()]


def unit_lines(units: DeckUnits) -> list[str]:
    """What the numbers of a deck were taken to be in, where that is not SI."""
    return [] if units == SI else [f'deck and results: {units.name}, temperature = "{units.temperature}"']


def _partial_lines(elements: list[int]) -> list[str]:
    """A note on elements that lack some of their midside nodes."""
    if not elements:
        return []
    shown = ", ".join(map(str, elements[:8])) + (" ..." if len(elements) > 8 else "")
    return [f"note: {len(elements)} elements lack midside nodes; their mass follows their corners alone: {shown}"]


def step_lines(load: UnitLoad) -> list[str]:
    """A note on a step that single precision does not hold."""
    if load.single_error <= _COARSE:
        return []
    return [
        f"note: a solver that keeps temperatures in single precision applies the step of {load.load_K:g} K of"
        f" '{load.label}' with an error of {100.0 * load.single_error:.2g} %, and [D] has it too; take a larger step,"
        " or a reference temperature nearer to 0"
    ]
