"""A layout whose elements have moved, as one of its own: to be judged as any other."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from tedm_cli.arrays import AnyArray, FloatArray
from tedm_cli.optics.layout import OpticalLayout, Vec3
from tedm_cli.optics.layout_checks import Finding, check_layout
from tedm_cli.optics.trace import nominal_poses


def moved_layout(layout: OpticalLayout, motion: FloatArray) -> OpticalLayout:
    """The layout after the finite motions [n_elements, 6] (m, rad) of its elements about their reference points."""
    poses = nominal_poses(layout).moved(motion)
    return replace(
        layout,
        elements=tuple(
            replace(
                element,
                ref_m=_vector(poses.ref[n]),
                normal=_vector(poses.normal[n]),
                local_y=None if element.local_y is None else _vector(poses.local_y[n]),
            )
            for n, element in enumerate(layout.elements)
        ),
    )


def findings_after(layout: OpticalLayout, motion: FloatArray, before: tuple[Finding, ...]) -> FloatArray:
    """Values of the checks `before`, in their order, after motions [n_elements, 6]; NaN where a beam is lost."""
    after = {key: f.value for key, f in _by_place(check_layout(moved_layout(layout, motion)))}
    values = [after.get(key) for key, _ in _by_place(before)]
    return np.array([np.nan if value is None else value for value in values])


def _by_place(findings: Iterable[Finding]) -> Iterator[tuple[tuple[str, ...], Finding]]:
    """Findings with what names them: a beam may meet the same face twice."""
    seen: Counter[tuple[str, ...]] = Counter()
    for finding in findings:
        key = (finding.check, finding.where, finding.element)
        yield (*key, str(seen[key])), finding
        seen[key] += 1


def _vector(values: AnyArray) -> Vec3:
    x, y, z = (float(v) for v in values)
    return x, y, z
