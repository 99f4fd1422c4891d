"""What the terminal says of the field at rest: the rows that matter, and a count of the others."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from tedm_cli.cli.printing.gravity import sensitivity_lines
from tedm_cli.gravity.requirements import DcVerdict
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.report.proof import at_rest_section
from tedm_cli.stages.gravity.sensitivity import SensitivitySummary


def summary(verdicts: list[DcVerdict], *subsystems: str) -> SensitivitySummary:
    """Two sources on one test mass; the second turns it by rounding alone."""
    return SensitivitySummary(
        path=Path("sensitivity.h5"),
        test_masses=[TestMass(position_m=np.zeros(3), side_m=np.full(3, 0.046), mass_kg=1.96, name="TM1")],
        sources=("structure", "other test mass"),
        acceleration=np.array([[[-2e-9, 5e-26, 3e-17], [9e-10, 0.0, -1e-18]]]),
        angular_acceleration=np.array([[[0.0, 1e-9, 0.0], [0.0, 0.0, -9.8e-30]]]),
        gamma_lin=np.array([np.diag([2e-7, -1e-7, -1e-7]), np.diag([2e-9, -1e-9, -1e-9])])[None],
        row_labels=[],
        row_units=[],
        largest=[],
        blocks=[],
        block_quadrature=[],
        verdicts=verdicts,
        mass_model="quadrature",
        points=[8],
        subsystems=list(subsystems),
    )


def verdict(ratio: float, subsystem: str = "IS") -> DcVerdict:
    return DcVerdict("TM1", "a_x", subsystem, -1e-9 * ratio, -1e-9, 1e-9)


def test_rounding_is_printed_as_zero() -> None:
    rows = [line.split("  ") for line in sensitivity_lines(summary([verdict(0.5)])) if line.startswith("TM1")]
    numbers = [[cell.strip() for cell in row if cell.strip()][-3:] for row in rows[:6]]
    assert numbers == [
        ["-2.0000e-09", "0", "3.0000e-17"],
        ["0", "1.0000e-09", "0"],
        ["2.0000e-07", "-1.0000e-07", "-1.0000e-07"],
        ["9.0000e-10", "0", "0"],
        ["0", "0", "0"],
        ["2.0000e-09", "-1.0000e-09", "-1.0000e-09"],
    ]


def test_small_ratios_are_counted_and_not_listed() -> None:
    lines = sensitivity_lines(summary([verdict(r) for r in (0.05, 0.5, 1e-15, 3.0)]))
    listed = [line.split()[-2:] for line in lines if line.startswith("TM1  a_x")]
    assert listed == [["0.5", "pass"], ["3", "FAIL"]]
    assert "field at rest: 3 of 4 within their limits; the rest is below 0.1 and in the file" in lines


def test_nothing_is_left_out_without_a_word() -> None:
    quiet = sensitivity_lines(summary([verdict(0.01)]))
    assert not any(line.startswith("DC") for line in quiet)
    assert "field at rest: 1 of 1 within their limits; the rest is below 0.1 and in the file" in quiet
    assert "field at rest: 0 of 1 within their limits" in sensitivity_lines(summary([verdict(2.0)]))


def test_what_is_not_judged_is_said() -> None:
    assert "field at rest: not judged" in sensitivity_lines(summary([]))[-1]
    lpf = [replace(verdict(0.5, name), requirement="lpf", whole=False) for name in ("IS", "LTP")]
    clause = "what lpf allocates to S/C (rest of the satellite), for the model has no subsystem of that name"
    assert f"not judged: {clause}" in sensitivity_lines(summary(lpf))
    assert f"Not judged: {clause}." in str(at_rest_section(lpf, []))
    every = [*lpf, replace(verdict(0.5, "IS+LTP+S/C"), requirement="lpf")]
    assert not any("not judged" in line for line in sensitivity_lines(summary(every)))
    assert "ot judged" not in str(at_rest_section(every, []))
    own = [replace(v, requirement="own") for v in lpf]
    assert not any("not judged" in line for line in sensitivity_lines(summary(own)))


def test_where_all_is_judged_together_parts_that_there_are_are_named() -> None:
    whole = [verdict(0.5, "all")]
    said = "only everything in the model together is judged; "
    assert f"{said}parts need [gravity.subsystems]" in sensitivity_lines(summary(whole))
    assert f"{said}no limit is on a part of it (IS, bench)" in sensitivity_lines(summary(whole, "IS", "bench"))


def test_a_difference_is_named() -> None:
    lines = sensitivity_lines(summary([replace(verdict(0.5), test_mass="TM2", minus="TM1")]))
    assert any(line.startswith("TM2-TM1  a_x") for line in lines)
    assert "TM2-TM1: the difference, each in its own frame" in lines
