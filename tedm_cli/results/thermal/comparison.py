"""What a case file says of the thermal network beside the assumed cases, and of the levels of its disturbances."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.contracts import CASE, THERMAL
from tedm_cli.files.store import Reader, Writer, open_checked
from tedm_cli.noise.case_run import CaseResult
from tedm_cli.noise.network import places_of
from tedm_cli.noise.resemblance import Resemblance

_UNIT = {"temperature": "K", "power": "W"}


@dataclass(frozen=True, eq=False)
class Comparison:
    """Of one case of the thermal network.

    resemblance : None where no other case has noise in all of its nodes. disturbance : [u] names. unit : [u], before
    "per √Hz". frequency_hz : [F]. level : [u, F], amplitude spectral densities of the disturbances.
    """

    resemblance: Resemblance | None
    disturbance: tuple[str, ...]
    unit: tuple[str, ...]
    frequency_hz: FloatArray
    level: FloatArray

    @property
    def by_case(self) -> dict[str, float]:
        """How far each assumed case is from the network, the most alike first."""
        r = self.resemblance
        return {} if r is None else dict(zip(r.cases, r.deviation.tolist(), strict=True))

    def level_at(self, frequency_hz: float) -> FloatArray:
        """[u] at the nearest frequency."""
        return np.asarray(self.level[:, int(np.abs(self.frequency_hz - frequency_hz).argmin())])


def comparison(result: CaseResult, thermal: Path, found: Resemblance | None) -> Comparison:
    """With the levels from thermal.h5, and those of the areas that its map leaves out."""
    assert result.disturbances is not None
    names = result.disturbances.names
    with open_checked(thermal, THERMAL) as file:
        place, _ = places_of(result.frequency_hz, file.array(THERMAL.FREQUENCY))
        level = file.array(THERMAL.DISTURBANCE_ASD)[:, place]
        unit = [_UNIT[kind] for kind in file.strings(THERMAL.DISTURBANCE_KIND)]
    own = slice(len(result.areas) - (len(names) - len(level)), None)
    level = np.concatenate([level, result.temperature_asd[result.temperature_set[own]]])
    return Comparison(found, names, (*unit, *result.areas.unit[own]), result.frequency_hz, level)


def write_comparison(writer: Writer, of: Comparison) -> None:
    """Put it into a case file."""
    writer.write(CASE.DISTURBANCE_UNIT, list(of.unit))
    writer.write(CASE.DISTURBANCE_LEVEL, of.level, units="see /disturbance/unit")
    r = of.resemblance
    if r is None:
        return
    writer.write(CASE.RESEMBLANCE_CASE, list(r.cases))
    writer.write(CASE.RESEMBLANCE_DEVIATION, r.deviation)
    writer.write(CASE.RESEMBLANCE_GROUP, list(r.groups))
    writer.write(CASE.RESEMBLANCE_COHERENCE, r.coherence)
    writer.write(CASE.RESEMBLANCE_COMPUTED, r.computed)
    writer.write(CASE.RESEMBLANCE_ASSUMED, r.assumed)
    writer.write(CASE.RESEMBLANCE_ASD, r.asd)
    writer.write(CASE.RESEMBLANCE_ASSUMED_ASD, r.assumed_asd)


def read_comparison(file: Reader) -> Comparison | None:
    """Of an open case file; None where it has none."""
    if not file.has(CASE.DISTURBANCE_LEVEL):
        return None
    found = None
    if file.has(CASE.RESEMBLANCE_CASE):
        found = Resemblance(
            tuple(file.strings(CASE.RESEMBLANCE_CASE)),
            file.array(CASE.RESEMBLANCE_DEVIATION),
            tuple(file.strings(CASE.RESEMBLANCE_GROUP)),
            file.array(CASE.RESEMBLANCE_COHERENCE),
            file.array(CASE.RESEMBLANCE_COMPUTED),
            file.array(CASE.RESEMBLANCE_ASSUMED),
            file.array(CASE.RESEMBLANCE_ASD),
            file.array(CASE.RESEMBLANCE_ASSUMED_ASD),
        )
    names, unit = (tuple(file.strings(d)) for d in (CASE.DISTURBANCE_NAME, CASE.DISTURBANCE_UNIT))
    return Comparison(found, names, unit, file.array(CASE.FREQUENCY), file.array(CASE.DISTURBANCE_LEVEL))
