"""accuracy: the published studies of numerical error, on the configured test mass and compensation masses."""

from __future__ import annotations

import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from tedm_cli import __version__
from tedm_cli.arrays import FloatArray
from tedm_cli.config.model.compensation import compensation_masses
from tedm_cli.config.model.file import ModelConfig, load_model
from tedm_cli.config.project import Project
from tedm_cli.errors import ConfigError, UsageError
from tedm_cli.files.store import replacing
from tedm_cli.gravity.accuracy import (
    SLAB_THICKNESS,
    Shape,
    bode_error,
    collapse_error,
    linearisation_error,
    nodal_mesh,
    simpson_error,
)
from tedm_cli.gravity.bodies.cuboid import Cuboid
from tedm_cli.gravity.compensation import field_of_compensation_masses
from tedm_cli.gravity.field import self_gravity
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.tables.csv_table import csv_line

if TYPE_CHECKING:
    from tedm_cli.figures.model.accuracy import Convergence, Isolines

FOLDER = "accuracy"
_MESH_NODES = 120_000
_SHAPES: dict[Shape, str] = {
    "centre": "cube to its centre",
    "corners": "cube to eight corners",
    "slab": f"slab, {SLAB_THICKNESS:g} d thick, to its centre",
}


@dataclass(frozen=True)
class Study:
    """What a study found: columns of the data file, the figure, and some values to print."""

    title: str
    notes: list[str]
    columns: dict[str, FloatArray]
    figure: Isolines | Convergence
    spot_head: tuple[str, ...]
    spots: list[tuple[str, ...]]


@dataclass(frozen=True)
class AccuracyResult:
    """A study and the files it was written to."""

    study: Study
    data: Path
    figure: Path


def accuracy(project: Project, number: str, output_dir: Path | None) -> AccuracyResult:
    """Run the study of one figure; write its data (CSV) and the figure (SVG).

    Raises
    ------
    UsageError : there is no such study.
    ConfigError : a model without test masses, or figure 6.4 without compensation masses.
    """
    if number not in STUDIES:
        raise UsageError(f"there is no accuracy study {number!r}", hint=f"there are: {', '.join(sorted(STUDIES))}")
    from tedm_cli.figures.model.accuracy import draw

    file, config = load_model(project.model)
    config.required_test_masses(project.model)
    study = STUDIES[number](project, config)
    folder = output_dir if output_dir is not None else project.build_dir / FOLDER
    stem = f"figure_{number.replace('.', '_')}"
    data, figure = folder / f"{stem}.csv", folder / f"{stem}.svg"
    notes = [study.title, *study.notes, f"tedm {__version__}; {file.path.name} sha256 {file.sha256}"]
    with replacing(data) as temporary:
        temporary.write_text(_csv_text(notes, study.columns), encoding="utf-8", newline="\n")
    drawn = draw(study.figure)
    with replacing(figure) as temporary:
        temporary.write_bytes(drawn)
    return AccuracyResult(study, data, figure)


def _csv_text(notes: list[str], columns: dict[str, FloatArray]) -> str:
    stream = io.StringIO()
    stream.writelines(f"# {' '.join(note.split())}\n" for note in notes)
    stream.write(csv_line(columns))
    for row in zip(*(c.ravel() for c in columns.values()), strict=True):
        stream.write(csv_line("" if np.isnan(v) else repr(float(v)) for v in row))
    return stream.getvalue()


def _test_mass_note(tm: TestMass) -> str:
    edges = f"edges {', '.join(f'{s:g}' for s in tm.side_m)} m"
    held = "" if isinstance(tm.body, Cuboid) else "the cuboid that holds it, "
    return f"test mass {tm.name}: {held}{edges}; reference: exact kernel of the cuboid"


def _plane(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Coordinates of every point of the plane, y slowest."""
    grid_x, grid_y = np.meshgrid(x, y)
    return grid_x, grid_y


def _quadrature(config: ModelConfig, number: str) -> Study:
    from tedm_cli.figures.model.accuracy import Isolines

    tm = config.test_masses()[0]
    half = float(tm.side_m.max()) / 2.0
    # 24 to 55 mm for an edge of 46 mm
    distance = half * np.linspace(1.043, 2.39, 64)
    is_force = number == "7.2"
    counts = list(range(1, 51)) if is_force else list(range(2, 51, 2))
    what = "Fx, composite Bode" if is_force else "Gamma_xy, composite Simpson"
    unit = "panels" if is_force else "divisions"
    error_of: Callable[..., FloatArray] = bode_error if is_force else simpson_error
    error = 100.0 * error_of(distance, counts, tm.side_m)
    title = f"Figure {number}: error of the quadrature over the test mass, {what}, source at X = Y = Z"
    y = np.array(counts, dtype=float)
    grid_x, grid_y = _plane(distance, y)
    near = np.array([half + 0.002, half + 0.010])
    shown = [5, 10, 25, 50] if is_force else [10, 20, 40, 50]
    spot = 100.0 * error_of(near, shown, tm.side_m)
    return Study(
        title,
        [_test_mass_note(tm), f"N: number of {unit} along z, {4 if is_force else 1} N + 1 points"],
        {"distance_m": grid_x, f"{unit}": grid_y, "error_percent": error},
        Isolines(
            title=f"Test mass quadrature: error of {what}",
            x_label="X = Y = Z [m]",
            y_label=f"N, {unit}",
            x=distance,
            y=y,
            panels={"error isolines": error},
            edge=half,
        ),
        (f"N ({unit})", *(f"error at {x:g} m" for x in near)),
        [(str(n), *(f"{v:.2g} %" for v in row)) for n, row in zip(shown, spot, strict=True)],
    )


def _collapse(config: ModelConfig, number: str) -> Study:
    from tedm_cli.figures.model.accuracy import Isolines

    tm = config.test_masses()[0]
    row = 0 if number == "7.3" else 1
    what = ("Fx", "Gamma_xx")[row]
    distance, size = (
        (np.linspace(0.06, 0.25, 24), np.linspace(0.002, 0.02, 19))
        if row == 0
        else (np.linspace(0.05, 0.25, 26), np.linspace(0.002, 0.026, 21))
    )
    errors = {shape: 100.0 * collapse_error(distance, size, tm.side_m, shape)[row] for shape in _SHAPES}
    grid_x, grid_y = _plane(distance, size)
    pairs = [(0.05, 0.005), (0.1, 0.01), (0.2, 0.02), (1.0, 0.02)]
    spots = []
    for r, d in pairs:
        found = [
            100.0 * float(collapse_error(np.array([r]), np.array([d]), tm.side_m, shape)[row][0, 0])
            for shape in _SHAPES
        ]
        spots.append((f"{r:g}", f"{d:g}", *(f"{v:.2g} %" for v in found), f"{found[0] * (r / d) ** 4:.3g} %"))
    return Study(
        f"Figure {number}: error in {what} of a source of edge d at r on the x axis, replaced by points",
        [_test_mass_note(tm), *(f"{shape}: {name}" for shape, name in _SHAPES.items())],
        {"distance_m": grid_x, "size_m": grid_y, **{f"{shape}_percent": error for shape, error in errors.items()}},
        Isolines(
            title=f"Size of elements: error of {what}",
            x_label="distance r [m]",
            y_label="edge d [m]",
            x=distance,
            y=size,
            panels={_SHAPES[shape]: error for shape, error in errors.items()},
            guideline=0.1,
        ),
        ("r [m]", "d [m]", *_SHAPES, "centre / (d/r)^4"),
        spots,
    )


def _linearisation(config: ModelConfig, number: str) -> Study:
    from tedm_cli.figures.model.accuracy import Isolines

    tm = config.test_masses()[0]
    half = float(tm.side_m[0]) / 2.0
    distance, displacement = np.linspace(half * 1.01, 0.2, 80), np.linspace(1e-9, 1e-7, 40)
    error = 100.0 * linearisation_error(distance, displacement, tm.side_m)
    grid_x, grid_y = _plane(distance, displacement)
    spots = []
    for x in (half + 0.002, 2.0 * half, 0.1, 0.2):
        found = 100.0 * linearisation_error(np.array([x]), np.array([1e-8, 9e-8]), tm.side_m)[:, 0]
        spots.append((f"{x:g}", *(f"{v:.3g} %" for v in found), f"{found[1] / (150.0 * 9e-8 / x):.3f}"))
    return Study(
        f"Figure {number}: error of the linearised change of Fx for a source on the x axis that moves along it",
        [_test_mass_note(tm), "linearised change: -Gamma_xx dx"],
        {"distance_m": grid_x, "displacement_m": grid_y, "error_percent": error},
        Isolines(
            title="Linearisation error of Fx",
            x_label="source distance along x [m]",
            y_label="displacement dx [m]",
            x=distance,
            y=displacement,
            panels={"error isolines": error},
            edge=half,
        ),
        ("x [m]", "dx = 1e-8 m", "dx = 9e-8 m", "over 1.5 dx/x"),
        spots,
    )


def _compensation_mesh(project: Project, config: ModelConfig, number: str) -> Study:
    from tedm_cli.figures.model.accuracy import Convergence

    blocks = compensation_masses(project, config)
    if not blocks:
        raise ConfigError(
            [("compensation_mass", "none; figure 6.4 meshes the compensation masses")],
            where=str(project.model),
            hint="give [[compensation_mass]] tables, or gravity.compensation_masses a CSV",
        )
    tm, g = config.test_masses()[0], config.gravity.gravitational_constant_m3_kg_s2
    exact_field, doubt, _ = field_of_compensation_masses(tm, blocks, g, tolerance=config.gravity.compensation_tolerance)
    exact = float(exact_field.acceleration[0])
    longest = max(float(b.size_m.max()) for b in blocks)
    edges, counts, values = [], [], []
    edge = longest
    while True:
        meshes = [nodal_mesh(block, edge) for block in blocks]
        count = sum(len(masses) for _, masses in meshes)
        if count > _MESH_NODES:
            break
        points, masses = (np.concatenate(part) for part in zip(*meshes, strict=True))
        edges.append(edge)
        counts.append(count)
        values.append(float(self_gravity(points, masses, tm, G=g).acceleration[0]))
        edge /= np.sqrt(2.0)
    value, nodes = np.array(values), np.array(counts, dtype=float)
    error = 100.0 * np.abs(value - exact) / abs(exact) if exact else np.full(len(values), np.nan)
    return Study(
        f"Figure {number}: Fx/M on {tm.name} of the compensation masses as nodal masses, against the number of nodes",
        [
            f"compensation masses: {len(blocks)}, {sum(b.mass_kg for b in blocks):.6g} kg, meshed by equal hexahedra",
            f"reference: graded quadrature, {exact:.12e} m/s^2, estimated relative error {doubt:.1e} of the magnitudes",
        ],
        {"element_m": np.array(edges), "nodes": nodes, "acceleration_x_m_s2": value, "error_percent": error},
        Convergence(
            title="Mesh of the compensation masses",
            value_label=f"Fx/M on {tm.name} [m/s^2]",
            nodes=nodes,
            value=value,
            exact=exact,
            error_percent=error,
        ),
        ("element [m]", "nodes", "Fx/M [m/s^2]", "error"),
        [
            (f"{e:.3g}", f"{n:,}", f"{v:.6e}", f"{x:.2g} %")
            for e, n, v, x in zip(edges, counts, values, error, strict=True)
        ],
    )


STUDIES: dict[str, Callable[[Project, ModelConfig], Study]] = {
    "6.4": lambda project, config: _compensation_mesh(project, config, "6.4"),
    "7.2": lambda _project, config: _quadrature(config, "7.2"),
    "7.3": lambda _project, config: _collapse(config, "7.3"),
    "7.8": lambda _project, config: _quadrature(config, "7.8"),
    "7.9": lambda _project, config: _collapse(config, "7.9"),
    "8.1": lambda _project, config: _linearisation(config, "8.1"),
}
