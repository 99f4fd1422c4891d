"""The unit-load deck, its solution and the distortion matrix, as lines of text and for programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from tedm_cli.cli.printing.areas import mean_step_dict, mean_step_lines
from tedm_cli.fem.drilling import DECISIVE

if TYPE_CHECKING:
    from tedm_cli.stages.model.deck import DeckSummary
    from tedm_cli.stages.model.distortion import DistortionSummary
    from tedm_cli.stages.model.reduce import ReduceSummary
    from tedm_cli.stages.model.solve import SolveReport

_STIFF = 0.01  # relative change of displacements by bubble functions above which the mesh is called too stiff


def deck_lines(done: DeckSummary) -> list[str]:
    """Size of the deck, the steps that its areas get, and what was dropped."""
    return [
        f"{done.path}: {done.areas} unit loads and the uniform load on {done.grids:,} grids,"
        f" from {done.reference:.12g} {done.temperature}",
        *mean_step_lines(done.mean_step),
        *(f"note: {note}" for note in done.notes),
    ]


def deck_dict(done: DeckSummary) -> dict[str, Any]:
    return {
        "file": done.path,
        "grids": done.grids,
        "areas": done.areas,
        "reference_temperature": done.reference,
        "temperature": done.temperature,
        "mean_step": mean_step_dict(done.mean_step),
        "notes": done.notes,
    }


def elsewhere_lines(path: Path, subcases: int, command: str) -> list[str]:
    """Results of the user's own solver."""
    return [f"{path}: {subcases} subcases by {command}"]


def elsewhere_dict(path: Path, subcases: int, command: str) -> dict[str, Any]:
    return {"file": path, "load_cases": subcases, "command": command}


def solve_dict(path: Path, done: SolveReport) -> dict[str, Any]:
    """What a program needs of a solution by the embedded solver."""
    s, change = done.static, done.drilling_change
    return {
        "file": path,
        "load_cases": done.n_cases,
        "grids": done.n_grids,
        "elements": done.solids | done.others,
        "solver": s.solver,
        "unknowns": s.n_dof,
        "assemble_s": s.assemble_seconds,
        "factor_s": s.factor_seconds,
        "solve_s": s.solve_seconds,
        "peak_bytes": done.peak_bytes,
        "needed_bytes": s.needed_bytes,
        "relative_residual": s.max_relative_residual,
        "expansion_residual": s.expansion_residual,
        "bending_change": done.bending_change,
        "drilling_change": change
        and {
            "translation": change.translation,
            "rotation": change.rotation,
            "translation_grid": change.moves,
            "rotation_grid": change.turns,
            "optical_element": done.turned_element and done.turned_element[0],
            "optical_rotation": done.turned_element and done.turned_element[1],
        },
        "linear_tetrahedra": done.linear_tetrahedra,
        "elements_with_own_temperatures": done.own_temperatures.elements,
        "grids_without_stiffness": s.unattached_grids,
        "notes": done.notes,
    }


def reduce_lines(done: ReduceSummary) -> list[str]:
    """What was written, and the table that names it."""
    return [
        f"{done.path}: {done.grids:,} grids reduced to {done.freedoms} freedoms, {done.areas} thermal areas",
        f"{done.areas_csv}, {done.masses_csv}: {done.points:,} points of {done.mass_kg:.6g} kg",
        "for model.toml:",
        *(f"  {line}" for line in done.table),
    ]


def reduce_dict(done: ReduceSummary) -> dict[str, Any]:
    return {
        "file": done.path,
        "areas_csv": done.areas_csv,
        "masses_csv": done.masses_csv,
        "grids": done.grids,
        "freedoms": done.freedoms,
        "areas": done.areas,
        "shared": list(done.shared),
        "points": done.points,
        "mass_kg": done.mass_kg,
        "grounded": done.grounded,
        "table": list(done.table),
    }


def distortion_lines(done: DistortionSummary) -> list[str]:
    """Size of [D], its superposition, and its largest entries."""
    check = "not checked (no uniform load)"
    if done.superposition is not None:
        check = f"{done.superposition:.1e} (results in {done.precision} precision)"
    bent = (
        "" if done.largest_gradient is None else "; under a gradient {:.3g} m/(K/m) ({})".format(*done.largest_gradient)
    )
    optical = f"{done.optical} optical elements" if done.optical else "no optical elements: the project has no optics"
    return [
        f"{done.path}: D for {done.areas} areas, {done.grids:,} grids, {optical}",
        f"superposition residual {check}; largest translation {done.largest_m_per_K:.3g} m/K ({done.largest_area}),"
        f" largest rigid-body part {done.largest_rigid_m_per_K:.3g} m/K{bent}",
        *(f"warning: {note}" for note in done.notes),
    ]


def distortion_dict(done: DistortionSummary) -> dict[str, Any]:
    gradient = done.largest_gradient
    return {
        "file": done.path,
        "areas": done.areas,
        "grids": done.grids,
        "optical_elements": done.optical,
        "precision": done.precision,
        "superposition_residual": done.superposition,
        "largest_m_per_K": done.largest_m_per_K,
        "largest_area": done.largest_area,
        "largest_rigid_m_per_K": done.largest_rigid_m_per_K,
        "largest_gradient": gradient and {"m_per_K_per_m": gradient[0], "area": gradient[1]},
        "warnings": done.notes,
    }


def solve_lines(path: Path, done: SolveReport) -> list[str]:
    """Size of the model, quality of the solution, and what the elements do badly."""
    s = done.static
    elements = ", ".join(f"{number:,} {kind}" for kind, number in (done.solids | done.others).items() if number)
    lines = [
        f"{path}: {done.n_cases} load cases, {done.n_grids:,} grids, {elements}",
        f"{s.solver}: {s.n_dof:,} unknowns, assembled in {s.assemble_seconds:.1f} s, factorised in"
        f" {s.factor_seconds:.1f} s, solved in {s.solve_seconds:.1f} s; peak memory {done.peak_bytes / 1e9:.1f} GB,"
        f" of which {s.needed_bytes / 1e9:.1f} GB were foreseen for factors and load cases",
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
    if change is None or max(change.translation, change.rotation) <= DECISIVE:
        return []
    optics = done.turned_element
    of_optics = f"; of optical elements by up to {optics[1]:.2g} ({optics[0]})" if optics else ""
    if optics is None:
        advice = "spread what stands on a shell over its foot (RBE2, RBE3)"
    elif optics[1] > DECISIVE:
        advice = "spread the feet of optical elements over several grids of the shell (RBE2, RBE3)"
    else:
        advice = "optical elements hardly feel it, but sums of areas that cancel may change by more of themselves"
    return [
        f"drilling: with PARAM,K6ROT a hundred times as large displacements change by up to {change.translation:.2g}"
        f" (grid {change.moves}), rotations by up to {change.rotation:.2g} (grid {change.turns}){of_optics}; each of"
        " the largest of all grids",
        "note: the stiffness of shells about their normal has a part in the results, and no physics fixes it: rotations"
        f" change by up to {change.rotation:.2g} (grid {change.turns}){of_optics}, each of the largest rotation of all"
        f" grids, with PARAM,K6ROT a hundred times as large; {advice}; compare solvers with the same PARAM,K6ROT",
    ]
