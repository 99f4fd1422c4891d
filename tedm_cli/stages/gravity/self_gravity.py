"""self-gravity: the field of a list of point sources on the test masses of the configuration."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.errors import InputError, UsageError
from tedm_cli.files.store import replacing
from tedm_cli.gravity.field import SelfGravity, self_gravity, self_gravity_by_source
from tedm_cli.gravity.testmass import TestMass, to_test_mass_frame
from tedm_cli.quantities import FAR_COORDINATE, POINT_MASS
from tedm_cli.tables.csv_table import Row, csv_line, read_table

COLUMNS = {**dict.fromkeys(("x_m", "y_m", "z_m"), FAR_COORDINATE), "mass_kg": POINT_MASS}
#: Unit of every quantity of `SelfGravity`, and the ending that says it in the name of a key or column.
FIELD_UNITS = {
    "acceleration": ("m/s^2", "m_s2"),
    "angular_acceleration": ("rad/s^2", "rad_s2"),
    "gamma_lin": ("1/s^2", "1_s2"),
    "omega_lin": ("1/(m s^2)", "1_m_s2"),
    "gamma_ang": ("m/(s^2 rad)", "m_s2_rad"),
    "omega_ang": ("1/(s^2 rad)", "1_s2_rad"),
}


@dataclass(frozen=True)
class PointSources:
    """Sources as read: lines of the file [n], positions [n,3] (basic frame, m), masses [n] (kg)."""

    path: Path
    line: list[int]
    position: FloatArray
    mass: FloatArray


@dataclass(frozen=True)
class PointField:
    """The sources and their field on each test mass; `by_source` has a leading axis over the sources."""

    sources: PointSources
    test_masses: list[TestMass]
    total: list[SelfGravity]
    by_source: list[SelfGravity] | None


def point_self_gravity(project: Project, points: Path, *, per_source: bool, output: Path | None) -> PointField:
    """Field of the point sources in a CSV file; written to `output` (.json or .csv) where one is given.

    Raises
    ------
    UsageError : `output` ends neither in .json nor in .csv.
    InputError : the file or a line of it is wrong, or a source is inside or on a test mass; names the line.
    """
    if output is not None and output.suffix not in (".json", ".csv"):
        raise UsageError(f"--output must end in .json or .csv, not {output.name!r}")
    _, config = load_model(project.model)
    test_masses = config.required_test_masses(project.model)
    g = config.gravity.gravitational_constant_m3_kg_s2
    sources = read_sources(points, test_masses)
    done = PointField(
        sources,
        test_masses,
        [self_gravity(sources.position, sources.mass, tm, G=g) for tm in test_masses],
        [self_gravity_by_source(sources.position, sources.mass, tm, G=g) for tm in test_masses] if per_source else None,
    )
    if output is not None:
        text = json.dumps(point_dict(done), indent=1) + "\n" if output.suffix == ".json" else _csv_text(done)
        with replacing(output) as temporary:
            temporary.write_text(text, encoding="utf-8", newline="\n")
    return done


def read_sources(path: Path, test_masses: list[TestMass]) -> PointSources:
    """Read `x_m,y_m,z_m,mass_kg` (basic frame), refusing implausible numbers and sources in a test mass."""
    rows = read_table(path, COLUMNS)
    position = np.array([[row.number[c] for c in list(COLUMNS)[:3]] for row in rows])
    for tm in test_masses:
        local = to_test_mass_frame(tm, position)
        inside = tm.body.first_inside(local)
        if inside is not None:
            fact = tm.body.inside_fact(local[inside]).replace("the test mass", f"test mass {tm.name!r}")
            raise InputError(f"the source {fact}", where=f"{path}:{rows[inside].line}")
    return PointSources(path, _lines(rows), position, np.array([row.number["mass_kg"] for row in rows]))


def _lines(rows: list[Row]) -> list[int]:
    return [row.line for row in rows]


def point_dict(done: PointField) -> dict[str, Any]:
    """The answer for programs."""
    answer: dict[str, Any] = {
        "points": str(done.sources.path),
        "sources": len(done.sources.line),
        "mass_kg": float(done.sources.mass.sum()),
        "test_masses": [
            {
                "name": tm.name,
                "force_N": (field.acceleration * tm.mass_kg).tolist(),
                "torque_N_m": (tm.inertia_kg_m2 @ field.angular_acceleration).tolist(),
                **_quantities(field),
            }
            for tm, field in zip(done.test_masses, done.total, strict=True)
        ],
    }
    if done.by_source is not None:
        answer["per_source"] = [
            {
                "line": line,
                "position_m": done.sources.position[i].tolist(),
                "mass_kg": float(done.sources.mass[i]),
                "test_masses": [
                    {"name": tm.name, **_quantities(field, i)}
                    for tm, field in zip(done.test_masses, done.by_source, strict=True)
                ],
            }
            for i, line in enumerate(done.sources.line)
        ]
    return answer


def _quantities(field: SelfGravity, index: int | None = None) -> dict[str, Any]:
    values = {f.name: getattr(field, f.name) for f in fields(SelfGravity)}
    return {f"{k}_{FIELD_UNITS[k][1]}": (v if index is None else v[index]).tolist() for k, v in values.items()}


def _csv_text(done: PointField) -> str:
    """Per source: a line per source and test mass; else a line per component."""
    lines: list[list[object]] = []
    if done.by_source is not None:
        columns = [f"{k}_{''.join(i)}_{FIELD_UNITS[k][1]}" for k in FIELD_UNITS for i in _components(k)]
        lines.append(["line", *COLUMNS, "test_mass", *columns])
        for n, line in enumerate(done.sources.line):
            for tm, field in zip(done.test_masses, done.by_source, strict=True):
                values = np.concatenate([getattr(field, k)[n].ravel() for k in FIELD_UNITS])
                place = [*done.sources.position[n], done.sources.mass[n]]
                lines.append([line, *(repr(float(v)) for v in place), tm.name, *(repr(float(v)) for v in values)])
        return "".join(map(csv_line, lines))
    lines.append(["test_mass", "quantity", "component", "unit", "value"])
    for tm, field in zip(done.test_masses, done.total, strict=True):
        for quantity, unit, value in totals(tm, field):
            axes = _components(quantity) if quantity in FIELD_UNITS else list("xyz")
            for component, v in zip(axes, value.ravel(), strict=True):
                lines.append([tm.name, quantity, component, unit, repr(float(v))])
    return "".join(map(csv_line, lines))


def totals(tm: TestMass, field: SelfGravity) -> list[tuple[str, str, FloatArray]]:
    """(quantity, unit, value) of everything on one test mass, force [N] and torque [N m] first."""
    return [
        ("force", "N", field.acceleration * tm.mass_kg),
        ("torque", "N m", tm.inertia_kg_m2 @ field.angular_acceleration),
        *((k, unit, getattr(field, k)) for k, (unit, _) in FIELD_UNITS.items()),
    ]


def _components(quantity: str) -> list[str]:
    return list("xyz") if "acceleration" in quantity else [i + j for i in "xyz" for j in "xyz"]
