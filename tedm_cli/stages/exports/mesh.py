"""export-vtu: the finite-element mesh with displacements, gradients and contributions of each grid, for ParaView."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import CASE, DISTORTION, SENSITIVITY, UNIT_LOADS
from tedm_cli.errors import UsageError
from tedm_cli.exports.node_terms import gradient, superposed
from tedm_cli.exports.vtu import MeshArray, array_name, distinct, write_vtu
from tedm_cli.files.build_folder import DISTORTION_FILE, OPTICS_FILE, SENSITIVITY_FILE, UNIT_LOADS_FILE, require_input
from tedm_cli.files.provenance import InputFile, input_files
from tedm_cli.files.store import Reader, open_checked
from tedm_cli.noise.areas import AreaTable
from tedm_cli.progress import Step, counter
from tedm_cli.results.areas import read_areas, unit_per
from tedm_cli.results.gravity.compensation import Blocks, read_blocks
from tedm_cli.stages.common import known_name
from tedm_cli.stages.exports.mesh_adjoint import adjoint_arrays
from tedm_cli.stages.exports.mesh_cases import case_file, case_files, case_weights, require_moving, worst_of_cases
from tedm_cli.stages.exports.mesh_geometry import mesh_geometry, optical_grids
from tedm_cli.stages.exports.mesh_outputs import Output, read_output

UNIFORM = "uniform"


@dataclass(frozen=True)
class WantedArrays:
    """What to put on the mesh: names of areas (or `uniform`) and outputs, ids of cases."""

    areas: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()
    cases: tuple[str, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.areas or self.outputs or self.cases)


@dataclass(frozen=True)
class MeshExport:
    """What was written. `left_out`: cards and numbers of elements that have no cell."""

    paths: tuple[Path, ...]
    points: int
    cells: int
    on_points: tuple[MeshArray, ...]
    on_cells: tuple[MeshArray, ...]
    left_out: dict[str, int]


@dataclass(frozen=True, eq=False)
class _Term:
    """What the grids have in an output under `weights` [k] of the areas: the array's name, unit and meaning."""

    output: Output
    weights: FloatArray
    name: str
    unit: str
    meaning: str
    effects: float = 0.0  # what effects of the user's own have in it, at no grid


def export_mesh(build_dir: Path, output: Path | None, wanted: WantedArrays, step: Step) -> MeshExport:
    """Write the mesh with what was wanted; where nothing was, with what the worst verdict is about.

    Memory grows with the arrays that are written, not with the number of areas.

    Raises
    ------
    UsageError : an area, output or case that there is not, or a file that does not end in .vtu.
    InputError : a file is missing, stale, breaks its contract, or its matrices do not add up.
    """
    path = build_dir / "export" / "mesh.vtu" if output is None else output
    if path.suffix.lower() != ".vtu":
        raise UsageError(f"{path} does not end in .vtu", hint="-o names the file; --of chooses an output")
    with contextlib.ExitStack() as stack:
        unit = stack.enter_context(open_checked(build_dir / UNIT_LOADS_FILE, UNIT_LOADS))
        wanted = _completed(build_dir, wanted)
        distortion = None
        if wanted or (build_dir / DISTORTION_FILE).exists():
            distortion = stack.enter_context(open_checked(build_dir / DISTORTION_FILE, DISTORTION))
            require_input(distortion, input_files([build_dir / UNIT_LOADS_FILE])[0])
        blocks = None if distortion is None else _blocks(build_dir)
        mesh = mesh_geometry(unit, distortion, blocks)
        on_points, on_cells = mesh.on_points, mesh.on_cells
        if distortion is not None and wanted:
            on_points += _asked_arrays(build_dir, unit, distortion, blocks, wanted, step)
            of_grids, of_cells = adjoint_arrays(build_dir, unit, wanted.outputs, mesh.element)
            on_points, on_cells = on_points + of_grids, on_cells + of_cells
        on_cells = distinct(on_cells)
        on_points = [_with_corners(a, len(mesh.points)) for a in distinct(on_points)]
        paths = write_vtu(path, mesh.points, mesh.cells, on_points, on_cells, mesh.names)
    cells = sum(len(c.nodes) for c in mesh.cells)
    return MeshExport(tuple(paths), len(mesh.points), cells, tuple(on_points), tuple(on_cells), mesh.left_out)


def _blocks(build_dir: Path) -> Blocks | None:
    """The compensation masses of sensitivity.h5, where that file is there."""
    path = build_dir / SENSITIVITY_FILE
    if not path.exists():
        return None
    with open_checked(path, SENSITIVITY) as file:
        require_input(file, input_files([build_dir / DISTORTION_FILE])[0])
        return read_blocks(file)


def _with_corners(array: MeshArray, points: int) -> MeshArray:
    """With corners of blocks behind the grids, where they are not there already; these have nothing, or no number."""
    more = points - len(array.values)
    if not more:
        return array
    nothing = -1 if array.values.dtype.kind == "i" else 0.0
    corners = np.full((more, *array.values.shape[1:]), nothing, dtype=array.values.dtype)
    return replace(array, values=np.concatenate([array.values, corners]))


def _completed(build_dir: Path, wanted: WantedArrays) -> WantedArrays:
    """With what goes without saying: the worst verdict, its output and area, and the uniform load."""
    if not wanted:
        worst = worst_of_cases(list(case_files(build_dir).values()))
        if worst is not None:
            return WantedArrays((UNIFORM, worst.area), (worst.output,), (worst.case,))
        return WantedArrays((UNIFORM,)) if (build_dir / DISTORTION_FILE).exists() else wanted
    if wanted.cases and not wanted.outputs:
        found = [worst_of_cases([case_file(build_dir, case)]) for case in wanted.cases]
        outputs = tuple(dict.fromkeys(worst.output for worst in found if worst is not None))
        if not outputs:
            for case in wanted.cases:
                require_moving(case_file(build_dir, case))
            raise UsageError("nothing is judged in this case", hint="name an output: --of TM1_a_x")
        return WantedArrays(wanted.areas, outputs, wanted.cases)
    return wanted if wanted.areas or wanted.cases else WantedArrays((UNIFORM,), wanted.outputs)


def _asked_arrays(
    build_dir: Path, unit: Reader, distortion: Reader, blocks: Blocks | None, wanted: WantedArrays, step: Step
) -> list[MeshArray]:
    areas = read_areas(distortion)
    loads = {name: _weights(name, areas) for name in wanted.areas}
    file = input_files([build_dir / DISTORTION_FILE])[0]
    outputs = [read_output(build_dir, label, distortion, file) for label in dict.fromkeys(wanted.outputs)]
    terms = [*_area_terms(outputs, loads, areas), *_case_terms(build_dir, outputs, wanted.cases)]
    fields = _fields(unit, distortion, loads, [t.weights for t in terms if t.output.elements is None], step)
    grids = optical_grids(unit, distortion)
    arrays = _displacements(loads, fields, areas, blocks)
    for output in outputs:
        own = [t for t in terms if t.output is output]
        if output.elements is None:
            arrays += _gravity_arrays(build_dir, output, own, fields)
            continue
        for term in own:
            values = np.bincount(grids, output.elements @ term.weights, fields.grids).astype(np.float64)
            output.require_sum(values, term.weights, build_dir / OPTICS_FILE)
            arrays.append(MeshArray(term.name, values, term.unit, term.meaning + _rest(term), total=True))
    return arrays


@dataclass(frozen=True, eq=False)
class _Fields:
    """Displacements under weights of the areas (their bytes): of all grids [N, 3], and rotations of those with levers
    [L, 3]; rotations [N, 3] under the loads asked for, by name. `grids`: N."""

    moved: dict[bytes, FloatArray]
    levers: dict[bytes, FloatArray]
    turned: dict[str, FloatArray]
    grids: int


def _fields(
    unit: Reader, distortion: Reader, loads: dict[str, FloatArray], more: Sequence[FloatArray], step: Step
) -> _Fields:
    """Every different field once, and [D] read once for all of them."""
    different = {w.tobytes(): w for w in (*loads.values(), *more)}
    k, n, _ = distortion.dataset(DISTORTION.D_TRANSLATION).shape
    weights, own = (np.array([*rows]).reshape(-1, k) for rows in (different.values(), loads.values()))
    lever = distortion.dataset(DISTORTION.D_ROTATION)
    used, shown = (np.count_nonzero(w.any(axis=0)) for w in (weights, own))
    advance = counter(step, used * (n + lever.shape[1]) + shown * n, "reading displacements")
    return _Fields(
        dict(zip(different, superposed(distortion.dataset(DISTORTION.D_TRANSLATION), weights, advance), strict=True)),
        dict(zip(different, superposed(lever, weights, advance), strict=True)),
        dict(
            zip(
                loads,
                superposed(unit.dataset(UNIT_LOADS.ROTATION), own, advance, unit.array(UNIT_LOADS.AREA_LOAD_K)),
                strict=True,
            )
        ),
        n,
    )


def _displacements(
    loads: dict[str, FloatArray], fields: _Fields, areas: AreaTable, blocks: Blocks | None
) -> list[MeshArray]:
    arrays = []
    for name, weights in loads.items():
        u, theta = fields.moved[weights.tobytes()], fields.turned[name]
        if blocks is not None:
            moved, turned = blocks.motion(weights)
            u, theta = np.concatenate([u, moved]), np.concatenate([theta, turned])
        unit, per = _of_load(name, areas)
        arrays.append(MeshArray(array_name("displacement", name), u, unit_per("m", unit), f"translation {per}"))
        if theta.any():  # grids of solids do not turn
            arrays.append(MeshArray(array_name("rotation", name), theta, unit_per("rad", unit), f"rotation {per}"))
    return arrays


def _gravity_arrays(build_dir: Path, output: Output, terms: Sequence[_Term], fields: _Fields) -> list[MeshArray]:
    """The gradient of an output, and its terms: gradient times displacement, grid by grid."""
    path = build_dir / SENSITIVITY_FILE
    with open_checked(path, SENSITIVITY) as file:
        slope = gradient(file.dataset(SENSITIVITY.OPERATOR_G), output.rows)
        turning = gradient(file.dataset(SENSITIVITY.OPERATOR_G_ROTATION), output.rows)
        node = file.array(SENSITIVITY.OPERATOR_OFFSET_NODE)
    label, unit = output.label, output.unit
    arrays = [MeshArray(array_name("gradient", label), slope, f"{unit} per m", f"{label} by translation of the grid")]
    if len(node):
        everywhere = np.zeros_like(slope)
        everywhere[node] = turning
        meaning = f"{label} by rotation of the grid, from which a mass is offset"
        arrays.append(MeshArray(array_name("gradient_rotation", label), everywhere, f"{unit} per rad", meaning))
    for term in terms:
        key = term.weights.tobytes()
        values = np.einsum("nc,nc->n", slope, fields.moved[key])
        values[node] += np.einsum("nc,nc->n", turning, fields.levers[key])
        output.require_sum(values, term.weights, path)
        arrays.append(MeshArray(term.name, values, term.unit, term.meaning + _rest(term), total=True))
    return arrays


def _weights(name: str, areas: AreaTable) -> FloatArray:
    """Of the areas [k] under a load: of mean temperatures all together, or one area, of either kind."""
    names = areas.name.tolist()
    if name == UNIFORM and name not in names:
        return np.asarray(~areas.gradient, dtype=np.float64)
    weights = np.zeros(len(areas))
    weights[names.index(known_name("area", name, names))] = 1.0
    return weights


def _of_load(name: str, areas: AreaTable) -> tuple[str, str]:
    """Unit of a load, and in words what fields are per."""
    names = areas.name.tolist()
    if name not in names:
        return "K", f"per kelvin of all {'mean temperatures' if areas.gradient.any() else 'areas'} together"
    unit = areas.unit[names.index(name)]
    return unit, f"per {'kelvin' if unit == 'K' else unit} of area {name}"


def _area_terms(outputs: Sequence[Output], loads: dict[str, FloatArray], areas: AreaTable) -> list[_Term]:
    found = []
    for o in outputs:
        for name, weights in loads.items():
            unit, per = _of_load(name, areas)
            label = array_name("contribution", o.label, name)
            found.append(_Term(o, weights, label, unit_per(o.unit, unit), f"part of {o.label} {per}"))
    return found


def _case_terms(build_dir: Path, outputs: Sequence[Output], cases: Sequence[str]) -> list[_Term]:
    found = []
    for case in dict.fromkeys(cases):
        path = case_file(build_dir, case)
        with open_checked(path, CASE) as file:
            number = file.string(CASE.CASE_ID)
            for o in outputs:
                require_input(file, _source(build_dir, o))
                weights, hz, effects = case_weights(file, o.label, o.g)
                meaning = f"signed share of the PSD of {o.label} in case {number} at {hz * 1e3:.4g} mHz"
                found.append(_Term(o, weights, array_name("share", o.label, f"case{number}"), "1", meaning, effects))
    return found


def _source(build_dir: Path, output: Output) -> InputFile:
    return input_files([build_dir / (SENSITIVITY_FILE if output.elements is None else OPTICS_FILE)])[0]


def _rest(term: _Term) -> str:
    """What of an output is at no grid."""
    rest = term.effects + (0.0 if term.output.elsewhere is None else float(term.output.elsewhere @ term.weights))
    return f"; {rest:.6g} more at no grid: expanding test masses, glass of plates, own effects" if rest else ""
