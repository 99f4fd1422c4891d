"""The balance of the small sample: met, read again by the chain, tolerances and re-trim, and what is refused."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "borders"))

from border_tools import tedm

from tedm_cli.config.project import Project
from tedm_cli.contracts import SENSITIVITY
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.files.store import open_checked
from tedm_cli.progress import silent
from tedm_cli.results.gravity.field import dc_verdicts
from tedm_cli.stages.balance.balance import balance
from tedm_cli.stages.balance.retrim import retrim
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest

Make = Callable[..., Project]
HEAD = "margin = 0.1\nclearance_m = 0.003\n"
STACK = """
[[box]]
name = "{name}"
frame = "TM1"
low_m = [-0.046, 0.016, {low}]
high_m = [-0.034, 0.060, {high}]
density_kg_m3 = 18500.0
shim_m = 3e-3
stack = "-x"
mirror = true
alike = true
"""
CM = """
[[box]]
name = "CM"
frame = "TM1"
low_m = [-0.050, -0.014, -0.010]
high_m = [-0.034, 0.014, 0.010]
density_kg_m3 = 18500.0
alike = true
"""
SENSORS = """
[[box]]
name = "IS_OUT"
frame = "TM1"
low_m = [-0.044, -0.010, 0.014]
high_m = [-0.034, 0.010, 0.030]
density_kg_m3 = 18500.0
step_kg = 0.001
alike = true
group = "IS1"
alike_group = "IS2"

[[box]]
name = "IS_IN"
frame = "TM1"
low_m = [0.034, -0.010, 0.014]
high_m = [0.044, 0.010, 0.030]
density_kg_m3 = 18500.0
alike = true
group = "IS1"
alike_group = "IS2"
"""
STACKS = STACK.format(name="HIGH", low=-0.012, high=0.030) + STACK.format(name="LOW", low=-0.052, high=-0.013)
BOXES = HEAD + STACKS + CM + SENSORS
ONE = HEAD + CM.replace("-0.050", "-0.064").replace("0.014", "0.030")
TOLERANCE = '\n[tolerance]\nblock_mass = 1e-3\nblock_position_m = 2e-5\nparts = "parts.csv"\ndraws = 2000\n'
PARTS = "part,sigma_mass,sigma_position_m\narea IS1_EH_OUTER,1e-3,2e-5\nproperty 1,1e-3,0\ngrid 850001,0.01,1e-4\n"


def run(project: Project, **given: Path | None) -> object:
    return balance(project, given.get("output"), given.get("csv"), silent)


def values(path: Path) -> dict[tuple[str, str, str], float]:
    with open_checked(path, SENSITIVITY) as file:
        return {(v.place, v.quantity, v.subsystem): v.value for v in dc_verdicts(file)}


def test_all_limits_are_met_and_the_chain_finds_the_same(project_of: Make) -> None:
    """What sensitivity.h5 of the model with these blocks says; some of them count to the inertial sensors."""
    project = project_of(BOXES)
    done = balance(project, None, None, silent)
    r = done.results
    assert sum(v.passed for v in r.before) == 25
    assert r.met == 30
    assert max(v.ratio for v in r.after) <= 0.9 + 1e-6
    assert r.total_relaxed_kg - 1e-9 <= r.bound_kg <= r.total_kg + 1e-9
    assert r.total_kg == pytest.approx(r.block_kg.sum(), rel=1e-12)
    assert {"HIGH", "HIGH_alike_mirror", "IS_IN", "IS_IN_alike"} <= set(r.block)
    then = values(project.build_dir / "sensitivity.h5")
    assert {(v.place, v.quantity, v.subsystem): v.value for v in r.before} == then
    model = project.model.read_text(encoding="utf-8")
    project.model.write_text(
        model.replace("[gravity]\n", f'[gravity]\ncompensation_masses = "{done.csv}"\n'), encoding="utf-8"
    )
    build_sensitivity(project, project.build_dir / "again.h5", silent)
    now = values(project.build_dir / "again.h5")
    for v in r.after:
        assert abs(now[v.place, v.quantity, v.subsystem] - v.value) < 1e-12 * min(-v.lower, v.upper)
    gained = now["TM1", "gamma_xx", "IS"] - then["TM1", "gamma_xx", "IS"]
    assert gained == pytest.approx(1.57e-8, rel=0.01), "from 1.057 times the limit to nine tenths of it"


def test_one_block_and_one_limit_by_hand(project_of: Make) -> None:
    """Its mass is what is beyond nine tenths of the limit, over what the chain says that a kilogram of it does."""
    project = project_of('subsystems = ["all"]\n' + ONE)
    r = balance(project, None, None, silent).results
    then = values(project.build_dir / "sensitivity.h5")["TM2-TM1", "a_x", "all"]
    block = r.block.index("CM")
    centre, size = (", ".join(repr(float(v)) for v in x[block]) for x in (r.centre, r.size))
    table = f'\n[[compensation_mass]]\nname = "X"\ncentre_m = [{centre}]\nsize_m = [{size}]\nmass_kg = 1.0\n'
    other = table.replace('"X"', '"Y"').replace(f"[{centre}]", f"[{', '.join(map(repr, r.centre[1].tolist()))}]")
    with project.model.open("a", encoding="utf-8") as model:
        model.write(table + other)
    build_sensitivity(project, None, silent)
    per_kg = values(project.build_dir / "sensitivity.h5")["TM2-TM1", "a_x", "all"] - then
    assert r.block_kg[block] == pytest.approx((-0.9 * 1.3e-9 - then) / per_kg, rel=1e-6)
    row = next(i for i, v in enumerate(r.after) if v.quantity == "a_x")
    assert r.price_kg[row] == pytest.approx(2 * 0.9 * 1.3e-9 / per_kg, rel=1e-5), "of both blocks"


def test_what_no_box_reaches_is_named(project_of: Make) -> None:
    """Compensation masses are of the LTP: what is wrong with the inertial sensors is out of their reach."""
    project = project_of(ONE)
    done = tedm("balance", "-c", project.file.path, "-d", project.build_dir).ok()
    assert "not reached: TM1 gamma_xx of IS, ratio 1.06: no box has mass that changes it" in done.out
    assert "25 of 30 limits at rest are met" in done.out


def test_a_box_that_is_too_small_is_named_with_what_it_blocks(project_of: Make) -> None:
    small = ONE.replace("-0.064", "-0.040")
    project = project_of(small)
    done = tedm("balance", "-c", project.file.path, "-d", project.build_dir, "--fail-on-violation")
    assert done.code == 5
    assert "blocked: TM2 − TM1 a_x of LTP (100 %) cannot be met" in done.out
    assert "full boxes that would help if they held more: CM (a kilogram more" in done.out
    assert re.search(r"TM2 − TM1 a_x of LTP is brought nearer by CM \(\d\S* % of its limit by a gram\)", done.out)


def test_builds_within_tolerances_meet_everything_and_others_do_not(project_of: Make) -> None:
    """Room for three deviations leaves next to none outside; the same blocks with ten times the deviations do not."""
    project = project_of(BOXES + TOLERANCE)
    (project.model.parent / "parts.csv").write_text(PARTS, encoding="utf-8")
    r = balance(project, None, None, silent).results
    assert r.tolerances is not None
    assert r.drawn is not None
    assert r.drawn.met == r.drawn.draws == 2000
    assert r.drawn.low == pytest.approx(0.025 ** (1 / 2000), rel=1e-9), "Clopper and Pearson, where all draws are met"
    assert len(r.tolerances.name) == 4 * (4 + 4 + 2 + 2 + 2) + 4 + 1 + 4
    row = next(i for i, v in enumerate(r.after) if (v.quantity, v.subsystem) == ("a_x", "IS"))
    assert r.off[row] == pytest.approx(3.0 * np.sqrt((r.tolerances.change[:, row] ** 2).sum()), rel=1e-9)
    assert all(v.ratio + r.off_ratio(i) <= 0.9 + 1e-5 for i, v in enumerate(r.after))
    # What is drawn deviates as the first order says, of shifts that are small against the distance.
    spread = (r.drawn.ratio[2, row] - r.drawn.ratio[0, row]) / 2 / 1.645 * 3.5e-10
    assert 3.0 * spread == pytest.approx(r.off[row], rel=0.05)
    assert r.drawn.error < 1e-6


def test_shims_bring_a_build_back(project_of: Make) -> None:
    """Parts and blocks that are far off break limits; other shims meet all of them again."""
    project = project_of(BOXES)
    names = balance(project, None, None, silent).results.block
    rng = np.random.default_rng(4)
    table = project.model.parent / "measured.csv"
    offsets = 5e-4 * rng.standard_normal((len(names), 3))
    rows = [f"block {n},0,{','.join(map(repr, o.tolist()))}" for n, o in zip(names, offsets, strict=True)]
    rows += ["area IS1_EH_OUTER,0,-2.5e-3,0,0", "property 1,0,0,0,2e-4"]
    table.write_text("\n".join(["part,mass_kg,dx_m,dy_m,dz_m", *rows, ""]), encoding="utf-8")
    done = retrim(project, table, None, None, silent)
    r = done.results
    assert sum(v.passed for v in r.before) < 30
    assert r.met == 30
    assert r.shims_before is not None
    assert r.mass_before_kg is not None
    assert (r.shims != r.shims_before).any()
    assert 0.0 < np.abs(r.mass_kg - r.mass_before_kg).sum() < 0.4
    assert np.array_equal(r.mass_before_kg > 0, r.shims_before != 0)
    lines = done.csv.read_text(encoding="utf-8").splitlines()
    first = next(line for line in lines if line.startswith("HIGH,")).split(",")
    assert float(first[2]) == pytest.approx(offsets[names.index("HIGH"), 1] + 0.038, abs=1e-9), "where it was measured"


@pytest.mark.parametrize(
    ("old", "new", "fact"),
    [
        ("low_m = [-0.064", "low_m = [-0.024", "low_m is not below high_m along x"),
        ('frame = "TM1"', 'frame = "TM3"', "there is no frame 'TM3'; there are: basic, TM1, TM2"),
        ("[-0.034, 0.030, 0.010]", "[-0.012, 0.030, 0.010]", "CM is in the way of test mass TM1"),
        ("[-0.034, 0.030, 0.010]", "[-0.030, 0.030, 0.010]", "elements of the structure"),
        ("density_kg_m3 = 18500.0", "density_kg_m3 = 18500.0\nmost_kg = -1.0", "mass -1 is outside 1e-18 to"),
        ("density_kg_m3 = 18500.0", 'density_kg_m3 = 18500.0\ngroup = "IS7"', "no area has the group 'IS7'; there are"),
        ("alike = true", 'alike = true\nalike_group = "IS7"', "no area has the group 'IS7'; there are"),
        ("alike = true", "mirror = true", "CM and CM_mirror reach into each other"),
        ("density_kg_m3 = 18500.0", "density_kg_m3 = 18500.0\nmost_kg = 0.01\nstep_kg = 0.1", "no room for a step"),
        ("margin = 0.1", "margin = 1.0", "margin 1 is outside 0 to 0.99"),
        ("margin = 0.1", 'subsystems = ["S/C"]', "no limit is on 'S/C'; there are limits on: IS, LTP, IS[+]LTP, all"),
        ("margin = 0.1", 'goal = "best"', "goal: must be 'least worst ratio' or 'most met'"),
        ("[[box]]", "[[box]]\nshim = 1.0", "did you mean shim_m"),
    ],
)
def test_what_is_wrong_is_named(project_of: Make, old: str, new: str, fact: str) -> None:
    project = project_of(ONE.replace(old, new, 1))
    with pytest.raises(ConfigError, match=fact) as caught:
        balance(project, None, None, silent)
    assert caught.value.where == str(project.balance)
    assert not (project.build_dir / "balance.h5").exists()


def test_two_boxes_of_one_name(project_of: Make) -> None:
    twice = ONE + "[[box]]" + ONE.split("[[box]]")[1]
    with pytest.raises(ConfigError, match="two boxes have the same name: CM"):
        balance(project_of(twice), None, None, silent)


def test_parts_around_the_structure_are_left_out(project_of: Make) -> None:
    """A box from the test mass outwards, in parts of 10 mm: those that meet it or its housing are left out."""
    text = ONE.replace("[-0.034, 0.030, 0.010]", "[-0.004, 0.030, 0.010]")
    assert text != ONE
    text = text.replace("alike", "parts = [6, 1, 1]\naround = true\nalike")
    done = balance(project_of(text), None, None, silent)
    assert done.left_out == {"CM": 3}
    assert done.results.candidate == ["CM_1", "CM_2", "CM_3"]


@pytest.mark.parametrize(
    ("row", "fact"),
    [
        ("area IS9,1e-3,0", "the model has no element with mass of area IS9"),
        ("property 99,1e-3,0", "the model has no element with mass of property 99"),
        ("grid 1,1e-3,0", "the model has no concentrated mass of grid 1"),
        ("shell 1,1e-3,0", "'shell 1' names no part"),
        ("block CM,1e-3,0", "'block CM' names no part"),
        ("property 1:2,1e-3,0\nproperty 1,1e-3,0", "property 1 has mass that is in property 1:2 already"),
        ("property 1,-1e-3,0", "sigma_mass: relative deviation -0.001 is outside"),
        ("property 1,0,0\nproperty 1,0,0", "property 1 is in line 2 already"),
    ],
)
def test_wrong_parts_are_named_with_their_line(project_of: Make, row: str, fact: str) -> None:
    project = project_of(ONE + TOLERANCE)
    table = project.model.parent / "parts.csv"
    table.write_text(f"{PARTS.splitlines()[0]}\n{row}\n", encoding="utf-8")
    with pytest.raises(InputError, match=fact) as caught:
        balance(project, None, None, silent)
    assert caught.value.where.startswith(f"{table}:")


def test_a_block_that_was_not_balanced_is_no_part(project_of: Make) -> None:
    project = project_of(ONE)
    balance(project, None, None, silent)
    table = project.model.parent / "measured.csv"
    table.write_text("part,mass_kg,dx_m,dy_m,dz_m\nblock CM_alive,0.1,0,0,0\n", encoding="utf-8")
    with pytest.raises(InputError, match="the balance has no block 'CM_alive'") as caught:
        retrim(project, table, None, None, silent)
    assert "did you mean CM_alike?" in caught.value.hint


def test_files_that_are_old_are_refused(project_of: Make) -> None:
    project = project_of(ONE)
    text = project.model.read_text(encoding="utf-8")
    project.model.write_text(text + "\n", encoding="utf-8")
    with pytest.raises(InputError, match="is stale"):
        balance(project, None, None, silent)
    project.model.write_text(text, encoding="utf-8")
    (project.build_dir / "sensitivity.h5").unlink()
    with pytest.raises(InputError, match="no such file"):
        balance(project, None, None, silent)


def test_a_project_without_boxes(built: Path) -> None:
    done = tedm("balance", "-c", built / "tedm.toml", "-d", built / "build")
    assert done.code == 3
    assert 'name it: balance = "balance.toml"' in done.err


def test_the_figure_shows_blocks_and_limits(project_of: Make, tmp_path: Path) -> None:
    """A section along each axis of every test mass, a row for each limit that is near, and what is not met."""
    project = project_of(ONE)
    path = tmp_path / "balance.svg"
    r = balance(project, None, None, silent, path).results
    text = path.read_text(encoding="utf-8")
    for words in ("TM1, cut at its z", "TM2, cut at its x", "TM2 − TM1 a_x IS+LTP", "FAIL", "CM, "):
        assert words in text
    near = sum(max(b.ratio, a.ratio) > 0.01 for b, a in zip(r.before, r.after, strict=True))
    assert text.count("Γ_xx") == sum(
        max(b.ratio, a.ratio) > 0.01 for b, a in zip(r.before, r.after, strict=True) if a.quantity == "gamma_xx"
    )
    assert near >= 10
    done = tedm("balance", "-c", project.file.path, "-d", project.build_dir, "--figure", "balance.jpeg")
    done.refused(2, "--figure balance.jpeg: must end in .svg or .png")


def test_the_price_of_tied_blocks_is_what_the_chain_finds(project_of: Make) -> None:
    """S_SG of the model with blocks that follow the nearest grids, against S_SG without them and what they add."""
    project = project_of(ONE.replace("alike = true", "alike = true\nnearest_grids = 3"))
    done = balance(project, None, None, silent)
    price = done.results.thermal
    assert price is not None
    assert all(tie.startswith("grids ") for tie in done.results.tie)
    assert done.turning == []
    text = project.model.read_text(encoding="utf-8")
    named = text.replace("[gravity]\n", f'[gravity]\ncompensation_masses = "{done.csv}"\n')
    project.model.write_text(named, encoding="utf-8")
    ingest(project, None, silent)
    build_distortion(project, None, silent)
    build_sensitivity(project, None, silent)
    with open_checked(project.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        found = file.array(SENSITIVITY.S)
    np.testing.assert_allclose(price.without + price.added, found, rtol=0, atol=1e-12 * np.abs(found).max())
    assert np.abs(price.added).max() > 1e-3 * np.abs(found).max()
    apart = price.root_sum_squares
    np.testing.assert_allclose(apart[1], np.sqrt((found**2).sum(axis=1)), rtol=1e-9)
