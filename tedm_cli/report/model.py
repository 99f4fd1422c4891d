"""The model and its distortion, as a section of the report."""

from __future__ import annotations

from collections import Counter

import numpy as np

from tedm_cli.files.store import Reader
from tedm_cli.report.document import Columns, Facts, Section, Table, Text, columns, row
from tedm_cli.results.wording import sci, vector


def model_section(unit_loads: Reader, distortion: Reader) -> Section:
    """Size and mass of the model, its areas and elements, and how it deforms."""
    facts: list[tuple[str, Text]] = [
        ("Grids", f"{unit_loads.dataset('/grid/id').shape[0]:,}"),
        ("Elements", f"{unit_loads.dataset('/element/id').shape[0]:,}"),
        ("Mass", f"{unit_loads.number('/mass/total'):.6g} kg"),
        ("Centre of gravity", f"{vector(unit_loads.array('/mass/centre_of_gravity').tolist())} m, Nastran basic frame"),
        *_distortion_facts(distortion),
    ]
    tables = Columns((_areas(unit_loads), _elements(unit_loads)))
    return Section("model", "Model and distortion", "Model", (Facts(tuple(facts)), tables))


def _distortion_facts(file: Reader) -> list[tuple[str, Text]]:
    names = file.strings("/area/name")
    largest = file.array("/check/max_translation")
    rigid = np.linalg.norm(file.array("/check/rigid_translation"), axis=1)
    facts: list[tuple[str, Text]] = [
        (
            "Largest translation per kelvin of one area",
            f"{sci(float(largest.max()))} m/K ({names[int(largest.argmax())]})",
        ),
        (
            "Its rigid-body part at most",
            f"{sci(float(rigid.max()))} m/K at the centre of gravity ({names[int(rigid.argmax())]})",
        ),
    ]
    residuals: list[tuple[str, Text]] = [
        (
            f"Superposition, {what}",
            f"largest |sum over areas − uniform load| is {sci(file.number(f'/check/superposition_{key}'), 2)} of the"
            " largest |uniform load|",
        )
        for key, what in (("translation", "translations of all grids"), ("optics", "rotations of the optical elements"))
        if file.has(f"/check/superposition_{key}")
    ]
    return facts + (residuals or [("Superposition", "not checked: the results hold no uniform load")])


def _areas(file: Reader) -> Table:
    groups, shields = file.strings("/area/group"), file.strings("/area/shield")
    mass = file.array("/area/mass")
    rows = []
    for group in dict.fromkeys(groups):
        members = [i for i, g in enumerate(groups) if g == group]
        sides = ", ".join(sorted({shields[i] for i in members}))
        rows.append(row(group, f"{len(members)}", sci(float(mass[members].sum())), sides))
    rows.append(row("all", f"{len(groups)}", sci(float(mass.sum())), "", kind="sum"))
    head = columns("Group", "Areas", "Lumped mass\n(kg)", "Thermal shield", text=(0, 3))
    return Table(head, tuple(rows), "Thermal areas by group")


def _elements(file: Reader) -> Table:
    types, mass = file.strings("/element/type"), file.array("/element/mass")
    rows = [
        row(kind, f"{number:,}", sci(float(mass[np.array(types) == kind].sum())))
        for kind, number in sorted(Counter(types).items())
    ]
    concentrated = file.array("/mass/concentrated")
    rows.append(row("concentrated masses", f"{len(concentrated):,}", sci(float(concentrated.sum()))))
    return Table(columns("Type", "Number", "Mass\n(kg)", text=(0,)), tuple(rows), "Elements by type")
