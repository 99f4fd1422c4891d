"""The LISA-like sample, coarsely meshed: two benches at 60 degrees read as each alone and unturned."""

from __future__ import annotations

import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tedm_cli.arrays import FloatArray
from tedm_cli.cli.printing.contributors import contributor_lines
from tedm_cli.config.cases import select_cases
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project, load_project
from tedm_cli.contracts import CASE, DISTORTION, OPTICS, SENSITIVITY
from tedm_cli.files.store import open_checked
from tedm_cli.optics.benches import benches
from tedm_cli.optics.chain import OpticsChain, optics_chain
from tedm_cli.optics.layout import LAYOUT_AXES, Axes, Element, OpticalLayout, Vec3
from tedm_cli.optics.sensitivity import move_reference_points, optical_sensitivity
from tedm_cli.progress import silent
from tedm_cli.results.gravity.self_gravity import read_self_gravity
from tedm_cli.results.optics import read_bench_motion, read_read_outs
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.deck import write_deck
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.model.solve import solve
from tedm_cli.stages.noise.case import run_cases
from tedm_cli.stages.optics.build import build_optics

ROOT = Path(__file__).parents[2]
CONFIGS = ROOT / "configs" / "lisa_like"
MASSES = ("TM1", "TM2")


@pytest.fixture(scope="module")
def lisa(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """The sample up to the matrices and one of its cases."""
    folder = tmp_path_factory.mktemp("lisa")
    shutil.copytree(CONFIGS, folder / "configs")
    script = [sys.executable, str(ROOT / "sample_models" / "lisa_like.py"), "--element-size-mm", "1000"]
    script += ["--layout", str(CONFIGS / "optics.toml"), "-o", str(folder / "build" / "lisa.bdf")]
    subprocess.run(script, check=True, capture_output=True)
    project = load_project(folder / "configs" / "tedm.toml", folder / "build")
    write_deck(project, None)
    solve(project, None, silent)
    ingest(project, None, silent)
    build_distortion(project, None, silent)
    build_sensitivity(project, None, silent)
    build_optics(project, None)
    run_cases(project, ["5"], None, silent)
    return project


def test_the_shipped_layout_is_what_its_script_writes(tmp_path: Path) -> None:
    script = ROOT / "sample_models" / "lisa_like_layout.py"
    subprocess.run([sys.executable, str(script), "-o", str(tmp_path / "optics.toml")], check=True)
    assert (tmp_path / "optics.toml").read_bytes() == (CONFIGS / "optics.toml").read_bytes()


def vec3(v: FloatArray) -> Vec3:
    x, y, z = (float(c) for c in v)
    return x, y, z


def unturned(e: Element, R: FloatArray, origin: FloatArray) -> Element:
    """The element in the frame of its assembly, on whose axes a test mass is."""
    axes: Axes = LAYOUT_AXES
    if e.kind == "test_mass":
        np.testing.assert_allclose(np.array(e.axes) @ R, np.eye(3), atol=1e-14)
    return replace(
        e,
        ref_m=vec3((np.array(e.ref_m) - origin) @ R),
        normal=vec3(np.array(e.normal) @ R),
        local_y=None if e.local_y is None else vec3(np.array(e.local_y) @ R),
        axes=axes,
    )


def alone(layout: OpticalLayout, number: int) -> tuple[OpticalLayout, FloatArray, FloatArray]:
    """One bench with its test mass in the frame of its assembly, and where that is: axes (columns) and origin."""
    mass = layout.test_masses[number]
    R, origin = np.array(mass.axes).T, np.array(mass.ref_m)
    assert np.degrees(np.arctan2(R[1, 0], R[0, 0])) == pytest.approx(30.0 - 60.0 * number)
    mine = {mass.name} | {e.name for e in benches(layout)[f"OB{number + 1}"]}
    photodiodes = [name for name in layout.photodiodes if name in mine]
    one = replace(
        layout,
        elements=tuple(unturned(e, R, origin) for e in layout.elements if e.name in mine),
        paths=tuple(p for p in layout.paths if p.photodiode in mine),
        sets={name: tuple(d for d in of if d in photodiodes) for name, of in layout.sets.items()},
    )
    assert list(benches(one)) == [f"OB{number + 1}"]
    return one, R, origin


def chain_alone(project: Project, number: int) -> OpticsChain:
    """The optics of one bench whose grids, and what they do, are turned back into the frame of its assembly."""
    layout = load_layout(project.required_optics())[1]
    one, R, origin = alone(layout, number)
    with open_checked(project.build_dir / "distortion.h5", DISTORTION) as file:
        bench = read_bench_motion(file)
    places = [bench.element.index(e.name) for e in one.bench]
    nodes = (bench.position_m[places] - origin) @ R
    motion = bench.motion[:, places]
    turned = (motion.reshape(*motion.shape[:2], 2, 3) @ R).reshape(motion.shape)
    return optics_chain(one, move_reference_points(optical_sensitivity(one), one, nodes), turned, nodes)


@pytest.mark.parametrize("number", [0, 1])
def test_each_bench_reads_as_it_does_alone_and_unturned(lisa: Project, number: int) -> None:
    """To the rounding of the sums; in all sets, in the part of the bench as one, and in its distortion."""
    chain = chain_alone(lisa, number)
    with open_checked(lisa.build_dir / "optics.h5", OPTICS) as file:
        read = read_read_outs(file)
        rows = [i for i, label in enumerate(read.label) if label.startswith(MASSES[number])]
        assert [read.label[i] for i in rows] == [f"{MASSES[number]}_{dof}" for dof in ("x", "eta", "phi")]
        for s in chain.sets:
            scale = (np.abs(s.gain) @ np.abs(chain.motion)).max(axis=1, keepdims=True)
            for dataset, wanted in (
                (OPTICS.N, s.N),
                (OPTICS.N_RIGID, s.N_rigid),
                (OPTICS.N_DISTORTION, s.N_distortion),
            ):
                found = file.array(dataset.of(s.name))[rows]
                assert (np.abs(found - wanted) < 1e-10 * scale).all()
                assert np.abs(wanted).max() > 1e-3 * scale.max()
        assert file.strings(OPTICS.BENCH_NAME) == ["OB1", "OB2"]
        motion = file.array(OPTICS.COMMON_MODE_MOTION)[6 * number : 6 * number + 6]
    _, R, _ = alone(load_layout(lisa.required_optics())[1], number)
    there = (chain.rigid.amplitude.T.reshape(-1, 2, 3) @ R.T).reshape(-1, 6).T
    np.testing.assert_allclose(motion, there, atol=1e-10 * np.abs(there).max())


def test_one_bench_does_not_read_what_the_other_does(lisa: Project) -> None:
    with open_checked(lisa.build_dir / "optics.h5", OPTICS) as file:
        read = read_read_outs(file)
        owner = dict(zip(file.strings(OPTICS.ELEMENT_NAME), file.strings(OPTICS.ELEMENT_BENCH), strict=True))
    assert {owner[name] for name in MASSES} == {""}
    for name in read.sets:
        for label, terms in zip(read.label, read.by_element(name), strict=True):
            other = [e for e in read.element if owner[e] == ("OB2" if label.startswith("TM1") else "OB1")]
            assert len(other) == 10
            assert not terms[[read.element.index(e) for e in other]].any()


def test_self_gravity_mirrors_as_the_assemblies_do(lisa: Project) -> None:
    """The structure is mirrored in y, and so is each assembly in itself: x and z are the same, y is opposite."""
    with open_checked(lisa.build_dir / "sensitivity.h5", SENSITIVITY) as file:
        names, gravity = file.strings(SENSITIVITY.AREA_NAME), read_self_gravity(file)
    mirrored = [n for n in names if n.startswith("A1_") and "_Y" not in n and n[-1] not in "123456"]
    assert len(mirrored) == 15
    here, there = ([names.index(n.replace("A1_", mark)) for n in mirrored] for mark in ("A1_", "A2_"))
    for direction, sign in (("x", 1.0), ("y", -1.0), ("z", 1.0)):
        one, two = (gravity.S[gravity.label.index(f"{mass}_a_{direction}")] for mass in MASSES)
        rounding = 2e-6 * np.abs(one).max()  # single precision of the OP2
        for a, b in ((one[here], two[there]), (one[there], two[here])):
            np.testing.assert_allclose(sign * b, a, atol=rounding)
            assert np.abs(a).max() > 20 * rounding


def test_each_test_mass_is_judged_by_itself(lisa: Project) -> None:
    """Both alike, for nothing tells them apart but the side on which the optics stand on their benches."""
    assert select_cases(lisa.cases, ["all"]) == ["1", "2", "3", "4", "5", "6", "7"]
    with open_checked(lisa.build_dir / "case05.h5", CASE) as file:
        outputs = file.strings(CASE.VERDICT_OUTPUT)
        ratio = dict(zip(outputs, file.array(CASE.VERDICT_RATIO).tolist(), strict=True))
    assert outputs == ["TM1_a_x", "TM2_a_x", "A_TM1_x", "A_TM2_x", "B_TM1_x", "B_TM2_x"]
    assert ratio["TM2_a_x"] == pytest.approx(ratio["TM1_a_x"], rel=1e-5)
    assert ratio["A_TM2_x"] == pytest.approx(ratio["A_TM1_x"], rel=1e-2)
    assert ratio["A_TM2_x"] != pytest.approx(ratio["A_TM1_x"], rel=1e-5)


def test_each_bench_is_said_not_to_move_as_one(lisa: Project, tmp_path: Path) -> None:
    said: list[str] = []
    run_cases(
        lisa,
        ["5"],
        tmp_path / "case.h5",
        silent,
        lambda one: said.extend(contributor_lines(one.result, 10)),
    )
    assert len([line for line in said if "ratio if each bench did not move as one: " in line]) == 4
    assert not [line for line in said if "the bench" in line]
