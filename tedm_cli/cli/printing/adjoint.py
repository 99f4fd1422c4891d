"""What every temperature does, by areas, as lines of text and for programs."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from tedm_cli.cli.printing.table import table

if TYPE_CHECKING:
    from tedm_cli.results.adjoint.file import AdjointResults
    from tedm_cli.stages.adjoint.build import AdjointSummary
    from tedm_cli.stages.adjoint.deck import AdjointDeckSummary

_WORST = 3  # sums that are named
_MUCH = 10  # cancellation from which on an area's mean hides what is in it


def adjoint_lines(done: AdjointSummary, most: int | None) -> list[str]:
    """How many temperatures there are, whether their sums are the unit loads, what evens out, and materials."""
    if isinstance(done.results, str):
        return [f"{done.path}: no adjoint of this model, and the file says so: {done.results}"]
    found = done.results
    without = f"; no read-outs: {done.no_read_outs}" if done.no_read_outs else ""
    return [
        f"{done.path}: {len(found.label)} outputs by the temperatures of {found.n_grids:,} grids and of"
        f" {found.n_elements:,} shells, bars and rods{without}",
        *_solved(done),
        f"sums over the {len(found.areas)} areas are their unit loads, within {found.difference.max():.1e} of the"
        f" largest of each block, and {(found.difference / found.allowed).max():.2g} of what is allowed",
        *_table(found),
        "",
        *material_lines([asdict(effect) for effect in found.materials], most),
    ]


def _solved(done: AdjointSummary) -> list[str]:
    """Who has solved it; of another solver, how far its stiffness is that of the elements here."""
    assert done.solved is not None
    assert not isinstance(done.results, str)
    report = done.solved.report
    if report is not None:
        return [
            f"solved in {report.solve_seconds:.2g} s after a factorisation of {report.factor_seconds:.2g} s"
            f" ({report.solver})"
        ]
    off = f"they are in single precision, which may change a sum by {done.results.allowed.max():.1e} of the largest of"
    single = [f"{off} its block at most"] if done.solved.rounding.any() else []
    return [
        f"solutions from {', '.join(map(str, done.solved.results))}; thermal forces, and what moduli and thicknesses"
        " do, by the elements of `tedm solve`",
        *single,
        f"all moduli together change an output by {done.results.moduli_together:.1e} of the largest of its block, and"
        " by 0 where the stiffness is theirs",
    ]


def adjoint_deck_lines(done: AdjointDeckSummary) -> list[str]:
    """Size of the deck, outputs that are not in it, and what to know."""
    without = f"; no read-outs: {done.no_read_outs}" if done.no_read_outs else ""
    nothing = [f"note: nothing acts on {', '.join(done.without)}: no subcase"] if done.without else []
    return [
        f"{done.path}: {len(done.outputs)} outputs as loads of {done.cards:,} cards on {done.grids:,} grids{without}",
        *nothing,
        *(f"note: {note}" for note in done.notes),
    ]


def adjoint_deck_dict(done: AdjointDeckSummary) -> dict[str, Any]:
    return {
        "file": done.path,
        "grids": done.grids,
        "cards": done.cards,
        "outputs": done.outputs,
        "without_load": done.without,
        "no_read_outs": done.no_read_outs or None,
        "notes": done.notes,
    }


def adjoint_dict(done: AdjointSummary) -> dict[str, Any]:
    """What a program needs; without an adjoint, why there is none."""
    if isinstance(done.results, str):
        return {"file": done.path, "refusal": done.results}
    found = done.results
    return {
        "file": done.path,
        "refusal": None,
        "n_grids": found.n_grids,
        "n_elements": found.n_elements,
        "no_read_outs": done.no_read_outs or None,
        "solver": None if done.solved is None or done.solved.report is None else done.solved.report.solver,
        "results": [] if done.solved is None else list(done.solved.results),
        "moduli_together": found.moduli_together,
        "largest_difference": found.difference.max(),
        "largest_share_of_allowed": float((found.difference / found.allowed).max()),
        "median_cancellation": float(np.median(found.mean_cancellation)),
        "cancelling_most": [asdict(c) for c in found.cancelling_most[:_WORST]],
        "field": None if found.field is None else _field_dict(found),
        "outputs": [
            {
                "output": a.output,
                "unit": a.unit,
                "mean": {"area": a.mean_area, "per_K": a.by_mean},
                "gradient": {"area": a.gradient_area, "per_K_per_m": a.by_gradient},
            }
            for a in found.acting_most
        ],
        "materials": [asdict(effect) for effect in found.materials],
    }


def _field_dict(found: AdjointResults) -> dict[str, Any]:
    field = found.field
    assert field is not None
    return {
        "length_m": field.length_m.tolist(),
        "outputs": [
            {"output": label, "ratio": field.ratio[:, row].tolist(), "left_out": field.left_out[:, row].tolist()}
            for row, label in enumerate(found.label)
            if found.felt[row]
        ],
    }


def material_lines(materials: list[dict[str, Any]], most: int | None) -> list[str]:
    """What one per cent more of each property does, the `most` of them; None: all."""
    if not materials:
        return []
    rows = [
        (f"{m['of']} {m['quantity']}", m["used_by"], f"{m['change']:+.3g} %", m["output"], m["area"])
        for m in materials[:most]
    ]
    more = len(materials) - len(rows)
    return [
        "what one per cent more does to the rms of the output that it changes most, where the temperatures of the areas"
        " vary independently and by as much",
        *table(("one per cent of", "in", "rms", "output", "most by"), rows, right=(2,)),
        *([f"and {more} more (--top 0: all)"] if more else []),
    ]


def _table(found: AdjointResults) -> list[str]:
    rows = [
        (
            a.output,
            a.unit.removesuffix("/K"),
            f"{a.by_mean:.2e}",
            a.mean_area,
            f"{a.by_gradient:.2e}",
            a.gradient_area,
        )
        for a in found.acting_most
    ]
    cancels = found.mean_cancellation
    return [
        *table(("output", "unit", "per K", "most by", "per K/m within", "most by"), rows, right=(2, 4)),
        f"within an area the sizes of what each grid does are {np.median(cancels):.2g} times their sum (median)",
        f"in {int((cancels > _MUCH).sum()):,} of {cancels.size:,} sums they are more than {_MUCH} times as much: an"
        " even temperature hides there what an uneven one does",
        *_cancelling(found),
        "",
        *_against_a_field(found),
    ]


def _cancelling(found: AdjointResults) -> list[str]:
    """The worst of what cancels, by name."""
    worst = [f"{c.area} in {c.output} ({c.factor:.3g})" for c in found.cancelling_most[:_WORST]]
    return [f"most of what does not cancel altogether: {', '.join(worst)}"] if worst else []


def _against_a_field(found: AdjointResults) -> list[str]:
    """The ratios furthest from 1 over the correlation length, and what is left out."""
    field, felt = found.field, np.flatnonzero(found.felt)
    if field is None:
        return ["areas against a temperature field: not found of so many grids; --area-error does it all the same"]
    rows = []
    for length, ratio, left in zip(field.length_m, field.ratio[:, felt], field.left_out[:, felt], strict=True):
        far, most = int(np.abs(ratio - 1.0).argmax()), int(left.argmax())
        names = [found.label[felt[i]] for i in (far, most)]
        rows.append((f"{1e3 * length:g}", f"{ratio[far]:.3f}", names[0], f"{100 * left[most]:.1f} %", names[1]))
    return [
        "areas against even temperature fields of some correlation length: rms by the areas over that of the field",
        *table(("length mm", "ratio", "furthest from 1", "left out", "most in"), rows, right=(0, 1, 3)),
    ]
