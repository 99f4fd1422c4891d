"""Matrices and systems that were written for other programs, as lines of text and for programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from tedm_cli.results.wording import count

if TYPE_CHECKING:
    from tedm_cli.stages.exports.closed_loop import ExportedLoop
    from tedm_cli.stages.exports.matrices import Exported
    from tedm_cli.stages.exports.state_space import ExportedSystem


def matrix_lines(done: Exported) -> list[str]:
    """The files, and the size and meaning of each matrix."""
    held = [f"{m.name} {m.values.shape[0]} x {m.values.shape[1]}: {m.description}" for m in done.matrices]
    return [*(str(path) for path in done.paths), *held]


def matrix_dict(done: Exported) -> dict[str, Any]:
    return {
        "files": done.paths,
        "matrices": [{"name": m.name, "shape": m.values.shape, "meaning": m.description} for m in done.matrices],
    }


def loop_lines(done: ExportedLoop) -> list[str]:
    """The files of the drag-free loop, and its size."""
    size = f"{done.states} states, {done.inputs} inputs, {done.outputs} outputs"
    return [*(str(path) for path in done.paths), f"drag-free loop: {size}"]


def loop_dict(done: ExportedLoop) -> dict[str, Any]:
    return {"files": done.paths, "states": done.states, "inputs": done.inputs, "outputs": done.outputs}


def system_lines(done: ExportedSystem) -> list[str]:
    """The files of a case, its size, and how near its spectra are to the exact ones."""
    return [
        *(str(path) for path in done.paths),
        f"case {done.case_id}: {count(done.states, 'state')}, {count(done.inputs, 'white noise')} of one-sided PSD"
        f" 1/Hz; amplitudes within {done.filter_deviation:.2g} of the configured ones, outputs within"
        f" {done.output_deviation:.2g} of {done.compared_with}",
    ]


def system_dict(done: ExportedSystem) -> dict[str, Any]:
    return {
        "case": done.case_id,
        "files": done.paths,
        "states": done.states,
        "inputs": done.inputs,
        "amplitude_deviation": done.filter_deviation,
        "output_deviation": done.output_deviation,
        "compared_with": done.compared_with,
    }
