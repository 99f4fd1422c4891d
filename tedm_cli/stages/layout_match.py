"""Whether the optical layout fits the model: one symmetry plane, the same test masses, grids near their elements."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.optics.against_model import compare_test_masses
from tedm_cli.config.optics.layout import load_layout
from tedm_cli.config.project import Project
from tedm_cli.errors import ConfigError
from tedm_cli.optics.layout import Element, OpticalLayout
from tedm_cli.optics.levers import Levers, long_levers

_NAMED = 4  # elements named in a warning


@dataclass(frozen=True)
class Match:
    """Problems of the layout as (dotted path, fact), and how to mend them; what is odd; the test masses compared."""

    layout_file: Path
    problems: list[tuple[str, str]]
    hint: str
    remarks: list[str]
    compared: list[str]

    @property
    def notes(self) -> list[str]:
        """What is odd, with the file that it is in."""
        return [f"{self.layout_file}: {line}" for line in self.remarks]

    def require(self) -> None:
        """Raise one `ConfigError` with all problems, where there are any."""
        if self.problems:
            raise ConfigError(self.problems, where=str(self.layout_file), hint=self.hint)


def match_layout(
    layout: OpticalLayout,
    layout_file: Path,
    model: ModelConfig,
    model_file: Path,
    node_positions_m: FloatArray | None = None,
    model_size_m: float = math.inf,
) -> Match:
    """Compare the layout with the model's configuration and, where given, with the grids of its elements.

    Parameters
    ----------
    node_positions_m : grids of the bench elements in layout order, [n_bench, 3] m, basic frame.
    model_size_m : diagonal of the finite-element model.
    """
    found = compare_test_masses(layout, model.test_masses(), model_file.name)
    hints, remarks = [], list(found.notes)
    problems = list(found.problems)
    if problems:
        hints.append(
            f"correct {layout_file.name}, in the frame that its [frame] gives, or {model_file}, in the basic frame"
            + _in_metres([path for path, _ in problems])
        )
    if node_positions_m is not None:
        levers = long_levers(layout, node_positions_m, model_size_m)
        problems += [
            (f"element[{layout.index(e.name)}].ref_m", f"{e.name} is {r:.4g} m away from its grid {e.grid}")
            for e, r in levers.too_long
        ]
        if levers.too_long:
            hints.append(_hint(levers))
        remarks += _long(levers)
    return Match(layout_file, problems, "; ".join(hints), remarks, found.compared)


def match_grids(
    layout: OpticalLayout,
    layout_file: Path,
    model: ModelConfig,
    model_file: Path,
    grid_id: IntArray,
    position_m: FloatArray,
) -> Match:
    """The same against all grids of the model: their ids [N], ascending, and positions [N, 3] m, basic frame.

    Elements without a grid yet have none to be compared with.
    """
    at = np.array(layout.frame_origin_m) + np.array([e.ref_m for e in layout.bench]).reshape(-1, 3) @ layout.axes
    absent = []
    for number, e in enumerate(layout.bench):
        row = np.searchsorted(grid_id, e.grid) if e.grid is not None else len(grid_id)
        if row < len(grid_id) and grid_id[row] == e.grid:
            at[number] = position_m[row]
        elif e.grid is not None:
            away = np.linalg.norm(position_m - at[number], axis=1)
            near = int(away.argmin())
            fact = (
                f"the model has no grid {e.grid}, which is to carry {e.name}; the grid nearest to {e.name} is"
                f" {grid_id[near]}, {1e3 * away[near]:.4g} mm away"
            )
            absent.append((f"element[{layout.index(e.name)}].grid", fact))
    if len(absent) > _NAMED:  # of another model: no grid by itself is a slip
        lost = [e for e in layout.bench if e.grid is not None and e.grid not in grid_id]
        fact = f"the model lacks {len(lost)} of the {len(layout.bench)} grids that elements name: "
        absent = [("element", fact + ", ".join(f"{e.grid} of {e.name}" for e in lost[:_NAMED]) + _more(lost))]
    found = match_layout(layout, layout_file, model, model_file, at, float(np.linalg.norm(np.ptp(position_m, axis=0))))
    if not absent:
        return found
    hint = f"correct {layout_file.name}, or add the grids to the model, tied by RBE2 or RBE3"
    return replace(found, problems=[*absent, *found.problems], hint="; ".join(filter(None, [hint, found.hint])))


def require_layout_fits(project: Project, model: ModelConfig, grid_id: IntArray, position_m: FloatArray) -> None:
    """Refuse a model that the project's layout does not fit, before it is solved; a project without has none to fit.

    Elements may be without a grid yet: the solution does not depend on them.
    """
    if project.optics is not None:
        _, layout = load_layout(project.optics, needs_grids=False)
        match_grids(layout, project.optics, model, project.model, grid_id, position_m).require()


def _in_metres(paths: list[str]) -> str:
    """Where lengths differ, that they are in metres."""
    return "; both are in metres" if any(path.endswith("_m") for path in paths) else ""


def _hint(levers: Levers) -> str:
    return (
        f"the bench is {levers.size_m:.4g} m across; lengths must be in metres, and [frame] is in the basic frame;"
        f" lever_ok = true in an [[element]] says that its lever is meant{_common(levers)}"
    )


def _common(levers: Levers) -> str:
    if levers.common_m is None:
        return ""
    shown = ", ".join(f"{round(float(v), 6) + 0.0:.4g}" for v in levers.common_m)
    return f"; all are off by about ({shown}) m in the basic frame: is origin_m of [frame] right?"


def _long(levers: Levers) -> list[str]:
    if not levers.long:
        return []
    ranked = sorted(levers.long, key=lambda found: -found[1])
    shown = ", ".join(_named(e, r) for e, r in ranked[:_NAMED])
    return [
        f"more than {1e3 * levers.limit_m:.4g} mm away from the grid that carries it: {shown}{_more(ranked)}; the two"
        f" count as rigidly joined, and lever_ok = true in an [[element]] says that this is meant{_common(levers)}"
    ]


def _more(found: Sequence[object]) -> str:
    return f" and {len(found) - _NAMED} more" if len(found) > _NAMED else ""


def _named(e: Element, length: float) -> str:
    return f"{e.name} {1e3 * length:.4g} mm (grid {e.grid})"
