"""build-loads on the small sample: feet that move, gravity and moisture that are released, frequencies."""

from __future__ import annotations

import itertools
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from loads_project import with_loads

from tedm_cli.cli.printing.loads import loads_dict, loads_lines
from tedm_cli.config.loads import load_loads
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project
from tedm_cli.config.trade import CriterionTable
from tedm_cli.contracts import LOADS, OPTICS, SENSITIVITY, UNIT_LOADS
from tedm_cli.errors import ConfigError, InputError
from tedm_cli.fem.constraints import rigid_body_matrix
from tedm_cli.files.store import open_checked
from tedm_cli.optics.common_mode import common_mode
from tedm_cli.optics.exaggerated import motion_of_elements
from tedm_cli.optics.layout_checks import check_layout
from tedm_cli.optics.trace import nominal_poses, trace
from tedm_cli.progress import silent
from tedm_cli.results.loads import LoadResults
from tedm_cli.stages.loads.build import LoadsSummary, build_loads
from tedm_cli.stages.loads.model import loaded_model
from tedm_cli.stages.reporting.show import show_dict
from tedm_cli.stages.trade.criteria import measured
from tedm_cli.stages.trade.found import VariantResults

FEET = [f"STRUT_{n}" for n in range(1, 9)]
ALPHA = {1: 2e-8, 2: 8.6e-6, 6: 7e-6}  # of the deck's materials
TOML = (
    "".join(f'[[foot]]\nname = "{name}"\ngrid = {800004 + 100 * n}\n\n' for n, name in enumerate(FEET, 1))
    + '[[gravity_release]]\nname = "UP"\nground_m_s2 = [0.0, 0.0, -9.80665]\n\n'
    + '[[gravity_release]]\nname = "ACROSS"\nground_m_s2 = [3.0, -4.0, 0.0]\n\n'
    + '[[moisture_release]]\nname = "WARM"\n'
    + "".join(
        f"[[moisture_release.swelling]]\nmaterial = {mid}\nexpansion_per_percent = {alpha}\nchange_percent = 1.0\n"
        for mid, alpha in ALPHA.items()
    )
    + '[[moisture_release]]\nname = "DRY"\n[[moisture_release.swelling]]\nmaterial = 6\n'
    + "expansion_per_percent = 2e-4\nchange_percent = -0.5\n[modes]\nnumber = 5\n"
)


@pytest.fixture(scope="module")
def made(small: Project, tmp_path_factory: pytest.TempPathFactory) -> LoadsSummary:
    folder = tmp_path_factory.mktemp("loads")
    return build_loads(with_loads(small, folder, TOML), folder / "loads.h5", silent)


@pytest.fixture(scope="module")
def loads(made: LoadsSummary) -> LoadResults:
    return made.results


def columns(r: LoadResults, foot: str) -> list[int]:
    return [r.name.index(f"{foot}_{motion}") for motion in ("ux", "uy", "uz", "rx", "ry", "rz")]


def test_chain_every_foot_has_six_motions_and_all_together_are_one_more(loads: LoadResults) -> None:
    assert len(loads.name) == 6 * 9 + 4
    assert [loads.name[k] for k in loads.releases] == ["UP", "ACROSS", "WARM", "DRY"]
    assert set(loads.foot) == {*FEET, "INTERFACE", ""}
    assert [loads.unit[k] for k in columns(loads, "STRUT_3")] == ["m"] * 3 + ["rad"] * 3
    assert 0.0 < loads.interface < 1e-8


def test_chain_feet_that_move_as_one_move_the_structure_as_one(
    made: LoadsSummary, loads: LoadResults, small: Project
) -> None:
    """Six sums of the columns of the feet are the rigid motions of all grids, and of the outputs."""
    with open_checked(made.path, LOADS) as file, open_checked(small.build_dir / "unit_loads.h5", UNIT_LOADS) as unit:
        D, ids = file.array(LOADS.TRANSLATION), unit.array(UNIT_LOADS.GRID_ID)
        position = unit.array(UNIT_LOADS.GRID_POSITION)
    feet = position[np.searchsorted(ids, [800004 + 100 * n for n in range(1, 9)])]
    centre = feet.mean(axis=0)
    rigid, of_feet = (rigid_body_matrix(places - centre) for places in (position, feet))
    together = columns(loads, "INTERFACE")
    for k in range(6):
        weights = np.zeros(len(loads.name))
        for foot, place in zip(FEET, of_feet, strict=True):
            weights[columns(loads, foot)] = place[:, k]
        wanted = rigid[:, :3, k]
        np.testing.assert_allclose(np.tensordot(weights, D, 1), wanted, atol=1e-8 * np.abs(wanted).max())
        size = np.abs(loads.output * weights).sum(axis=1)
        assert (np.abs(loads.output @ weights - loads.output[:, together[k]]) <= 1e-7 * size).all()
        assert (np.abs(loads.by_distortion @ weights) <= 1e-6 * size).all()


def test_chain_a_bench_that_moves_as_one_reads_as_the_opposite_motion(loads: LoadResults) -> None:
    """Supports all along x: the test masses stay, so x of both is read as -1, and nothing else."""
    k = loads.name.index("INTERFACE_ux")
    for row, label in enumerate(loads.label):
        if loads.row_unit[row] in ("m", "rad"):
            assert loads.output[row, k] == pytest.approx(-1.0 if label.endswith("_x") else 0.0, abs=1e-6)


def test_chain_read_outs_by_distortion_are_without_the_bench_that_moves_as_one(
    made: LoadsSummary, loads: LoadResults, small: Project
) -> None:
    """Of every load: O⁻¹ P S_BW of what is left of the motions once that of the bench is taken off."""
    assert small.optics is not None
    _, layout = load_layout(small.optics)
    with open_checked(made.path, LOADS) as file, open_checked(small.build_dir / "unit_loads.h5", UNIT_LOADS) as unit:
        moved = file.array(LOADS.MOTION)
        position, ids = unit.array(UNIT_LOADS.GRID_POSITION), unit.array(UNIT_LOADS.GRID_ID)
        bench = file.array(LOADS.BENCH_DISTORTION)
    with open_checked(small.build_dir / "optics.h5", OPTICS) as file:
        gain = np.concatenate([file.array(OPTICS.GAIN.of(name)) for name in file.strings(OPTICS.SET_NAME)])
    at = position[np.searchsorted(ids, [int(e.grid or 0) for e in layout.bench])]
    left = moved - common_mode(layout, moved, at).motion
    rows = loads.of_unit("m") + loads.of_unit("rad")
    order = np.argsort(rows)
    wanted, whole = gain @ left, np.abs(gain) @ np.abs(moved)
    found = loads.by_distortion[np.array(rows)[order]]
    assert (np.abs(found - wanted) <= 1e-9 * whole).all()
    assert (np.abs(wanted) > 1e-4 * whole).any()
    along = left.reshape(len(layout.elements), 2, 3, -1)[:, 0]
    np.testing.assert_allclose(bench, np.linalg.norm(along, axis=1).max(axis=0), rtol=1e-9)


def test_chain_a_strain_is_that_of_a_temperature(loads: LoadResults, small: Project) -> None:
    """Swelling by the expansions of the materials is a warming of everything by 1 K: S_SG and N of all areas."""
    k = loads.name.index("WARM")
    with open_checked(small.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        S = file.array(SENSITIVITY.S)
    with open_checked(small.build_dir / "optics.h5", OPTICS) as file:
        # without what the faces of test masses do, which do not swell
        N = np.concatenate([file.array(OPTICS.N.of(name)) for name in file.strings(OPTICS.SET_NAME)])
        gain = np.concatenate([file.array(OPTICS.GAIN.of(name)) for name in file.strings(OPTICS.SET_NAME)])
        motion, names = file.array(OPTICS.MOTION), file.strings(OPTICS.LABEL_ELEMENT_DOF)
    faces = np.array([name.startswith("TM") for name in names])
    N = N - gain[:, faces] @ motion[faces]
    wanted = np.concatenate([S, N])
    size = np.abs(wanted).sum(axis=1)
    assert (np.abs(loads.output[:, k] - wanted.sum(axis=1)) < 2e-5 * size).all()
    assert (np.abs(wanted.sum(axis=1)) > 1e-3 * size).any()


def test_chain_a_trade_takes_the_worst_foot_and_no_rounding(small: Project, loads: LoadResults) -> None:
    """What distorts a bench by less than a millionth of the motion is no distortion; the interface is no foot."""
    assert loads.bench is not None
    assert {loads.foot[k] for k in np.flatnonzero(loads.bench_as_one)} == {"INTERFACE"}
    of_feet = [k for k in loads.motions if loads.foot[k] != "INTERFACE" and loads.unit[k] == "m"]
    rigid = replace(loads, bench=np.where(np.isin(np.arange(len(loads.name)), of_feet), 1e-9, loads.bench))
    for results, outputs in itertools.product((loads, rigid), (None, ["A_TM1_x"])):
        variant = VariantResults(replace(small, loads=small.model))
        criterion = CriterionTable(name="t", kind="transmission", outputs=outputs)
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(VariantResults, "loads", results)
            found = measured(criterion, variant)
        row = loads.by_distortion[loads.label.index("A_TM1_x")] if outputs else loads.bench
        wanted = 0.0 if results is rigid else np.abs(row[of_feet]).max()
        assert (found.value, found.unit) == (wanted, "m/m")
        assert (found.of == "rigid motion only") == (results is rigid)


def test_chain_gravity_is_linear_in_its_field(loads: LoadResults, small: Project, tmp_path: Path) -> None:
    text = '[[gravity_release]]\nname = "A"\nground_m_s2 = [0.0, 0.0, 19.6133]\n[modes]\nnumber = 0\n'
    twice = build_loads(with_loads(small, tmp_path, text), tmp_path / "loads.h5", silent).results
    assert twice.modes is None
    np.testing.assert_allclose(
        twice.output[:, 0], -2.0 * loads.output[:, loads.name.index("UP")], rtol=1e-6, atol=1e-22
    )
    # what is free of weight rises
    with open_checked(tmp_path / "loads.h5", LOADS) as file:
        assert file.array(LOADS.RIGID_TRANSLATION)[0, 2] < 0.0


def test_chain_spots_and_margins_are_those_of_beams_traced_anew(
    made: LoadsSummary, loads: LoadResults, small: Project
) -> None:
    """S_BW against the trace of the moved layout; checks whose numbers are there before and after."""
    assert small.optics is not None
    _, layout = load_layout(small.optics)
    with open_checked(made.path, LOADS) as file, open_checked(small.build_dir / "unit_loads.h5", UNIT_LOADS) as unit:
        moved = file.array(LOADS.MOTION)
        position, ids = unit.array(UNIT_LOADS.GRID_POSITION), unit.array(UNIT_LOADS.GRID_ID)
    at = position[np.searchsorted(ids, [int(e.grid or 0) for e in layout.bench])]
    k = loads.name.index("DRY")
    bench = moved[layout.columns_of(layout.bench), k].reshape(-1, 2, 3) @ layout.axes
    motion = motion_of_elements(layout, bench.reshape(-1, 6), at)
    change = trace(layout, nominal_poses(layout).moved(motion)) - trace(layout)
    np.testing.assert_allclose(loads.beam_shift[:, k], change.reshape(-1), atol=1e-3 * np.abs(change).max())
    margins = loads.margins
    assert margins is not None
    nominal = {(str(f.check), f.where, f.element): f.value for f in check_layout(layout)}
    assert len(margins.check) > 100
    for key, before in zip(
        zip(margins.check, margins.where, margins.element, strict=True), margins.before, strict=True
    ):
        assert nominal[key] == pytest.approx(before, rel=1e-6, abs=1e-12)
    assert np.isnan(margins.after[:, loads.motions]).all()
    spots = [n for n, check in enumerate(margins.check) if check == "overlap"]
    names = [loads.beam[b] for b in range(len(loads.beam))]
    for n in spots:  # the distance of the two spots of a photodiode, which meet before
        meas, ref = (
            np.array([loads.beam_shift[names.index(f"{margins.element[n]}_{beam}_{axis}"), k] for axis in "xy"])
            for beam in ("meas", "ref")
        )
        assert margins.after[n, k] == pytest.approx(np.linalg.norm(meas - ref), rel=0.02, abs=1e-10)


def test_chain_modes_are_in_the_file_with_their_masses(loads: LoadResults) -> None:
    modes = loads.modes
    assert modes is not None
    assert modes.rigid == []
    assert (np.diff(modes.frequency_hz) >= 0.0).all()
    assert len(modes.frequency_hz) == 5
    assert 1.0 < modes.frequency_hz[0] < 1e3
    assert 0.5 < modes.share.sum(axis=0).max() <= 1.0


def test_chain_loads_as_text_and_for_programs(made: LoadsSummary) -> None:
    lines = "\n".join(loads_lines(made, 3))
    assert "58 loads (54 motions of 8 feet, 4 releases), 24 outputs" in lines
    assert "and 24 more (--top 0: all)" in lines
    assert "supports that move as one carry the structure as one" in lines
    assert "natural frequencies" in lines
    told = loads_dict(made)
    assert [one["name"] for one in told["loads"]] == made.results.name
    assert told["loads"][-1]["margins"]["least"]["left_after"] <= 1.0
    assert told["loads"][0]["margins"] is None
    main = show_dict(made.path)["main"]
    assert main["first_frequency_Hz"] == told["modes"]["frequency_hz"][0]
    assert main["DRY"].startswith("distorts the benches by")
    assert main["STRUT_1_rx"].endswith("per rad")


@pytest.mark.parametrize(
    ("text", "fact"),
    [
        ('[[foot]]\nname = "A"\ngrid = 5\n', "foot A has no grid that the deck holds; it holds 800104, 800204"),
        ('[[foot]]\nname = "A"\ngrid = 77777\n', "the deck has no grid 77777; it holds 800104"),
        ('[[foot]]\nname = "A"\nset = 7\n', "the deck has no set 7"),
        ('[[foot]]\nname = "A"\nbox = { frame = 9, x_m = [0.0, 1.0] }\n', "the deck has no coordinate system 9"),
        ('[[foot]]\nname = "A"\nbox = { x_m = [5.0, 6.0] }\n', "foot A has no grid that the deck holds"),
        (
            '[[foot]]\nname = "A"\ngrid = 800104\n[[foot]]\nname = "B"\ngrid = "800104:800204"\n',
            "grid 800104 is of foot A already",
        ),
        ('[[foot]]\nname = "A"\ngrid = 800104\nset = 1\n', "needs one of grid, set, box and each_support"),
        ('[[foot]]\nname = "A"\neach_support = false\n', "each_support"),
        (
            '[[foot]]\nname = "A"\neach_support = true\nabout_m = [0.0, 0.0, 0.0]\n',
            "there is no about_m with each_support",
        ),
        (
            '[[foot]]\nname = "A"\nbox = { x_m = [-9.0, 9.0] }\n[[foot]]\nname = "B"\neach_support = true\n',
            "the deck holds no grid that is not of a foot already",
        ),
        ('[[foot]]\nname = "interface"\ngrid = 800104\n', "INTERFACE is the name of all supports together"),
        (
            '[[foot]]\nname = "A"\ngrid = 800104\n[[gravity_release]]\nname = "a"\nground_m_s2 = [0.0, 0.0, 1.0]\n',
            "two loads have the same name: A",
        ),
        (
            '[[foot]]\nname = "A"\ngrid = 800104\n[[gravity_release]]\nname = "a_UX"\nground_m_s2 = [0.0, 0.0, 1.0]\n',
            "two loads are called A_UX",
        ),
        ('[[gravity_release]]\nname = "A"\nground_m_s2 = [0.0, 0.0, 0.0]\n', "has no field of gravity to release"),
        (
            '[[moisture_release]]\nname = "A"\n[[moisture_release.swelling]]\nmaterial = 77\n'
            "expansion_per_percent = 1e-4\nchange_percent = 1.0\n",
            "no element has the material 77; there are: 1, 2, 6",
        ),
        ("[modes]\nnumber = 0\n", "has no load, and asks for no modes"),
        ("[modes]\nnumber = -1\n", "number of modes -1 is outside"),
    ],
)
def test_chain_loads_that_are_not_there_are_refused(small: Project, tmp_path: Path, text: str, fact: str) -> None:
    with pytest.raises(ConfigError, match=fact):
        build_loads(with_loads(small, tmp_path, text), tmp_path / "loads.h5", silent)
    assert not (tmp_path / "loads.h5").exists()


def test_chain_each_support_that_has_no_name_is_a_foot_of_its_own(small: Project, tmp_path: Path) -> None:
    text = '[[foot]]\nname = "EACH"\neach_support = true\nmotions = ["uy"]\n[[foot]]\nname = "A"\ngrid = 800304\n'
    project = with_loads(small, tmp_path, text)
    assert project.loads is not None
    found = loaded_model(project, load_loads(project.loads)[1], project.loads).loads
    others = [800004 + 100 * n for n in (1, 2, 4, 5, 6, 7, 8)]
    feet = [column.foot for column in found]
    assert list(dict.fromkeys(feet)) == ["A", *(f"EACH_{grid}" for grid in others), "INTERFACE"]
    assert [c.name for c in found if c.foot.startswith("EACH")] == [f"EACH_{grid}_uy" for grid in others]


def test_chain_more_supports_than_can_be_feet_are_refused(
    small: Project, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tedm_cli.stages.loads.columns._MOST_SUPPORTS", 7)
    project = with_loads(small, tmp_path, '[[foot]]\nname = "EACH"\neach_support = true\n')
    assert project.loads is not None
    with pytest.raises(ConfigError, match="the deck holds 8 more grids, and at most 7 may be feet of their own"):
        loaded_model(project, load_loads(project.loads)[1], project.loads)


def test_chain_a_project_without_loads_says_how_to_name_them(small: Project, tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="the project has no loads but temperatures") as error:
        build_loads(small, tmp_path / "loads.h5", silent)
    assert 'loads = "loads.toml"' in str(error.value)
    with pytest.raises(InputError, match="cannot read the configuration"):
        build_loads(replace(small, loads=tmp_path / "none.toml"), tmp_path / "loads.h5", silent)


def test_chain_modes_alone_need_no_load(small: Project, tmp_path: Path) -> None:
    found = build_loads(with_loads(small, tmp_path, ""), tmp_path / "loads.h5", silent)
    assert found.results.name == []
    assert found.results.modes is not None
    assert "natural frequencies" in "\n".join(loads_lines(found, None))


def test_chain_loads_of_another_deck_are_refused(small: Project, tmp_path: Path) -> None:
    """The deck has changed since the unit loads were read."""
    folder = tmp_path / "copy"
    shutil.copytree(small.model.parent, folder)
    deck = folder / "unit_loads.bdf"
    deck.write_text(deck.read_text().replace("9.03+10", "9.04+10"))
    project = with_loads(replace(small, model=folder / "model.toml"), tmp_path, TOML)
    with pytest.raises(InputError, match="is stale"):
        build_loads(project, tmp_path / "loads.h5", silent)


def test_chain_loads_are_in_the_library_by_name(made: LoadsSummary, loads: LoadResults, tmp_path: Path) -> None:
    tedm = pytest.importorskip("tedm")
    pytest.importorskip("xarray")
    shutil.copy(made.path, tmp_path / "loads.h5")
    found = tedm.Build(tmp_path).read("loads.h5")
    k, row = loads.name.index("STRUT_3_uz"), loads.label.index("TM1_a_y")
    assert float(found.output_distortion.sel(load="STRUT_3_uz", row="TM1_a_y")) == loads.by_distortion[row, k]
    assert list(found.mode_frequency.values) == list(loads.modes.frequency_hz if loads.modes else [])


def test_chain_loads_are_of_projects_with_test_masses(small: Project, tmp_path: Path) -> None:
    model = tmp_path / "model.toml"
    model.write_text(small.model.read_text(encoding="utf-8").partition("[[test_mass]]")[0], encoding="utf-8")
    with pytest.raises(ConfigError, match="the model has none, and the effect of loads, also that of read-outs"):
        build_loads(with_loads(replace(small, model=model), tmp_path, TOML), tmp_path / "loads.h5", silent)
