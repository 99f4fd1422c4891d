"""`import tedm`: the numbers are those that the commands write, to the bit, under names; bad input is refused."""

from __future__ import annotations

import hashlib
import subprocess
import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest
import tedm
import xarray as xr
from label_scales import is_scale_alone

from tedm_cli.config.project import Project
from tedm_cli.contracts import KINDS
from tedm_cli.files.seal import seal
from tedm_cli.gravity import field, kernel
from tedm_cli.library.datasets import name_of

ROOT = Path(__file__).parents[2]
FILES = ["unit_loads", "distortion", "sensitivity", "optics", "adjoint", "case03", "case10b"]
PSD_UNITS = "(output_unit)^2/Hz"


@pytest.fixture(scope="module")
def project(small: Project) -> tedm.Project:
    return tedm.load_project(small.file.path.parent, small.build_dir)


@pytest.fixture(scope="module")
def case(project: tedm.Project) -> xr.Dataset:
    return project.run_case(3)


def held(path: Path) -> dict[str, Any]:
    """Every dataset of a file by its path, as another program reads it."""
    found: dict[str, Any] = {}
    with h5py.File(path) as file:
        kind = KINDS[str(file.attrs["schema"]).removeprefix("tedm.")]

        def visit(name: str, item: Any) -> None:
            if isinstance(item, h5py.Dataset) and "units" in item.attrs and not is_scale_alone(item):
                text = item.dtype.kind == "S"
                found["/" + name] = (item.asstr()[()] if text else item[()]), str(item.attrs["units"])

        file.visititems(visit)
    assert {p for p in kind.datasets if "{" not in p and not kind.datasets[p].optional} <= found.keys()
    return found


@pytest.mark.parametrize("name", FILES)
def test_every_number_of_a_file_is_there(small: Project, project: tedm.Project, name: str) -> None:
    """Compared with h5py, which knows nothing of the contracts."""
    path = small.build_dir / f"{name}.h5"
    with h5py.File(path) as file:
        kind = KINDS[str(file.attrs["schema"]).removeprefix("tedm.")]
    found = project.build.read(path.name)
    seen = 0
    for place, (values, units) in held(path).items():
        spec = kind.datasets.get(place)  # type: ignore[call-overload]
        if spec is None:  # of a family
            group, _, member = place.rpartition("/")
            spec = next(s for p, s in kind.datasets.items() if p.startswith(group + "/{"))
            got = found[name_of(spec)].sel({found[name_of(spec)].dims[0]: member})
        else:
            labelled = [dim for dim in found.sizes if kind.label_of(str(dim)) == place]
            got = found[labelled[0] if labelled else name_of(spec)]
            if spec.units is not None and spec.dtype != "str":
                assert got.attrs["units"] == units
        np.testing.assert_array_equal(got.values, values)
        seen += 1
    assert seen > 15


@pytest.mark.parametrize("case_id", ["4b", "10b"])
def test_a_case_in_memory_is_the_one_of_the_command(project: tedm.Project, case_id: str) -> None:
    made, written = project.run_case(case_id), project.build.case(case_id)
    assert made.attrs["schema"] == written.attrs["schema"]
    xr.testing.assert_identical(made.drop_attrs(deep=False), written.drop_attrs(deep=False))


def test_values_are_found_by_their_names(small: Project, project: tedm.Project, case: xr.Dataset) -> None:
    with h5py.File(small.build_dir / "optics.h5") as file:
        areas, rows = (list(file[p].asstr()[()]) for p in ("/area/name", "/label/read_out"))
        wanted = file["/N/B"][rows.index("TM2_eta"), areas.index("STRUT_5")]
    found = project.build.optics.N.sel(set="B", read_out="TM2_eta", area="STRUT_5")
    assert float(found) == wanted != 0.0
    assert str(found.read_out_unit.item()) == "rad"
    assert found.area_group.item() == "struts"
    share = case.contribution_share.sel(output="TM1_a_x")
    assert float(share.sum()) == pytest.approx(1.0)
    assert share.groupby("area_group").sum().sizes["area_group"] == len(set(case.area_group.values))
    near = case.psd.sel(output="TM1_a_x").sel(frequency=1e-3, method="nearest")
    assert float(near.frequency) == pytest.approx(1e-3)
    assert case.psd.attrs["units"] == PSD_UNITS
    assert case.correlation_real.sel(area="STRUT_1", area_column="STRUT_1") == 1.0
    distortion = project.build.read("distortion.h5", ["D_translation"])
    assert list(distortion.data_vars) == ["D_translation"]
    assert distortion.D_translation.sel(area="STRUT_5", node=1, xyz="z").attrs["units"] == "m/K; m/(K/m) of gradients"
    dc = project.build.sensitivity.dc_acceleration.sel(test_mass="TM1", source="structure", xyz="x")
    assert dc.attrs["units"] == "m/s^2"
    assert "test mass" in dc.attrs["frame"]


def test_verdicts_are_a_table(project: tedm.Project, case: xr.Dataset) -> None:
    verdicts = tedm.table(case)
    assert verdicts.columns[:4].tolist() == ["requirement", "output", "ratio", "binding_frequency"]
    assert verdicts.passed.dtype == bool
    assert (verdicts.passed == (verdicts.ratio <= 1.0)).all()
    assert verdicts.ratio.tolist() == case.verdict_ratio.values.tolist()
    at_rest = tedm.table(project.build.sensitivity, "dc_verdict")
    assert set(at_rest.test_mass) == {"TM1", "TM2"}
    areas = tedm.table(project.build.unit_loads, "area")
    assert areas.index.name == "area"
    assert areas.loc["STRUT_5", "group"] == "struts"


def test_changes_reach_the_noise_and_no_file(small: Project, project: tedm.Project, case: xr.Dataset) -> None:
    before = snapshot(small.build_dir)
    twice = project.run_case(3, temperature={"outside_K": 2e-3, "inside_K": 2e-4})
    np.testing.assert_allclose(twice.psd, 4.0 * case.psd, rtol=1e-12)
    assert twice.attrs["changed"] == "temperature"

    names, frequency = case.area.values[::-1], [1e-5, 1.0]
    asd = xr.DataArray(np.full((2, len(names)), 1e-4), {"frequency": frequency, "area": names}, ("frequency", "area"))
    given = project.run_case(3, temperature=asd)
    white = project.run_case(3, temperature={"preset": "white", "outside_K": 1e-4, "inside_K": 1e-4})
    np.testing.assert_allclose(given.psd, white.psd, rtol=1e-4)

    alone = project.run_case(3, correlation={"partition": "none"})
    identity = np.eye(len(names))[:, ::-1]
    R = xr.DataArray(identity, {"area": case.area.values, "area_column": names}, ("area", "area_column"))
    np.testing.assert_allclose(project.run_case(3, correlation=R).psd, alone.psd, rtol=1e-9)
    np.testing.assert_array_equal(alone.correlation_real, np.eye(len(names)))
    silent = project.run_case(3, correlation=R.sel(area=names[:2], area_column=names[:2]))
    assert int((silent.case_block >= 0).sum()) == 2

    strict = project.run_case(3, safety_factor=6.0, frequency={"points": 51})
    assert strict.sizes["frequency"] < case.sizes["frequency"]
    np.testing.assert_allclose(strict.verdict_ratio, 3.0 * case.verdict_ratio, rtol=1e-2)
    none = project.run_case(3, requirements=[])
    assert tedm.table(none).empty
    assert snapshot(small.build_dir) == before


def test_keys_that_are_not_given_stay_as_the_file_has_them(small: Project, tmp_path: Path) -> None:
    """Unless another preset is given: then the file's table is left aside."""
    named = f'title = "t"\nmodel = "{small.model.resolve()}"\noptics = "{small.required_optics().resolve()}"\n'
    (tmp_path / "tedm.toml").write_text(named, encoding="utf-8")
    tables = small.cases.read_text(encoding="utf-8").split("\n[")
    kept = [t for t in tables if not t.startswith(("temperature]", "[temperature"))]
    own = 'temperature]\npreset = "white"\noutside_K = 3e-3\ninside_K = 2e-3\n'
    (tmp_path / "cases.toml").write_text("\n[".join([*kept, own]), encoding="utf-8")
    project = tedm.load_project(tmp_path, small.build_dir)

    def levels(run: xr.Dataset) -> list[float]:
        return sorted({float(a) for a in run.temperature_asd.sel(frequency=1e-3, method="nearest")})

    assert levels(project.run_case(3)) == [2e-3, 3e-3]
    assert levels(project.run_case(3, temperature={"outside_K": 5e-3})) == [2e-3, 5e-3]
    assert levels(project.run_case(3, temperature={"preset": "white", "outside_K": 5e-3})) == [1e-4, 5e-3]


def snapshot(folder: Path) -> dict[str, str]:
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.iterdir() if p.is_file()}


def test_a_field_is_that_of_the_kernel(project: tedm.Project) -> None:
    points, masses = np.array([[0.5, 0.1, 0.3], [0.0, 0.4, -0.2]]), np.array([1.0, 2.5])
    found = tedm.self_gravity(points, masses, project.test_masses)
    parts = tedm.self_gravity(points, masses, project.test_masses, per_source=True)
    for tm in project.test_masses:
        wanted = field.self_gravity(points, masses, tm)
        for name in found.data_vars:
            np.testing.assert_array_equal(found[name].sel(test_mass=tm.name), getattr(wanted, str(name)))
    np.testing.assert_allclose(parts.sum("point").gamma_lin, found.gamma_lin, rtol=1e-13)
    assert parts.acceleration.dims == ("point", "test_mass", "xyz")
    cuboid = tedm.cuboid_field(points, [0.04, 0.05, 0.06])
    wanted_cuboid = kernel.cuboid_field(points, [0.04, 0.05, 0.06])
    for name in ("force", "gamma_lin", "torque", "omega_lin", "gamma_ang", "omega_ang"):
        np.testing.assert_array_equal(cuboid[name], getattr(wanted_cuboid, name))
    np.testing.assert_array_equal(cuboid.position.sel(point=1), points[1])
    trace = sum(float(cuboid.gamma_lin.sel(point=0, xyz=i, xyz_column=i)) for i in "xyz")
    assert abs(trace) < 1e-12 * float(abs(cuboid.gamma_lin).max())


def test_a_displaced_layout_is_traced(project: tedm.Project) -> None:
    """To first order the change is S_BW of the file; what moves as one is not seen."""
    step = 1e-7
    moved = tedm.trace(project, {"TM1": {"ux": step}})
    optics = project.build.optics
    column = optics.S_BW.sel(element_dof="TM1_ux")
    np.testing.assert_allclose(moved.ray_change.values.ravel(), step * column, atol=1e-3 * step)
    wanted = (optics.P @ column).sel(laser_output="PD1A_OPD")
    assert float(moved.laser_change.sel(laser_output="PD1A_OPD")) == pytest.approx(step * float(wanted), rel=1e-5)
    elements = [e.name for e in project.layout.elements]
    together = tedm.trace(project.layout, {name: [step, 0, 0, 0, 0, 0] for name in elements})
    assert float(abs(together.ray_change).max()) < 1e-12
    array = xr.DataArray([[step]], {"element": ["TM1"], "motion": ["ux"]}, ("element", "motion"))
    xr.testing.assert_identical(tedm.trace(project, array), moved)
    still = tedm.trace(ROOT / "configs" / "optics.toml")
    assert not still.ray_change.any()
    assert float(still.ray_output.sel(path="PD1A meas", ray="opl")) > 0.1


NAMES = ["STRUT_1", "STRUT_2"]
PAIR = xr.DataArray([[1.0, 2.0], [2.0, 1.0]], {"a": NAMES, "b": NAMES}, ("a", "b"))
REFUSED: dict[str, tuple[Callable[[tedm.Project], object], type[tedm.Error], str]] = {
    "case": (lambda p: p.run_case(33), tedm.UsageError, "there is no case '33'"),
    "key": (lambda p: p.run_case(3, temperature={"outside": 1.0}), tedm.ConfigError, "did you mean outside_K"),
    "level": (lambda p: p.run_case(3, temperature={"outside_K": 1e9}), tedm.ConfigError, "temperature.outside_K"),
    "number": (lambda p: p.run_case(3, temperature=3.0), tedm.InputError, "wanted area and frequency"),  # type: ignore[arg-type]
    "table": (lambda p: p.run_case(3, frequency=3.0), tedm.InputError, "wanted the keys"),  # type: ignore[arg-type]
    "rho": (lambda p: p.run_case(3, correlation={"partition": "all", "rho": 2.0}), tedm.ConfigError, "rho"),
    "matrix": (lambda p: p.run_case(3, correlation=PAIR), tedm.PhysicsError, "STRUT_1"),
    "names": (lambda p: p.run_case(3, correlation=PAIR[:1]), tedm.InputError, "other areas"),
    "no labels": (lambda p: p.run_case(3, correlation=PAIR.drop_vars("a")), tedm.InputError, "coordinate a"),
    "area": (
        lambda p: p.run_case(3, correlation=PAIR.assign_coords(a=["X", "Y"], b=["X", "Y"])),
        tedm.ConfigError,
        "'X'",
    ),
    "requirement": (lambda p: p.run_case(3, requirements=[{"name": "x"}]), tedm.ConfigError, "requirement[0]"),
    "safety": (lambda p: p.run_case(3, safety_factor=-1.0), tedm.ConfigError, "safety_factor"),
    "file": (lambda p: p.build.case(33), tedm.InputError, "case33.h5: no such file"),
    "variable": (lambda p: p.build.read("distortion.h5", ["D_translaton"]), tedm.UsageError, "D_translaton"),
    "folder": (lambda p: tedm.open_build("nowhere"), tedm.InputError, "nowhere"),
    "project": (lambda p: tedm.load_project("nowhere"), tedm.InputError, "nowhere"),
    "no project": (lambda p: tedm.load_project(ROOT / "docs"), tedm.InputError, "no tedm.toml, nor configs/tedm.toml"),
    "no TOML": (lambda p: tedm.load_project(ROOT / "README.md"), tedm.ConfigError, "not valid TOML"),
    "no layout": (lambda p: tedm.trace("nowhere.toml"), tedm.InputError, "nowhere.toml"),
    "dimension": (lambda p: tedm.table(p.build.optics), tedm.UsageError, "no dimension is called 'verdict'"),
    "inside": (lambda p: tedm.cuboid_field([0.0, 0.0, 0.0], 0.1), tedm.PhysicsError, "inside or on"),
    "points": (lambda p: tedm.cuboid_field([[0.0, 1.0]], 0.1), tedm.InputError, "points_m"),
    "words": (lambda p: tedm.cuboid_field(["a", "b", "c"], 0.1), tedm.InputError, "points_m"),  # type: ignore[list-item]
    "side": (lambda p: tedm.cuboid_field([1.0, 1.0, 1.0], 0.0), tedm.InputError, "side_m"),
    "masses": (lambda p: tedm.self_gravity([[1.0, 1, 1]], [1.0, 2], p.test_masses), tedm.InputError, "masses_kg"),
    "no mass": (lambda p: tedm.self_gravity([[1.0, 1, 1]], [1.0], []), tedm.InputError, "test_masses"),
    "element": (lambda p: tedm.trace(p, {"TM3": {"ux": 1.0}}), tedm.UsageError, "TM3"),
    "motion": (lambda p: tedm.trace(p, {"TM1": {"x": 1.0}}), tedm.UsageError, "'x'"),
    "six": (lambda p: tedm.trace(p, {"TM1": [1.0, 2.0]}), tedm.InputError, "wanted 6 finite"),
    "lost": (lambda p: tedm.trace(p, {"TM1": {"rz": 1.5}}), tedm.PhysicsError, "path PD1A meas"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_bad_input_is_refused(project: tedm.Project, name: str) -> None:
    call, error, fact = REFUSED[name]
    with pytest.raises(error) as refusal:
        call(project)
    assert isinstance(refusal.value, tedm.Error)
    assert fact in str(refusal.value)
    told = "".join(traceback.format_exception(refusal.value))
    assert told.count("Traceback") == 1, "what the message says in full is not shown as a second error"
    assert told.rstrip().endswith(f"hint: {refusal.value.hint}" if refusal.value.hint else refusal.value.placed)
    assert refusal.value.placed.startswith(refusal.value.where)


def test_a_stale_and_a_damaged_file_are_refused(small: Project, tmp_path: Path) -> None:
    """A case whose sensitivities are others by now, and a file that has been cut short."""
    for name in ("case03.h5", "distortion.h5", "optics.h5", "sensitivity.h5"):
        (tmp_path / name).write_bytes((small.build_dir / name).read_bytes())
    build = tedm.open_build(tmp_path)
    assert build.files == ["case03.h5", "distortion.h5", "optics.h5", "sensitivity.h5"]
    with h5py.File(tmp_path / "optics.h5", "r+") as file:
        file.attrs["touched"] = 1
    seal(tmp_path / "optics.h5")
    with pytest.raises(tedm.InputError, match=r"stale: not made from .*optics\.h5"):
        build.case(3)
    (tmp_path / "distortion.h5").write_bytes((tmp_path / "distortion.h5").read_bytes()[:-1])
    with pytest.raises(tedm.InputError, match="no seal"):
        build.read("distortion.h5")


IMPORTED = """
import sys
import tedm
heavy = {"xarray", "pandas", "matplotlib", "numba", "pyNastran", "typer", "rich", "jinja2", "typst"}
assert not heavy & sys.modules.keys(), heavy & sys.modules.keys()
tedm.load_project(sys.argv[1]).cases
assert not {"xarray", "typer", "rich"} & sys.modules.keys()
sys.modules["xarray"] = None
try:
    tedm.cuboid_field([1.0, 0.0, 0.0], 0.1)
except tedm.Error as error:
    print(error)
"""


def test_what_is_not_used_is_not_imported(small: Project) -> None:
    """Nor is xarray needed for what is no result; where it is missing, that is said."""
    path = f"{ROOT}:{ROOT / 'tedm_cli' / 'library' / 'top_level'}"
    done = subprocess.run(
        [sys.executable, "-c", IMPORTED, str(small.file.path)], env={"PYTHONPATH": path}, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    assert "xarray is not installed" in done.stdout
    assert "tedm[notebook]" in done.stdout
