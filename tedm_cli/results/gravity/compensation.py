"""Compensation masses as sensitivity.h5 tells them: where each is, what it follows, and how it moves by that."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import SENSITIVITY
from tedm_cli.files.store import Reader

_NAMED = 8  # blocks named in a sentence
# Corners of a cuboid as VTK has them: round its bottom, then round its top.
_ROUND = np.array(
    [[x, y, z] for z, (x, y) in product((-0.5, 0.5), ((-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)))]
)


@dataclass(frozen=True, eq=False)
class Blocks:
    """b cuboid blocks, basic frame.

    Parameters
    ----------
    tie : what each follows, empty where it stays still. density : [b], kg/m³.
    centre, axes : [b, 3] m and [b, 3, 3], edges as rows. corner : [b, 8, 3] m, in the order of VTK's hexahedron.
    translation, rotation : [k, b, 3], m/K and rad/K of k areas; 0 of those that stay still.
    """

    name: list[str]
    tie: list[str]
    mass_kg: FloatArray
    density: FloatArray
    centre: FloatArray
    axes: FloatArray
    corner: FloatArray
    translation: FloatArray
    rotation: FloatArray

    def motion(self, weights: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Displacement and rotation [8 b, 3] of the corners, block by block, under `weights` [k] of the areas."""
        turn = np.einsum("k,kbc->bc", weights, self.rotation)
        move = np.einsum("k,kbc->bc", weights, self.translation)
        arm = self.corner - self.centre[:, None]
        moved = move[:, None] + np.cross(turn[:, None], arm)
        return moved.reshape(-1, 3), turn.repeat(8, axis=0)


def ties_text(name: Sequence[str], tie: Sequence[str]) -> str:
    """Which blocks follow the structure, and which stay still: `1 follows the structure (CM1: grid 4711) and ...`."""
    tied = [f"{n}: {to}" for n, to in zip(name, tie, strict=True) if to]
    still = [n for n, to in zip(name, tie, strict=True) if not to]
    said = []
    if tied:
        verb = "follow the structure" if len(tied) > 1 else "follows the structure"
        said.append(f"{len(tied)} {verb} ({_some(tied, '; ')}) and {'are' if len(tied) > 1 else 'is'} in S_SG")
    if still:
        said.append(f"{len(still)} {'stay' if len(still) > 1 else 'stays'} still ({_some(still, ', ')})")
    return "; ".join(said)


def _some(words: Sequence[str], between: str) -> str:
    more = len(words) - _NAMED
    return between.join(words[:_NAMED]) + (f" and {more} more" if more > 0 else "")


def read_blocks(file: Reader) -> Blocks:
    """The blocks in sensitivity.h5."""
    centre, size = file.array(SENSITIVITY.COMPENSATION_CENTRE), file.array(SENSITIVITY.COMPENSATION_SIZE)
    axes, mass = file.array(SENSITIVITY.COMPENSATION_AXES), file.array(SENSITIVITY.COMPENSATION_MASS)
    return Blocks(
        name=file.strings(SENSITIVITY.COMPENSATION_NAME),
        tie=file.strings(SENSITIVITY.COMPENSATION_TIE),
        mass_kg=mass,
        density=mass / size.prod(axis=1),
        centre=centre,
        axes=axes,
        corner=centre[:, None] + (_ROUND * size[:, None]) @ axes,
        translation=file.array(SENSITIVITY.COMPENSATION_TRANSLATION),
        rotation=file.array(SENSITIVITY.COMPENSATION_ROTATION),
    )
