"""The optics in the report: quality of the matrices, and the areas that each read-out feels most."""

from __future__ import annotations

import numpy as np

from tedm_cli.noise.areas import AreaTable
from tedm_cli.report.document import (
    Block,
    Cell,
    Facts,
    Figure,
    Folded,
    Heading,
    Paragraph,
    Section,
    Table,
    Text,
    columns,
    row,
)
from tedm_cli.report.frames import own_axes
from tedm_cli.results.areas import unit_per
from tedm_cli.results.optics import OpticsQuality, ReadOuts
from tedm_cli.results.ranking import first_largest
from tedm_cli.results.titles import output_title
from tedm_cli.results.wording import TO_LOOK_AT, and_text, capital, count, sci

_ROUNDING = 1e-12  # parts of a read-out that are so small are none


def optics_section(
    quality: OpticsQuality, read_outs: ReadOuts, areas: AreaTable, figures: dict[str, list[Figure]]
) -> Section:
    """What the report says of optics.h5."""
    blocks: list[Block] = [
        *figures["bench"],
        *_benches(read_outs),
        Heading("Sensitivity of the beams"),
        Facts(tuple(_facts(quality, read_outs))),
        _residuals(quality),
        *figures["optics"],
        Heading("Read-out by area"),
        Paragraph(
            "Read-out of the test masses per kelvin, in their own frames. Sum: all areas warmed together, with their"
            " signs; rss: root sum of squares over the areas, all of them uncorrelated."
            + " Gradients, per K/m, have their own table and are not part of the sums per kelvin."
            * bool(areas.gradient.any())
        ),
        *own_axes(list(read_outs.axes), np.array(list(read_outs.axes.values())), "layout frame"),
        *(_worst_areas(read_outs, areas, gradient) for gradient in sorted(set(areas.gradient.tolist()))),
        *_plates(read_outs, areas),
        *figures["read-out"],
    ]
    first, rest = figures["load"][:1], figures["load"][1:]
    blocks += [Heading(f"The bench{'es' if len(read_outs.benches) > 1 else ''} under the worst areas")] if first else []
    blocks += [*first, *(Folded(f.caption.split(", before")[0], (f,)) for f in rest)]
    return Section("optics", "Optics", "Optics", tuple(blocks))


def _benches(read_outs: ReadOuts) -> list[Table]:
    """Which elements are on which bench, where there are several."""
    if len(read_outs.benches) < 2:
        return []
    rows = tuple(row(name, ", ".join(elements)) for name, elements in read_outs.benches.items())
    caption = "Optical benches, each of which can move as a rigid body, and their elements."
    return [Table(columns("Bench", "Elements", text=(0, 1)), rows, caption)]


def _facts(quality: OpticsQuality, read_outs: ReadOuts) -> list[tuple[str, Text]]:
    shape, sigma, rank = quality.shape, quality.singular_value, quality.rank
    lever = np.linalg.norm(quality.reference_offset_m, axis=1)
    farthest = int(lever.argmax())
    beyond = f", then {sci(float(sigma[rank]), 2)}" if rank < len(sigma) else ""
    facts: list[tuple[str, Text]] = [
        ("Optical sensitivity matrix S_BW", f"{shape[0]} × {shape[1]}, layout frame (m, rad)"),
        (
            "Rank of O_ideal",
            f"{rank} for {count(len(read_outs.label), 'read-out')}; singular values"
            f" {', '.join(sci(float(v)) for v in sigma[:rank])}{beyond} (m, rad)",
        ),
    ]
    facts += [(f"Condition number, set {name}", f"{sci(c)} (m, rad)") for name, c in quality.condition.items()]
    facts.append(
        (
            "Reference points",
            f"up to {sci(float(lever[farthest]), 3)} m from their finite-element grids ({quality.element[farthest]}),"
            " which counts as a rigid lever",
        )
    )
    return facts + [(TO_LOOK_AT, note) for note in quality.notes]


def _residuals(quality: OpticsQuality) -> Table:
    rows = tuple(row(name.replace("_", " "), sci(value, 2)) for name, value in quality.residual.items())
    head = columns("Invariance", "Residual (1)", text=(0,))
    return Table(head, rows, "Residuals of invariances that hold exactly.")


def _plates(r: ReadOuts, areas: AreaTable) -> list[Table]:
    """What the read-outs are made of, where the glass of plates is a part of it."""
    if r.plates is None:
        return []
    means = ~areas.gradient
    rows = []
    for name in r.sets:
        parts = (r.gain[name] @ r.rigid_motion, r.gain[name] @ (r.motion - r.rigid_motion), r.N_plates(name), r.N[name])
        sizes = [np.linalg.norm(part[:, means], axis=1) for part in parts]
        for i, (label, unit) in enumerate(zip(r.label, r.unit, strict=True)):
            cell = Cell(capital(output_title(f"{name}_{label}")), label=f"{name}_{label}")
            numbers = [float(size[i]) if size[i] > _ROUNDING * sizes[-1][i] else 0.0 for size in sizes]
            rows.append(row(cell, *(sci(v, 3) for v in numbers), f"{unit}/K"))
    head = columns("Read-out", "Bench as one", "Distortion", "Plates", "N", "Unit", text=(0, 5))
    caption = (
        "What the read-outs are made of, root sum of squares over the areas: rigid motion of the bench, its distortion,"
        f" and the glass of the plates {and_text(r.plates.name)}, whose index and thickness change."
    )
    return [Table(head, tuple(rows), caption)]


def _worst_areas(r: ReadOuts, areas: AreaTable, gradient: bool) -> Table:
    """The area with the largest read-out for each degree of freedom, and all areas by root sum of squares; of one kind.

    Gradients have no sum: their signs are those of the directions that were chosen for them.
    """
    rows = []
    of = areas.gradient == gradient
    names, per = areas.name[of], np.array(areas.unit)[of][0]
    for name in r.sets:
        for label, unit, values in zip(r.label, r.unit, r.N[name][:, of], strict=True):
            worst = first_largest(range(len(values)), [float(v) for v in np.abs(values)])
            sums = [] if gradient else [float(values.sum())]
            numbers = (float(values[worst]), *sums, float(np.linalg.norm(values)))
            rows.append(
                row(
                    Cell(capital(output_title(f"{name}_{label}")), label=f"{name}_{label}"),
                    names[worst],
                    *(sci(v, 3) for v in numbers),
                    unit_per(unit, per),
                )
            )
    if gradient:
        head = columns("Read-out", "Worst gradient", "N", "Rss over gradients", "Unit", text=(0, 1, 4))
        return Table(head, tuple(rows), "Worst gradient of each read-out.")
    head = columns("Read-out", "Worst area", "N", "Sum over areas", "Rss over areas", "Unit", text=(0, 1, 5))
    return Table(head, tuple(rows), "Worst area of each read-out.")
