"""Verdicts on the field at rest of the small sample, from areas that are summed again here."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.cli.printing.gravity import sensitivity_lines
from tedm_cli.config.model.file import load_model
from tedm_cli.config.project import Project
from tedm_cli.contracts import SENSITIVITY, UNIT_LOADS
from tedm_cli.errors import ConfigError
from tedm_cli.files.store import open_checked
from tedm_cli.gravity.field import self_gravity
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.progress import silent
from tedm_cli.results.gravity.field import dc_verdicts
from tedm_cli.stages.gravity.sensitivity import build_sensitivity

IS = 'IS = { TM1 = ["IS1"], TM2 = ["IS2"] }'
SUBSYSTEMS = f'[gravity.subsystems]\n{IS}\nLTP = "rest"\n'
LPF = '[[requirement_at_rest]]\nname = "lpf"\n'
SECOND = '[[test_mass]]\nname = "TM2"\nposition_m = [0.188, 0.0, 0.0]\nside_m = 0.046\nmass_kg = 1.96\n'
SINGLE = LPF + 'applies_to = "single"\n'


def verdicts(path: Path) -> dict[tuple[str, str, str], float]:
    with open_checked(path, SENSITIVITY) as file:
        return {(v.place, v.quantity, v.subsystem): v.value for v in dc_verdicts(file)}


def changed(small: Project, tmp_path: Path, *replaced: tuple[str, str]) -> Project:
    text = small.model.read_text(encoding="utf-8")
    for old, new in replaced:
        assert text.count(old) == 1
        text = text.replace(old, new)
    (tmp_path / "model.toml").write_text(text, encoding="utf-8")
    return dataclasses.replace(small, model=tmp_path / "model.toml")


def judged(small: Project, tmp_path: Path, *replaced: tuple[str, str]) -> list[DcVerdict]:
    path = tmp_path / "sensitivity.h5"
    done = build_sensitivity(changed(small, tmp_path, *replaced), path, silent)
    with open_checked(path, SENSITIVITY) as file:
        assert dc_verdicts(file) == done.verdicts
    return done.verdicts


def test_inertial_sensor_is_the_areas_of_its_groups(small: Project, tmp_path: Path) -> None:
    """With lumped masses, whose field is easily summed again; alone, and as the difference of the test masses.

    The second test mass is off its centre: there would be no difference else.
    """
    moved = SECOND.replace("[0.188, 0.0, 0.0]", "[0.190, 0.001, 0.0]")
    found = {
        (v.place, v.quantity, v.subsystem): v.value
        for v in judged(small, tmp_path, ('"quadrature"', '"lumped"'), (LPF, LPF + SINGLE), (SECOND, moved))
    }
    assert len(found) == 2 * 7 * 3 + 6 * 4
    sensors = []
    with open_checked(small.build_dir / "unit_loads.h5", UNIT_LOADS) as unit:
        offset, index = unit.array("/area/node_offset"), unit.array("/area/node_index")
        for t, tm in enumerate(load_model(tmp_path / "model.toml")[1].test_masses()):
            members = [a for a, g in enumerate(unit.strings("/area/group")) if g == f"IS{t + 1}"]
            rows = np.concatenate([index[offset[a] : offset[a + 1]] for a in members])
            sensors.append(self_gravity(unit.array("/grid/position")[rows], unit.array("/mass/lumped")[rows], tm))
    first, second = sensors
    assert found["TM2", "gamma_xx", "IS"] == pytest.approx(second.gamma_lin[0, 0], rel=1e-10)
    scale = np.abs(second.gamma_lin).max() * 0.046
    assert found["TM2", "a_x", "IS"] == pytest.approx(second.acceleration[0], abs=1e-12 * scale)
    for axis, name in enumerate("xyz"):
        difference = second.acceleration[axis] - first.acceleration[axis]
        assert found["TM2-TM1", f"a_{name}", "IS"] == pytest.approx(difference, abs=1e-12 * scale)
    assert np.abs(second.acceleration - first.acceleration).min() > 1e-9 * scale
    assert found["TM2", "omegadot_phi", "IS"] == pytest.approx(second.angular_acceleration[2], rel=1e-6, abs=1e-18)


def test_parts_sum_to_the_whole_field_and_its_difference(small: Project) -> None:
    found = verdicts(small.build_dir / "sensitivity.h5")
    assert len(found) == 2 * 3 + 6 * 4
    with open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        acceleration = file.array("/dc/acceleration").sum(axis=1)
        angular = file.array("/dc/angular_acceleration").sum(axis=1)
        gamma = file.array("/stiffness/gamma_lin").sum(axis=1)
    for t, name in enumerate(("TM1", "TM2")):
        assert found[name, "gamma_xx", "IS+LTP"] == pytest.approx(gamma[t, 0, 0], rel=1e-14)
        parts = found[name, "gamma_xx", "IS"] + found[name, "gamma_xx", "LTP"]
        assert parts == pytest.approx(gamma[t, 0, 0], rel=1e-12)
    place = "TM2-TM1"
    for quantity, value in (("a_x", acceleration[:, 0]), ("omegadot_eta", angular[:, 1])):
        for subsystem in ("IS+LTP", "all"):
            assert found[place, quantity, subsystem] == pytest.approx(value[1] - value[0], rel=1e-14)
        parts = found[place, quantity, "IS"] + found[place, quantity, "LTP"]
        assert parts == pytest.approx(value[1] - value[0], rel=1e-9)
    assert abs(found[place, "a_z", "all"]) < 1e-9 * abs(acceleration[0, 2]), "both are pulled alike along z"


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


def test_without_subsystems_both_are_judged_together(small: Project, tmp_path: Path) -> None:
    done = build_sensitivity(changed(small, tmp_path, (SUBSYSTEMS, "")), tmp_path / "sensitivity.h5", silent)
    assert {v.subsystem for v in done.verdicts} == {"IS+LTP", "all"}
    assert all(v.whole for v in done.verdicts)
    assert any("parts need [gravity.subsystems]" in line for line in sensitivity_lines(done))


def test_without_limits_nothing_is_judged(small: Project, tmp_path: Path) -> None:
    done = build_sensitivity(changed(small, tmp_path, (LPF, "")), tmp_path / "sensitivity.h5", silent)
    assert done.verdicts == []
    assert "not judged" in sensitivity_lines(done)[-1]
    assert verdicts(tmp_path / "sensitivity.h5") == {}


def test_subsystems_of_any_number_and_a_spacecraft(small: Project, tmp_path: Path) -> None:
    """Where the other test mass and what is not of the LTP are named, the parts still make the whole."""
    subsystems = f"""[gravity.subsystems]
{IS}
bench = ["OB"]
"S/C" = ["struts", "flanges"]
tm = ["other test mass"]
LTP = "rest"
"""
    own = """[[requirement_at_rest]]
name = "own"
quantity = "gamma_yz"
subsystem = ["bench", "tm", "S/C"]
lower = -1e-8
upper = 3e-8
test_mass = "TM2"
source = "SRD 4.2"
[[requirement_at_rest]]
name = "own"
quantity = "a_x"
subsystem = "tm"
magnitude = 1e-9
[[requirement_at_rest]]
name = "own"
quantity = "a_x"
subsystem = "bench"
magnitude = 1e-9
"""
    found = {
        (v.place, v.quantity, v.subsystem): v
        for v in judged(small, tmp_path, (SUBSYSTEMS, subsystems), (LPF, SINGLE + own))
    }
    with open_checked(tmp_path / "sensitivity.h5", SENSITIVITY) as file:
        a = file.array("/dc/acceleration")
        assert found["TM1", "a_x", "tm"].value == a[0, 1, 0]
        assert found["TM2", "a_x", "tm"].value == a[1, 1, 0]
        names = ("IS", "S/C", "LTP", "bench", "tm")
        assert sum(found["TM1", "a_x", n].value for n in names) == pytest.approx(a[0].sum(axis=0)[0], rel=1e-9)
        assert found["TM1", "a_x", "IS+LTP+S/C"].value == pytest.approx(
            sum(found["TM1", "a_x", n].value for n in names[:3]), rel=1e-12
        )
        assert not found["TM1", "a_x", "IS+LTP+S/C"].whole
    third = found["TM2", "gamma_yz", "bench+tm+S/C"]
    assert (third.lower, third.upper, third.requirement, third.source) == (-1e-8, 3e-8, "own", "SRD 4.2")
    assert ("TM1", "gamma_yz", "bench+tm+S/C") not in found


OWN = '[[requirement_at_rest]]\nname = "own"\nquantity = "a_y"\nmagnitude = 1e-9\n'


@pytest.mark.parametrize(
    ("old", "new", "fact"),
    [
        (SUBSYSTEMS, '[gravity.subsystems]\nTM1 = ["IS1"]\nTM2 = ["IS2"]\n',
         r'TM1: is a test mass, not a subsystem; .* IS = \{ TM1 = \["IS1"\], TM2 = \["IS2"\] \}, LTP = "rest"'),
        (IS, 'IS = { TM3 = ["IS1"] }', "subsystems.IS: no test mass 'TM3'; there are: TM1, TM2"),
        (IS, 'IS = { TM1 = ["IS1"] }', "subsystems.IS: says nothing of TM2"),
        (IS, 'IS = ["IS7"]', "no rule of .areas. has the group 'IS7', nor is it other test mass or compensation"),
        (IS, 'IS = ["IS1"]\nB = ["IS1"]', "B: group 'IS1' belongs to IS already"),
        (IS, 'IS = "rest"', "LTP: IS is the rest already"),
        (IS, '"a+b" = ["IS1"]', r"subsystems.a\+b: names of subsystems are made of letters"),
        (IS, 'IS = []', "subsystems.IS: must have at least 1 item, not 0"),
        (IS, 'all = ["IS1"]', "all is everything in the model"),
        (LPF, LPF + OWN.replace("a_y", "a_w"), "quantity: must be 'gamma_xx'"),
        (LPF, LPF + OWN + 'subsystem = "SC"\n', "subsystem: there is no subsystem 'SC'; there are: IS, LTP, all"),
        (LPF, LPF + OWN + 'subsystem = ["IS", "IS"]\n', "subsystem: IS is there twice"),
        (LPF, LPF + OWN + 'test_mass = "TM3"\n', "test_mass: there is no test mass 'TM3'; there are: TM1, TM2, all"),
        (LPF, LPF + OWN + "lower = -1.0\n", "has both magnitude and lower or upper"),
        (LPF, LPF + OWN.replace("magnitude", "upper"), "needs magnitude, or both lower and upper"),
        (LPF, LPF + OWN.replace("magnitude", "lower = 1e-10\nupper"), "1e-10 to 1e-09 does not hold 0"),
        (LPF, LPF + OWN.replace("1e-9", "0"), r"magnitude must be positive \(found 0\)"),
        (LPF, LPF + OWN.replace("1e-9", "-1e-9"), r"magnitude must be positive \(found -1e-09\)"),
        (LPF, LPF + OWN + OWN, r"own limits the same in requirement_at_rest\[1\]"),
        (LPF, LPF + LPF, r"lpf limits the same in requirement_at_rest\[0\]"),
        (LPF, LPF + OWN.replace("own", "lpf"), "lpf is the name of a preset"),
        (LPF, LPF.replace("lpf", "lfp"), "unknown requirement 'lfp'; did you mean lpf"),
        (LPF, LPF + "magnitude = 1e-9\n", "magnitude of the preset lpf cannot be changed"),
        (LPF, OWN + 'test_mass = "TM1"\napplies_to = "difference"\n', "test masses, and this is of TM1; applies"),
        (IS, IS.replace("IS =", "GRS ="), "name: lpf limits the subsystem IS, which .* lacks; it has GRS, LTP"),
        (f'{IS}\nLTP', f'GRS{IS[2:]}\nbench', "lpf limits the subsystems IS and LTP, which .* lacks; .* GRS, bench"),
        (IS, IS.replace("IS =", "is ="), "name: lpf limits the subsystem IS, which .* lacks; did you mean IS by is"),
        (IS, IS.replace("IS =", '"S/C" ='), "name: lpf limits the subsystem IS, which .* lacks; it has S/C, LTP"),
        ('LTP = "rest"', 'bench = "rest"', "name: lpf limits the subsystem LTP, which .* lacks; it has IS, bench"),
        (IS, IS + '\nSC = ["struts"]', "name: lpf limits the subsystem S/C, which .* lacks; did you mean S/C by SC"),
        (LPF, LPF + OWN.replace("1e-9", "1e-40"), "limit at rest 1e-40 is neither 0 nor at least"),
        (LPF, LPF + OWN.replace("1e-9", "nan"), "magnitude: must be a finite number"),
    ],
)  # fmt: skip
def test_wrong_subsystems_and_limits_are_refused(small: Project, tmp_path: Path, old: str, new: str, fact: str) -> None:
    with pytest.raises(ConfigError, match=fact) as caught:
        load_model(changed(small, tmp_path, (old, new)).model)
    assert len(caught.value.problems) == 1


ABOUT_X = "axes = [[1.0, 0.0, 0.0], [0.0, 0.6, 0.8], [0.0, -0.8, 0.6]]\n"
HALF_TURN = "axes = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]\n"
ABOUT_Z = "axes = [[0.5, 0.8660254037844386, 0.0], [-0.8660254037844386, 0.5, 0.0], [0.0, 0.0, 1.0]]\n"


@pytest.mark.parametrize(
    ("axes", "limit", "fact"),
    [
        (ABOUT_Z, LPF, r"applies_to: the x axes of TM1 and TM2 are not parallel \(60 deg apart\)"),
        (HALF_TURN, LPF, r"the x axes of TM1 and TM2 are not parallel \(180 deg apart\)"),
        (ABOUT_X, LPF, r"the y axes of TM1 and TM2 are not parallel \(53.13 deg"),
        (ABOUT_X, OWN.replace("a_y", "a_x") + 'applies_to = "difference"\n', ""),
        (ABOUT_Z, OWN.replace("a_y", "omegadot_phi") + 'applies_to = "difference"\n', ""),
        (ABOUT_Z, OWN.replace("a_y", "gamma_xz") + 'applies_to = "difference"\n', "the x axes"),
        (ABOUT_Z, SINGLE, ""),
    ],
)
def test_differences_need_parallel_axes(small: Project, tmp_path: Path, axes: str, limit: str, fact: str) -> None:
    model = changed(small, tmp_path, (SECOND, SECOND + axes), (LPF, limit)).model
    if not fact:
        load_model(model)
        return
    with pytest.raises(ConfigError, match=fact) as caught:
        load_model(model)
    assert 'applies_to = "single"' in str(caught.value)


def test_a_difference_needs_two_test_masses(small: Project, tmp_path: Path) -> None:
    alone = [(SECOND, ""), (IS, 'IS = ["IS1"]')]
    with pytest.raises(ConfigError, match="a difference is that of two test masses, and this is of TM1"):
        load_model(changed(small, tmp_path, *alone).model)
    limits = load_model(changed(small, tmp_path, *alone, (LPF, SINGLE)).model)[1].limits_at_rest()
    assert {limit.test_masses for limit in limits} == {("TM1",)}
    third = SECOND.replace("TM2", "TM3").replace("0.188", "0.5")
    three = [(SECOND, SECOND + third), (IS, 'IS = ["IS1"]')]
    with pytest.raises(ConfigError, match=r"this is of TM1, TM2, TM3; applies_to"):
        load_model(changed(small, tmp_path, *three).model)
    own = OWN + 'applies_to = "difference"\n'
    with pytest.raises(ConfigError, match=r'name two: test_mass = \["A", "B"\] is B minus A'):
        load_model(changed(small, tmp_path, *three, (LPF, own)).model)
    named = own + 'test_mass = ["TM3", "TM1"]\n'
    limits = load_model(changed(small, tmp_path, *three, (LPF, named)).model)[1].limits_at_rest()
    assert limits[0].places == [("TM1", "TM3")]
