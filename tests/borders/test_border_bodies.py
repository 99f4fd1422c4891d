"""Shapes of test masses in a configuration: what they make, and what is refused by name."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pytest
from border_tools import MODEL_TOML, Project, replace

from tedm_cli.config.model.file import load_model
from tedm_cli.errors import ConfigError
from tedm_cli.gravity.bodies.composite import Composite
from tedm_cli.gravity.bodies.cuboid import Cuboid, Sphere
from tedm_cli.gravity.bodies.solid import cuboid_triangles
from tedm_cli.gravity.testmass import TestMass

KEYS = "side_m = 0.046\nmass_kg = 1.96"
SPHERE = 'shape = "sphere"\nradius_m = 0.03\nmass_kg = 1.96'
CYLINDER = 'shape = "cylinder"\nradius_m = 0.02\nheight_m = 0.06\ndensity_kg_m3 = 2e4'
MESH = 'shape = "polyhedron"\nstl = "body.stl"\nstl_unit = "mm"\nmass_kg = 1.96'
POCKET = '\n[[test_mass.pocket]]\nface = "+z"\ndiameter_m = 0.012\ndepth_m = 0.005\n'
CUBE = cuboid_triangles(np.full(3, -23.0), np.full(3, 23.0)) + np.array(
    [0.0, 0.0, 23.0]
)  # mm, about the middle of a face


def stl(triangles: np.ndarray) -> bytes:
    lines = ["solid cube"]
    for t in triangles:
        lines += ["facet normal 0 0 0", "outer loop", *("vertex " + " ".join(map(repr, map(float, c))) for c in t)]
        lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid", ""]).encode()


def loaded(folder: Path, keys: str, surface: np.ndarray = CUBE) -> TestMass:
    (folder / "body.stl").write_bytes(stl(surface))
    (folder / "model.toml").write_text(MODEL_TOML.replace(KEYS, keys))
    (mass,) = load_model(folder / "model.toml")[1].test_masses()
    return mass


def test_without_a_shape_it_is_a_cuboid(tmp_path: Path) -> None:
    mass = loaded(tmp_path, KEYS)
    assert isinstance(mass.body, Cuboid)
    np.testing.assert_array_equal(mass.body.side_m, 0.046)


def test_shapes(tmp_path: Path) -> None:
    assert isinstance(loaded(tmp_path, SPHERE).body, Sphere)
    cylinder = loaded(tmp_path, CYLINDER)
    assert cylinder.mass_kg == pytest.approx(2e4 * np.pi * 0.02**2 * 0.06, rel=1e-14)
    lying = loaded(tmp_path, CYLINDER + "\naxis = [2.0, 0.0, 0.0]\ninner_radius_m = 0.01")
    np.testing.assert_allclose(lying.body.extent_m, [0.06, 0.04, 0.04], rtol=1e-15)
    assert lying.body.volume_m3 == pytest.approx(np.pi * (0.02**2 - 0.01**2) * 0.06, rel=1e-14)
    assert not lying.body.contains(np.zeros((1, 3)))[0]
    both = loaded(tmp_path, KEYS + "\ndensity_kg_m3 = 20137")
    assert both.mass_kg == 1.96


def test_the_frame_is_about_the_centre_of_mass(tmp_path: Path) -> None:
    """`position_m` is where the geometry has its origin: the middle of a face in this file, turned with the axes."""
    axes = "\naxes = [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]"
    mass = loaded(tmp_path, MESH + axes)
    np.testing.assert_allclose(mass.position_m, [0.1 + 0.023, 0.2, 0.0], rtol=1e-12)
    cube = loaded(tmp_path, KEYS)
    points = np.array([[0.04, 0.01, -0.02], [0.1, 0.3, 0.2]])
    np.testing.assert_allclose(mass.body.field(points).force, cube.body.field(points).force, rtol=1e-11)
    pocket = loaded(tmp_path, KEYS + POCKET)
    removed = np.pi * 0.006**2 * 0.005
    shift = -removed * 0.0205 / (0.046**3 - removed)
    np.testing.assert_allclose(pocket.position_m, [0.1, 0.2, shift], rtol=1e-12, atol=1e-17)


def test_pockets_of_every_face_go_where_they_are_said_to(tmp_path: Path) -> None:
    for axis, face in enumerate("xyz"):
        for sign, upper in (("+", 1.0), ("-", -1.0)):
            text = (
                f'\n[[test_mass.pocket]]\nface = "{sign}{face}"\nsize_m = [0.01, 0.006]\ncentre_m = [0.008, -0.004]\n'
            )
            mass = loaded(tmp_path, f"{KEYS}\nchamfer_m = 0.002{text}depth_m = 0.004\n")
            assert isinstance(mass.body, Composite)
            across = [k for k in range(3) if k != axis]
            middle = np.zeros(3)
            middle[axis], middle[across] = upper * 0.021, [0.008, -0.004]
            places = np.tile(middle, (5, 1))
            places[1, axis], places[2, axis] = upper * 0.0189, upper * 0.0231
            places[3, across[0]] += 0.0051
            places[4, across[1]] += 0.0031
            inside = mass.body.contains(places - mass.body.centre_m)
            assert inside.tolist() == [False, True, False, True, True]


REFUSED = [
    (SPHERE + "\nside_m = 0.046", "test_mass[0].side_m: is a key of shape = 'cuboid', and this one is 'sphere'"),
    (SPHERE + POCKET, "test_mass[0].pocket: is a key of shape = 'cuboid'"),
    ('shape = "sphere"\nmass_kg = 1.0', "test_mass[0].radius_m: missing"),
    ('shape = "ball"\nmass_kg = 1.0', "test_mass[0].shape: must be 'cuboid', 'cylinder', 'sphere' or 'polyhedron'"),
    (CYLINDER.replace("density_kg_m3 = 2e4", ""), "test_mass[0].mass_kg: missing"),
    (CYLINDER.replace("2e4", "0.0"), "test_mass[0].density_kg_m3: density 0 is outside"),
    (CYLINDER.replace("2e4", "-2e4"), "test_mass[0].density_kg_m3: density -20000 is outside"),
    (CYLINDER + "\nmass_kg = 1.0", "test_mass[0]: density_kg_m3 20000 times the volume"),
    (CYLINDER + "\ninner_radius_m = 0.02", "inner_radius_m: inner radius 0.02 m is not smaller than radius_m, 0.02 m"),
    (CYLINDER + "\naxis = [0.0, 0.0, 0.0]", "test_mass[0].axis: has no length"),
    (KEYS + "\nchamfer_m = 0.023", "chamfer_m: 0.023 m leaves nothing of an edge of 0.046 m"),
    (KEYS + POCKET.replace("0.005", "0.05"), "test_mass[0]: pocket[0] is 0.05 m deep, the body only 0.046 m"),
    (
        KEYS + POCKET + "centre_m = [0.02, 0.0]",
        "test_mass[0]: pocket[0] is not inside the body: it sticks out of it by",
    ),
    (KEYS + POCKET + POCKET, "test_mass[0]: pocket[0] and pocket[1] overlap"),
    (KEYS + POCKET.replace("diameter_m = 0.012", ""), "test_mass[0].pocket[0]: needs either diameter_m or size_m"),
    (KEYS + POCKET.replace("diameter_m = 0.012", "size_m = 0.046").replace("0.005", "0.046"), "no volume is left"),
    (MESH.replace("body.stl", "other.stl"), "other.stl: cannot read the file"),
    (MESH.replace('"mm"', '"m"'), "is stl_unit 'm' right?"),
    (MESH.replace('stl_unit = "mm"', ""), "test_mass[0].stl_unit: missing"),
    (MESH.replace("body.stl", "."), "is a folder, not a regular file"),
]


@pytest.mark.parametrize(("keys", "fact"), REFUSED)
def test_what_is_refused(tmp_path: Path, keys: str, fact: str) -> None:
    with pytest.raises(ConfigError) as caught:
        loaded(tmp_path, keys)
    assert fact in str(caught.value)
    assert len(caught.value.problems) == 1


@pytest.mark.parametrize(
    ("surface", "fact"),
    [
        (
            CUBE[:-1],
            r"test_mass\[0\].stl: .*body.stl: the surface is open: 3 edges .*, of triangle \d+ from",
        ),
        (np.concatenate([CUBE, np.add(CUBE, [5.0, 6.0, 7.0])]), r"intersects itself: triangles \d+ and \d+"),
        (np.concatenate([CUBE[:1, ::-1], CUBE[1:]]), r"triangles \d+ and \d+ have opposite orientations"),
    ],
)
def test_surfaces_that_bound_nothing(tmp_path: Path, surface: np.ndarray, fact: str) -> None:
    with pytest.raises(ConfigError) as caught:
        loaded(tmp_path, MESH, surface)
    assert re.search(fact, str(caught.value)), str(caught.value)


def test_all_test_masses_are_told_of_at_once(tmp_path: Path) -> None:
    second = MODEL_TOML.partition("[[test_mass]]")[2].replace("TM1", "TM2")
    (tmp_path / "model.toml").write_text(MODEL_TOML + "[[test_mass]]" + second.replace(KEYS, MESH))
    text = (tmp_path / "model.toml").read_text().replace(KEYS, KEYS + "\ndensity_kg_m3 = 1.0", 1)
    (tmp_path / "model.toml").write_text(text)
    with pytest.raises(ConfigError) as caught:
        load_model(tmp_path / "model.toml")
    assert [place for place, _ in caught.value.problems] == ["test_mass[0]", "test_mass[1].stl"]


def test_a_cube_in_a_file_gives_the_sensitivities_of_the_cuboid(small: Project) -> None:
    """Both test masses of the sample as surfaces, one as it is and one described about the middle of a face."""
    with h5py.File(small.build / "sensitivity.h5") as file:
        cuboid = {
            name: file[name][...] for name in ("S", "test_mass/inertia", "dc/acceleration", "stiffness/linearised")
        }
    (small.folder / "one.stl").write_bytes(stl(np.subtract(CUBE, [0.0, 0.0, 23.0])))
    (small.folder / "two.stl").write_bytes(stl(CUBE))
    mesh = 'shape = "polyhedron"\nstl = "{}.stl"\nstl_unit = "mm"'
    for name in ("one", "two"):
        replace(small.model, "side_m = 0.046", mesh.format(name))
    replace(small.model, "position_m = [0.188, 0.0, 0.0]", "position_m = [0.188, 0.0, -0.023]")
    small.run("ingest").ok()
    small.run("build-distortion").ok()
    small.run("build-sensitivity").ok()
    with h5py.File(small.build / "sensitivity.h5") as file:
        for name, wanted in cuboid.items():
            np.testing.assert_allclose(file[name][...], wanted, rtol=0, atol=1e-8 * np.abs(wanted).max(), err_msg=name)
        assert file["test_mass/shape"][0] == b"surface of 12 triangles"
        paths = [Path(path.decode()).name for path in file["provenance/input_path"][...]]
        assert {"one.stl", "two.stl"} <= set(paths)
    small.run("make-rules").ok()
    assert "two.stl" in (small.build / "rules.mk").read_text()
