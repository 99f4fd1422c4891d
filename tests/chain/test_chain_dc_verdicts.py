"""Verdicts on the field at rest of the small sample, from areas that are summed again here."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.cli.printing.gravity import sensitivity_lines
from tedm_cli.config.model import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import SENSITIVITY, UNIT_LOADS
from tedm_cli.errors import ConfigError
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.field import self_gravity
from tedm_cli.progress import silent
from tedm_cli.stages.gravity.sensitivity import build_sensitivity


def verdicts(path: Path) -> dict[tuple[str, str, str], float]:
    with open_checked(path, SENSITIVITY) as file:
        keys = zip(*(file.strings(f"/dc_verdict/{c}") for c in ("test_mass", "quantity", "subsystem")), strict=True)
        return dict(zip(keys, file.array("/dc_verdict/value"), strict=True))


def test_inertial_sensor_is_the_areas_of_its_groups(small: Project, tmp_path: Path) -> None:
    """With lumped masses, whose field is easily summed again."""
    text = small.model.read_text(encoding="utf-8")
    (tmp_path / "model.toml").write_text(text.replace('"quadrature"', '"lumped"'), encoding="utf-8")
    lumped = dataclasses.replace(small, model=tmp_path / "model.toml")
    build_sensitivity(lumped, tmp_path / "sensitivity.h5", silent)
    tm = load_model(small.model)[1].test_masses()[1]
    with open_checked(small.build_dir / "unit_loads.h5", UNIT_LOADS) as unit:
        offset, index = unit.array("/area/node_offset"), unit.array("/area/node_index")
        members = [a for a, g in enumerate(unit.strings("/area/group")) if g == "IS2"]
        rows = np.concatenate([index[offset[a] : offset[a + 1]] for a in members])
        sensor = self_gravity(unit.array("/grid/position")[rows], unit.array("/mass/lumped")[rows], tm)
    found = verdicts(tmp_path / "sensitivity.h5")
    assert len(found) == 2 * 7 * 3
    assert found["TM2", "gamma_xx", "IS"] == pytest.approx(sensor.gamma_lin[0, 0], rel=1e-10)
    scale = np.abs(sensor.gamma_lin).max() * 0.046
    assert found["TM2", "a_x", "IS"] == pytest.approx(sensor.acceleration[0], abs=1e-12 * scale)
    assert found["TM2", "omegadot_phi", "IS"] == pytest.approx(sensor.angular_acceleration[2], rel=1e-6, abs=1e-18)


def test_parts_sum_to_the_whole_field(small: Project) -> None:
    found = verdicts(small.build_dir / "sensitivity.h5")
    with open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        acceleration = file.array("/dc/acceleration").sum(axis=1)
        angular = file.array("/dc/angular_acceleration").sum(axis=1)
    for t, name in enumerate(("TM1", "TM2")):
        for quantity, value in (("a_z", acceleration[t, 2]), ("omegadot_eta", angular[t, 1])):
            assert found[name, quantity, "IS+LTP"] == pytest.approx(value, rel=1e-14)
            parts = found[name, quantity, "IS"] + found[name, quantity, "LTP"]
            assert parts == pytest.approx(value, rel=1e-12)


def test_area_contributions_sum_to_the_structure(small: Project) -> None:
    """Every grid that carries mass is in an area of this model: the areas make the whole structure."""
    with (
        open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file,
        open_checked(small.build_dir / "unit_loads.h5", UNIT_LOADS) as unit,
    ):
        mass, index = unit.array("/mass/lumped"), unit.array("/area/node_index")
        assert np.isin(np.flatnonzero(mass > 0), index).all()
        for t in range(len(load_model(small.model)[1].test_mass)):
            for name, group in (("acceleration", "dc"), ("angular_acceleration", "dc"), ("gamma_lin", "stiffness")):
                whole = file.array(f"/{group}/{name}")[t, 0]
                parts = file.array(f"/area_contribution/{name}")[t]
                gross = np.abs(parts).sum(axis=0).max()
                assert np.abs(parts.sum(axis=0) - whole).max() < 1e-13 * gross


def with_subsystems(small: Project, tmp_path: Path, text: str) -> Project:
    model = tmp_path / "model.toml"
    kept = small.model.read_text(encoding="utf-8").replace('TM1 = ["IS1"]\nTM2 = ["IS2"]\n', text)
    model.write_text(kept, encoding="utf-8")
    return dataclasses.replace(small, model=model)


def test_without_subsystems_both_are_judged_together(small: Project, tmp_path: Path) -> None:
    done = build_sensitivity(with_subsystems(small, tmp_path, ""), tmp_path / "sensitivity.h5", silent)
    assert {v.subsystem for v in done.verdicts} == {"IS+LTP"}
    assert any("no [gravity.subsystems]" in line for line in sensitivity_lines(done))


@pytest.mark.parametrize(
    ("text", "fact"),
    [
        ('TM3 = ["IS1"]\n', "TM3: no such test mass"),
        ('TM1 = ["IS7"]\n', "no rule of .areas. has the group 'IS7'"),
        ('TM1 = ["IS1"]\nTM2 = ["IS1"]\n', "group 'IS1' belongs to TM1 already"),
    ],
)
def test_wrong_subsystems_are_refused(small: Project, tmp_path: Path, text: str, fact: str) -> None:
    with pytest.raises(ConfigError, match=fact):
        load_model(with_subsystems(small, tmp_path, text).model)
