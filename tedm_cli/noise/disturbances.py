"""Which disturbances of a thermal network the noise of outputs comes from, and how stable each has to be."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tedm_cli.arrays import AnyArray, FloatArray, IndexArray
from tedm_cli.noise.case_contributions import Contributions, Judged
from tedm_cli.noise.improvement import scale_to_meet
from tedm_cli.noise.network import NetworkNoise, NetworkOutputs
from tedm_cli.noise.requirements import in_band


@dataclass(frozen=True, eq=False)
class DisturbanceContributions:
    """What u disturbances make of n_out outputs. Shares of an output sum to 1, or are 0 where it has no noise.

    Parameters
    ----------
    names : [u]: of the network, then areas with a spectrum of their own.
    share : [n_out, u], part of the PSD at the frequency of `Contributions`; negative where a disturbance that is
        correlated with others cancels them. band_share : of the power in the band.
    asd : [n_out, u, F], amplitude spectral density of the output by each disturbance alone, unit of the output/√Hz.
    weights : [n_out, k], at the frequency of `Contributions`, of the columns: `NetworkOutputs.share_weights`.
    level_factor : [verdicts, u], the factor on the level of each disturbance, the others unchanged, that just meets the
        requirement; infinite where the output does not feel it, NaN where this disturbance alone cannot do it.
    """

    names: tuple[str, ...]
    share: FloatArray
    band_share: FloatArray
    asd: FloatArray
    level_factor: FloatArray
    weights: FloatArray


def disturbance_contributions(
    noise: NetworkOutputs, found: Contributions, judged: Judged, safety_factor: float
) -> DisturbanceContributions:
    """Contributions of disturbances at the frequencies and in the bands of `found`."""
    f, names, factor = noise.frequency_hz, noise.source.disturbances, noise.source.factor
    share = np.zeros((len(noise.rows), len(names)))
    band_share = np.zeros_like(share)
    weights = np.zeros_like(noise.rows)
    for o in range(len(noise.rows)):
        one = noise.of(noise.rows[o : o + 1])
        weights[o] = one.at(found.frequency_hz[o : o + 1]).share_weights()[0]
        low, high = found.band_hz[o]
        inside = f[(f >= low * (1.0 - 1e-9)) & (f <= high * (1.0 + 1e-9))]
        for out, at in ((share, found.frequency_hz[o : o + 1]), (band_share, inside)):
            power = one.at(at).disturbance_powers()[0]
            out[o] = power / power.sum() if power.sum() > 0.0 else 0.0
    level = np.empty((len(judged), len(names)))
    for v, (requirement, o) in enumerate(judged):
        band = f[in_band(requirement, f)]
        limit = requirement.amplitude(band) / safety_factor
        driven = noise.of(noise.rows[o : o + 1]).at(band).by_disturbance[0]  # [n, u]
        for d in range(len(names)):
            own = driven[:, d] * factor[d][:, None]
            rest = np.delete(driven, d, axis=1) @ np.delete(factor, d, axis=0)
            level[v, d] = scale_to_meet(own, rest.T, limit)
    asd = np.abs(noise.by_disturbance).transpose(0, 2, 1)
    return DisturbanceContributions(names, share, band_share, asd, level, weights)


@dataclass(frozen=True, eq=False)
class OutputsByClass:
    """Noise of linear outputs whose rows differ by the class of the disturbance that makes the temperatures.

    Parameters
    ----------
    rows : [n, c k], for each of c classes in turn the output per kelvin of the k columns under its disturbances.
    class_of : [u], the class of each disturbance.
    """

    rows: FloatArray
    source: NetworkNoise
    class_of: IndexArray
    frequency_hz: FloatArray

    def of(self, rows: FloatArray) -> OutputsByClass:
        """Of other outputs, with `rows` [n, c k]."""
        return OutputsByClass(rows, self.source, self.class_of, self.frequency_hz)

    def at(self, frequency_hz: FloatArray) -> OutputsByClass:
        """At other frequencies [F]."""
        return OutputsByClass(self.rows, self.source, self.class_of, frequency_hz)

    def cross_spectra(self) -> AnyArray:
        """One-sided cross-spectral densities of the outputs, [F, n, n]; Hermitian."""
        f, n, u = len(self.frequency_hz), len(self.rows), len(self.class_of)
        driven = np.zeros((n, f, u), dtype=np.complex128)
        for c, rows in enumerate(np.split(self.rows, int(self.class_of.max()) + 1, axis=1)):
            some, mine = np.flatnonzero(rows.any(axis=1)), np.flatnonzero(self.class_of == c)
            made = self.source.outputs(rows[some], self.frequency_hz).by_disturbance
            driven[np.ix_(some, np.arange(f), mine)] = made[:, :, mine]
        y = (driven @ self.source.factor).transpose(1, 0, 2)
        return np.asarray(y @ y.conj().transpose(0, 2, 1))
