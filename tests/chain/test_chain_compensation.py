"""Compensation masses in the chain: a third source, apart from the others, that no temperature moves."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.cli.printing.gravity import sensitivity_lines
from tedm_cli.config.model.compensation import COLUMNS, compensation_masses
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import SENSITIVITY
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.compensation import field_of_compensation_masses
from tedm_cli.progress import silent
from tedm_cli.stages.gravity.sensitivity import build_sensitivity

TABLES = """
[[compensation_mass]]
name = "CM1"
centre_m = [-0.10, 0.0, 0.03]
size_m = [0.01, 0.02, 0.02]
density_kg_m3 = 19300.0

[[compensation_mass]]
name = "CM2"
centre_m = [0.10, 0.02, 0.03]
size_m = 0.02
mass_kg = 0.1
rotation_rad = [0.0, 0.0, 0.5]
"""
LINE = "CM3,0.0,0.05,0.05,0.01,0.02,0.03,0.1,0,0,0.2\n"


def with_blocks(project: Project, folder: Path, tables: str, csv: str | None = None) -> Project:
    """The project with compensation masses in its model configuration."""
    text = project.model.read_text(encoding="utf-8")
    if csv is not None:
        (folder / "cm.csv").write_text(csv, encoding="utf-8")
        text = text.replace("[gravity]\n", '[gravity]\ncompensation_masses = "cm.csv"\n')
    model = folder / "model.toml"
    model.write_text(text + tables, encoding="utf-8")
    return dataclasses.replace(project, model=model)


def test_third_source_is_kept_apart(small: Project, tmp_path: Path) -> None:
    project = with_blocks(small, tmp_path, TABLES, ",".join(COLUMNS) + "\n" + LINE)
    done = build_sensitivity(project, tmp_path / "sensitivity.h5", silent)
    blocks = compensation_masses(project, load_model(project.model)[1])
    assert [b.name for b in blocks] == ["CM3", "CM1", "CM2"]
    assert blocks[1].mass_kg == pytest.approx(19300.0 * 4e-6)
    np.testing.assert_allclose(blocks[2].axes[0], [np.cos(0.5), np.sin(0.5), 0.0], atol=1e-15)
    with (
        open_checked(tmp_path / "sensitivity.h5", SENSITIVITY) as file,
        open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as bare,
    ):
        assert file.strings("/source/name") == ["structure", "other test mass", "compensation masses"]
        assert bare.strings("/source/name") == ["structure", "other test mass"]
        for path in ("/dc/acceleration", "/dc/angular_acceleration", "/stiffness/gamma_lin", "/stiffness/omega_ang"):
            assert (file.array(path)[:, :2] == bare.array(path)).all()
        assert (file.array("/S") == bare.array("/S")).all()
        for t, tm in enumerate(done.test_masses):
            wanted, error, _ = field_of_compensation_masses(tm, blocks)
            assert (file.array("/dc/acceleration")[t, 2] == wanted.acceleration).all()
            assert (file.array("/stiffness/omega_ang")[t, 2] == wanted.omega_ang).all()
            assert file.array("/source/quadrature_error")[t, 2] == error
        assert [i.path.name for i in file.provenance().inputs][-1] == "cm.csv"
    text = "\n".join(sensitivity_lines(done))
    assert re.search(r"TM2 +compensation masses  acceleration ", text)
    assert "3 compensation masses, 0.3772 kg" in text


@pytest.mark.parametrize(
    ("line", "fact"),
    [
        (LINE.replace("0.2\n", "-0.2\n"), "mass_kg: mass -0.2 is outside 1e-18 to"),
        (LINE.replace("0.03,", "0,"), "size_z_m: length 0 is outside 1e-09 to 10000 m"),
        (LINE.replace("CM3", ""), "name is empty"),
        (LINE.replace("CM3", "CM\x003"), "control character U.0000"),
        (LINE.replace("0.1,0,0", "x,0,0"), "rotation_x_rad must be a finite number"),
        (LINE, "the block 'CM3' is in line 2 already"),
    ],
)
def test_a_wrong_line_is_named(small: Project, tmp_path: Path, line: str, fact: str) -> None:
    project = with_blocks(small, tmp_path, "", ",".join(COLUMNS) + "\n" + LINE + line)
    with pytest.raises(InputError, match=fact) as caught:
        compensation_masses(project, load_model(project.model)[1])
    assert caught.value.where == f"{tmp_path / 'cm.csv'}:3"


def test_wrong_tables_are_named(small: Project, tmp_path: Path) -> None:
    both = TABLES.replace("mass_kg = 0.1", "mass_kg = 0.1\ndensity_kg_m3 = 1.0")
    with pytest.raises(ConfigError, match=r"compensation_mass\[1\]: needs either mass_kg or density_kg_m3"):
        load_model(with_blocks(small, tmp_path, both).model)
    project = with_blocks(small, tmp_path, TABLES.replace("CM2", "CM1"))
    with pytest.raises(ConfigError, match="two blocks have the name 'CM1'"):
        compensation_masses(project, load_model(project.model)[1])


def test_equations_of_motion_hold_all_sources(small: Project, tmp_path: Path) -> None:
    """Each test mass moved alone feels the stiffness of everything; moved together, that of what stays behind."""
    project = with_blocks(small, tmp_path, TABLES)
    build_sensitivity(project, tmp_path / "sensitivity.h5", silent)
    with open_checked(tmp_path / "sensitivity.h5", SENSITIVITY) as file:
        k = file.array("/stiffness/linearised")
        gamma = file.array("/stiffness/gamma_lin")
        omega_ang = file.array("/stiffness/omega_ang")
        labels = file.strings("/label/tm_output")
        motions = file.strings("/label/tm_motion")
    assert k.shape == (12, 12)
    for t, name in enumerate(("TM1", "TM2")):
        row, column = labels.index(f"{name}_a_x"), motions.index(f"{name}_x")
        np.testing.assert_allclose(k[row : row + 3, column : column + 3], gamma[t].sum(axis=0), rtol=1e-14)
        together = k[row, motions.index("TM1_x")] + k[row, motions.index("TM2_x")]
        assert together == pytest.approx(gamma[t, [0, 2], 0, 0].sum(), rel=1e-9)
        row, column = labels.index(f"{name}_omegadot_z"), motions.index(f"{name}_phi")
        assert k[row, column] == pytest.approx(omega_ang[t, :, 2, 2].sum(), rel=1e-12)
