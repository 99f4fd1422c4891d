"""Masses and the solution of a model as lines of text."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from tedm_cli.deck_units import SI

if TYPE_CHECKING:
    from tedm_cli.deck_units import DeckUnits
    from tedm_cli.nastran.loads.unit_loads import UnitLoad
    from tedm_cli.stages.model.ingest import MassSummary
    from tedm_cli.stages.model.solve import SolveReport

_ROUNDING = 1e-9  # components this far below the largest of their quantity are printed as 0
_TURNED = 1e-3  # relative change of displacements by the drilling stiffness from which on it is spoken of
_COARSE = 1e-4  # relative error of a temperature step in single precision that is worth a word
_STIFF = 0.01  # relative change of displacements by bubble functions above which the mesh is called too stiff


def mass_lines(masses: MassSummary) -> list[str]:
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


def partial_lines(elements: list[int]) -> list[str]:
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


def solve_lines(path: Path, done: SolveReport) -> list[str]:
    """Size of the model, quality of the solution, and what the elements do badly."""
    s = done.static
    elements = ", ".join(f"{number:,} {kind}" for kind, number in (done.solids | done.others).items() if number)
    lines = [
        f"{path}: {done.n_cases} load cases, {done.n_grids:,} grids, {elements}",
        f"{s.solver}: {s.n_dof:,} unknowns, assembled in {s.assemble_seconds:.1f} s, factorised in"
        f" {s.factor_seconds:.1f} s, solved in {s.solve_seconds:.1f} s; peak memory {done.peak_bytes / 1e9:.1f} GB",
        f"relative residual {s.max_relative_residual:.1e}, uniform expansion to {s.expansion_residual:.1e}",
    ]
    if done.bending_change is not None:
        lines.append(
            f"bending: with bubble functions in all linear solids displacements change by {done.bending_change:.2g}"
        )
        if done.bending_change > _STIFF:
            lines.append(
                "note: the linear solids are too stiff in bending; leave IN and ISOP of their PSOLID blank (bubble"
                " functions), take CHEXA20, CPENTA15 or CTETRA10, or more elements through the thickness"
            )
    lines += _drilling_lines(done) + _own_temperature_lines(done)
    if done.linear_tetrahedra:
        lines.append(
            f"note: {done.linear_tetrahedra:,} CTETRA4 have constant strain and are too stiff in bending, by an amount"
            " that is not estimated; take CTETRA10"
        )
    if s.unattached_grids:
        lines.append(f"note: {len(s.unattached_grids)} grids have no stiffness and are written as zero")
    return lines + [f"note: {note}" for note in done.notes]


def _own_temperature_lines(done: SolveReport) -> list[str]:
    own = done.own_temperatures
    if not own.elements:
        return []
    lines = [
        f"temperatures of their own (TEMPP1, TEMPRB): {own.elements:,} elements,"
        f" {own.gradients:,} of them with a gradient in some load case"
    ]
    if own.idle:
        shown = ", ".join(map(str, own.idle[:8])) + (" ..." if len(own.idle) > 8 else "")
        lines.append(
            f"note: gradients do nothing to {len(own.idle):,} elements that do not bend (rods, membranes): {shown}"
        )
    return lines


def _drilling_lines(done: SolveReport) -> list[str]:
    change = done.drilling_change
    if change is None or max(change.translation, change.rotation) <= _TURNED:
        return []
    return [
        f"drilling: with PARAM,K6ROT a hundred times as large displacements change by up to {change.translation:.2g},"
        f" rotations by up to {change.rotation:.2g}",
        "note: the stiffness of shells about their normal has a part in the results, and no physics fixes it; spread"
        " what stands on a shell over its foot (RBE2, RBE3), and compare solvers with the same PARAM,K6ROT",
    ]
