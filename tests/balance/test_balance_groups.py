"""Blocks that count to a group of areas: in the subsystem of the group, and nowhere else."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from tedm_cli.config.model.compensation import compensation_masses, csv_text
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import SENSITIVITY
from tedm_cli.errors import ConfigError
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.compensation import field_of_compensation_masses
from tedm_cli.progress import silent
from tedm_cli.results.gravity.field import dc_verdicts
from tedm_cli.stages.gravity.sensitivity import build_sensitivity

Make = Callable[..., Project]
BLOCK = """
[[compensation_mass]]
name = "{name}"
centre_m = [-0.14, 0.02, 0.0]
size_m = 0.012
mass_kg = 0.03
"""


def values(project: Project) -> dict[tuple[str, str, str], float]:
    build_sensitivity(project, None, silent)
    with open_checked(project.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        return {(v.place, v.quantity, v.subsystem): v.value for v in dc_verdicts(file)}


def with_block(project: Project, text: str) -> Project:
    model = project.model.read_text(encoding="utf-8").partition("\n[[compensation_mass]]")[0]
    project.model.write_text(model + text, encoding="utf-8")
    return project


def test_a_block_counts_to_the_subsystem_of_its_group(project_of: Make) -> None:
    """What it adds is its own field: to the sensor of TM1 for TM1, to the LTP for TM2, whose sensor is another one."""
    project = project_of("")
    bare = values(with_block(project, "\n"))
    plain = values(with_block(project, BLOCK.format(name="B")))
    grouped = values(with_block(project, BLOCK.format(name="B") + 'group = "IS1"\n'))
    config = load_model(project.model)[1]
    blocks = compensation_masses(project, config)
    first, second = (field_of_compensation_masses(tm, blocks)[0] for tm in config.test_masses())
    assert blocks[0].group == "IS1"

    def added(found: dict[tuple[str, str, str], float], *key: str) -> float:
        place, quantity, subsystem = key
        return found[place, quantity, subsystem] - bare[place, quantity, subsystem]

    for place, field in (("TM1", first), ("TM2", second)):
        both = [added(plain, place, "gamma_xx", name) for name in ("IS", "LTP", "IS+LTP")]
        assert both == pytest.approx([0.0, field.gamma_lin[0, 0], field.gamma_lin[0, 0]], abs=1e-20)
    assert added(grouped, "TM1", "gamma_xx", "IS") == pytest.approx(first.gamma_lin[0, 0], rel=1e-9)
    assert added(grouped, "TM1", "gamma_xx", "LTP") == pytest.approx(0.0, abs=1e-20)
    assert added(grouped, "TM2", "gamma_xx", "IS") == pytest.approx(0.0, abs=1e-20)
    assert added(grouped, "TM2", "gamma_xx", "LTP") == pytest.approx(second.gamma_lin[0, 0], rel=1e-9)
    assert added(grouped, "TM2-TM1", "a_x", "IS") == pytest.approx(-first.acceleration[0], rel=1e-9)
    assert added(grouped, "TM2-TM1", "a_x", "LTP") == pytest.approx(second.acceleration[0], rel=1e-9)
    assert added(grouped, "TM2-TM1", "a_x", "all") == pytest.approx(added(plain, "TM2-TM1", "a_x", "all"), rel=1e-12)


def test_a_group_that_no_area_has_is_refused(project_of: Make) -> None:
    project = with_block(project_of(""), BLOCK.format(name="B") + 'group = "IS9"\n')
    with pytest.raises(ConfigError, match=r"no rule of .areas. has the group 'IS9'; there are: ") as caught:
        compensation_masses(project, load_model(project.model)[1])
    assert "block 'B'" in caught.value.fact
    assert "IS1, IS2" in caught.value.fact


def test_the_csv_is_read_again_as_it_was_written(project_of: Make, tmp_path: Path) -> None:
    """Names, numbers to the last digit, turns to rounding, ties and groups."""
    turned = 'rotation_rad = [0.3, -0.2, 0.1]\ngroup = "IS1"\ngrid = [7, "9:12"]\n'
    other = BLOCK.format(name="=C").replace("0.02, 0.0]", "0.0625, 0.1]") + "set = 12\n"
    project = with_block(project_of(""), BLOCK.format(name="B") + turned + other)
    written = compensation_masses(project, load_model(project.model)[1])
    (project.model.parent / "blocks.csv").write_text(csv_text(written), encoding="utf-8")
    with_block(project, "\n")
    text = project.model.read_text(encoding="utf-8")
    project.model.write_text(text.replace("[gravity]\n", '[gravity]\ncompensation_masses = "blocks.csv"\n'))
    for one, two in zip(compensation_masses(project, load_model(project.model)[1]), written, strict=True):
        assert (one.name, one.mass_kg, one.group) == (two.name, two.mass_kg, two.group)
        assert (one.centre_m == two.centre_m).all()
        assert (one.size_m == two.size_m).all()
        assert abs(one.axes - two.axes).max() < 1e-15
        assert one.tie is not None
        assert two.tie is not None
        assert one.tie.words == two.tie.words
