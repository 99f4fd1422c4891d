"""Parts of results, and what they make together, as lines of text and as JSON."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tedm_cli.cli.printing.gravity import sensitivity_dict, sensitivity_lines
from tedm_cli.cli.printing.model import distortion_dict, distortion_lines

if TYPE_CHECKING:
    from tedm_cli.stages.model.merge import MergeSummary
    from tedm_cli.stages.model.parts import PartSummary

_SHOWN = 8


def part_lines(done: PartSummary) -> list[str]:
    """Which areas are in the part."""
    names = ", ".join(done.areas[:_SHOWN]) + (" ..." if len(done.areas) > _SHOWN else "")
    uniform = " and the uniform load" if done.uniform else ""
    return [
        f"{done.path}: {len(done.areas)} of {done.of} areas{uniform}, of {done.results}",
        *([names] if names else []),
        "with all parts in one build folder, `tedm merge` puts them together",
    ]


def part_dict(done: PartSummary) -> dict[str, Any]:
    return {
        "file": done.path,
        "results": done.results,
        "areas": done.areas,
        "areas_of_the_model": done.of,
        "uniform_load": done.uniform,
    }


def merge_lines(done: MergeSummary) -> list[str]:
    """What the stages say that make these files, and what was left aside."""
    files = "one result file" if done.parts == 1 else f"{done.parts} result files"
    return [
        f"{done.unit_loads}: of {files}; displacements of grids are not kept",
        *distortion_lines(done.distortion),
        *sensitivity_lines(done.sensitivity),
        *(f"note: {path} is of no result file in model.op2, and was left aside" for path in done.unused),
    ]


def merge_dict(done: MergeSummary) -> dict[str, Any]:
    return {
        "parts": done.parts,
        "unit_loads": done.unit_loads,
        "distortion": distortion_dict(done.distortion),
        "sensitivity": sensitivity_dict(done.sensitivity),
        "left_aside": done.unused,
    }
