"""Force noise of test masses whose positions are imposed, as in figure 6.2 of Montemurro (2004): no loop, no control.

Along x, test mass i moves by x_i and the other one by x_j, independently: a_i = Σ over sources (own x_i + other x_j).
What moves with the spacecraft has a stiffness to the own motion alone; the other test mass has both, Γ_xx (x_i - x_j),
which makes √2 of what the thesis estimates in section 6.2.4 from the motion of one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.gravity.field import COMPENSATION, OTHER_TEST_MASS, SOURCES, STRUCTURE

MOTIONS = ("own", "other")
PUBLISHED = "Montemurro 2004"
#: Γ_xx on either test mass, 1/s²: sections 6.1.3 (the LTP), 6.2.3 and 6.3.1.
_PUBLISHED_S2 = {STRUCTURE: -0.8529e-7, OTHER_TEST_MASS: 4.8576e-9, COMPENSATION: 0.5888e-7}


@dataclass(frozen=True, eq=False)
class MovedTestMass:
    """Stiffness of one test mass along x.

    Parameters
    ----------
    model : whose numbers these are. name : of the test mass.
    sources : what pulls. stiffness : [sources, 2], 1/s², acceleration by the own motion and by that of the other
        test mass.
    """

    model: str
    name: str
    sources: tuple[str, ...]
    stiffness: FloatArray

    @property
    def gain(self) -> float:
        """Acceleration noise over the noise of either position, 1/s²: both move alike and independently."""
        return float(np.linalg.norm(self.stiffness.sum(axis=0)))

    @property
    def gain_alone(self) -> FloatArray:
        """[sources], 1/s²: the same of each source without the others."""
        out: FloatArray = np.linalg.norm(self.stiffness, axis=1)
        return out

    @property
    def share(self) -> FloatArray:
        """[sources], signed part of each source in the power: they feel one motion, may cancel, and sum to 1."""
        total = self.stiffness.sum(axis=0)
        power = float(total @ total)
        return self.stiffness @ total / power if power > 0.0 else np.zeros(len(self.sources))


def published() -> MovedTestMass:
    """Test mass 1 of LISA Pathfinder by the tables of Montemurro (2004); test mass 2 has the same."""
    stiffness = np.zeros((len(SOURCES), len(MOTIONS)))
    stiffness[:, 0] = [_PUBLISHED_S2[name] for name in SOURCES]
    stiffness[SOURCES.index(OTHER_TEST_MASS), 1] = -_PUBLISHED_S2[OTHER_TEST_MASS]
    return MovedTestMass(PUBLISHED, "TM1", SOURCES, stiffness)


def of_model(
    names: Sequence[str], sources: Sequence[str], gamma_xx: FloatArray, mutual: FloatArray
) -> list[MovedTestMass]:
    """The two test masses of a model.

    Parameters
    ----------
    gamma_xx : [2, sources], 1/s², by the own motion. mutual : [2], by the motion of the other test mass.
    """
    out = []
    for name, own, other in zip(names, gamma_xx, mutual, strict=True):
        stiffness = np.stack([own, np.where(np.array(sources) == OTHER_TEST_MASS, other, 0.0)], axis=1)
        out.append(MovedTestMass("this model", name, tuple(sources), stiffness))
    return out
