"""The least model that has all that inputs can get wrong: areas, frames, rigid elements, levers, a uniform load."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

import numpy as np
from msc_hdf5_file import write_msc_hdf5

from tedm_cli.config.project import Project, load_project
from tedm_cli.nastran.op2.reader import open_op2
from tedm_cli.nastran.op2.writer import write_op2
from tedm_cli.stages.model.deck import write_deck
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.model.solve import solve_deck

CONFIGS = Path(__file__).parents[2] / "configs"
OPTICAL = (900001, 900002)
AREAS = {"ROOT": range(1, 5), "WAIST": [*range(5, 9), OPTICAL[0]], "TIP": [*range(9, 13), OPTICAL[1]]}
FRAMES = {6: 10, 7: 10, 11: 20, 12: 30, OPTICAL[0]: 20}  # CD of grids; the others are in the basic frame
MODEL_TOML = """\
[model]
bdf = "model.bdf"
areas_csv = "areas.csv"
deck = "unit_loads.bdf"
op2 = ["unit_loads.op2"]

[areas]
rule = [{ match = "*", group = "bricks", shield = "inside" }]

[[test_mass]]
name = "TM1"
position_m = [-0.188, 0.0, 0.0]
side_m = 0.046
mass_kg = 1.96
"""


def model_cards(with_frames: bool) -> str:
    """Two bricks, 0.2 m long, held at one end; a fibre and a mirror on rigid elements, the mirror with a lever."""
    lines = ["SOL 101", "CEND", "SPC = 1", "BEGIN BULK", "$ two bricks"]
    places = [
        (4 * i + j + 1, x, y, z)
        for i, x in enumerate((0.0, 0.1, 0.2))
        for j, (y, z) in enumerate(((0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1)))
    ]
    places += [(OPTICAL[0], 0.05, 0.05, 0.13), (OPTICAL[1], 0.16, 0.04, 0.12)]
    for n, x, y, z in places:
        frame = str(FRAMES.get(n, "")) if with_frames else ""
        if n % 3 == 1:
            lines.append(f"GRID,{n},,{x},{y},{z},{frame}")
        elif n % 3 == 2:
            lines += [f"GRID*   {n:>16}{'':16}{x:>16}{y:>16}", f"*       {z:>16}{frame:>16}"]
        else:
            lines.append(f"GRID    {n:>8}{'':8}{x:>8}{y:>8}{z:>8}{frame:>8}")
    return "\n".join(
        [
            *lines,
            "CORD2C  10      0       .3      .02     -.01    .3      .02     1.",
            "        .5      .3      .1",
            "CORD2R,20,0,.1,.1,.1,.1,.9,.5",
            ",.9,.3,.2",
            "CORD2S,30,20,-.1,.2,.3,-.1,.9,.5",
            ",.9,.3,.2",
            "CHEXA   1       1       1       2       3       4       5       6",
            "        7       8",
            "CHEXA   2       2       5       6       7       8       9       10",
            "        11      12",
            "PSOLID  1       1",
            "PSOLID  2       2",
            "MAT1    1       7.+10           .33     2700.   2.3-5",
            "MAT1    2       1.1+11          .3      4430.   8.6-6",
            "SPC1    1       123     1       2       3       4",
            f"RBE2    51      {OPTICAL[0]}  123     6       7       8",
            f"RBE2    52      {OPTICAL[1]}  123     10      11      12",
            f"CONM2   61      {OPTICAL[1]}          .2      .01     .02     .03",
            f"CONM2   62      {OPTICAL[0]}          .1",
            "ENDDATA",
            "",
        ]
    )


def quiet(*_: object) -> None:
    """No progress."""


@dataclass(frozen=True)
class Case:
    """A project in a folder of its own, and its distortion.h5 as it ought to be."""

    project: Project

    @property
    def folder(self) -> Path:
        return self.project.file.path.parent

    @property
    def deck(self) -> Path:
        return self.folder / "unit_loads.bdf"

    @property
    def op2(self) -> Path:
        return self.folder / "unit_loads.op2"

    @property
    def unit_loads(self) -> Path:
        return self.project.build_dir / "unit_loads.h5"

    @property
    def distortion(self) -> Path:
        return self.project.build_dir / "distortion.h5"

    @property
    def msc_hdf5(self) -> Path:
        """The same results as MSC Nastran's HDF5, in double precision."""
        return self.folder / "unit_loads.msc.h5"

    def run(self) -> None:
        """ingest and build-distortion."""
        ingest(self.project, None, quiet)
        build_distortion(self.project, None, quiet)

    def copy(self, folder: Path) -> Case:
        shutil.copytree(self.folder, folder)
        return Case(load_project(folder / "tedm.toml", folder / "build"))


def make(folder: Path, cards: str) -> Case:
    folder.mkdir(parents=True)
    (folder / "model.bdf").write_text(cards)
    rows = [f"{i},{name}" for name, ids in AREAS.items() for i in ids]
    (folder / "areas.csv").write_text("\n".join(["node_id,area", *rows]) + "\n")
    (folder / "model.toml").write_text(MODEL_TOML)
    layout, n = (CONFIGS / "optics.toml").read_text(), iter(OPTICAL * 20)
    (folder / "optics.toml").write_text(
        re.sub(r"(?m)^grid = \d+", lambda _: f"lever_ok = true\ngrid = {next(n)}", layout)
    )
    (folder / "tedm.toml").write_text('title = "two bricks"\n')
    case = Case(load_project(folder / "tedm.toml", folder / "build"))
    write_deck(case.project, None)
    return case


def fuzz_case(folder: Path) -> Case:
    """The model with displacement frames, its results by way of its twin without any, and its distortion."""
    twin, case = make(folder / "twin", model_cards(False)), make(folder / "case", model_cards(True))
    double: list[tuple[int, str, np.ndarray]] = []

    def write(path: Path, grid_id: np.ndarray, cases: Iterable[tuple[int, str, np.ndarray]]) -> None:
        made = list(cases)
        double.extend((n, label, in_frames(case.deck, grid_id, motion, to_basic=False)) for n, label, motion in made)
        write_op2(path, grid_id, made)
        write_msc_hdf5(case.msc_hdf5, grid_id, double)

    with mock.patch("tedm_cli.stages.model.solve.write_op2", write):
        solve_deck(twin.deck, twin.op2)
    motions, ids = [], np.zeros(0, dtype=np.int64)
    with open_op2(twin.op2) as (tables, read):
        for table in tables:
            got = read(table)
            ids = got.grid_id
            motions.append((table.subcase, table.label, in_frames(case.deck, ids, got.motion, to_basic=False)))
    write_op2(case.op2, ids, motions)
    case.run()
    return case


def in_frames(deck: Path, ids: np.ndarray, motion: np.ndarray, *, to_basic: bool) -> np.ndarray:
    """Motion [n, 6] turned between the displacement frames of a deck and the basic frame, by pyNastran's own geometry.

    A direction is the limit of a small step along the coordinate: nothing of the project's frames is used.
    """
    from pyNastran.bdf.bdf import BDF

    model = BDF(debug=None)
    model._parse_primary_file_header = lambda _: None
    model.read_bdf(str(deck), xref=False, punch=False, encoding="latin-1")
    model.cross_reference(
        xref_loads=False, xref_constraints=False, xref_aero=False, xref_sets=False, xref_optimization=False
    )
    out = np.array(motion, dtype=float)
    for row, grid in enumerate(ids.tolist()):
        node = model.nodes[grid]
        frame = node.cd_ref
        if frame is None or frame.cid == 0:
            continue
        place = np.array(node.get_position(), dtype=float)
        local = np.asarray(frame.beta()) @ (place - np.asarray(frame.origin))
        axes = _directions(frame.Type, local) @ np.asarray(frame.beta())  # rows, basic frame
        pair = out[row].reshape(2, 3)
        out[row] = (pair @ axes if to_basic else pair @ axes.T).ravel()
    return out


def _directions(kind: str, p: np.ndarray) -> np.ndarray:
    """Unit vectors (rows) of a frame at p: the normalised gradients of its coordinates."""
    x, y, z = p
    flat = np.hypot(x, y)
    if kind == "R" or flat == 0.0:
        return np.eye(3)
    around = np.array([-y, x, 0.0]) / flat
    if kind == "C":
        return np.array([np.array([x, y, 0.0]) / flat, around, [0.0, 0.0, 1.0]])
    r = np.linalg.norm(p)
    return np.array([p / r, np.array([x * z, y * z, -(flat**2)]) / (flat * r), around])
