"""[D] is per kelvin whatever the steps of temperature in the deck and the temperature they start from.

The decks are solved anew: twice the step moves the structure twice as far, and [D] is that of steps of 1 K.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from decimal import Decimal
from pathlib import Path

import numpy as np
import pytest
from offset_mass import with_mass

from tedm_cli.cli.printing.ingest import step_lines
from tedm_cli.config.project import Project
from tedm_cli.contracts import DISTORTION, UNIT_LOADS
from tedm_cli.errors import PhysicsError
from tedm_cli.files.store import open_checked
from tedm_cli.nastran.loads.temperature_sets import plain
from tedm_cli.nastran.op2.reader import open_op2
from tedm_cli.nastran.op2.writer import write_op2
from tedm_cli.progress import silent
from tedm_cli.stages.exports.mesh import WantedArrays, export_mesh
from tedm_cli.stages.gravity.sensitivity import build_sensitivity
from tedm_cli.stages.model.distortion import build_distortion
from tedm_cli.stages.model.ingest import ingest
from tedm_cli.stages.model.solve import solve_deck

SINGLE = 5e-7  # relative, through two OP2 files in single precision
LEVER_GRID = 850001
AREAS = 28  # the subcase after them warms all of them


def solved(folder: Path, step: Callable[[int], str], reference: str = "0.") -> Project:
    """The small sample with a lever, each subcase with its own step (K) above a reference, solved and ingested."""
    folder.mkdir()
    project = with_mass(folder, LEVER_GRID)
    deck = folder / "unit_loads.bdf"
    cold = f"{reference:>8}"

    def warmed(card: re.Match[str]) -> str:
        warm = plain(Decimal(reference) + Decimal(step(int(card[0][8:16]))))
        return card[0].replace("      1.", f"{warm:>8}")

    text = re.sub(r"(?m)^TEMP  .*$", warmed, deck.read_text(encoding="ascii"))
    text = re.sub(r"(?m)^(TEMPD.{11}).{8}$", lambda card: card[1] + cold, text)
    text = re.sub(r"(?m)^(MAT1.{52}).{8}$", lambda card: card[1] + cold, text)
    deck.write_text(text, encoding="ascii")
    solve_deck(deck, folder / "unit_loads.op2")
    model = folder / "model.toml"
    model.write_text(re.sub(r"(?m)^op2 = .*$", 'op2 = ["unit_loads.op2"]', model.read_text(encoding="utf-8")))
    ingest(project, None, silent)
    return project


def matrices(project: Project) -> dict[str, np.ndarray]:
    """Everything in distortion.h5 that is per kelvin."""
    build_distortion(project, None, silent)
    with open_checked(project.build_dir / "distortion.h5", DISTORTION) as file:
        assert 0.0 < file.number("/check/superposition_translation") < 2.0 * SINGLE
        assert 0.0 < file.number("/check/superposition_optics") < 2.0 * SINGLE
        names = ("D/translation", "D/rotation", "D_opt/translation", "D_opt/rotation", "check/max_translation",
                 "check/rigid_translation", "check/rigid_rotation")  # fmt: skip
        return {name: file.array(f"/{name}").astype(float) for name in names}


def steps_of(project: Project) -> tuple[list[float], float]:
    with open_checked(project.build_dir / "unit_loads.h5", UNIT_LOADS) as file:
        return file.array("/area/load_K").tolist(), file.number("/uniform/load_K")


@pytest.fixture(scope="module")
def of_one_kelvin(tmp_path_factory: pytest.TempPathFactory) -> tuple[Project, dict[str, np.ndarray]]:
    project = solved(tmp_path_factory.mktemp("one") / "deck", lambda _: "1.")
    return project, matrices(project)


def mixed(sid: int) -> str:
    """Steps of 0.5, 1, 2 and -1 K in turn, and of 3 K for all areas together."""
    return "3." if sid > AREAS else ("0.5", "1.", "2.", "-1.")[sid % 4]


@pytest.mark.parametrize(
    ("step", "reference"),
    [(lambda _: "2.", "0."), (lambda _: "0.5", "0."), (lambda _: "0.02", "293."), (mixed, "293.15")],
    ids=["2 K", "0.5 K", "0.02 K at 293 K", "different steps"],
)
def test_the_distortion_is_per_kelvin(
    of_one_kelvin: tuple[Project, dict[str, np.ndarray]], tmp_path: Path, step: Callable[[int], str], reference: str
) -> None:
    project = solved(tmp_path / "deck", step, reference)
    areas, uniform = steps_of(project)
    assert areas == [float(step(sid)) for sid in range(1, AREAS + 1)]  # to the last digit, as the cards say it
    assert uniform == float(step(AREAS + 1))
    found = matrices(project)
    for name, wanted in of_one_kelvin[1].items():
        for area in range(AREAS):
            error = np.abs(found[name][area] - wanted[area]).max()
            assert error < SINGLE * np.abs(wanted[area]).max(), (name, area)


def test_a_step_too_small_for_single_precision_is_noted(tmp_path: Path) -> None:
    """The worst subcase is named; steps of 1 K at 293.15 K need no word."""
    project = solved(tmp_path / "deck", lambda sid: "0.02" if sid == 5 else "1.", "293.15")
    (note,) = step_lines(ingest(project, None, silent).coarsest)
    warm, cold = struct.unpack("2f", struct.pack("2f", 293.17, 293.15))
    percent = 100.0 * abs((warm - cold) / 0.02 - 1.0)
    assert f"the step of 0.02 K of 'IS1_EH_UP' with an error of {percent:.2g} %" in note
    project = solved(tmp_path / "other", lambda sid: "1.", "293.15")
    assert step_lines(ingest(project, None, silent).coarsest) == []


def test_motions_in_the_exported_mesh_are_per_kelvin(
    of_one_kelvin: tuple[Project, dict[str, np.ndarray]], tmp_path: Path
) -> None:
    """Displacements and rotations of one area and of all together."""
    other = solved(tmp_path / "deck", mixed, "293.15")
    arrays = []
    for project in (of_one_kelvin[0], other):
        build_distortion(project, None, silent)
        build_sensitivity(project, None, silent)
        wanted = WantedArrays(("FLANGE_1", "uniform"), ("TM1_a_y",))
        arrays.append({a.name: a.values for a in export_mesh(project.build_dir, None, wanted, silent).on_points})
    moving = [name for name in arrays[0] if name.startswith(("displacement", "rotation", "contribution"))]
    assert {"displacement_FLANGE_1", "rotation_FLANGE_1", "rotation_uniform"} <= set(moving)
    for name in moving:
        one, two = (found[name] for found in arrays)
        assert np.abs(one - two).max() < 5e-6 * np.abs(one).max(), name


@pytest.mark.parametrize("step", ["2.", "0.5"])
def test_what_is_implausible_is_judged_per_kelvin_from_both_sides(
    of_one_kelvin: tuple[Project, dict[str, np.ndarray]], tmp_path: Path, step: str
) -> None:
    """A hundred times the free growth of the whole model is the most that a kelvin is believed to move a grid."""
    project = solved(tmp_path / "deck", lambda _: step)
    with open_checked(project.build_dir / "unit_loads.h5", UNIT_LOADS) as unit:
        expansion, position = unit.array("/element/expansion"), unit.array("/grid/position")
    growth = np.nanmax(expansion) * np.linalg.norm(position.max(axis=0) - position.min(axis=0))
    largest = of_one_kelvin[1]["check/max_translation"].max()
    op2 = tmp_path / "deck" / "unit_loads.op2"
    sound = op2.read_bytes()

    def build(times_growth: float) -> None:
        op2.write_bytes(sound)
        amplify(op2, times_growth * growth / largest)
        ingest(project, None, silent)
        build_distortion(project, None, silent)

    build(99.9)
    with pytest.raises(PhysicsError, match=rf"moves a grid by {100.1 * growth:.3g} m/K; free growth is {growth:.3g}"):
        build(100.1)


def amplify(op2: Path, factor: float) -> None:
    with open_op2(op2) as (tables, read):
        found = [(table.subcase, table.label, read(table)) for table in tables]
    write_op2(op2, found[0][2].grid_id, [(number, label, factor * got.motion) for number, label, got in found])
