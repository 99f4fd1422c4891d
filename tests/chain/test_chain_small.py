"""Physics of the whole chain on the small sample: superposition, symmetry, brute force, identities between cases."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import CASE, DISTORTION, OPTICS, SENSITIVITY, UNIT_LOADS
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.field import self_gravity
from tedm_cli.gravity.quadrature import quadrature_points
from tedm_cli.gravity.structure import structure_gravity
from tedm_cli.results.unit_loads import mass_of

SINGLE = 3e-7  # relative, through an OP2 in single precision


def mirrored(name: str) -> str:
    """The thermal area that the mirror plane x = 0 maps `name` to."""
    if name.startswith("IS"):
        return name.replace("IS1", "IS9").replace("IS2", "IS1").replace("IS9", "IS2")
    kind, _, number = name.partition("_")
    if kind == "STRUT":
        return f"STRUT_{(int(number) + 3) % 8 + 1}"
    if kind == "FLANGE":
        return f"FLANGE_{(int(number) + 1) % 4 + 1}"
    return name


def test_sensitivities_sum_to_the_uniform_load(small: Project) -> None:
    with (
        open_checked(small.build_dir / "unit_loads.h5", UNIT_LOADS) as unit,
        open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file,
    ):
        uniform = -np.einsum("rnc,nc->r", file.array("/operator/G"), unit.array("/uniform/translation"))
        total = file.array("/S").sum(axis=1)
        scale = np.abs(file.array("/S")).reshape(4, 3, -1).max(axis=(1, 2)).repeat(3)
    assert np.abs((total - uniform) / scale).max() < SINGLE


def test_distortion_sums_to_the_uniform_load(small: Project) -> None:
    with open_checked(small.build_dir / "distortion.h5", DISTORTION) as file:
        assert file.number("/check/superposition_translation") < SINGLE
        assert file.number("/check/superposition_optics") < SINGLE


def test_test_masses_mirror_each_other_as_the_model_does(small: Project) -> None:
    """Mirror in x: vectors flip x, angular accelerations flip y and z, areas swap sides."""
    flip_a, flip_w = np.array([-1.0, 1, 1]), np.array([1.0, -1, -1])
    with open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        names = file.strings("/area/name")
        order = [names.index(mirrored(n)) for n in names]
        s = file.array("/S")
        for first, flip in ((0, flip_a), (6, flip_w)):
            one, two = s[first : first + 3], s[first + 3 : first + 6]
            np.testing.assert_allclose(flip[:, None] * one[:, order], two, rtol=0, atol=1e-6 * np.abs(one).max())
        a, w = file.array("/dc/acceleration"), file.array("/dc/angular_acceleration")
        np.testing.assert_allclose(a[0, 0] * flip_a, a[1, 0], rtol=0, atol=1e-12 * np.abs(a).max())
        np.testing.assert_allclose(w[0, 0] * flip_w, w[1, 0], rtol=0, atol=1e-10 * np.abs(w).max())


def test_stiffness_identities(small: Project) -> None:
    """Outside the sources the force gradient has no trace; torque by translation is force by rotation, transposed."""
    _, config = load_model(small.model)
    with open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        for t, tm in enumerate(config.test_masses()):
            inertia = np.diag(tm.inertia_kg_m2)[:, None]
            for s in range(len(file.strings("/source/name"))):
                gamma = file.array("/stiffness/gamma_lin")[t, s]
                assert abs(np.trace(gamma)) < 1e-12 * np.abs(gamma).max()
                np.testing.assert_allclose(gamma, gamma.T, rtol=0, atol=1e-12 * np.abs(gamma).max())
                omega_lin = file.array("/stiffness/omega_lin")[t, s] * inertia
                gamma_ang = file.array("/stiffness/gamma_ang")[t, s] * tm.mass_kg
                np.testing.assert_allclose(omega_lin, gamma_ang.T, rtol=0, atol=1e-12 * np.abs(omega_lin).max())


@pytest.mark.parametrize("area", ["IS1_EH_OUTER", "STRUT_1", "OB_BENCH_PLUS_Y"])
def test_sensitivity_against_displaced_mesh(small: Project, area: str) -> None:
    """Brute force: move every piece of mass by plus and minus ten kelvin of an area and difference the field.

    Elements move with their shape functions. The third order is below 1e-6 of the result.
    """
    _, config = load_model(small.model)
    with (
        open_checked(small.build_dir / "unit_loads.h5", UNIT_LOADS) as unit,
        open_checked(small.build_dir / "distortion.h5", DISTORTION) as distortion,
        open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file,
    ):
        column = file.strings("/area/name").index(area)
        masses = mass_of(unit)
        move = 10.0 * distortion.dataset("/D/translation")[column]
        found = file.array("/S")[:, column]
    n = len(config.test_mass)
    brute = np.zeros(6 * n)
    for t, tm in enumerate(config.test_masses()):
        pieces = list(quadrature_points(masses, tm, config.gravity.quadrature_tolerance))
        mass = np.concatenate([p.mass.ravel() for p in pieces])
        position = np.concatenate([p.position.reshape(-1, 3) for p in pieces]) @ tm.axes + tm.position_m
        shift = np.concatenate([(p.values @ move[p.nodes]).reshape(-1, 3) for p in pieces])
        plus, minus = (self_gravity(position + sign * shift, mass, tm) for sign in (1, -1))
        brute[3 * t : 3 * t + 3] = (plus.acceleration - minus.acceleration) / 20.0
        brute[3 * (n + t) : 3 * (n + t) + 3] = (plus.angular_acceleration - minus.angular_acceleration) / 20.0
    for block in range(2 * n):
        rows = slice(3 * block, 3 * block + 3)
        assert np.abs(found[rows] - brute[rows]).max() < 1e-5 * np.abs(brute[rows]).max()


def test_lumped_masses_and_quadrature_have_one_mass_and_centre(small: Project) -> None:
    with open_checked(small.build_dir / "unit_loads.h5", UNIT_LOADS) as unit:
        total, centre = unit.number("/mass/total"), unit.array("/mass/centre_of_gravity")
        (tm, *_) = load_model(small.model)[1].test_masses()
        for lumped in (False, True):
            pieces = list(quadrature_points(mass_of(unit, lumped=lumped), tm, 1e-3))
            mass = np.concatenate([p.mass.ravel() for p in pieces])
            position = np.concatenate([p.position.reshape(-1, 3) for p in pieces]) + tm.position_m
            assert mass.sum() == pytest.approx(total, rel=1e-13)
            np.testing.assert_allclose(mass @ position / total, centre, rtol=0, atol=1e-14)


def test_lumping_of_coarse_elements_turns_the_gradient_round(small: Project) -> None:
    """Elements of 66 mm at 4 mm from the test mass: lumped, even the sign of the gradient along x is wrong."""
    with open_checked(small.build_dir / "unit_loads.h5", UNIT_LOADS) as unit:
        (tm, *_) = load_model(small.model)[1].test_masses()
        spread, lumped = (structure_gravity(mass_of(unit, lumped=way), tm, tolerance=1e-4) for way in (False, True))
    assert spread.field.gamma_lin[0, 0] < 0 < lumped.field.gamma_lin[0, 0]
    with open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        np.testing.assert_allclose(file.array("/stiffness/gamma_lin")[0, 0], spread.field.gamma_lin, rtol=1e-12)
        contributions = file.array("/area_contribution/acceleration")[0].sum(axis=0)
        # the optical grids and the clamped ends of the struts belong to no area but carry little
        np.testing.assert_allclose(contributions, file.array("/dc/acceleration")[0, 0], rtol=1e-3)


def psd(small: Project, case: str) -> dict[str, np.ndarray]:
    with open_checked(small.build_dir / f"case{case}.h5", CASE) as file:
        return {name: file.array(f"/psd/{name}") for name in file.strings("/output/label")}


@pytest.mark.parametrize(
    ("whole", "parts"), [("02", ("06", "08")), ("03", ("05", "07")), ("04", ("05", "09"))], ids=["S2", "S3", "S4"]
)
def test_identities_between_cases(small: Project, whole: str, parts: tuple[str, str]) -> None:
    total, first, second = psd(small, whole), psd(small, parts[0]), psd(small, parts[1])
    assert len(total) == 24
    with open_checked(small.build_dir / f"case{whole}.h5", CASE) as file:
        for name, value in total.items():
            # Coherent sums cancel: rounding is that of the sum of magnitudes, which the upper bound is made of.
            rounding = 1e-14 * file.array(f"/bounds/maximum/{name}")
            assert (np.abs(value - first[name] - second[name]) <= rounding).all()
            assert value.max() > 1e6 * np.abs(value - first[name] - second[name]).max()


def test_a_case_by_hand(small: Project) -> None:
    """Case 3 is two coherent sums: outside and inside of the shield."""
    with (
        open_checked(small.build_dir / "case03.h5", CASE) as case,
        open_checked(small.build_dir / "optics.h5", OPTICS) as optics,
    ):
        temperature = case.array("/temperature/asd")[case.array("/temperature/spectrum")]
        shield = np.array(case.strings("/area/shield"))
        row = optics.array("/N/A")[optics.strings("/label/read_out").index("TM1_x")]
        wanted = sum((row[shield == side] @ temperature[shield == side]) ** 2 for side in ("outside", "inside"))
        np.testing.assert_allclose(case.array("/psd/A_TM1_x"), wanted, rtol=1e-12)


def test_bounds_contain_every_case(small: Project) -> None:
    for path in sorted(small.build_dir.glob("case*.h5")):
        with open_checked(path, CASE) as file:
            for name in file.strings("/output/label"):
                value, most = file.array(f"/psd/{name}"), file.array(f"/bounds/maximum/{name}")
                assert (value <= most * (1 + 1e-9)).all()
                assert (value >= file.array(f"/bounds/minimum/{name}") * (1 - 1e-9)).all()
                assert (value <= file.array(f"/bounds/known_blocks/{name}") * (1 + 1e-9)).all()
            np.testing.assert_allclose(file.array("/contribution/share").sum(axis=1), 1.0, rtol=1e-9)


def test_sets_agree_for_plane_waves(small: Project) -> None:
    """A pure difference of plane waves: the redundant set reads the same noise."""
    with open_checked(small.build_dir / "optics.h5", OPTICS) as file:
        a, b = file.array("/N/A"), file.array("/N/B")
        assert file.number("/rank") == 6
    np.testing.assert_allclose(a, b, rtol=0, atol=1e-12 * np.abs(a).max())


def test_sample_model_is_reproducible(tmp_path: Path) -> None:
    """The committed model is what the script writes, to the byte."""
    import subprocess
    import sys

    root = Path(__file__).parents[2]
    small = root / "sample_models" / "small"
    script = [sys.executable, "sample_models/ltp_like.py", "--detail", "small", "--element-size-mm", "1000"]
    subprocess.run(
        [*script, "--layout", "configs/optics.toml", "-o", str(tmp_path / "ltp_small.bdf")], cwd=root, check=True
    )
    network = [f"thermal_{name}.csv" for name in ("nodes", "conductors", "powers", "elements")]
    for name in ("ltp_small.bdf", "ltp_small_areas.csv", *network):
        assert (tmp_path / name).read_bytes() == (small / name).read_bytes(), f"make sample-small rewrites {name}"
