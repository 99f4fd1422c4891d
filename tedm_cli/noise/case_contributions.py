"""Where the noise of the outputs of one case comes from, at the frequency and in the band that decide."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import AnyArray, FloatArray
from tedm_cli.noise.bounds import BOUNDS, extremal
from tedm_cli.noise.contributions import area_shares, path_shares, sum_by
from tedm_cli.noise.outputs import Outputs
from tedm_cli.noise.requirements import REFERENCE_HZ, Requirement, Verdict, in_band
from tedm_cli.noise.sources import AnyNoise

Judged = Sequence[tuple[Requirement, int]]


@dataclass(frozen=True, eq=False)
class Contributions:
    """Where the noise of n_out outputs comes from. Shares of an output sum to 1, or are 0 where it has no noise.

    Parameters
    ----------
    frequency_hz : [n_out], the binding frequency of the worst verdict, 1 mHz for an output without one.
    amplitude : [n_out, k], signed amplitudes there, unit/√Hz, zero for silent areas.
    share : [n_out, k], each area's part of the PSD there.
    band_hz : [n_out, 2], band of the worst verdict, all frequencies for an output without one.
    band_share : [n_out, k], each area's part of the power in that band.
    path_names : [p]; path_share, path_band_share : by label of an output that is a sum over these paths, the same.
    extremal : for each of `BOUNDS`, V [n_out, k, 2] whose V_i · V_j is a correlation that reaches it at `frequency_hz`
        (for known blocks: between areas of different blocks); zero for silent areas.
    """

    frequency_hz: FloatArray
    amplitude: FloatArray
    share: FloatArray
    band_hz: FloatArray
    band_share: FloatArray
    path_names: tuple[str, ...]
    path_share: dict[str, FloatArray]
    path_band_share: dict[str, FloatArray]
    extremal: dict[str, FloatArray]

    def by(self, labels: AnyArray) -> tuple[AnyArray, FloatArray, FloatArray]:
        """Distinct labels [q] of areas with `labels` [k], and sums [n_out, q] of share and of band_share over them."""
        names, share = sum_by(self.share, labels)
        return names, share, sum_by(self.band_share, labels)[1]


def contributions(noise: AnyNoise, outputs: Outputs, judged: Judged, verdicts: Sequence[Verdict]) -> Contributions:
    """Contributions to the noise of `outputs`, each where its worst verdict binds and in that one's band.

    `judged`, `verdicts`: requirement and index of the output, and the verdict, of every one.
    """
    rows, frequency_hz = noise.rows, noise.frequency_hz
    at_hz = np.full(len(rows), REFERENCE_HZ)
    band_hz = np.tile(frequency_hz[[0, -1]], (len(rows), 1))
    inside = np.ones((len(rows), len(frequency_hz)), dtype=bool)
    worst = np.full(len(rows), -1.0)
    for (requirement, o), verdict in zip(judged, verdicts, strict=True):
        if verdict.ratio > worst[o]:
            worst[o], at_hz[o], band_hz[o] = verdict.ratio, verdict.binding_hz, requirement.band_hz
            inside[o] = in_band(requirement, frequency_hz)
    share, band_share = np.empty_like(rows), np.empty_like(rows)
    for o in range(len(rows)):
        one = noise.of(rows[o : o + 1])
        share[o] = area_shares(one.at(at_hz[o : o + 1]))[0]
        band_share[o] = area_shares(one.at(frequency_hz[inside[o]]))[0]
    amplitude = noise.amplitude_contributions(at_hz)
    place = {label: o for o, label in enumerate(outputs.labels) if label in outputs.parts_of_read_outs}
    paths = {label: noise.of(outputs.parts_of_read_outs[label].by_element) for label in place}
    return Contributions(
        frequency_hz=at_hz,
        amplitude=amplitude,
        share=share,
        band_hz=band_hz,
        band_share=band_share,
        path_names=next((parts.names for parts in outputs.parts_of_read_outs.values()), ()),
        path_share={label: path_shares(paths[label].at(at_hz[o : o + 1])) for label, o in place.items()},
        path_band_share={label: path_shares(paths[label].at(frequency_hz[inside[o]])) for label, o in place.items()},
        extremal={bound: extremal(noise, amplitude, at_hz, bound) for bound in BOUNDS},
    )
