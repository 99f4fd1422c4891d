"""Whether the optical layout fits the model: one symmetry plane, the same test masses, grids near their elements."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from tedm_cli.arrays import FloatArray
from tedm_cli.config.layout_against_model import compare_test_masses
from tedm_cli.config.model import ModelConfig
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
    more = f" and {len(ranked) - _NAMED} more" if len(ranked) > _NAMED else ""
    return [
        f"more than {1e3 * levers.limit_m:.4g} mm away from the grid that carries it: {shown}{more}; the two count as"
        f" rigidly joined, and lever_ok = true in an [[element]] says that this is meant{_common(levers)}"
    ]


def _named(e: Element, length: float) -> str:
    return f"{e.name} {1e3 * length:.4g} mm (grid {e.grid})"
