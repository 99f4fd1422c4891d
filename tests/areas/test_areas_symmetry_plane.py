"""The symmetry plane: geometry, where it is from, and the sides of areas."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tedm_cli.areas.attributes import area_attributes
from tedm_cli.config.base import validate
from tedm_cli.config.model.areas import AreasTable
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project, load_project
from tedm_cli.config.symmetry_plane import ProjectPlane, project_plane
from tedm_cli.errors import ConfigError
from tedm_cli.noise.areas import AreaTable
from tedm_cli.noise.correlation import CorrelationCase, correlation
from tedm_cli.noise.selection import BlockSelector
from tedm_cli.symmetry_plane import BASIC_PLANE, SymmetryPlane

ROOT = Path(__file__).parents[2]
MODEL = (ROOT / "sample_models" / "small" / "model.toml").read_text(encoding="utf-8")
LAYOUT = (ROOT / "configs" / "optics.toml").read_text(encoding="utf-8")
RULES = [{"match": "*", "group": "all", "shield": "inside"}]


def rigid(seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A rotation, whose rows are the turned axes, and a shift of up to 10 m."""
    rng = np.random.default_rng(seed)
    return Rotation.random(random_state=seed).as_matrix(), rng.uniform(-10.0, 10.0, 3)


def table(mid_m: float = 1e-3) -> AreasTable:
    return validate(AreasTable, {"mid_half_width_m": mid_m, "rule": RULES}, where="model.toml")


@settings(max_examples=50)
@given(seed=st.integers(0, 2**32 - 1))
def test_images(seed: int) -> None:
    """Twice mirrored is not mirrored; points and images are as far from the plane, and from each point of it."""
    axes, shift = rigid(seed)
    plane = SymmetryPlane(shift, 3.0 * axes[1])
    points = np.random.default_rng(seed).normal(size=(5, 3))
    image = plane.image(points)
    np.testing.assert_allclose(plane.image(image), points, atol=1e-13)
    np.testing.assert_allclose(plane.distance(image), -plane.distance(points), atol=1e-13)
    on_it = shift + 2.0 * axes[0] - axes[2]
    np.testing.assert_allclose(np.linalg.norm(image - on_it, axis=1), np.linalg.norm(points - on_it, axis=1))
    np.testing.assert_allclose(plane.distance(on_it), 0.0, atol=1e-13)


@settings(max_examples=50)
@given(seed=st.integers(0, 2**32 - 1))
def test_sides_and_pairs_go_with_a_rigid_motion(seed: int) -> None:
    rng = np.random.default_rng(seed)
    axes, shift = rigid(seed)
    half = rng.uniform(0.1, 1.0, (4, 3))
    centroid = np.concatenate([half, half * [1.0, -1.0, 1.0], [[0.3, 0.004, 0.1]]])
    names = [f"A{i}" for i in range(len(centroid))]

    def blocks(c: np.ndarray, plane: SymmetryPlane) -> tuple[list[str], list[list[int]]]:
        found = area_attributes(dict.fromkeys(names, "mean"), c, table(0.005), plane, where="")
        placed = AreaTable(found.name, found.group, found.shield, found.side, c, plane=plane)
        pairs = correlation(CorrelationCase("m", "", (BlockSelector(areas=("*",), partition="mirror"),)), placed)
        return found.side.tolist(), sorted(b.tolist() for b in pairs.blocks)

    sides, pairs = blocks(centroid, BASIC_PLANE)
    assert sides == ["+y"] * 4 + ["-y"] * 4 + ["mid"]
    assert pairs == [[0, 4], [1, 5], [2, 6], [3, 7], [8]]
    assert blocks(centroid @ axes + shift, SymmetryPlane(shift, axes[1])) == (sides, pairs)


@pytest.mark.parametrize("y", [0.0, 5.0])
def test_an_image_is_as_near_as_its_area_to_the_plane(y: float) -> None:
    """0.2 m from the plane and 0.5 m from the image: neighbours along the structure, wherever the plane is."""
    centroid = np.array([[0.1, y + 0.2, 0.0], [0.6, y - 0.2, 0.0]])
    plane = SymmetryPlane(np.array([0.0, y, 0.0]), np.array([0.0, 1.0, 0.0]))
    areas = replace(
        area_attributes({"A": "mean", "B": "mean"}, centroid, table(), plane, where=""),
        centroid_m=centroid,
        plane=plane,
    )
    place = "y = 0" if y == 0.0 else "y = 5 m"
    with pytest.raises(ConfigError, match=rf"without a mirror image on the other side of {place} \(no area near"):
        correlation(CorrelationCase("m", "", (BlockSelector(areas=("*",), partition="mirror"),)), areas)


def test_the_sides_of_another_plane() -> None:
    """Beside the plane, towards its normal and away from it; a rule that gives the side is not asked twice."""
    plane = SymmetryPlane(np.array([0.0, 0.0, 0.2]), np.array([0.0, 0.0, -1.0]))
    centroid = np.array([[0.0, 9.0, 0.1], [0.0, 9.0, 0.3], [0.0, 9.0, 0.2005]])
    assert area_attributes(dict.fromkeys("abc", "mean"), centroid, table(), plane, where="").side.tolist() == [
        "+y",
        "-y",
        "mid",
    ]
    given_side = validate(AreasTable, {"rule": [{**RULES[0], "side": "+y"}]}, where="model.toml")
    assert area_attributes({"b": "mean"}, centroid[1:2], given_side, plane, where="").side.tolist() == ["+y"]


@pytest.mark.parametrize(
    ("point", "normal", "words", "key"),
    [
        ([3.0, 0.0, -1.0], [0.0, 1.0, 0.0], "y = 0", "0 1 0 0"),
        ([3.0, 0.25, 0.0], [0.0, 2.0, 0.0], "y = 0.25 m", "0 1 0 0.25"),
        ([0.5, 0.0, 0.0], [1.0, 0.0, 0.0], "x = 0.5 m", "1 0 0 0.5"),
        ([0.0, 0.0, 0.0], [0.0, -1.0, 0.0], "the plane through (0, 0, 0) m with the normal (0, -1, 0)", "0 -1 0 0"),
    ],
)
def test_planes_in_words(point: list[float], normal: list[float], words: str, key: str) -> None:
    plane = SymmetryPlane(np.array(point), np.array(normal))
    assert (plane.words, plane.key) == (words, key)


def test_a_plane_is_the_same_by_whichever_point() -> None:
    axes, shift = rigid(5)
    plane = SymmetryPlane(shift, axes[1])
    other = SymmetryPlane(shift + 0.3 * axes[0] - 2.0 * axes[2], axes[1])
    assert plane.is_same(other)
    assert plane.key == other.key
    for moved in (SymmetryPlane(shift + 1e-9 * axes[1], axes[1]), SymmetryPlane(shift, -axes[1])):
        assert not plane.is_same(moved)
        assert plane.key != moved.key


# --- where it is from -----------------------------------------------------------------------------------------------


def project(folder: Path, layout: str | None = LAYOUT, plane: str = "") -> Project:
    (folder / "tedm.toml").write_text('title = "t"\n', encoding="utf-8")
    (folder / "model.toml").write_text(MODEL.replace("[areas]\n", f"[areas]\n{plane}\n"), encoding="utf-8")
    if layout is not None:
        (folder / "optics.toml").write_text(layout, encoding="utf-8")
    return load_project(folder / "tedm.toml", folder / "build")


def plane_of(project: Project) -> ProjectPlane:
    return project_plane(project, load_model(project.model)[1])


FRAME = "origin_m = [0.0, 0.0, 0.0]\naxes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]"
TURNED = LAYOUT.replace(
    FRAME, "origin_m = [0.0, 0.0, 0.5]\naxes = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]"
)


def test_the_default_follows_the_layout(tmp_path: Path) -> None:
    found = plane_of(project(tmp_path, TURNED))
    assert (found.origin, found.plane.words) == ("layout", "z = 0.5 m")
    assert found.layout == tmp_path / "optics.toml"


def test_without_a_layout_it_is_basic(tmp_path: Path) -> None:
    found = plane_of(project(tmp_path, None))
    assert (found.origin, found.plane.words, found.layout) == ("basic", "y = 0", None)


def test_the_configuration_comes_first(tmp_path: Path) -> None:
    """Then the layout is not even read."""
    text = "symmetry_plane = { point_m = [0.1, 0.0, 0.0], normal = [2.0, 0.0, 0.0] }"
    found = plane_of(project(tmp_path, "= no TOML", text))
    assert (found.origin, found.plane.words) == ("configured", "x = 0.1 m")


def test_of_the_layout_only_its_frame_must_be_sound(tmp_path: Path) -> None:
    found = plane_of(project(tmp_path, TURNED.replace('kind = "test_mass"', 'kind = "kettle"')))
    assert found.plane.words == "z = 0.5 m"


@pytest.mark.parametrize(
    ("layout", "fact"),
    [
        ("= no TOML", "not valid TOML"),
        ('title = "t"\n', "frame: missing, or no table"),
        ("frame = 3\n", "frame: missing, or no table"),
        (LAYOUT.replace("origin_m = [0.0, 0.0, 0.0]", "origin = [0.0, 0.0, 0.0]"), "frame.origin: unknown key"),
        (LAYOUT.replace("axes = [[1.0, 0.0", "axes = [[1.1, 0.0"), "frame.axes: rows must be three right-handed"),
    ],
)
def test_a_layout_without_a_frame(tmp_path: Path, layout: str, fact: str) -> None:
    with pytest.raises(ConfigError, match=r"optics\.toml") as caught:
        plane_of(project(tmp_path, layout))
    assert fact in str(caught.value)
    assert caught.value.exit_code == 3


@pytest.mark.parametrize(
    ("plane", "where", "fact"),
    [
        ("{ point_m = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 0.0] }", "areas.symmetry_plane.normal", "is no direction"),
        ("{ point_m = [0.0, 0.0, 0.0] }", "areas.symmetry_plane.normal", "missing"),
        ("{ point_m = [0.0, 0.0], normal = [0.0, 1.0, 0.0] }", "areas.symmetry_plane.point_m", "3 items"),
        ("{ point_m = [0.0, 0.0, 1e9], normal = [0.0, 1.0, 0.0] }", "areas.symmetry_plane.point_m", "is outside"),
        ('"y = 0"', "areas.symmetry_plane", "must be"),
    ],
)
def test_planes_that_are_none(tmp_path: Path, plane: str, where: str, fact: str) -> None:
    with pytest.raises(ConfigError) as caught:
        plane_of(project(tmp_path, LAYOUT, f"symmetry_plane = {plane}"))
    ((path, said),) = caught.value.problems
    assert path.startswith(where)
    assert fact in said
