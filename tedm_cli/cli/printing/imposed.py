"""Acceleration noise of imposed motion, as lines of text and for programs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from tedm_cli.cli.printing.table import table
from tedm_cli.results.wording import percent

if TYPE_CHECKING:
    from tedm_cli.results.dynamics.imposed import ImposedMotion


def imposed_lines(path: Path, found: ImposedMotion) -> list[str]:
    """The noise of every test mass by all sources and by each, against the requirement."""
    low, high = (f * 1e3 for f in found.limit.band_hz)
    lines = [
        f"figure 6.2: acceleration along x of test masses with imposed positions, without a loop ({path})",
        f"positions: {found.motion[0]:.3g} m/sqrt(Hz) on each, independent, {low:g} to {high:g} mHz"
        f" ({found.motion_source})",
        f"requirement {found.limit.name}: {found.level:.3g} m/s^2/sqrt(Hz), with its shape"
        f" {found.limit.amplitude[0]:.3g} at {low:g} mHz ({found.limit.source})",
    ]
    rows = []
    for n in found.noises:
        rows.append(
            (
                n.model,
                n.test_mass,
                "all",
                f"{n.asd[0]:.4e}",
                percent(n.asd[0] / found.level, 1),
                f"{n.ratio:.3g}",
                f"{n.binding_hz * 1e3:.3g}",
                "",
            )
        )
        for source, alone in n.alone.items():
            rows.append(
                (
                    "",
                    "",
                    source,
                    f"{alone[0]:.4e}",
                    percent(alone[0] / found.level, 1),
                    "",
                    "",
                    percent(n.share[source], 1),
                )
            )
    head = (
        "stiffness of",
        "on",
        "source",
        "m/s^2/sqrt(Hz)",
        f"of {found.level:.3g}",
        "ratio",
        "at mHz",
        "part of the power",
    )
    return [
        *lines,
        *table(head, rows, right=(3, 4, 5, 6, 7)),
        "ratio: largest noise / requirement, no safety factor; sources feel one motion, so their parts have signs",
        "of the other test mass the thesis prints 2.5e-17: one test mass moving, 5e-9 x 5e-9; both move, sqrt(2) of it",
    ]


def imposed_dict(path: Path, found: ImposedMotion) -> dict[str, Any]:
    """What a program needs of it."""
    return {
        "file": str(path),
        "motion_m": float(found.motion[0]),
        "band_hz": list(found.limit.band_hz),
        "requirement": found.limit.name,
        "requirement_level": found.level,
        "noise": [
            {
                "model": n.model,
                "test_mass": n.test_mass,
                "asd": float(n.asd[0]),
                "ratio": n.ratio,
                "binding_hz": n.binding_hz,
                "alone": {source: float(a[0]) for source, a in n.alone.items()},
                "share": n.share,
            }
            for n in found.noises
        ],
    }
