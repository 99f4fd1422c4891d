"""A made-up project: random matrices that fit the contracts, the shipped bench moved at random, and real cases."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from tedm_cli.config.base import read_toml
from tedm_cli.config.cases import select_cases
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project, load_project
from tedm_cli.contracts import DISTORTION, OPTICS, SENSITIVITY, UNIT_LOADS, FileKind
from tedm_cli.contracts.spec import Values
from tedm_cli.figures.drawing.style import style, svg
from tedm_cli.files.provenance import Provenance, input_files
from tedm_cli.files.store import create
from tedm_cli.gravity.requirement_presets import lpf_limits
from tedm_cli.gravity.requirements import ALL, dc_quantities, judge_at_rest
from tedm_cli.optics.chain import optics_chain
from tedm_cli.optics.labels import input_labels, read_out_labels
from tedm_cli.optics.layout import OpticalLayout
from tedm_cli.optics.plates import PlateEffect, plate_sensitivity
from tedm_cli.optics.sensitivity import optical_sensitivity
from tedm_cli.progress import silent
from tedm_cli.results.build_folder import open_results
from tedm_cli.results.cases.file import read_case
from tedm_cli.stages.dynamics.build import build_dynamics
from tedm_cli.stages.dynamics.simulate import simulate
from tedm_cli.stages.noise.case import run_cases
from tedm_cli.stages.reporting.plot import FIGURES, figure_specs

CASES = """
safety_factor = 2.0

[temperature]
preset = "thesis"

[frequency]
points = 61

[[requirement]]
name = "lpf_selfgravity_ltp"
outputs = ["TM1_a_x", "TM2_a_x"]

[[requirement]]
name = "lpf_readout_item"
outputs = ["A_TM1_x", "B_TM2_x"]

[[case]]
id = "1"
title = "All correlated: 5 < 7 & $x$"
blocks = [{ areas = ["*"] }]

[[case]]
id = "2"
title = "All uncorrelated"
blocks = [{ areas = ["*"], each_alone = true }]

[[case]]
id = "4b"
title = "Inside the thermal shield only"
blocks = [{ shield = ["inside"] }]
"""
MODEL = """# model of <nothing> & all
[model]
[areas]
symmetry_plane = { point_m = [0.0, 0.125, 0.0], normal = [0.0, 1.0, 0.0] }
rule = [{ match = "*", group = "all", shield = "inside" }]
[[test_mass]]
name = "TM1"
position_m = [0.188, 0.0, 0.0]
side_m = 0.046
mass_kg = 1.928
[[test_mass]]
name = "TM2"
position_m = [-0.188, 0.0, 0.0]
side_m = 0.046
mass_kg = 1.928
"""
LAYOUT = Path(__file__).parents[2] / "configs" / "optics.toml"
# Names as users may write them: markup and mathematical type must come out as text.
AREAS = {
    "/area/id": [1, 2, 3, 4, 5],
    "/area/name": ["STRUT_1", "STRUT_2", "OB <b>&", "IS1_$a$_b", "IS1_OUTER"],
    "/area/group": ["struts", "struts", "OB", "IS1", "IS1"],
    "/area/shield": ["outside", "outside", "inside", "inside", "inside"],
    "/area/side": ["+y", "-y", "mid", "mid", "+y"],
    "/area/kind": ["mean"] * 5,
    "/area/unit": ["K"] * 5,
    "/symmetry_plane/point": [0.0, 0.125, 0.0],
    "/symmetry_plane/normal": [0.0, 1.0, 0.0],
    "/symmetry_plane/origin": "configured",
    "/symmetry_plane/layout": "",
}
ODD = "optics.toml: more than 20 mm away from the grid that carries it: PD1A 192 mm (grid 900101)"
MASSES = ["TM1", "TM2"]
ROWS = [f"{tm}_{q}_{c}" for q in ("a", "omegadot") for tm in MASSES for c in "xyz"]
MOTION_ROWS = [f"{tm}_{q}_{c}" for tm in MASSES for q in ("a", "omegadot") for c in "xyz"]
SIZES = {
    "node": 7, "area": 5, "optical": 22, "row": 12, "test_mass": 2, "source": 3, "element": 4, "area_edge": 6,
    "area_member": 7, "element_edge": 5, "element_member": 12, "concentrated": 1, "ray_output": 40, "element_dof": 144,
    "laser_output": 12, "test_mass_dof": 12, "read_out": 6, "set": 2, "residual": 3, "test_mass_dof_singular": 12,
    "xyz": 3, "xyz_column": 3, "offset_node": 2, "tm_output": 12, "tm_motion": 12, "dc_verdict": 42,
    "bench": 1, "note": 1, "rigid_motion": 6, "bench_xyz": 3, "block": 2, "block_edge": 3, "block_member": 3, "tie": 1,
    "tie_edge": 2, "tie_member": 3, "area_element_member": 3, "surface_triangle": 24, "corner": 3, "plate": 2,
}  # fmt: skip


def write_random(
    path: Path, kind: FileKind, trace: Provenance, given: Mapping[str, Any], seed: int, units: Mapping[str, str]
) -> None:
    """A file of `kind` with the datasets in `given`, and made-up numbers and names everywhere else."""
    rng = np.random.default_rng(seed)
    sizes = SIZES | kind.fixed_dims | ({"element": 24} if kind is OPTICS else {})  # there of the bench
    with create(path, kind, trace) as writer:
        for pattern, spec in kind.datasets.items():
            for name in [pattern.format(set=s) for s in "AB"] if "{set}" in pattern else [pattern]:
                shape = tuple(sizes[d] for d in spec.dims)
                value: Any = rng.normal(size=shape) * 1e-9
                if spec.dtype == "str" and not shape:
                    value = made_up_word(spec.values, spec.long_name, 0) if spec.values.words else spec.long_name
                elif spec.dtype == "str":
                    value = [made_up_word(spec.values, f"{name.rsplit('/', 1)[-1]}_{i}", i) for i in range(shape[0])]
                elif spec.dtype == "int":
                    value = whole_numbers(spec.values, shape, sizes)
                writer.write(name, given.get(name, value), units=units.get(name, "1"))


def made_up_word(rule: Values, name: str, i: int) -> str:
    """A word that a contract knows, or a name and, where the contract wants one, its end."""
    if rule.words:
        return rule.words[i % len(rule.words)]
    return f"{name}_{rule.ends[i % len(rule.ends)]}" if rule.ends else name


def whole_numbers(rule: Values, shape: tuple[int, ...], sizes: Mapping[str, int]) -> np.ndarray:
    """Ascending numbers as a contract wants them, and rows again and again where there are more of them than rows."""
    if rule.starts_in:
        return np.linspace(0, sizes[rule.starts_in], shape[0]).astype(np.int64)
    numbers = np.arange(int(np.prod(shape)), dtype=np.int64).reshape(shape)
    return numbers % sizes[rule.rows_of] if rule.rows_of else numbers + (rule.least or 0)


def field_at_rest(rng: np.random.Generator) -> dict[str, Any]:
    """A field along x and z whose y is rounding, and the verdicts on it: some met, some not."""
    acceleration, angular = rng.normal(size=(2, 2, 3, 3)) * 1e-9
    acceleration[..., 1] *= 1e-15
    acceleration[0, 0, 0] = 5e-9  # whatever the seed, the difference along x misses its limit
    gamma = rng.normal(size=(2, 3, 3, 3)) * 1e-8
    fields = {}
    for t, name in enumerate(MASSES):
        field = [q[t] for q in (acceleration, angular, gamma)]
        total, sensor = dc_quantities(*(q.sum(axis=0) for q in field)), dc_quantities(*(q[0] for q in field))
        fields[name] = {ALL: total, "IS": sensor, "LTP": total - sensor}
    verdicts = judge_at_rest(lpf_limits(("IS", "LTP"), tuple(MASSES)), fields, "LTP")
    words = ("test_mass", "minus", "quantity", "subsystem", "requirement", "source", "unit")
    return {
        "/dc/acceleration": acceleration,
        "/dc/angular_acceleration": angular,
        "/stiffness/gamma_lin": gamma,
        **{f"/dc_verdict/{c}": [getattr(v, c) for v in verdicts] for c in words},
        "/dc_verdict/whole": np.array([int(v.whole) for v in verdicts]),
        **{f"/dc_verdict/{c}": np.array([getattr(v, c) for v in verdicts]) for c in ("value", "lower", "upper")},
        "/dc_verdict/ratio": np.array([v.ratio for v in verdicts]),
        "/dc_verdict/passed": np.array([int(v.passed) for v in verdicts]),
    }


def moved_bench(layout: OpticalLayout, rng: np.random.Generator) -> tuple[dict[str, Any], dict[str, Any]]:
    """Random motions of the bench's grids, which lie at the reference points, and the optics that follow from them."""
    motion = 1e-8 * rng.normal(size=(5, len(layout.bench), 6))
    motion[2] *= 10.0  # one area is the worst for most read-outs: few figures of the bench under load
    matrix = optical_sensitivity(layout)
    plates = tuple(e for e in layout.elements if e.name in ("W1", "BS3"))
    change = np.zeros((2, 2, 5))  # of areas that are no gradient in any project
    change[:, :, :3] = 1e-7 * np.random.default_rng(7).normal(size=(2, 2, 3)) * np.array([[[1.0], [1e-3]]])
    glass = PlateEffect(plates, plate_sensitivity(layout, plates), change)
    chain = optics_chain(layout, matrix, motion, plates=glass)
    labels = read_out_labels(layout)
    names = [e.name for e in layout.bench]
    position = np.array([e.ref_m for e in layout.bench])
    moves = {
        "/optical/name": names,
        "/optical/position": position,
        "/D_opt/translation": motion[..., :3],
        "/D_opt/rotation": motion[..., 3:],
    }
    return moves, {
        "/S_BW": matrix,
        "/P": chain.P,
        "/O_ideal": chain.O_ideal,
        "/D": chain.D,
        **{f"/N/{read.name}": read.N for read in chain.sets},
        **{f"/N_plates/{read.name}": read.N_plates for read in chain.sets},
        "/plate/name": [plate.name for plate in plates],
        "/plate/by_index": glass.sensitivity[:, :, 0],
        "/plate/by_thickness": glass.sensitivity[:, :, 1],
        "/plate/index_change": change[:, 0],
        "/plate/thickness_change": change[:, 1],
        "/element/name": [e.name for e in layout.elements],
        "/element/bench": ["" if e.kind == "test_mass" else "bench" for e in layout.elements],
        "/bench/name": ["bench"],
        "/test_mass/name": [e.name for e in layout.test_masses],
        "/test_mass/axes": layout.test_mass_axes,
        "/label/element_dof": list(input_labels(layout).names),
        "/label/test_mass_dof": list(input_labels(layout, layout.test_masses).names),
        "/label/read_out": list(labels.names),
        "/label/read_out_unit": list(labels.units),
        "/set/name": [read.name for read in chain.sets],
        "/set/condition": np.array([read.law.condition for read in chain.sets]),
        "/rank": chain.rank,
        "/singular_values": chain.singular_values,
        "/optical/name": names,
    }


def write_matrices(
    project: Project,
    seed: int = 1,
    changed: Mapping[str, Any] | None = None,
    kinds: Sequence[str] = ("mean",) * 5,
) -> None:
    """Unit loads, distortion, sensitivities and optics, chained by their hashes as the stages chain them.

    `changed` replaces datasets of the sensitivities; `kinds` are those of the areas.
    """
    units = ["K/m" if kind == "gradient" else "K" for kind in kinds]
    areas = {**AREAS, "/area/kind": list(kinds), "/area/unit": units}
    build = project.build_dir
    model, (optics, layout) = read_toml(project.model)[0], load_layout(project.required_optics())
    rng = np.random.default_rng(seed)
    unit_loads, distortion = build / "unit_loads.h5", build / "distortion.h5"

    def trace(config: Any, *sources: Path) -> Provenance:
        return Provenance((config,), input_files(sources), "tedm made up")

    element = {"/element/type": ["CHEXA", "CBAR", "CHEXA", "CHEXA"], "/element/mass": [1.0, 0.5, 2.0, 3.0]}
    loads = {**areas, **element, "/mass/total": 6.5, "/area/mass": [0.25, 0.25, 3.0, 1.0, 2.0]}
    write_random(unit_loads, UNIT_LOADS, trace(model), loads, seed, {})
    moves, matrices = moved_bench(layout, rng)
    write_random(distortion, DISTORTION, trace(optics, unit_loads), {**areas, **moves}, seed, {})
    labels = {
        **areas,
        "/row/label": ROWS,
        "/row/unit": ["m/s^2/K"] * 6 + ["rad/s^2/K"] * 6,
        "/S": rng.normal(size=(12, 5)) * 1e-13,
        "/test_mass/name": MASSES,
        "/source/name": ["structure", "other test mass", "compensation masses"],
        "/source/mass_model": "quadrature",
        "/test_mass/mass": [1.928, 1.928],
        "/test_mass/side": np.full((2, 3), 0.046),
        "/test_mass/inertia": np.array([np.eye(3) * 1.928 * 0.046**2 / 6.0] * 2),
        "/test_mass/position": np.array([[0.188, 0.0, 0.0], [-0.188, 0.0, 0.0]]),
        "/test_mass/box_centre": np.array([[0.188, 0.0, 0.0], [-0.188, 0.0, 0.0]]),
        "/test_mass/axes": np.array([layout.axes, layout.axes]),
        **field_at_rest(rng),
        "/label/tm_output": MOTION_ROWS,
        "/label/tm_output_unit": [unit for _ in MASSES for unit in ("m/s^2", "rad/s^2") for _ in "xyz"],
        "/label/tm_motion": [f"{tm}_{c}" for tm in MASSES for c in ("x", "y", "z", "theta", "eta", "phi")],
        "/label/tm_motion_unit": [unit for _ in MASSES for unit in ("m", "rad") for _ in "xyz"],
        **(changed or {}),
    }
    write_random(build / "sensitivity.h5", SENSITIVITY, trace(model, unit_loads, distortion), labels, seed, {})
    matrices["/note"] = [ODD]
    write_random(build / "optics.h5", OPTICS, trace(optics, distortion), {**areas, **matrices}, seed, {})


def make_project(
    folder: Path,
    cases: str = CASES,
    changed: Mapping[str, Any] | None = None,
    kinds: Sequence[str] = ("mean",) * 5,
) -> Project:
    """A project with all results up to its cases."""
    (folder / "tedm.toml").write_text('title = "Made up & <small>"\n', encoding="utf-8")
    (folder / "model.toml").write_text(MODEL, encoding="utf-8")
    (folder / "optics.toml").write_text(LAYOUT.read_text(encoding="utf-8"), encoding="utf-8")
    (folder / "cases.toml").write_text(cases, encoding="utf-8")
    project = load_project(folder / "tedm.toml", folder / "build")
    write_matrices(project, changed=changed, kinds=kinds)
    run_cases(project, select_cases(project.cases, ["all"]), None, silent)
    return project


def close_loop(project: Project, case_ids: Sequence[str] = ("1", "2", "4b")) -> None:
    """The default loop around the made-up test masses, and the cases in it."""
    build_dynamics(project, None)
    simulate(project, case_ids, None, silent)


def sketch(project: Project) -> None:
    """Empty figures that bear the sources of the real ones, for tests of what stands around them."""
    folder = project.build_dir / FIGURES
    folder.mkdir(parents=True, exist_ok=True)
    with open_results(project) as results:
        for spec in figure_specs(results, [read_case(case) for case in results.cases]):
            figure = Figure(figsize=(4.0, 3.0))
            with style():
                (folder / spec.name).write_bytes(svg(figure, "sketch", spec.sources))
