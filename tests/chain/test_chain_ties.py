"""Compensation masses that follow the structure, from the configuration to S_SG, and what cannot carry one."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from offset_mass import LEVER, changed_small, with_mass
from pyvista import UnstructuredGrid
from pyvista import read as read_vtk

from tedm_cli.cli.printing.gravity import sensitivity_lines
from tedm_cli.config.model.compensation import COLUMNS, compensation_masses
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import DISTORTION, SENSITIVITY, UNIT_LOADS
from tedm_cli.errors import ConfigError, InputError, PhysicsError
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.ties import follower
from tedm_cli.nastran.geometry import ModelGeometry, model_geometry
from tedm_cli.nastran.reading import read_deck
from tedm_cli.progress import silent
from tedm_cli.results.explained import Told
from tedm_cli.stages.explain.name import Load, explain_name
from tedm_cli.stages.exports.mesh import WantedArrays, export_mesh
from tedm_cli.stages.gravity.sensitivity import SensitivitySummary, build_sensitivity
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.model.ties import ties_on

GRID = 850001  # a grid of bars, at the foot of a strut
PLACE = np.array([-0.188, -0.126, -0.012]) + LEVER
SET = (2, 3, 4, 44, 45, 46)  # grids of solids


def block(name: str, tie: str, size: float = 1e-3, kg: float = 0.5, centre: np.ndarray = PLACE) -> str:
    return (
        f'\n[[compensation_mass]]\nname = "{name}"\ncentre_m = {centre.tolist()}\nsize_m = {size}\nmass_kg = {kg}\n'
        f"{tie}\n"
    )


def built(project: Project) -> SensitivitySummary:
    ingest(project, None, silent)
    build_distortion(project, None, silent)
    return build_sensitivity(project, None, silent)


@pytest.fixture(scope="module")
def tied(tmp_path_factory: pytest.TempPathFactory) -> tuple[Project, SensitivitySummary]:
    """A small cube on a grid of bars, a block on a set of solids' grids, and one that stays still."""
    tables = block("CM1", f"grid = {GRID}")
    tables += block("CM2", "set = 7", 0.02, 0.2, np.array([-0.2, -0.13, 0.05]))
    tables += block("CM3", "", 0.02, 0.2, np.array([0.0, 0.0, 0.1]))
    project = changed_small(tmp_path_factory.mktemp("tied"), f"SET1,7,{','.join(map(str, SET))}\n", tables)
    return project, built(project)


def read(project: Project, path: str) -> np.ndarray:
    with open_checked(project.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        return file.array(path)


def labels(project: Project) -> list[str]:
    with open_checked(project.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        return file.strings("/row/label")


def moving(project: Project, label: str) -> dict[str, tuple[float, float]]:
    """What `tedm explain` says moves for an output: size and share."""
    (told,) = explain_name(project, label, Load())
    assert isinstance(told, Told)
    rows = next(table.rows for table in told.tables if table.name == "moving")
    return {str(name): (float(str(size)), float(str(share))) for name, size, share in rows}


def test_a_tied_cube_is_an_offset_mass_on_its_grid(small: Project, tmp_path: Path) -> None:
    """In S_SG: the same CONM2 in the deck, by the way of the structure. A cube of 1 mm has no quadrupole."""
    project = changed_small(tmp_path, "", block("CM1", f"grid = {GRID}"))
    built(project)
    (tmp_path / "conm2").mkdir()
    other = with_mass(tmp_path / "conm2", GRID)
    built(other)
    before = read(small, "/S")
    by_block, by_card = read(project, "/S") - before, read(other, "/S") - before
    for rows in (slice(6), slice(6, 12)):
        size = np.abs(by_card[rows]).max()
        assert np.abs(by_block[rows] - by_card[rows]).max() < 1e-8 * size
        assert size > 1e-2 * np.abs(before[rows]).max()  # it is no small thing
    np.testing.assert_array_equal(read(project, "/operator/offset_node"), read(other, "/operator/offset_node"))
    with open_checked(other.build_dir / "distortion.h5", DISTORTION) as distortion:
        row = labels(other).index("TM1_omegadot_y")
        by_shift = -np.einsum("nc,knc->k", read(other, "/operator/G")[row], distortion.array("/D/translation"))
    parts, by_turn = moving(other, "TM1_omegadot_y"), read(other, "/S")[row] - by_shift
    assert parts["structure, by translations of its grids"][0] == pytest.approx(np.linalg.norm(by_shift), rel=1e-9)
    assert parts["offset masses, by rotations of their grids"][0] == pytest.approx(np.linalg.norm(by_turn), rel=1e-6)
    assert sum(share for _, share in parts.values()) == pytest.approx(1.0)
    for path in ("/operator/G", "/operator/G_rotation"):
        one, two = read(project, path), read(other, path)
        for rows in (slice(6), slice(6, 12)):
            assert np.abs(one[rows] - two[rows]).max() < 1e-8 * np.abs(two[rows]).max()


def test_tied_blocks_follow_their_grids_and_others_stay_still(tied: tuple[Project, SensitivitySummary]) -> None:
    project, done = tied
    with (
        open_checked(project.build_dir / "sensitivity.h5", SENSITIVITY) as file,
        open_checked(project.build_dir / "distortion.h5", DISTORTION) as distortion,
        open_checked(project.build_dir / "unit_loads.h5", UNIT_LOADS) as unit,
    ):
        assert file.strings("/compensation/name") == ["CM1", "CM2", "CM3"]
        assert file.strings("/compensation/tie") == [f"grid {GRID}", "set 7", ""]
        ids, place = unit.array("/grid/id"), unit.array("/grid/position")
        offset = file.array("/compensation/node_offset")
        followed = [ids[r] for r in np.split(file.array("/compensation/node_index"), offset[1:-1])]
        assert [f.tolist() for f in followed] == [[GRID], list(SET), []]
        d = distortion.array("/D/translation")
        rows = np.searchsorted(ids, SET)
        moved = follower(place[rows], np.array([-0.2, -0.13, 0.05])).motion(d[:, rows], np.zeros((len(d), 6, 3)))
        translation, rotation = file.array("/compensation/translation"), file.array("/compensation/rotation")
        np.testing.assert_allclose(translation[:, 1], moved[:, :3], rtol=1e-12)
        np.testing.assert_allclose(rotation[:, 1], moved[:, 3:], rtol=1e-12)
        turn = unit.array("/rotation")[:, np.searchsorted(ids, GRID)] / unit.array("/area/load_K")[:, None]
        np.testing.assert_allclose(rotation[:, 0], turn, rtol=1e-12)
        assert np.abs(rotation[:, :2]).min(axis=2).max() > 0.0
        assert not translation[:, 2].any()
        assert not rotation[:, 2].any()
    text = "\n".join(sensitivity_lines(done))
    assert "2 follow the structure (CM1: grid 850001; CM2: set 7) and are in S_SG; 1 stays still (CM3)" in text


def test_what_is_tied_adds_to_the_sensitivity_and_to_nothing_at_rest(
    tied: tuple[Project, SensitivitySummary], tmp_path: Path
) -> None:
    """The same blocks untied: the field at rest, its stiffness and the motion of the test masses are the same bits."""
    project, _ = tied
    tables = (project.model.read_text(encoding="utf-8").split("\n[[compensation_mass]]"))[1:]
    free = changed_small(
        tmp_path, "", "".join(f"\n[[compensation_mass]]{re.sub('(?m)^(grid|set) = .*$', '', t)}" for t in tables)
    )
    built(free)
    for path in ("/dc/acceleration", "/stiffness/gamma_lin", "/stiffness/linearised", "/area_contribution/gamma_lin"):
        np.testing.assert_array_equal(read(free, path), read(project, path))
    assert read(free, "/operator/G_rotation").shape[1] == 0
    by_ties = read(project, "/S") - read(free, "/S")
    assert np.abs(by_ties).max() > 0.0
    for row, label in enumerate(labels(project)):
        size, share = moving(project, label)["tied compensation masses"]
        assert size == pytest.approx(np.linalg.norm(by_ties[row]), rel=1e-6)
        assert share == pytest.approx(by_ties[row] @ (S := read(project, "/S")[row]) / (S @ S), rel=1e-6)


def test_the_mesh_shows_the_blocks_as_they_move(tied: tuple[Project, SensitivitySummary], tmp_path: Path) -> None:
    project, _ = tied
    done = export_mesh(project.build_dir, tmp_path / "m.vtu", WantedArrays(("uniform",), ("TM1_a_x",)), silent)
    mesh = read_vtk(done.paths[0])
    assert isinstance(mesh, UnstructuredGrid)
    which = np.asarray(mesh["compensation_mass"])
    cells = np.flatnonzero(which >= 0)
    assert which[cells].tolist() == [0, 1, 2]
    np.testing.assert_allclose(np.asarray(mesh["element_mass"])[cells], [0.5, 0.2, 0.2])
    volume = mesh.extract_cells(cells.tolist()).compute_cell_sizes()["Volume"]
    np.testing.assert_allclose(volume, [1e-9, 8e-6, 8e-6], rtol=1e-9)
    with open_checked(project.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        t, turn = (file.array(f"/compensation/{q}").sum(axis=0) for q in ("translation", "rotation"))
        centre, S = file.array("/compensation/centre"), file.array("/S")[0].sum()
    for number, cell in enumerate(cells):
        corner = mesh.get_cell(int(cell)).point_ids
        wanted = t[number] + np.cross(turn[number], mesh.points[corner] - centre[number])
        np.testing.assert_allclose(np.asarray(mesh["displacement_uniform"])[corner], wanted, rtol=1e-9, atol=1e-16)
        np.testing.assert_allclose(np.asarray(mesh["rotation_uniform"])[corner], np.tile(turn[number], (8, 1)))
        assert (np.asarray(mesh["grid_id"])[corner] == -1).all()
    assert np.asarray(mesh["contribution_TM1_a_x_uniform"]).sum() == pytest.approx(S, rel=1e-9)


HEADER = ",".join(COLUMNS)
LINE = "CM1,0.0,0.05,0.05,0.01,0.02,0.03,0,0,0,0.2"


@pytest.mark.parametrize(
    ("cells", "ties"),
    [
        (["4711", "", "set 12"], ["grid 4711", None, "set 12"]),
        (["4711 4800:4810", "SET 3 5:7", "9:9"], ["grids 4711, 4800:4810", "sets 3, 5:7", "grid 9"]),
    ],
)
@pytest.mark.parametrize("divided", [",", ";"])
def test_ties_of_a_csv(small: Project, tmp_path: Path, cells: list[str], ties: list[str | None], divided: str) -> None:
    lines = [f"{HEADER},grid", *(f"{LINE.replace('CM1', f'CM{i}')},{cell}" for i, cell in enumerate(cells))]
    project = with_csv(small, tmp_path, "\n".join(lines).replace(",", divided) + "\n")
    blocks = compensation_masses(project, load_model(project.model)[1])
    assert [b.tie.words if b.tie else None for b in blocks] == ties


@pytest.mark.parametrize("cell", ["x", "set", "0", "4711.0", "4711;5", "set x", "5:", "-3", "12345678901"])
def test_a_cell_that_names_no_grids(small: Project, tmp_path: Path, cell: str) -> None:
    project = with_csv(small, tmp_path, f"{HEADER},grid\n{LINE},{cell}\n")
    with pytest.raises(InputError, match=r"grid: .* names no grids") as caught:
        compensation_masses(project, load_model(project.model)[1])
    assert caught.value.where == f"{tmp_path / 'cm.csv'}:2"


@pytest.mark.parametrize(
    ("header", "fact"),
    [
        (f"{HEADER},node", "mass_kg, which grid, group may follow; has 'node' besides$"),
        (HEADER.replace("y_m", "y_mm", 1), "which grid, group may follow; misses y_m, has 'y_mm'$"),
        (HEADER.replace("mass_kg", "node"), "which grid, group may follow; misses mass_kg, has 'node'$"),
        (HEADER.replace("x_m,y_m", "y_m,x_m", 1), "column 2 is 'y_m'$"),
        (f"{HEADER},grid,grid", "mass_kg,grid, which group may follow; column 13 is 'grid'$"),
        (f"grid,{HEADER}", "mass_kg,grid, which group may follow; column 1 is 'grid'$"),
    ],
)
def test_a_header_of_a_csv_that_is_another(small: Project, tmp_path: Path, header: str, fact: str) -> None:
    project = with_csv(small, tmp_path, f"{header}\n{LINE},\n")
    with pytest.raises(InputError, match=fact) as caught:
        compensation_masses(project, load_model(project.model)[1])
    assert caught.value.where == f"{tmp_path / 'cm.csv'}:1"


def test_a_range_that_falls(small: Project, tmp_path: Path) -> None:
    project = with_csv(small, tmp_path, f"{HEADER},grid\n{LINE},9:4\n")
    with pytest.raises(InputError, match="grid: '9:4' must be 'low:high'"):
        compensation_masses(project, load_model(project.model)[1])
    with pytest.raises(ConfigError, match=r"compensation_mass\[0\]\.grid: '9:4' must be 'low:high'"):
        load_model(changed_small(tmp_path, "", block("CM1", 'grid = "9:4"')).model)
    with pytest.raises(ConfigError, match="has both grid and set: it can follow one of them"):
        load_model(changed_small(tmp_path, "", block("CM1", "grid = 4\nset = 5")).model)


def with_csv(small: Project, folder: Path, csv: str) -> Project:
    (folder / "cm.csv").write_text(csv, encoding="utf-8")
    project = changed_small(folder)
    text = project.model.read_text(encoding="utf-8")
    project.model.write_text(
        text.replace("[gravity]\n", '[gravity]\ncompensation_masses = "cm.csv"\n'), encoding="utf-8"
    )
    return project


PARTS = "mass_kg = 1.96\nmodel_parts = { grids = [850001] }\n"
CARDS = """SET1,8,2,3,45
SET1,9,71234567
GRID,899998,,0.1,0.,0.
GRID,899999,,0.1,0.,0.
PLOTEL,899999,2,899999
"""


@pytest.fixture(scope="module")
def deck(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, ModelGeometry]:
    project = changed_small(tmp_path_factory.mktemp("deck"), CARDS)
    path = project.resolve("unit_loads.bdf")
    model = read_deck(path)
    return model, model_geometry(model, [path])


@pytest.mark.parametrize(
    ("tie", "fact"),
    [
        ("grid = 4711", r"compensation_mass\[0\]\.grid: block 'CM1': the deck has no grid 4711"),
        ('grid = [850001, "7000:7999"]', "the deck has no grid of 7000:7999"),
        ("set = 7", r"compensation_mass\[0\]\.set: block 'CM1': the deck has no set 7; there are: 8, 9"),
        ("set = 9", "set 9 of the deck has no grid"),
        ("grid = 1", "grid 1 is of solids or rods alone, whose rotations mean nothing\n"),
        # an RBE3 takes the mean of these grids, and gives them no rotation
        ("grid = 104", "grid 104 is of solids or rods alone, whose rotations mean nothing\n"),
        # an RBE2 that holds translations alone (CM = 123) neither
        ("grid = 2", "grid 2 is of solids or rods alone, whose rotations mean nothing\n"),
        ("grid = [1, 2]", "grids 1, 2 are of solids or rods alone, .*; its grids are in a line"),
        ("grid = 899998", "grid 899998 is in no element and no rigid element: nothing moves it"),
        ("grid = [2, 45, 46, 899998]", "grid 899998 is in no element"),
        ("grid = 899999", "grid 899999 is in no element"),
    ],
)
def test_what_cannot_carry_a_block(tmp_path: Path, deck: tuple[Any, ModelGeometry], tie: str, fact: str) -> None:
    project = changed_small(tmp_path, "", block("CM1", tie))
    config = load_model(project.model)[1]
    with pytest.raises(ConfigError, match=fact) as caught:
        ties_on(compensation_masses(project, config), config, *deck)
    assert caught.value.where == str(project.model)
    assert ("three grids or more that are not in a line" in caught.value.hint) == (
        "rotations mean nothing" in fact or "in a line" in fact
    )


def test_members_that_a_set_names_and_the_deck_lacks_are_remarked_upon(
    tmp_path: Path, deck: tuple[Any, ModelGeometry]
) -> None:
    project = changed_small(tmp_path, "", block("CM1", 'set = "8:9"') + block("CM2", f"grid = {GRID}"))
    config = load_model(project.model)[1]
    found, notes = ties_on(compensation_masses(project, config), config, *deck)
    assert notes == ["block 'CM1': set 9 names ids of a grid that the deck does not have: 71234567"]
    assert deck[1].grid_id[found.rows("CM1")].tolist() == [2, 3, 45]
    assert deck[1].grid_id[found.rows("CM2")].tolist() == [GRID]


def panel(at: int, *cards: str) -> str:
    """Four quads of 0.1 m in the x-y plane around grid `at` + 4, and cards with @n for grid `at` + n."""
    lines = [f"GRID,{at + 3 * j + i},,{2.0 + 0.1 * i:.1f},{0.1 * j:.1f},0.\n" for j in range(3) for i in range(3)]
    lines += [
        f"CQUAD4,{at + k},99,{at + n},{at + n + 1},{at + n + 4},{at + n + 3}\n" for k, n in enumerate((0, 1, 3, 4))
    ]
    return "".join(lines) + "".join(re.sub("@([0-9]+)", lambda m: str(at + int(m[1])), card) + "\n" for card in cards)


PANELS = (
    panel(900100, "GRID,@9,,2.1,.1,.1", "GRID,@10,,2.3,.1,.01", "CROD,@9,98,@4,@9", "CTRIA3,@10,99,@5,@8,@10"),
    panel(900200, "GRID,@9,,2.1,.2,.1", "GRID,@10,,2.1,.1,.1", "CQUAD4,@9,99,@4,@7,@9,@10"),
    panel(900300, "GRID,@9,,2.1,.1,.1", "CBAR,@9,97,@4,@9,1.,0.,0."),
    panel(900400, "GRID,@9,,2.1,.1,.1", "RBE2,@9,@4,123456,@9", "GRID,@10,,2.,.3,0.", "CTRIAR,@10,99,@6,@7,@10"),
    panel(900500, "GRID,@9,,2.1,.1,.1", "RBE3,@9,,@9,123456,1.,123,@4,@5,+", "+,@7"),
    # over the first: a line along the normal
    panel(900600).replace(",0.\n", ",0.2\n"),
)
OF_PANELS = "MAT1,99,7.+10,,.3,2700.,2.-5\nPSHELL,99,99,.01,99\nPROD,98,99,1.-4\nPBAR,97,99,1.-4,1.-9,1.-9,1.-9\n"


@pytest.fixture(scope="module")
def panels(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, ModelGeometry]:
    path = changed_small(tmp_path_factory.mktemp("panels"), OF_PANELS + "".join(PANELS)).resolve("unit_loads.bdf")
    model = read_deck(path)
    return model, model_geometry(model, [path])


@pytest.mark.parametrize(
    ("tie", "soft"),
    [
        ("grid = 900104", "grid 900104"),  # a rod on it holds no rotation
        ("grid = [900104, 900604]", "grids 900104, 900604"),  # in a line along the normal
        ("grid = 900105", "grid 900105"),  # a facet of 6 degrees holds next to nothing
        ("grid = 900504", "grid 900504"),  # an RBE3 takes its mean
        ("grid = [900304, 900604]", "grid 900604"),  # the other is of a bar
        ("grid = [900103, 900104, 900105]", ""),  # the line lies in the shell, which bends about it
        ("grid = [900100, 900104, 900105]", ""),  # off a line
        ("grid = 900204", ""),  # a fold
        ("grid = 900304", ""),  # a bar
        ("grid = 900404", ""),  # a rigid element
        ("grid = 900407", ""),  # a CTRIAR, which has a stiffness about its normal
        ("grid = 900509", ""),  # what an RBE3 gives
    ],
)
def test_blocks_that_turn_as_shells_alone_let_them_are_remarked_upon(
    tmp_path: Path, panels: tuple[Any, ModelGeometry], tie: str, soft: str
) -> None:
    """About the normal of smooth shells K6ROT decides: not where anything else holds the grid, or off a line."""
    project = changed_small(tmp_path, "", block("CM1", tie))
    config = load_model(project.model)[1]
    _, notes = ties_on(compensation_masses(project, config), config, *panels)
    assert len(notes) == bool(soft)
    assert not soft or (f": CM1 ({soft}). " in notes[0] and "three grids or more" in notes[0])


def test_a_grid_of_a_test_mass_carries_no_block(tmp_path: Path) -> None:
    project = changed_small(tmp_path, "", block("CM1", f"grid = {GRID}"))
    text = project.model.read_text(encoding="utf-8")
    project.model.write_text(text.replace("mass_kg = 1.96\n", PARTS, 1), encoding="utf-8")
    with pytest.raises(ConfigError, match=r"grid 850001 is of test mass TM1 \(its model_parts\), which floats free"):
        ingest(project, None, silent)


def test_a_grid_that_never_turns_is_found_in_the_results(tmp_path: Path) -> None:
    """Whatever the deck promises: here a constraint on a grid of solids."""
    project = changed_small(tmp_path, "MPC,5,1,1,1.0,5,1,-1.0\n", block("CM1", "grid = 1"))
    ingest(project, None, silent)
    with pytest.raises(PhysicsError, match=r"tied to grids that move, but never rotate .*: CM1 \(grid 1\)") as caught:
        build_distortion(project, None, silent)
    assert "three grids or more" in caught.value.hint


def test_a_block_that_no_load_moves_is_remarked_upon(tmp_path: Path) -> None:
    """On the clamped end of a strut; it adds nothing to S_SG."""
    project = changed_small(tmp_path, "", block("CM1", "grid = 800104") + block("CM2", f"grid = {GRID}"))
    ingest(project, None, silent)
    assert (
        build_distortion(project, None, silent).notes[-1] == "tied compensation masses whose grids no load moves: CM1"
    )


def test_the_line_of_a_csv_is_named(small: Project, tmp_path: Path) -> None:
    project = with_csv(small, tmp_path, f"{HEADER},grid\n{LINE},\n{LINE.replace('CM1', 'CM2')},4711\n")
    with pytest.raises(ConfigError, match="line 3, grid: block 'CM2': the deck has no grid 4711") as caught:
        ingest(project, None, silent)
    assert caught.value.where == str(tmp_path / "cm.csv")


def test_another_tie_after_ingest_is_noticed(tied: tuple[Project, SensitivitySummary], tmp_path: Path) -> None:
    project, _ = tied
    text = project.model.read_text(encoding="utf-8")
    for changed, then, now in (
        (text.replace(f"grid = {GRID}", "grid = 850002"), "tied to grid 850001", "tied to grid 850002"),
        (text.replace(f"grid = {GRID}", ""), "tied to grid 850001", "tied to nothing"),
        (text.replace('"CM3"', '"CM3"\nset = 7'), "tied to nothing", "tied to set 7"),
    ):
        project.model.write_text(changed, encoding="utf-8")
        for stage, out in ((build_distortion, "d.h5"), (build_sensitivity, "s.h5")):
            with pytest.raises(InputError, match=f"was {then} when it was made, and is {now} now") as caught:
                stage(project, tmp_path / out, silent)
            assert "tedm ingest" in caught.value.hint
            assert caught.value.where == str(project.build_dir / "unit_loads.h5")
    # where a block is, and what it weighs, may change
    project.model.write_text(text.replace("mass_kg = 0.5", "mass_kg = 0.6"), encoding="utf-8")
    build_sensitivity(project, tmp_path / "s.h5", silent)
    project.model.write_text(text, encoding="utf-8")
