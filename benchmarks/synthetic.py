"""Models and results of any size: a block of hexahedra around two test masses, and made-up displacements."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.base import read_toml
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project, load_project
from tedm_cli.contracts import UNIT_LOADS
from tedm_cli.deck_units import SI
from tedm_cli.files.provenance import Provenance
from tedm_cli.files.store import create
from tedm_cli.nastran.displacements import unit_load_displacements
from tedm_cli.nastran.geometry import ModelGeometry
from tedm_cli.nastran.loads.unit_loads import UnitLoad, UnitLoads
from tedm_cli.nastran.op2.writer import write_op2
from tedm_cli.nastran.positions import Frames
from tedm_cli.progress import Step, silent
from tedm_cli.stages.model.ingest import write_motions

CONFIGS = Path(__file__).parents[1] / "configs"
HALF_M = (0.5, 0.3, 0.2)
TEST_MASSES_M = ((-0.188, 0.0, 0.0), (0.188, 0.0, 0.0))
REACH_M = 0.027  # of the hollow from the centre of a test mass
MASS_KG = 600.0
FIRST_GRID = 1_000_000  # behind the optical grids of the shipped layout


@dataclass(frozen=True)
class Block:
    """A block of hexahedra, hollow around the test masses. Grids of the optical layout come first and hang free.

    grid_id : [N]; position : [N,3], m; nodes : [E,8], rows of the grid table; optical : number of optical grids.
    """

    grid_id: IntArray
    position: FloatArray
    nodes: IntArray
    optical: int


def hexahedra(cells: tuple[int, int, int], centres: Sequence[Sequence[float]]) -> tuple[FloatArray, IntArray]:
    """Grids [N,3] (m) and corners [E,8] of a block of 1.0 x 0.6 x 0.4 m without the elements around `centres`."""
    planes = [np.linspace(-half, half, n + 1) for half, n in zip(HALF_M, cells, strict=True)]
    position = np.stack(np.meshgrid(*planes, indexing="ij"), axis=-1).reshape(-1, 3)
    corner = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)])
    cell = np.stack(np.meshgrid(*(np.arange(n) for n in cells), indexing="ij"), axis=-1).reshape(-1, 1, 3)
    shape = tuple(n + 1 for n in cells)
    nodes = np.ravel_multi_index(tuple(np.moveaxis(cell + corner, -1, 0)), shape)
    solid = np.ones(len(nodes), dtype=bool)
    for centre in centres:
        low, high = (position[nodes[:, n]] - centre for n in (0, 6))
        solid &= ((low >= REACH_M) | (high <= -REACH_M)).any(axis=1)
    return position, nodes[solid]


def block(cells: tuple[int, int, int]) -> Block:
    """The block of `cells` elements along its edges, and the grids of the shipped layout."""
    layout = load_layout(CONFIGS / "optics.toml")[1]
    optical = [(e.grid, e.ref_m) for e in layout.elements if e.grid is not None]
    position, nodes = hexahedra(cells, TEST_MASSES_M)
    ids = sorted({int(grid) for grid, _ in optical})
    place = {int(grid): ref for grid, ref in optical}
    return Block(
        np.array([*ids, *range(FIRST_GRID, FIRST_GRID + len(position))]),
        np.concatenate([[place[i] for i in ids], position]),
        nodes + len(ids),
        len(ids),
    )


def motions(loads: UnitLoads, n_nodes: int) -> Iterator[tuple[UnitLoad, FloatArray, FloatArray]]:
    """Displacements of every load in turn, exact in single precision and costing nothing, and their sum at the end."""
    rng = np.random.default_rng(1)
    rows = (1e-6 * rng.normal(size=(2, 2, n_nodes, 3)).astype(np.float32)).astype(np.float32).astype(np.float64)
    for i, load in enumerate(loads.areas):
        yield load, *rows[i % 2]
    if loads.uniform is not None:
        even = (len(loads.areas) + 1) // 2
        total = even * rows[0] + (len(loads.areas) - even) * rows[1]
        yield loads.uniform, *total.astype(np.float32).astype(np.float64)


def unit_loads(model: Block, areas: int) -> UnitLoads:
    """Areas of about as many consecutive grids each, warmed by 1 K, and all together."""
    every = np.arange(len(model.grid_id))
    parts = [UnitLoad(i + 1, f"OB_{i + 1}", rows, 1.0) for i, rows in enumerate(np.array_split(every, areas))]
    return UnitLoads(parts, UnitLoad(areas + 1, "UNIFORM", every, 1.0))


def project(folder: Path, mass_model: str = "quadrature") -> Project:
    """A project with the shipped test masses and layout, its deck and results in the same folder."""
    folder.mkdir(parents=True, exist_ok=True)
    model = (CONFIGS / "model.toml").read_text(encoding="utf-8")
    for line in ('deck = "', 'op2 = ["'):
        model = model.replace(f"# {line}", f"{line}{{build_dir}}/")
    model = model.replace('mass_model = "quadrature"', f'mass_model = "{mass_model}"')
    dropped = (
        r"areas_csv = .*",
        r" *\{ match = \"(?!OB_).*",
        r"IS = .*",
        r"LTP = .*",
        r"\[\[requirement_at_rest\]\]\nname = \"lpf\"",
    )
    model = re.sub("|".join(rf"^{line}\n" for line in dropped), "", model, flags=re.MULTILINE)
    (folder / "model.toml").write_text(model, encoding="utf-8")
    names = "".join(f'{name} = "{CONFIGS / name}.toml"\n' for name in ("optics", "cases"))
    (folder / "tedm.toml").write_text(f'title = "made up"\n{names}', encoding="utf-8")
    return load_project(folder / "tedm.toml", folder)


def _inertia(position: FloatArray, kg: FloatArray) -> FloatArray:
    """Inertia tensor [3,3] of point masses about their centre of gravity."""
    arm = position - kg @ position / kg.sum()
    second = (kg[:, None] * arm).T @ arm
    return np.asarray(np.trace(second) * np.eye(3) - second)


def write_unit_loads(
    where: Project, model: Block, areas: int, step: Step = silent, results: Sequence[Path] = ()
) -> Path:
    """unit_loads.h5 of the block, its displacements (of `results`, or made up) written as `ingest` writes them."""
    loads = unit_loads(model, areas)
    n, elements = len(model.grid_id), len(model.nodes)
    share = np.full(8 * elements, MASS_KG / (8 * elements))
    lumped = np.bincount(model.nodes.ravel(), share, minlength=n)
    path = where.build_dir / "unit_loads.h5"
    with create(path, UNIT_LOADS, Provenance((read_toml(where.model)[0],), (), "made up")) as writer:
        for name, value in {
            "/grid/id": model.grid_id,
            "/grid/position": model.position,
            "/area/id": [a.subcase for a in loads.areas],
            "/area/name": [a.label for a in loads.areas],
            "/area/group": ["OB"] * areas,
            "/area/shield": ["inside"] * areas,
            "/area/side": ["mid"] * areas,
            "/area/kind": ["mean"] * areas,
            "/area/unit": ["K"] * areas,
            "/area/load_K": [a.load_K for a in loads.areas],
            "/area/mass": [lumped[a.rows].sum() for a in loads.areas],
            "/area/centroid": [model.position[a.rows].mean(axis=0) for a in loads.areas],
            "/symmetry_plane/point": np.zeros(3),
            "/symmetry_plane/normal": [0.0, 1.0, 0.0],
            "/symmetry_plane/origin": "basic",
            "/symmetry_plane/layout": "",
            "/area/node_offset": np.cumsum([0, *(len(a.rows) for a in loads.areas)]),
            "/area/node_index": np.concatenate([a.rows for a in loads.areas]),
            "/area/element_offset": np.zeros(areas + 1),
            "/area/element_index": [],
            "/element/id": np.arange(1, elements + 1),
            "/element/type": ["CHEXA"] * elements,
            "/element/property_id": np.ones(elements),
            "/element/node_offset": np.arange(0, 8 * elements + 1, 8),
            "/element/node_index": model.nodes.ravel(),
            "/element/lever": np.zeros((8 * elements, 3)),
            "/element/mass": np.full(elements, MASS_KG / elements),
            "/element/density": np.full(elements, 2700.0),
            "/element/expansion": np.full(elements, 2.3e-5),
            "/element/section": np.zeros(elements),
            "/element/weight": np.ones(8 * elements),
            "/mass/lumped": lumped,
            "/mass/concentrated": [],
            "/mass/concentrated_id": [],
            "/mass/concentrated_card": [],
            "/mass/concentrated_node": [],
            "/mass/concentrated_lever": np.zeros((0, 3)),
            "/mass/inertia": _inertia(model.position, np.asarray(lumped, dtype=np.float64)),
            "/mass/total": MASS_KG,
            "/results/precision": "single",
            "/tie/block": [],
            "/tie/to": [],
            "/tie/node_offset": [0],
            "/tie/node_index": [],
            "/mass/centre_of_gravity": lumped @ model.position / MASS_KG,
        }.items():
            writer.write(name, value)
        source = displacements_of(results, loads, model) if results else motions(loads, n)
        write_motions(writer, source, loads, n, single=True, step=step)
    return path


def displacements_of(
    results: Sequence[Path], loads: UnitLoads, model: Block
) -> Iterator[tuple[UnitLoad, FloatArray, FloatArray]]:
    """Displacements as `ingest` reads them, without a deck: all that is asked of the geometry, in the basic frame."""
    nowhere = np.zeros(len(model.grid_id), dtype=np.int64)
    geometry = SimpleNamespace(
        grid_id=model.grid_id,
        position_m=model.position,
        displacement_frame=nowhere,
        frames=Frames({}),
        structural=np.arange(len(nowhere)) >= model.optical,
        in_rigid_element=nowhere > 0,
        lumped_kg=nowhere,
        units=SI,
    )
    every = [*loads.areas, *([loads.uniform] if loads.uniform else [])]
    return unit_load_displacements(results, every, cast(ModelGeometry, geometry))


def write_deck(path: Path, model: Block, loads: UnitLoads) -> None:
    """The unit-load deck of the block: free optical grids, one material, TEMP cards."""
    with open(path, "w", encoding="ascii") as deck:
        deck.write("SOL 101\nCEND\nDISPLACEMENT(PLOT) = ALL\n")
        every = [*loads.areas, *([loads.uniform] if loads.uniform else [])]
        deck.writelines(
            f"SUBCASE {load.subcase}\n  LABEL = {load.label}\n  TEMPERATURE(LOAD) = {load.subcase}\n" for load in every
        )
        deck.write("BEGIN BULK\nMAT1,1,7.+10,,.33,2700.,2.3-5,0.\nPSOLID,1,1\n")
        deck.writelines(
            f"GRID,{n},,{x:.6f},{y:.6f},{z:.6f}\n" for n, (x, y, z) in zip(model.grid_id, model.position, strict=True)
        )
        for number, nodes in enumerate(model.grid_id[model.nodes], start=1):
            first, last = ",".join(map(str, nodes[:6])), ",".join(map(str, nodes[6:]))
            deck.write(f"CHEXA,{number},1,{first}\n,{last}\n")
        for load in every:
            deck.write(f"TEMPD,{load.subcase},0.\n")
            deck.writelines(f"TEMP,{load.subcase},{n},1.\n" for n in model.grid_id[load.rows])
        deck.write("ENDDATA\n")


def write_results(path: Path, model: Block, loads: UnitLoads) -> None:
    """An OP2 with the displacements of all loads."""
    cases = motions(loads, len(model.grid_id))
    write_op2(path, model.grid_id, ((load.subcase, load.label, np.hstack([t, r])) for load, t, r in cases))
