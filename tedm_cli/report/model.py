"""The model and its distortion, as a section of the report."""

from __future__ import annotations

from collections import Counter

import numpy as np

from tedm_cli.report.document import Columns, Facts, Section, Table, Text, columns, row
from tedm_cli.results.areas import unit_per
from tedm_cli.results.model import DistortionSize, ModelSize
from tedm_cli.results.wording import decimals, sci


def model_section(model: ModelSize, distortion: DistortionSize) -> Section:
    """Size and mass of the model, its areas and elements, and how it deforms."""
    facts: list[tuple[str, Text]] = [
        ("Grids", f"{model.grids:,}"),
        ("Elements", f"{len(model.card):,}"),
        ("Mass", f"{model.mass_kg:.6g} kg"),
        ("Centre of gravity", f"{decimals(model.centre_of_gravity_m.tolist(), 1e3, 3)} mm, Nastran basic frame"),
        ("Symmetry plane of sides and mirror pairs", model.symmetry_plane),
        *_distortion_facts(distortion),
    ]
    tables = Columns((_areas(model), _elements(model)))
    return Section("model", "Model and distortion", "Model", (Facts(tuple(facts)), tables))


def _distortion_facts(distortion: DistortionSize) -> list[tuple[str, Text]]:
    facts: list[tuple[str, Text]] = []
    parts = zip(distortion.most(distortion.largest), distortion.most(distortion.rigid), strict=True)
    for (unit, largest, of), (_, rigid, rigid_of) in parts:
        per = "kelvin of one area" if unit == "K" else f"{unit} of one gradient"
        shown = unit_per("m", unit)
        facts += [
            (f"Largest translation per {per}", f"{sci(largest)} {shown} ({of})"),
            ("Its rigid-body part at most", f"{sci(rigid)} {shown} at the centre of gravity ({rigid_of})"),
        ]
    summed = "mean temperatures" if distortion.areas.gradient.any() else "areas"
    residuals: list[tuple[str, Text]] = [
        (
            f"Superposition, {what}",
            f"largest |sum over {summed} − uniform load| is {sci(residual, 2)} of the largest |uniform load|",
        )
        for what, residual in (
            ("translations of all grids", distortion.superposition_translation),
            ("rotations of the optical elements", distortion.superposition_optics),
        )
        if residual is not None
    ]
    return facts + (residuals or [("Superposition", "not checked: the results hold no uniform load")])


def _areas(model: ModelSize) -> Table:
    groups, shields, mass = model.areas.group_by_unit, model.areas.shield, model.area_mass_kg
    rows = []
    for group in dict.fromkeys(groups.tolist()):
        members = [i for i, g in enumerate(groups) if g == group]
        sides = ", ".join(sorted({shields[i] for i in members}))
        rows.append(row(group, f"{len(members)}", sci(float(mass[members].sum())), sides))
    rows.append(row("all", f"{len(groups)}", sci(float(mass.sum())), "", kind="sum"))
    head = columns("Group", "Areas", "Lumped mass\n(kg)", "Thermal shield", text=(0, 3))
    return Table(head, tuple(rows), "Thermal areas by group.")


def _elements(model: ModelSize) -> Table:
    types, mass = model.card, model.element_mass_kg
    rows = [
        row(kind, f"{number:,}", sci(float(mass[np.array(types) == kind].sum())))
        for kind, number in sorted(Counter(types).items())
    ]
    concentrated = model.concentrated_kg
    rows.append(row("concentrated masses", f"{len(concentrated):,}", sci(float(concentrated.sum()))))
    return Table(columns("Type", "Number", "Mass\n(kg)", text=(0,)), tuple(rows), "Elements by type.")
