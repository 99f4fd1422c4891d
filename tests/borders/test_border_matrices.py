"""Matrices in files of other programs: what is exported comes back the same, and what is wrong is refused by name."""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from border_tools import CONFIGS, Project, replace, snapshot, tedm
from label_scales import is_scale_alone

from tedm_cli.config.optics.layout import load_layout
from tedm_cli.errors import InputError
from tedm_cli.matrix_files.mat_file import write_mat
from tedm_cli.matrix_files.named import NamedMatrix
from tedm_cli.optics.labels import input_labels, output_labels
from tedm_cli.optics.sensitivity import optical_sensitivity

SOURCES = {"csv": ("S_BW.csv", "P.csv"), "npz": ("optics.npz",) * 2, "mat": ("optics.mat",) * 2}
NOT_NEEDED = r"^(normal|front_offset_m|thickness_m|index|local_y|aperture_m|opl_offset_m|steps) = .*\n"


def use(project: Project, **keys: object) -> None:
    """Import the matrices that `keys` name."""
    table = "\n".join(f"{key} = {json.dumps(value)}" for key, value in keys.items())
    replace(project.folder / "optics.toml", "[frame]", f"[imported]\n{table}\n\n[frame]")


def read_out(project: Project) -> dict[str, np.ndarray]:
    with h5py.File(project.build / "optics.h5") as file:
        return {name: item[()] for name, item in file["/N"].items() if not is_scale_alone(item)}


@pytest.fixture(scope="session")
def exported(chain: Project, tmp_path_factory: pytest.TempPathFactory) -> Project:
    """The built sample with its matrices in `folder/matrices`. Not to be changed: copy it."""
    project = chain.copy(tmp_path_factory.mktemp("exported") / "small")
    for fmt in SOURCES:
        tedm("export", "--format", fmt, "-d", project.build, "-o", project.folder / "matrices").ok()
    return project


@pytest.fixture
def outside(exported: Project, tmp_path: Path) -> Project:
    """A copy that a test may change."""
    return exported.copy(tmp_path / "small")


@pytest.mark.parametrize("fmt", SOURCES)
def test_exported_matrices_come_back_the_same(outside: Project, fmt: str) -> None:
    before = read_out(outside)
    S_BW, P = SOURCES[fmt]
    use(outside, S_BW=f"matrices/{S_BW}", P=f"matrices/{P}", largest_difference=1e-12)
    out = outside.stage("build-optics").ok().out
    assert f"S_BW: imported from {S_BW} (double precision); P: imported from {P}" in out
    for name, values in read_out(outside).items():
        np.testing.assert_array_equal(values, before[name])
    with h5py.File(outside.build / "optics.h5") as file:
        inputs = {Path(p.decode()).name for p in file["/provenance/input_path"][()]}
    assert {S_BW, P} <= inputs
    if fmt == "csv":
        assert {"S_BW.csv.toml", "P.csv.toml"} <= inputs
    tedm("export", "optics", "--format", fmt, "-d", outside.build, "-o", outside.folder / "again", "-q").ok()


def test_imported_files_make_results_stale(outside: Project) -> None:
    use(outside, S_BW="matrices/S_BW.csv")
    outside.stage("build-optics").ok()
    side = outside.folder / "matrices" / "S_BW.csv.toml"
    side.write_text(side.read_text() + "# a comment\n")
    tedm("check", "-d", outside.build).refused(4, "optics.h5")
    outside.run("make-rules").ok()
    rule = next(line for line in (outside.build / "rules.mk").read_text().splitlines() if "OPTICS_SOURCES" in line)
    assert "S_BW.csv " in rule
    assert rule.endswith("S_BW.csv.toml")


def test_names_and_places_are_enough_with_an_imported_matrix(outside: Project) -> None:
    """Without normals, substrates and steps: the same noise, and check-layout says that it has nothing to trace."""
    before = read_out(outside)
    use(outside, S_BW="matrices/optics.mat")
    layout = outside.folder / "optics.toml"
    layout.write_text(re.sub(NOT_NEEDED, "", layout.read_text(), flags=re.M))
    assert "normal" not in layout.read_text().split("[[element]]", 1)[1]
    outside.stage("build-distortion").ok()
    outside.stage("build-optics").ok()
    for name, values in read_out(outside).items():
        np.testing.assert_array_equal(values, before[name])
    assert "S_BW is imported" in outside.run("check-layout").ok().out
    replace(layout, "[imported]\n", "[imported]\nlargest_difference = 1e-6\n")
    outside.stage("build-optics").refused(3, "cannot be traced: element[0].normal is missing")


def test_a_layout_that_is_traced_needs_its_geometry(outside: Project) -> None:
    layout = outside.folder / "optics.toml"
    layout.write_text(re.sub(NOT_NEEDED, "", layout.read_text(), flags=re.M))
    outcome = outside.stage("build-optics")
    outcome.refused(3, "element[0].normal: missing; a test_mass (TM1) needs it", "path[0].steps: missing")


def test_imported_names_something(outside: Project) -> None:
    replace(outside.folder / "optics.toml", "[frame]", "[imported]\n\n[frame]")
    outside.stage("build-optics").refused(3, "imported: names neither S_BW nor P")


REQUIRED = ("frame", "rotations", "slopes", "beams", "reference_points")


def test_everything_that_is_not_declared_is_named_at_once(outside: Project) -> None:
    use(outside, S_BW="matrices/S_BW.csv")
    (outside.folder / "matrices" / "S_BW.csv.toml").unlink()
    outcome = outside.stage("build-optics")
    outcome.refused(3, *(f"{key}: missing" for key in REQUIRED), hint="S_BW.csv.toml")
    assert len(outcome.err.splitlines()) == len(REQUIRED) + 1


@pytest.mark.parametrize("key", [*REQUIRED, "rows", "columns", "row_units", "column_units"])
def test_each_missing_item_is_named(outside: Project, key: str) -> None:
    """A bare matrix of another program, everything declared beside it but one thing."""
    with np.load(outside.folder / "matrices" / "optics.npz") as file:
        np.savetxt(outside.folder / "bare.csv", file["S_BW"], fmt="%.17g", delimiter=",")
        lists = {k: file[f"S_BW.{k}"].tolist() for k in ("rows", "columns", "row_units", "column_units")}
        declared = tomllib.loads(str(file["S_BW.declaration"]))
    points = declared.pop("reference_points")
    use(outside, S_BW="bare.csv")

    def declare(left_out: str) -> None:
        beams = declared["beams"]
        lines = [f"{k} = {json.dumps(v)}" for k, v in {**lists, **declared}.items() if k not in (left_out, "beams")]
        if left_out != "beams":
            lines.append(f'beams = {{ meas = "{beams["meas"]}", ref = "{beams["ref"]}" }}')
        if left_out != "reference_points":
            lines += ["[S_BW.reference_points]", *(f"{k} = {json.dumps(v)}" for k, v in points.items())]
        (outside.folder / "bare.csv.toml").write_text("[S_BW]\n" + "\n".join(lines) + "\n")

    declare("")
    outside.stage("build-optics").ok()
    declare(key)
    outside.stage("build-optics").refused(3, f"bare.csv.toml: {key}: missing", hint="table [S_BW]")


@pytest.mark.parametrize(
    ("old", "new", "fact"),
    [
        ('frame = "layout"', 'frame = "body"', "frame: must be 'layout' or 'basic'"),
        ('rotations = "small_angle"', 'rotations = "xyz"', "rotations: must be 'small_angle'"),
        ('slopes = "angle"', 'slopes = "noll"', "pupil_radius_m: missing; slopes = 'noll' needs it"),
        ('slopes = "angle"', 'slopes = "angle"\npupil_radius_m = 0.001', "pupil_radius_m: slopes that are angles have"),
        ('slopes = "angle"', 'slopes = "angle"\nacuracy = 1e-6', "acuracy: unknown key; did you mean accuracy?"),
        ('slopes = "angle"', 'slopes = "angle"\naccuracy = 0.5', "accuracy: accuracy 0.5 is outside 1e-17 to 0.01"),
        ('slopes = "angle"', 'slopes = "angle"\nrows = ["a"]', "rows: stands in S_BW.csv as well"),
        ("[S_BW]", "[S_WB]", "S_WB: unknown table"),
    ],
)
def test_wrong_declarations(outside: Project, old: str, new: str, fact: str) -> None:
    use(outside, S_BW="matrices/S_BW.csv")
    side = outside.folder / "matrices" / "S_BW.csv.toml"
    if old == "[S_BW]":
        side.write_text(side.read_text().replace("[S_BW", "[S_WB"))
    else:
        replace(side, old, new)
    before = snapshot(outside.build)
    outside.stage("build-optics").refused(3, "S_BW.csv.toml", fact)
    assert snapshot(outside.build) == before


@pytest.mark.parametrize(
    ("change", "place", "fact"),
    [
        (lambda t: t.replace("TM1_ux,", "TM1_uX,", 1), "S_BW.csv", "columns missing: TM1_ux"),
        (lambda t: t.replace(",m,m,m,rad", ",m,ft,m,rad", 1), "S_BW.csv", "column TM1_uy: unknown unit 'ft'"),
        (lambda t: t.replace("PD1A_meas_y,m,", "PD1A_meas_y,m,nan,", 1), "S_BW.csv:4", "147 fields"),
        (lambda t: re.sub(r"(PD1A_meas_y,m,)[^,]*", r"\1nan", t), "S_BW.csv:4", "TM1_ux must be a finite number"),
        (lambda t: re.sub(r"(PD1A_meas_y,m,0.0,)[^,]*", r"\1oops", t), "S_BW.csv:4", "TM1_uy must be a finite number"),
        (lambda t: t.replace(",", ";"), "S_BW.csv", "holds no numbers"),
        (lambda t: "", "S_BW.csv", "is empty"),
        (lambda t: "\n".join(t.splitlines()[:-1]), "S_BW.csv", "rows missing: PD12B_ref_z2"),
    ],
)
def test_wrong_csv(outside: Project, change: object, place: str, fact: str) -> None:
    use(outside, S_BW="matrices/S_BW.csv")
    path = outside.folder / "matrices" / "S_BW.csv"
    text = path.read_text()
    changed = change(text)  # type: ignore[operator]
    assert changed != text
    path.write_text(changed)
    outside.stage("build-optics").refused(4, place, fact)


def test_wrong_files(outside: Project) -> None:
    use(outside, S_BW="matrix.mat")
    path = outside.folder / "matrix.mat"
    outside.stage("build-optics").refused(4, "matrix.mat: no such file")
    path.write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(600))
    outside.stage("build-optics").refused(4, "version 7.3", hint="-v7")
    path.write_bytes(b"not a MAT file at all, whatever its name says" * 20)
    outside.stage("build-optics").refused(4, "not a readable MAT file")
    scipy.io.savemat(path, {"S": np.eye(3)})
    outside.stage("build-optics").refused(4, "holds no S_BW, but S", hint="variable")
    (outside.folder / "matrix.mat.toml").write_text('[S_BW]\nvariable = "S"\n')
    outside.stage("build-optics").refused(3, "rows: missing", "frame: missing")
    replace(outside.folder / "optics.toml", "matrix.mat", "matrix.npz")
    (outside.folder / "matrix.npz").write_bytes(b"PK\x03\x04 and nothing behind")
    outside.stage("build-optics").refused(4, "not a readable NPZ file")
    np.savez(outside.folder / "matrix.npz", S_BW=np.array([{"a": 1}]))
    outside.stage("build-optics").refused(4, "not a readable NPZ file of plain arrays")
    replace(outside.folder / "optics.toml", "matrix.npz", "matrix.xlsx")
    (outside.folder / "matrix.xlsx").write_text("1")
    outside.stage("build-optics").refused(4, "neither CSV, NPZ nor MAT")


def test_wrong_matrix_is_refused_with_its_defect(outside: Project) -> None:
    """A physical check: exit code 5, the old result untouched."""
    path = outside.folder / "matrices" / "S_BW.csv"
    lines = path.read_text().splitlines()
    first = lines[0].split(",").index("BS3_ux")
    for i in range(2, len(lines)):
        fields = lines[i].split(",")
        fields[first : first + 6] = [repr(1e-3 * float(f)) for f in fields[first : first + 6]]
        lines[i] = ",".join(fields)
    path.write_text("\n".join(lines) + "\n")
    use(outside, S_BW="matrices/S_BW.csv")
    before = snapshot(outside.build)
    outside.stage("build-optics").refused(5, "S_BW.csv", "rigid_body", "columns of BS3 look scaled by 0.001")
    assert snapshot(outside.build) == before


def test_a_matrix_of_another_bench_differs_from_the_trace(outside: Project) -> None:
    """Sound in itself, yet not the matrix of this layout."""
    use(outside, S_BW="matrices/S_BW.csv", largest_difference=1e-6)
    layout = outside.folder / "optics.toml"
    replace(layout, "thickness_m = 0.006", "thickness_m = 0.008")
    replace(layout, "path_mismatch_m = 1e-3", "path_mismatch_m = 1e-1")
    replace(layout, "beam_overlap_m = 1e-4", "beam_overlap_m = 1e-2")
    outside.stage("build-distortion").ok()
    outside.stage("build-optics").refused(5, "differs from the layout's own trace by", "allowed 1e-06")
    replace(layout, "largest_difference = 1e-06\n", "")
    assert "difference from the trace" in outside.stage("build-optics").ok().out


def test_matlab_files_say_what_they_hold(exported: Project) -> None:
    folder = exported.folder / "matrices"
    file = scipy.io.loadmat(folder / "optics.mat", simplify_cells=True)
    assert {"S_BW", "P", "O_ideal", "D", "N_A", "N_B", "contents"} <= set(file)
    assert [row[0] for row in file["contents"]] == ["S_BW", "P", "O_ideal", "D", "N_A", "N_B"]
    with h5py.File(exported.build / "optics.h5") as source:
        np.testing.assert_array_equal(file["N_A"]["value"], source["/N/A"][()])
        areas = [name.decode() for name in source["/area/name"][()]]
    assert file["N_A"]["columns"].tolist() == areas
    assert file["N_A"]["rows"].tolist()[:2] == ["TM1_x", "TM1_eta"]
    assert file["N_A"]["row_units"].tolist()[:2] == ["m", "rad"]
    assert set(file["N_A"]["column_units"]) == {"K"}
    assert "set A" in file["N_A"]["description"]
    other = scipy.io.loadmat(folder / "sensitivity.mat", simplify_cells=True)
    assert other["S_SG"]["row_units"].tolist()[0] == "m/s^2"
    assert other["stiffness"]["value"].shape == (12, 12)


def test_read_out_follows_from_the_exported_matrices_alone(exported: Project) -> None:
    """N = [P S_BW]_TM^-1 [P S_BW]_bench D_opt, by somebody who has the files only."""
    folder = exported.folder / "matrices"
    optics = scipy.io.loadmat(folder / "optics.mat", simplify_cells=True)
    D_opt = scipy.io.loadmat(folder / "distortion.mat", simplify_cells=True)["D_opt"]
    laser, columns = optics["P"]["rows"].tolist(), optics["S_BW"]["columns"].tolist()
    rows = [i for i, name in enumerate(laser) if name.startswith(("PD1A", "PD12A"))]
    PS = (optics["P"]["value"] @ optics["S_BW"]["value"])[rows]
    read = {"x": "ux", "eta": "ry", "phi": "rz"}
    masses = [f"{tm}_{read[dof]}" for tm, dof in (n.split("_") for n in optics["N_A"]["rows"])]
    O = PS[:, [columns.index(name) for name in masses]]  # noqa: E741 - the matrix has this name in the field
    D = PS[:, [columns.index(name) for name in D_opt["rows"]]] @ D_opt["value"]
    N = np.linalg.solve(O, D)
    np.testing.assert_allclose(optics["N_A"]["value"], N, rtol=0, atol=1e-13 * np.abs(N).max())


def test_exports_are_the_same_every_time(exported: Project, tmp_path: Path) -> None:
    for fmt in SOURCES:
        tedm("export", "--format", fmt, "-d", exported.build, "-o", tmp_path).ok()
    assert snapshot(tmp_path) == snapshot(exported.folder / "matrices")


def test_export_into_one_file_and_refusals(exported: Project, tmp_path: Path) -> None:
    out = tedm("export", "-d", exported.build, "-o", tmp_path / "all.mat").ok().out
    assert "S_SG 12 x" in out
    assert {"S_BW", "S_SG", "D_opt"} <= set(scipy.io.loadmat(tmp_path / "all.mat"))
    tedm("export", "cases", "-d", exported.build).refused(
        2, "there are no matrices to export from cases", hint="optics"
    )
    for fmt, name, hint in (("csv", "a.csv", "folder"), ("npz", "a.mat", ".npz")):
        tedm("export", "--format", fmt, "-d", exported.build, "-o", tmp_path / name).refused(2, f"as {fmt}", hint=hint)
    tedm("export", "-d", tmp_path / "nowhere").refused(4, "nothing to export")
    tedm("export", "optics", "-d", tmp_path / "nowhere").refused(4, "optics.h5")


def test_matlab_files_have_their_limit(tmp_path: Path) -> None:
    huge = np.broadcast_to(0.0, (20000, 20000))  # takes no memory
    labels, units = ["r"] * 20000, ["m"] * 20000
    with pytest.raises(InputError, match=r"2\.98 GiB"):
        write_mat(tmp_path / "huge.mat", [NamedMatrix("D", huge, labels, labels, units, units, "")])
    assert not list(tmp_path.iterdir())


def test_the_documented_example_is_accepted(outside: Project) -> None:
    """That of docs/how-to/optics.md, with numbers printed in mm and urad and the elements about their ref_m."""
    text = (CONFIGS.parent / "docs" / "how-to" / "optics.md").read_text(encoding="utf-8")
    example = re.findall(r"```toml\n(# S_BW.csv.*?)```", text, flags=re.S)[0]
    layout = load_layout(outside.folder / "optics.toml")[1]
    rows, columns = output_labels(layout), input_labels(layout)
    size = {"m": 1e3, "rad": 1e6}
    S = np.array([size[u] for u in rows.units])[:, None] * optical_sensitivity(layout)
    S /= np.array([size[u] for u in columns.units])
    lines = [",".join(["row", *columns.names])]
    lines += [",".join([name, *(f"{v:.8e}" for v in values)]) for name, values in zip(rows.names, S, strict=True)]
    (outside.folder / "S_BW.csv").write_text("\n".join(lines) + "\n")
    (outside.folder / "S_BW.csv.toml").write_text(example)
    before = read_out(outside)
    use(outside, S_BW="S_BW.csv", largest_difference=1e-7)
    assert "9 significant digits" in outside.stage("build-optics").ok().out
    for name, values in read_out(outside).items():
        np.testing.assert_allclose(values, before[name], atol=1e-7 * np.abs(before[name]).max())
