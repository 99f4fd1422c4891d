"""A thermal network with the temperatures that are given of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.thermal.network import ThermalNetwork
from tedm_cli.thermal.steady import SteadyState, steady_state


@dataclass(frozen=True, eq=False)
class GivenNetwork:
    """A network as it was read.

    Parameters
    ----------
    given_K, start_K : [n], temperatures that are kept, and those to begin from; NaN where there is none.
    place : [n, 3], m; NaN where it is not told. where : the file that messages name.
    """

    network: ThermalNetwork
    given_K: FloatArray
    start_K: FloatArray
    place: FloatArray
    where: str

    def as_start(self) -> GivenNetwork:
        """The same with the temperatures of free nodes to begin from only."""
        boundary = self.network.boundary
        kept = np.where(boundary, self.given_K, np.nan)
        return replace(self, given_K=kept, start_K=np.where(boundary, np.nan, self.given_K))

    def steady(self) -> SteadyState:
        """Its steady state; raises as `steady_state` does."""
        return steady_state(self.network, self.given_K, self.start_K, where=self.where)
