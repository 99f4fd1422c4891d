"""A concentrated mass on a lever, from the deck to S_SG."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from offset_mass import LEVER, with_mass

from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import SENSITIVITY, UNIT_LOADS
from tedm_cli.errors import PhysicsError
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.field import self_gravity
from tedm_cli.progress import silent
from tedm_cli.stages.exports.mesh import WantedArrays, export_mesh
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Project:
    project = with_mass(tmp_path_factory.mktemp("offset"), 850001)
    ingest(project, None, silent)
    build_distortion(project, None, silent)
    build_sensitivity(project, None, silent)
    return project


def test_offset_mass_adds_its_own_field_and_moves_with_its_grid(small: Project, project: Project) -> None:
    """What it adds to the sensitivity is the central difference of a point that moves by u + θ x w."""
    tm = load_model(project.model)[1].test_masses()[0]
    with (
        open_checked(project.build_dir / "unit_loads.h5", UNIT_LOADS) as unit,
        open_checked(project.build_dir / "sensitivity.h5", SENSITIVITY) as file,
        open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as before,
    ):
        ids = unit.array("/grid/id")
        grid = int(np.searchsorted(ids, 850001))
        place = unit.array("/grid/position")[grid] + LEVER
        np.testing.assert_array_equal(file.array("/operator/offset_node"), [grid])
        load = unit.array("/area/load_K")[:, None]
        move = unit.array("/translation")[:, grid] / load
        turn = unit.array("/rotation")[:, grid] / load
        more = file.array("/S")[:3] - before.array("/S")[:3]
        pull = file.array("/dc/acceleration")[0, 0] - before.array("/dc/acceleration")[0, 0]
    np.testing.assert_allclose(pull, self_gravity(place[None], [0.5], tm).acceleration, rtol=1e-6)
    shift = 1e2 * (move + np.cross(turn, LEVER))
    wanted = [
        (
            self_gravity((place + s)[None], [0.5], tm).acceleration
            - self_gravity((place - s)[None], [0.5], tm).acceleration
        )
        / 2e2
        for s in shift
    ]
    np.testing.assert_allclose(more.T, wanted, rtol=0, atol=1e-5 * np.abs(wanted).max())
    # without the rotation it would be another number
    assert np.abs(np.cross(turn, LEVER)).max() > 0.1 * np.abs(move).max()


def test_grid_with_a_lever_contributes_by_its_rotation(project: Project) -> None:
    """Of the arrays in the .vtu: gradients times motions, grid by grid, and their sum [S_SG]."""
    done = export_mesh(project.build_dir, None, WantedArrays(("uniform",), ("TM1_a_y",)), silent)
    found = {a.name: a.values for a in done.on_points}
    part = found["contribution_TM1_a_y_uniform"]
    moved = (found["gradient_TM1_a_y"] * found["displacement_uniform"]).sum(axis=1)
    turned = (found["gradient_rotation_TM1_a_y"] * found["rotation_uniform"]).sum(axis=1)
    np.testing.assert_allclose(part, moved + turned, rtol=0, atol=1e-12 * np.abs(part).max())
    assert found["grid_id"][np.flatnonzero(found["gradient_rotation_TM1_a_y"].any(axis=1))].tolist() == [850001]
    with open_checked(project.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        S = file.array("/S")[file.strings("/row/label").index("TM1_a_y")].sum()
    assert part.sum() == pytest.approx(S, rel=1e-9, abs=0)
    assert abs(turned.sum()) > 1e-6 * abs(S)  # it would be missed


def test_offset_mass_on_a_grid_that_cannot_turn_is_refused(tmp_path: Path) -> None:
    project = with_mass(tmp_path, 100)
    ingest(project, None, silent)
    with pytest.raises(PhysicsError, match="never rotate under any load: 100"):
        build_distortion(project, None, silent)
