"""The thermal network, as lines of text and for programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tedm_cli.stages.thermal.build import ThermalSummary


def thermal_lines(done: ThermalSummary) -> list[str]:
    """What was made."""
    return [f"{done.path}"]


def thermal_dict(done: ThermalSummary) -> dict[str, Any]:
    """What a program needs."""
    return {"file": done.path}
