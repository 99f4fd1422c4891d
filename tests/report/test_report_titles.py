"""Plain titles of outputs, requirements and blocks."""

from __future__ import annotations

import numpy as np
import pytest

from tedm_cli.config.requirements import RequirementTable
from tedm_cli.dynamics.signals import OUTPUTS
from tedm_cli.noise.requirement_presets import PRESETS
from tedm_cli.results.cases.file import block_name
from tedm_cli.results.titles import at_rest_title, by_subsystem, output_title, requirement_title, subsystem_label
from tedm_cli.results.wording import clause, decimals, number_word


@pytest.mark.parametrize(
    ("labels", "title"),
    [
        ("A_TM2_x", "read-out of x, test mass 2, set A"),
        ("B_TM1_eta", "read-out of η, test mass 1, set B"),
        ("A_TM2_x, B_TM2_x", "read-out of x, test mass 2, sets A and B"),
        ("A_TM1_x, A_TM2_x, B_TM1_x, B_TM2_x", "read-out of x, test masses 1 and 2, sets A and B"),
        ("A_TM1_x, B_TM2_x", "read-out of x, test mass 1, set A and read-out of x, test mass 2, set B"),
        ("TM1_a_x", "acceleration of test mass 1 along x"),
        ("TM2_a_x, TM1_a_x", "acceleration of test masses 1 and 2 along x"),
        ("TM1_omegadot_z", "angular acceleration of test mass 1 about z"),
        ("TM1_a_x-TM2_a_x", "acceleration of test mass 1 along x minus that of test mass 2"),
        ("delta_g", "differential acceleration Δg (as LISA Pathfinder computes it)"),
        ("TM1_x", "position of test mass 1 along x in its housing"),
        ("SC_theta", "attitude θ of the spacecraft"),
        ("u_SC_Fx", "commanded force along x on the spacecraft"),
        ("meas_TM2_x", "measured x of test mass 2"),
        ("H1_a_x", "acceleration of the housing of test mass 1 along x"),
        ("GRS_a_x", "acceleration of test mass GRS along x"),
        ("A_GRS_1_x", "read-out of x, A_GRS_1"),  # which part is the set cannot be told
        ("something else", "something else"),
    ],
)
def test_titles_of_outputs(labels: str, title: str) -> None:
    assert output_title(labels) == title


def test_every_output_of_the_loop_has_a_title_of_its_own() -> None:
    titles = {output_title(name) for name in OUTPUTS}
    assert len(titles) == len(OUTPUTS)
    assert not titles & set(OUTPUTS)


def test_titles_of_the_field_at_rest() -> None:
    assert at_rest_title("gamma_xx", "TM1") == "gravity gradient xx on test mass 1"
    assert at_rest_title("omegadot_eta", "TM2") == "angular acceleration of test mass 2 about y"
    assert at_rest_title("a_z", "TM1", "TM2") == "acceleration of test masses 1 and 2 along z"
    assert at_rest_title("a_z", "TM2-TM1") == "acceleration of test mass 2 along z minus that of test mass 1"
    assert at_rest_title("gamma_xz", "TM2-TM1") == "gravity gradient xz on test mass 2 minus that on test mass 1"


def test_titles_of_subsystems_are_those_of_the_project() -> None:
    names = ("IS", "IS+LTP", "S/C", "antenna", "antenna+IS", "all")
    assert [by_subsystem(n) for n in names] == [
        "the inertial sensor", "inertial sensor and rest of the LTP together", "the rest of the satellite",
        "the antenna", "antenna and inertial sensor together", "everything in the model",
    ]  # fmt: skip
    assert [subsystem_label(n) for n in names] == [
        "IS: inertial sensor", "IS+LTP: both together", "S/C: rest of the satellite", "antenna",
        "antenna+IS: both together", "all: everything in the model",
    ]  # fmt: skip


def test_titles_of_requirements() -> None:
    """Presets have theirs, users give their own, and a name without a title stands for itself."""
    assert all(preset.title and preset.title != name for name, preset in PRESETS.items())
    assert len({preset.title for preset in PRESETS.values()}) == len(PRESETS)
    assert requirement_title("lpf_acceleration", {}) == "LISA Pathfinder, acceleration noise"
    assert requirement_title("budget", {}) == "budget"
    assert requirement_title("budget", {"budget": "Budget of 2031"}) == "Budget of 2031"
    table = RequirementTable(name="lpf_jitter", outputs=["TM1_x"], title="Our jitter")
    assert table.requirement().title == "Our jitter"


@pytest.mark.parametrize(
    ("members", "name"),
    [
        ([0, 1], "all 2 areas inside the shield"),
        ([0, 1, 2], "S1, S2, B1"),
        ([2, 3], "all 2 areas outside the shield"),
        ([4, 5], "all 2 areas of far"),
        ([4], "B3"),
    ],
)
def test_blocks_in_few_words(members: list[int], name: str) -> None:
    names = np.array(["S1", "S2", "B1", "B2", "B3", "B4"])
    attributes = [
        ("{} the shield", np.array(["inside", "inside", "outside", "outside", "between", "nowhere"])),
        ("of {}", np.array(["x", "y", "z", "z", "far", "far"])),
    ]
    assert block_name(names, attributes, np.isin(np.arange(6), members)) == name


def test_words() -> None:
    assert [number_word(n) for n in (0, 1, 12, 13)] == ["no", "one", "twelve", "13"]
    assert decimals([-1e-4, 2.5e-8, -8.4832e-3], 1e3, 3) == "(−0.100, 0, −8.483)"
    assert (clause("x, test mass 1"), clause("x")) == ("x, test mass 1,", "x")
