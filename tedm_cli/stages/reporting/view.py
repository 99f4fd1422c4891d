"""view: the model, its outputs and its cases as one page that can be turned, warmed and played."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli import __version__
from tedm_cli.arrays import IntArray
from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE, DISTORTION, SENSITIVITY, UNIT_LOADS
from tedm_cli.exports.mesh import label_of_cells
from tedm_cli.fem.surface import outer_surface
from tedm_cli.figures.drawing.colours import area_colours
from tedm_cli.files.build_folder import UNIT_LOADS_FILE, require_input
from tedm_cli.files.provenance import input_files
from tedm_cli.files.store import Reader, open_checked, replacing
from tedm_cli.gravity.bodies.solid import cuboid_mesh
from tedm_cli.noise.areas import AreaTable
from tedm_cli.progress import Step
from tedm_cli.results.build_folder import Results, open_results
from tedm_cli.results.gravity.compensation import read_blocks
from tedm_cli.results.optics import read_bench_motion
from tedm_cli.results.outputs import read_outputs
from tedm_cli.results.thermal.case_shares import of_network
from tedm_cli.results.titles import output_title
from tedm_cli.results.unit_loads import area_of_grids
from tedm_cli.results.wording import capital
from tedm_cli.stages.common import out_path
from tedm_cli.stages.reporting.view_cases import case_views, limits_of
from tedm_cli.stages.reporting.view_series import series_films
from tedm_cli.view.bench import drawn_bench
from tedm_cli.view.mesh import DrawnMesh, drawn_mesh
from tedm_cli.view.packing import Quantised, quantised
from tedm_cli.view.page import page
from tedm_cli.view.payload import Box, Drawing, ViewModel, payload, planes

VIEW_FILE = "view.html"
_BINARY = [0, 1, 3, 2, 4, 5, 7, 6]  # corners of VTK's hexahedron in the order of `_CUBE`
_CUBE, _BRICK = cuboid_mesh(np.full(3, -0.5), np.full(3, 0.5))
AT_REST = "The structure is drawn at rest: displacements of grids were not kept when its results were reduced"
MOST_NUMBERS = 6_000_000  # displacements in a page, of all areas: 12 MB before they are deflated
_MOST_TRIANGLES = 5_000  # of a test mass; one with more is drawn as the cuboid that holds it


@dataclass(frozen=True)
class ViewWritten:
    """What was written: how many of the model's grids are drawn, and how many cases and series are there.

    left_out : cases of the thermal network and series of thermal nodes, which are no areas that the page could move.
    moving : whether the structure moves; else the displacements of its grids were not kept.
    """

    path: Path
    drawn: int
    grids: int
    cases: int
    series: int
    left_out: tuple[str, ...]
    moving: bool


def view(project: Project, output: Path | None, step: Step, most_numbers: int = MOST_NUMBERS) -> ViewWritten:
    """Write the page.

    Raises
    ------
    InputError : a result is missing, or does not stem from the others or from the configuration as they are now.
    """
    path = out_path(project, VIEW_FILE, output)
    loads = project.build_dir / UNIT_LOADS_FILE
    with open_results(project) as results, open_checked(loads, UNIT_LOADS) as unit:
        used = [*input_files([loads]), results.distortion_file]
        for file in (results.distortion, *(m.reader for m in results.matrices)):
            for one in used:
                require_input(file, one)
        of_model = read_outputs(project)
        outputs = of_model.with_differences(results.config.applied_requirements())
        moving = results.distortion.has(DISTORTION.D_TRANSLATION)
        drawing = _drawing(project, results, unit, outputs.areas, most_numbers, step)
        content = ViewModel(
            title=project.title,
            version=__version__,
            sources=[
                (f.path.name, f.sha256) for f in (*used, *(m.file for m in results.matrices), *results.case_files)
            ],
            outputs=outputs,
            output_titles=[capital(output_title(label)) for label in outputs.labels],
            limits=limits_of(results.cases, results.requirement_titles),
            cases=case_views(project, results, of_model, step),
            series=series_films(project, results, outputs.areas),
            drawing=drawing,
            half=". ".join(filter(None, (results.half, AT_REST * (not moving)))),
        )
        text = page(project.title, payload(content))
        nodes = [f"case {file.string(CASE.CASE_ID)}" for file in results.cases if of_network(file)]
        nodes += [f"series {t.name}" for t in results.config.series if t.of == "nodes" and t.name in results.series]
    with replacing(path) as temporary:
        temporary.write_text(text, encoding="utf-8", newline="\n")
    drawn, there = (len(drawing.mesh.grid), drawing.grids), (len(content.cases), len(content.series))
    return ViewWritten(path, *drawn, *there, tuple(nodes), moving)


def _drawing(
    project: Project, results: Results, unit: Reader, areas: AreaTable, most_numbers: int, step: Step
) -> Drawing:
    position = unit.array(UNIT_LOADS.GRID_POSITION)
    label = area_of_grids(unit)
    card = unit.strings(UNIT_LOADS.ELEMENT_TYPE)
    surface = outer_surface(card, unit.array(UNIT_LOADS.ELEMENT_NODE_OFFSET), unit.array(UNIT_LOADS.ELEMENT_NODE_INDEX))
    mesh = drawn_mesh(
        position,
        surface,
        label_of_cells(surface.face, label),
        label_of_cells(surface.line, label),
        label,
        most_numbers // (3 * len(areas)),
    )
    bench, gravity = read_bench_motion(results.distortion), results.gravity
    layout = None if results.read_out is None else results.read_out.layout
    return Drawing(
        mesh=mesh,
        position=position[mesh.grid],
        motion=_motion(results.distortion, mesh.grid, step),
        grids=len(position),
        bench=drawn_bench(layout, bench.motion, bench.position_m),
        boxes=_boxes(None if gravity is None else gravity.reader, len(areas)),
        colour=area_colours(areas.group_by_unit.tolist(), _neighbours(mesh)),
    )


def _motion(distortion: Reader, grid: IntArray, step: Step) -> Quantised:
    """[D] of the drawn grids, read area by area; zeros where it was not kept."""
    if not distortion.has(DISTORTION.D_TRANSLATION):
        areas = len(distortion.strings(DISTORTION.AREA_NAME))
        return quantised(np.zeros((areas, 3 * len(grid))))
    dataset = distortion.dataset(DISTORTION.D_TRANSLATION)
    k = dataset.shape[0]
    rows = []
    for area in range(k):
        step(area, k, "reading displacements")
        field = np.asarray(dataset[area, :], dtype=np.float64)[grid]
        rows.append(quantised(planes(field[None])))
    step(k, k, "reading displacements")
    return Quantised(np.concatenate([q.scale for q in rows]), np.concatenate([q.step for q in rows]))


def _neighbours(mesh: DrawnMesh) -> set[tuple[int, int]]:
    """Pairs of areas, lower row first, whose faces share a grid."""
    corner = np.unique(np.column_stack([mesh.face.reshape(-1), np.repeat(mesh.face_area, 4)]), axis=0)
    pairs: set[tuple[int, int]] = set()
    for members in np.split(corner[:, 1], np.flatnonzero(np.diff(corner[:, 0])) + 1):
        if len(members) > 1:
            found = sorted(int(m) for m in members if m >= 0)
            pairs |= {(a, b) for i, a in enumerate(found) for b in found[i + 1 :]}
    return pairs


def _boxes(sensitivity: Reader | None, areas: int) -> list[Box]:
    """Compensation masses, which may move, before test masses; none of a project without test masses."""
    if sensitivity is None:
        return []
    blocks = read_blocks(sensitivity)
    corner = blocks.corner[:, _BINARY][:, _BRICK]
    motion = np.array([blocks.motion(one)[0] for one in np.eye(areas)]).reshape(areas, -1, 8, 3)
    boxes = [
        Box(name, "compensation mass", corner[i], motion[:, i, _BINARY][:, _BRICK.ravel()])
        for i, name in enumerate(blocks.name)
    ]
    surface = sensitivity.array(SENSITIVITY.TEST_MASS_SURFACE)
    owner = sensitivity.array(SENSITIVITY.TEST_MASS_SURFACE_OWNER)
    place = [sensitivity.array(d) for d in (SENSITIVITY.TEST_MASS_BOX_CENTRE, SENSITIVITY.TEST_MASS_SIDE)]
    axes = sensitivity.array(SENSITIVITY.TEST_MASS_AXES)
    for t, name in enumerate(sensitivity.strings(SENSITIVITY.TEST_MASS_NAME)):
        triangles = surface[owner == t]
        if len(triangles) > _MOST_TRIANGLES:
            triangles = place[0][t] + _CUBE[_BRICK] * place[1][t] @ axes[t]
        boxes.append(Box(name, "test mass", triangles))
    return boxes
