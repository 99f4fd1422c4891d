"""The mesh for ParaView: what VTK reads of it is what the HDF5 files hold, and the grids' parts make the whole."""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest
from pyvista import CellType, UnstructuredGrid
from pyvista import read as read_vtk

from tedm_cli.config.project import Project
from tedm_cli.errors import InputError, UsageError
from tedm_cli.exports.node_terms import gradient, superposed
from tedm_cli.files.blocks import Blocks
from tedm_cli.files.seal import seal
from tedm_cli.progress import silent
from tedm_cli.stages.exports.mesh import WantedArrays, export_mesh

AREA = "STRUT_1"
GRAVITY, READ_OUT = ("TM1_a_x", "TM2_omegadot_z"), ("A_TM1_x", "B_TM2_phi")
OUTPUTS = (*GRAVITY, *READ_OUT)
CASES = ("2", "3", "10b")
DIFFERENCE = "TM1_a_x-TM2_a_x"


@pytest.fixture(scope="module")
def path(small: Project, tmp_path_factory: pytest.TempPathFactory) -> Path:
    asked = WantedArrays((AREA, "uniform"), OUTPUTS, CASES)
    return export_mesh(small.build_dir, tmp_path_factory.mktemp("mesh") / "small.vtu", asked, silent).paths[0]


def read_grid(path: Path) -> UnstructuredGrid:
    grid = read_vtk(path)
    assert isinstance(grid, UnstructuredGrid)
    return grid


@pytest.fixture(scope="module")
def mesh(path: Path) -> UnstructuredGrid:
    return read_grid(path)


@pytest.fixture(scope="module")
def files(small: Project) -> Iterator[dict[str, h5py.File]]:
    names = ("unit_loads", "distortion", "sensitivity", "optics", *(f"case{c.zfill(2)}" for c in CASES))
    opened = {name: h5py.File(small.build_dir / f"{name}.h5") for name in names}
    yield opened
    for file in opened.values():
        file.close()


def text(data: h5py.Dataset) -> list[str]:
    return [str(s) for s in data.asstr()[()]]


def legend(path: Path, array: str) -> dict[int, str]:
    presets = json.loads(path.with_name(path.stem + "_colours.json").read_text(encoding="utf-8"))
    pairs = next(p["Annotations"] for p in presets if p["Name"] == f"tedm {array}")
    return {int(i): name for i, name in zip(pairs[::2], pairs[1::2], strict=True)}


def test_all_of_the_model_is_there(path: Path, mesh: UnstructuredGrid, files: dict[str, h5py.File]) -> None:
    unit, optical = files["unit_loads"], text(files["distortion"]["/optical/name"])
    heavy = len(unit["/mass/concentrated"])
    np.testing.assert_array_equal(mesh.points, unit["/grid/position"][()])
    assert mesh.n_cells == len(unit["/element/id"]) + heavy + len(optical)
    np.testing.assert_array_equal(np.sort(mesh["element_id"][: len(unit["/element/id"])]), unit["/element/id"][()])
    card = dict(zip(unit["/element/id"][()].tolist(), text(unit["/element/type"]), strict=True))
    names = legend(path, "element_type")
    for cell in range(0, len(card), 97):
        assert names[int(mesh["element_type"][cell])] == card[int(mesh["element_id"][cell])]
    assert mesh["element_mass"].sum() == pytest.approx(unit["/mass/total"][()], rel=1e-12)
    rides = mesh["optical_element"] >= 0
    grids = mesh.points[[mesh.get_cell(i).point_ids[0] for i in np.flatnonzero(rides)]]
    np.testing.assert_array_equal(grids, files["distortion"]["/optical/position"][()])
    assert [legend(path, "optical_element")[int(i)] for i in mesh["optical_element"][rides]] == optical


def test_volumes_are_mass_over_density(mesh: UnstructuredGrid) -> None:
    solid = mesh.extract_cells((mesh.celltypes == CellType.HEXAHEDRON).nonzero()[0].tolist()).compute_cell_sizes()
    assert solid.n_cells > 100
    # with its sign: an element that VTK sees inside out has a negative volume
    np.testing.assert_allclose(solid["Volume"], solid["element_mass"] / solid["density"], rtol=1e-9)


def test_areas_and_groups_have_their_names(path: Path, mesh: UnstructuredGrid, files: dict[str, h5py.File]) -> None:
    unit = files["unit_loads"]
    name, group = text(unit["/area/name"]), text(unit["/area/group"])
    names, groups = legend(path, "area_index"), legend(path, "group_index")
    assert names == {-1: "none", **dict(enumerate(name))}
    offset, index = unit["/area/node_offset"][()], unit["/area/node_index"][()]
    for area in range(len(name)):
        members = index[offset[area] : offset[area + 1]]
        np.testing.assert_array_equal(np.sort(members), np.flatnonzero(mesh["area_index"] == area))
        assert {groups[int(g)] for g in mesh["group_index"][members]} == {group[area]}
    for cell in range(0, mesh.n_cells, 31):
        votes = mesh["area_index"][mesh.get_cell(cell).point_ids].tolist()
        most = {area for area in votes if votes.count(area) == max(map(votes.count, votes))}
        assert int(mesh["element_area"][cell]) == min(most)


def test_displacements_are_those_of_the_distortion_matrix(mesh: UnstructuredGrid, files: dict[str, h5py.File]) -> None:
    D, unit = files["distortion"]["/D/translation"], files["unit_loads"]
    row = text(unit["/area/name"]).index(AREA)
    np.testing.assert_array_equal(mesh[f"displacement_{AREA}"], D[row])
    load = unit["/area/load_K"][row]
    np.testing.assert_allclose(mesh[f"rotation_{AREA}"], unit["/rotation"][row] / load, rtol=1e-15)
    uniform = unit["/uniform/translation"][()] / unit["/uniform/load_K"][()]
    np.testing.assert_allclose(mesh["displacement_uniform"], uniform, atol=1e-6 * np.abs(uniform).max())


@pytest.mark.parametrize("output", GRAVITY)
def test_gradient_times_displacement_makes_the_self_gravity(
    mesh: UnstructuredGrid, files: dict[str, h5py.File], output: str
) -> None:
    s, areas = files["sensitivity"], text(files["unit_loads"]["/area/name"])
    S = s["/S"][text(s["/row/label"]).index(output)]
    for name, wanted in ((AREA, S[areas.index(AREA)]), ("uniform", S.sum())):
        part = mesh[f"contribution_{output}_{name}"]
        assert part.sum() == pytest.approx(wanted, rel=1e-9, abs=0)
        np.testing.assert_allclose(
            part, (mesh[f"gradient_{output}"] * mesh[f"displacement_{name}"]).sum(axis=1), rtol=1e-12, atol=0
        )


@pytest.mark.parametrize("output", READ_OUT)
def test_read_out_is_made_where_the_optical_elements_are(
    mesh: UnstructuredGrid, files: dict[str, h5py.File], output: str
) -> None:
    o, areas = files["optics"], text(files["unit_loads"]["/area/name"])
    N = o[f"/N/{output[0]}"][text(o["/label/read_out"]).index(output[2:])]
    on_optics = np.isin(mesh["grid_id"], files["distortion"]["/optical/grid"][()])
    for name, wanted in ((AREA, N[areas.index(AREA)]), ("uniform", N.sum())):
        part = mesh[f"contribution_{output}_{name}"]
        assert part.sum() == pytest.approx(wanted, rel=1e-9, abs=0)
        assert np.count_nonzero(part[on_optics]) > 10
        assert not part[~on_optics].any()


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("output", OUTPUTS)
def test_shares_sum_to_one(mesh: UnstructuredGrid, output: str, case: str) -> None:
    assert mesh[f"share_{output}_case{case}"].sum() == pytest.approx(1.0, rel=1e-9)


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("output", READ_OUT)
def test_shares_of_optical_elements_are_those_of_the_case(
    mesh: UnstructuredGrid, files: dict[str, h5py.File], output: str, case: str
) -> None:
    """The case finds them from the temperature model, not from tables of spectra."""
    file, distortion = files[f"case{case.zfill(2)}"], files["distortion"]
    by_path = dict(zip(text(file["/path/name"]), file[f"/path/share/{output}"][()], strict=True))
    grid = distortion["/optical/grid"][()]
    wanted = [by_path[name] for name in text(distortion["/optical/name"])]
    rows = np.searchsorted(mesh["grid_id"], grid)
    np.testing.assert_allclose(mesh[f"share_{output}_case{case}"][rows], wanted, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("case", CASES)
def test_share_of_a_grid_is_half_the_relative_change_of_the_power(
    mesh: UnstructuredGrid, files: dict[str, h5py.File], case: str
) -> None:
    """S grows by 2 ε Re(y_n y*) when what one grid contributes grows by ε: central differences of S = h R h."""
    output = GRAVITY[0]
    s, file, D = files["sensitivity"], files[f"case{case.zfill(2)}"], files["distortion"]["/D/translation"]
    row = text(s["/row/label"]).index(output)
    o = text(file["/output/label"]).index(output)
    at = int(np.argmin(np.abs(file["/frequency"][()] - file["/contribution/frequency"][o])))
    amplitude = file["/temperature/asd"][()][file["/temperature/spectrum"][()], at]
    R, g = file["/correlation/real"][()], s["/S"][row]

    def power(rows: np.ndarray) -> float:
        return float((rows * amplitude) @ R @ (rows * amplitude))

    assert power(g) == pytest.approx(file[f"/psd/{output}"][at], rel=1e-9, abs=0)
    share = mesh[f"share_{output}_case{case}"]
    for n in np.argsort(-np.abs(share))[:5].tolist():
        part = 10.0 * -(D[:, n] @ s["/operator/G"][row, n])
        assert (power(g + part) - power(g - part)) / 40.0 / power(g) == pytest.approx(share[n], rel=1e-6)


def test_fields_of_loads_of_any_size_add_up_block_by_block(tmp_path: Path) -> None:
    rng = np.random.default_rng(3)
    fields = rng.normal(size=(4, 70_001, 3)).astype(np.float32)  # more than one block
    weights, load = rng.normal(size=(2, 4)) * [1.0, 1.0, 0.0, 1.0], np.array([1.0, 10.0, 2.0, 0.5])
    read: list[int] = []
    with h5py.File(tmp_path / "d.h5", "w") as file:
        blocks = Blocks(file.create_dataset("d", data=fields), tmp_path / "d.h5")
        found = superposed(blocks, weights, read.append, load)
        rows = ((2.0, 0), (-1.0, 3))
        np.testing.assert_array_equal(gradient(blocks, rows), fields[3].astype(float) - 2.0 * fields[0].astype(float))
    np.testing.assert_allclose(found, np.einsum("ma,anc->mnc", weights / load, fields), rtol=0, atol=1e-12)
    assert sum(read) == 3 * 70_001  # the area without weight is not read


def test_difference_of_two_outputs(small: Project, tmp_path: Path, mesh: UnstructuredGrid) -> None:
    export_mesh(small.build_dir, tmp_path / "d.vtu", WantedArrays((AREA,), (DIFFERENCE, "TM2_a_x")), silent)
    other = read_grid(tmp_path / "d.vtu")
    mine = other[f"adjoint_density_{DIFFERENCE}"] + other["adjoint_density_TM2_a_x"]
    np.testing.assert_allclose(mine, mesh["adjoint_density_TM1_a_x"], rtol=0, atol=1e-12 * np.nanmax(np.abs(mine)))
    np.testing.assert_allclose(
        other[f"contribution_{DIFFERENCE}_{AREA}"],
        mesh[f"contribution_TM1_a_x_{AREA}"] - other[f"contribution_TM2_a_x_{AREA}"],
        atol=1e-12 * np.abs(mesh[f"contribution_TM1_a_x_{AREA}"]).max(),
    )


@pytest.mark.parametrize("output", OUTPUTS)
def test_sensitivity_per_volume_adds_up_to_the_uniform_load(
    small: Project, path: Path, mesh: UnstructuredGrid, files: dict[str, h5py.File], output: str
) -> None:
    """Integrated over the cells as VTK measures them, with the sections of plates and bars; of grids it is a sum."""
    if output in GRAVITY:
        wanted = files["sensitivity"]["/S"][text(files["sensitivity"]["/row/label"]).index(output)].sum()
    else:
        o = files["optics"]
        wanted = o[f"/N/{output[0]}"][text(o["/label/read_out"]).index(output[2:])].sum()
    sizes = mesh.compute_cell_sizes()
    flat, line = sizes["Area"] * mesh["section"], sizes["Length"] * mesh["section"]
    volume = sizes["Volume"] + flat + line
    density, whole = mesh[f"adjoint_density_{output}"], mesh[f"adjoint_element_{output}"]
    room = 1e-6 * np.abs(whole).sum()
    assert abs(np.nansum(density * volume) - wanted) < room
    assert abs(whole.sum() - wanted) < room
    assert np.isnan(density[mesh["optical_element"] >= 0]).all()
    assert np.isfinite(density[: len(files["unit_loads"]["/element/id"])]).all()
    with h5py.File(small.build_dir / "adjoint.h5") as file:
        row = text(file["/row/label"]).index(output)
        np.testing.assert_array_equal(mesh[f"adjoint_{output}"], file["/s"][row])
        by_id = dict(zip(mesh["element_id"].tolist(), whole.tolist(), strict=True))
        worst = int(np.abs(file["/map/s"][row]).argmax())
        assert by_id[int(file["/map/element_id"][worst])] == file["/map/s"][row, worst] != 0.0


def test_without_an_adjoint_there_are_no_arrays_of_it_and_a_stale_one_is_refused(
    small: Project, tmp_path: Path
) -> None:
    build = tmp_path / "build"
    build.mkdir()
    for name in ("unit_loads", "distortion", "sensitivity"):
        shutil.copy(small.build_dir / f"{name}.h5", build)
    asked = WantedArrays((AREA,), ("TM1_a_x",))
    done = export_mesh(build, None, asked, silent)
    assert not [a.name for a in (*done.on_points, *done.on_cells) if "adjoint" in a.name]
    shutil.copy(small.build_dir / "adjoint.h5", build)
    done = export_mesh(build, None, asked, silent)
    assert {a.name for a in done.on_cells if "adjoint" in a.name} == {
        "adjoint_element_TM1_a_x",
        "adjoint_density_TM1_a_x",
    }
    with h5py.File(build / "sensitivity.h5", "r+") as file:
        file["/S"][0, 0] *= 1.0 + 1e-14
    seal(build / "sensitivity.h5")
    with pytest.raises(InputError, match=r"adjoint\.h5: is stale"):
        export_mesh(build, None, asked, silent)


def test_table_says_what_the_arrays_are(path: Path, mesh: UnstructuredGrid) -> None:
    with open(path.with_name("small_arrays.csv"), encoding="utf-8", newline="") as stream:
        rows = {(r["array"], r["on"]): r for r in csv.DictReader(stream)}
    assert {n for n, on in rows if on == "points"} == set(mesh.point_data)
    assert {n for n, on in rows if on == "cells"} == set(mesh.cell_data)
    share = rows["share_TM1_a_x_case3", "points"]
    assert float(share["sum"]) == pytest.approx(1.0)
    assert "at 1 mHz" in share["meaning"]
    assert rows["gradient_TM1_a_x", "points"]["unit"] == "m/s^2 per m"


def test_meshio_reads_it_too(path: Path, mesh: UnstructuredGrid) -> None:
    other = meshio.read(path)
    assert sum(len(block) for block in other.cells) == mesh.n_cells
    assert set(other.point_data) == set(mesh.point_data)
    for name, values in other.point_data.items():
        np.testing.assert_array_equal(values, mesh.point_data[name])


def test_without_options_it_is_about_the_worst_verdict(small: Project, tmp_path: Path) -> None:
    done = export_mesh(small.build_dir, tmp_path / "worst.vtu", WantedArrays(), silent)
    worst = (-1.0, "", "")
    for path in small.build_dir.glob("case*.h5"):
        with h5py.File(path) as file:
            v = int(file["/verdict/ratio"][()].argmax())
            verdict = (file["/verdict/ratio"][v], file["/verdict/output"].asstr()[v], file["/case/id"].asstr()[()])
            worst = max(worst, verdict)
    names = [a.name for a in done.on_points]
    assert f"share_{worst[1]}_case{worst[2]}" in names
    assert "displacement_uniform" in names


def test_before_the_cases_there_is_less_to_see(small: Project, tmp_path: Path) -> None:
    shutil.copy(small.build_dir / "unit_loads.h5", tmp_path)
    bare = export_mesh(tmp_path, None, WantedArrays(), silent)
    assert bare.paths[0] == tmp_path / "export" / "mesh.vtu"
    assert {a.name for a in bare.on_points} == {"grid_id", "area_index", "group_index", "mass"}
    with pytest.raises(InputError, match=r"distortion\.h5: no such file"):
        export_mesh(tmp_path, None, WantedArrays((AREA,)), silent)
    shutil.copy(small.build_dir / "distortion.h5", tmp_path)
    assert "displacement_uniform" in {a.name for a in export_mesh(tmp_path, None, WantedArrays(), silent).on_points}
    with pytest.raises(InputError, match=r"sensitivity\.h5: no such file"):
        export_mesh(tmp_path, None, WantedArrays((), ("TM1_a_x",)), silent)
    with pytest.raises(InputError, match=r"case03\.h5: no such file") as error:
        export_mesh(tmp_path, None, WantedArrays((), (), ("3",)), silent)
    assert error.value.hint == "make it with `tedm run-case 3`, or `tedm run`"


@pytest.mark.parametrize(
    ("asked", "fact", "hint"),
    [
        (WantedArrays(("STRUT1",)), "no area is called 'STRUT1'", "did you mean STRUT_1?"),
        (WantedArrays((), ("TM1_a_X",)), "no output is called 'TM1_a_X'", "did you mean TM1_a_x?"),
        (WantedArrays((), ("TM1_a_x-TM2_ax",)), "no output is called 'TM2_ax'", "did you mean TM2_a_x?"),
        (WantedArrays((), ("TM1_a_x-A_TM1_x",)), "difference of m/s^2 and m", ""),
        (WantedArrays((), (), ("33",)), "no case that was run is called '33'", "did you mean 3?"),
        (WantedArrays((), (DIFFERENCE,), ("3",)), f"no output of case03.h5 is called '{DIFFERENCE}'", ""),
    ],
)
def test_what_there_is_not(small: Project, tmp_path: Path, asked: WantedArrays, fact: str, hint: str) -> None:
    with pytest.raises(UsageError) as error:
        export_mesh(small.build_dir, tmp_path / "no.vtu", asked, silent)
    assert fact in error.value.fact
    assert hint in error.value.hint
    assert not list(tmp_path.iterdir())


def test_files_that_do_not_belong_together(small: Project, tmp_path: Path) -> None:
    build = tmp_path / "build"
    build.mkdir()
    for name in ("unit_loads", "distortion", "sensitivity", "case03"):
        shutil.copy(small.build_dir / f"{name}.h5", build)
    with h5py.File(build / "sensitivity.h5", "r+") as file:
        G = file["/operator/G"]
        heaviest = int(np.abs(G[0]).max(axis=1).argmax())
        G[0, heaviest] = 1.001 * G[0, heaviest]
    seal(build / "sensitivity.h5")
    with pytest.raises(InputError, match="the grids' parts of TM1_a_x add up to"):
        export_mesh(build, None, WantedArrays((AREA,), ("TM1_a_x",)), silent)
    with pytest.raises(InputError, match=r"case03\.h5: is stale"):
        export_mesh(build, None, WantedArrays((), ("TM1_a_x",), ("3",)), silent)
    with h5py.File(build / "unit_loads.h5", "r+") as file:
        file["/mass/lumped"][0] *= 2.0
    seal(build / "unit_loads.h5")
    with pytest.raises(InputError, match=r"distortion\.h5: is stale"):
        export_mesh(build, None, WantedArrays((AREA,)), silent)
