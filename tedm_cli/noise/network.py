"""Temperature noise of a thermal network: the disturbances reach every column through a gain of its own.

With gains H(f) [k, u] from disturbances of amplitude spectral densities a(f) [u] and correlation R = L Lᵀ, and with
D = H diag(a), the temperatures have the cross-spectra C(f) = D R Dᴴ, and outputs y = g ΔT the PSD |g D L|². In the
correlation cases C is amplitudes times one correlation for all frequencies; here both follow from the network.
`NetworkOutputs` answers what `propagation.OutputNoise` answers.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from tedm_cli.arrays import AnyArray, BoolArray, ComplexArray, FloatArray, IndexArray
from tedm_cli.errors import InputError
from tedm_cli.noise.correlation import Correlation
from tedm_cli.noise.network_system import Network
from tedm_cli.noise.propagation import Sizes, trapezoid

_SAME_HZ = 1e-9  # frequencies this close, relatively, are one


def places_of(wanted_hz: FloatArray, have_hz: FloatArray) -> tuple[IndexArray, FloatArray]:
    """Where each of the wanted frequencies [n] is among those there are [F], and those that are not there."""
    place = np.abs(np.log(have_hz[:, None] / wanted_hz)).argmin(axis=0)
    return np.asarray(place), wanted_hz[np.abs(have_hz[place] / wanted_hz - 1.0) > _SAME_HZ]


@dataclass(frozen=True, eq=False)
class NetworkNoise:
    """The temperature noise of k columns: thermal nodes, and areas with a spectrum of their own.

    Parameters
    ----------
    driven : D [k, F, u], K/√Hz: gain times amplitude spectral density of each disturbance.
    frequency_hz : [F], increasing; there are no others.
    disturbances : [u], names. factor : L [u, m], of their correlation R = L Lᵀ.
    blocks : columns that some disturbances, or some that are correlated, drive together; different blocks are
        uncorrelated. column_block : [m], the block that each column of L drives.
    gradient : [k], columns in K/m. told : the model in words.
    network : that it is of; None where nothing solves it at other frequencies, or as a system.
    """

    driven: ComplexArray
    frequency_hz: FloatArray
    disturbances: tuple[str, ...]
    factor: FloatArray
    blocks: tuple[IndexArray, ...]
    column_block: IndexArray
    gradient: BoolArray
    told: str
    network: Network | None = None

    def at(self, frequency_hz: FloatArray) -> NetworkNoise:
        """The same noise at other frequencies [n], increasing: solved for where they are not known yet.

        Raises `InputError` as `places` does where nothing solves the network.
        """
        if self.network is None:
            return replace(self, driven=self.driven[:, self.places(frequency_hz)], frequency_hz=frequency_hz)
        place, missing = places_of(frequency_hz, self.frequency_hz)
        driven = self.driven[:, place]
        if missing.size:
            driven[:, np.isin(frequency_hz, missing)] = self.network.driven(missing)
        return replace(self, driven=driven, frequency_hz=frequency_hz)

    def outputs(self, rows: FloatArray, frequency_hz: FloatArray) -> NetworkOutputs:
        """The noise of outputs with `rows` [n_out, k] at some of the frequencies."""
        return NetworkOutputs(rows, self, frequency_hz)

    def places(self, frequency_hz: FloatArray) -> IndexArray:
        """Where each of the frequencies is among those of the network; `InputError` for one that is not."""
        place, missing = places_of(frequency_hz, self.frequency_hz)
        if missing.size:
            fact = f"the gains of the network are not known at {missing[0]:g} Hz"
            raise InputError(fact, where="thermal network")
        return place

    @cached_property
    def _amplitude(self) -> FloatArray:
        """Amplitude spectral density [k, F] of every column."""
        found = np.empty(self.driven.shape[:2])
        for i, of in enumerate(self.driven):
            by_source = of @ self.factor
            found[i] = np.sqrt(np.sum(by_source.real**2 + by_source.imag**2, axis=1))
        return found

    @property
    def active(self) -> BoolArray:
        """[k]: the columns that have noise."""
        return np.asarray(self._amplitude.any(axis=1))

    def amplitudes(self, frequency_hz: FloatArray) -> FloatArray:
        """Amplitude spectral density [k, F] of every column, K/√Hz."""
        return np.asarray(self._amplitude[:, self.places(frequency_hz)])

    def distinct(self, frequency_hz: FloatArray) -> tuple[IndexArray, FloatArray]:
        """The spectrum [k] that each column has, and these [k, F]: each has its own."""
        return np.arange(len(self.driven)), self.amplitudes(frequency_hz)

    def correlation_at(self, frequency_hz: float) -> Correlation:
        """Correlation of the columns at one frequency, its phases in the factor."""
        one = np.array([frequency_hz])
        drive = self.driven[:, self.places(one)[0]] @ self.factor
        amplitude = self.amplitudes(one)
        factor = np.divide(drive, amplitude, out=np.zeros_like(drive), where=amplitude > 0.0)
        return Correlation(self.blocks, factor, self.column_block, np.zeros(len(drive)))

    def words(self) -> str:
        """The model in words."""
        return self.told


@dataclass(frozen=True, eq=False)
class NetworkOutputs:
    """The noise that the temperatures of a network make of linear static outputs, at n of its frequencies.

    Parameters
    ----------
    rows : g [n_out, k], unit of the output per kelvin.
    """

    rows: FloatArray
    source: NetworkNoise
    frequency_hz: FloatArray

    def of(self, rows: FloatArray) -> NetworkOutputs:
        """Of other outputs, with `rows` [n, k]."""
        return NetworkOutputs(rows, self.source, self.frequency_hz)

    def at(self, frequency_hz: FloatArray) -> NetworkOutputs:
        """At other frequencies [n]."""
        return NetworkOutputs(self.rows, self.source, frequency_hz)

    @cached_property
    def _driven(self) -> ComplexArray:
        """D [k, n, u] at the frequencies."""
        place = self.source.places(self.frequency_hz)
        whole = len(place) == len(self.source.frequency_hz) and np.array_equal(place, np.arange(len(place)))
        return self.source.driven if whole else np.ascontiguousarray(self.source.driven[:, place])

    @cached_property
    def by_disturbance(self) -> ComplexArray:
        """g D [n_out, n, u]: what each disturbance makes of each output, unit of the output per √Hz, with its phase."""
        shape = self._driven.shape
        flat = self._driven.reshape(shape[0], -1)
        # Row by row: what comes of an output is the same to the last bit whichever others there are.
        return np.array([row @ flat for row in self.rows]).reshape(len(self.rows), *shape[1:])

    @cached_property
    def fields(self) -> ComplexArray:
        """g D L [n_out, n, m]."""
        return np.array([of @ self.source.factor for of in self.by_disturbance])

    def psd(self) -> FloatArray:
        """One-sided PSD [n_out, n], (unit of the output)²/Hz."""
        return _power(self.fields, 2)

    def cross_spectra(self) -> AnyArray:
        """One-sided cross-spectral densities of the outputs, [n, n_out, n_out], by their units; Hermitian."""
        y = self.fields.transpose(1, 0, 2)
        return np.asarray(y @ y.conj().transpose(0, 2, 1))

    def components(self) -> AnyArray:
        """What the outputs are made of [n_out, m, n]: their sums of products over m are the cross-spectra."""
        return np.asarray(self.fields.transpose(0, 2, 1))

    def terms(self) -> AnyArray:
        """What each column makes of the only output at the only frequency [k, m]; their sum over k is the output."""
        return np.asarray(self.rows[0][:, None] * (self._driven[:, 0] @ self.source.factor))

    def in_phase(self) -> FloatArray:
        """PSD [n_out, n] if all columns shared one fluctuation, each with its own amplitude."""
        total: FloatArray = self.rows @ self.source.amplitudes(self.frequency_hz)
        return np.square(total)

    def area_powers(self) -> FloatArray:
        """Part [n_out, k] of each column in the PSD at one frequency, or in the power over n of them."""
        return np.asarray(self.rows * self._with_columns())

    def share_weights(self) -> FloatArray:
        """At one frequency weights [n_out, k] as `contributions.share_weights`: r · w is the share of any term r [k].

        They are Re(ΔT y*)/S of the columns' temperatures ΔT; 0 where there is no noise.
        """
        found, power = self._with_columns(), self.psd()
        return np.divide(found, power, out=np.zeros_like(found), where=power > 0.0)

    def _with_columns(self) -> FloatArray:
        """Re(ΔT y*) [n_out, k] of the temperatures of the columns, at one frequency, or over n of them."""
        weight = trapezoid(self.frequency_hz)
        partner = (self.fields.conj() @ self.source.factor.T) * weight[:, None]
        flat = self._driven.reshape(len(self._driven), -1)
        return np.asarray(np.real(partner.reshape(len(self.rows), -1) @ flat.T))

    def path_powers(self) -> FloatArray:
        """Part [p] of each of the p outputs in their sum, at one frequency, or in the power over n of them."""
        whole = self.fields.sum(axis=0).conj() * trapezoid(self.frequency_hz)[:, None]
        return np.asarray(np.real(np.tensordot(self.fields, whole, axes=((1, 2), (0, 1)))))

    def disturbance_powers(self) -> FloatArray:
        """Part [n_out, u] of each disturbance in the PSD at one frequency, or in the power over n of them.

        Re(y_d y*), y_d = g D_d: its own power where it is uncorrelated; signed where it is correlated with others.
        """
        partner = (self.fields.conj() @ self.source.factor.T) * trapezoid(self.frequency_hz)[:, None]
        return np.asarray(np.real(self.by_disturbance * partner).sum(axis=1))

    def sizes(self) -> Sizes:
        """Sums and largest of the sizes of all contributions."""
        amplitude = self.source.amplitudes(self.frequency_hz)
        largest = np.array([(np.abs(row)[:, None] * amplitude).max(axis=0) for row in self.rows])
        return Sizes(
            total=np.abs(self.rows) @ amplitude,
            positive=np.maximum(self.rows, 0.0) @ amplitude,
            negative=np.minimum(self.rows, 0.0) @ amplitude,
            largest=largest.reshape(len(self.rows), -1),
        )

    def block_amplitudes(self) -> tuple[FloatArray, FloatArray]:
        """Sum and largest [n_out, n] of the amplitudes √S_b of the blocks."""
        blocks = range(len(self.source.blocks))
        of = np.array([np.sqrt(_power(self.fields[..., self.source.column_block == b], 2)) for b in blocks])
        return of.sum(axis=0), of.max(axis=0)

    def amplitude_contributions(self, frequency_hz: FloatArray) -> FloatArray:
        """Signed h_i = g_i A_i(f) [n_out, k], unit of the output per √Hz, each at its own `frequency_hz` [n_out]."""
        return np.asarray(self.rows * self.source.amplitudes(frequency_hz).T)


def _power(y: ComplexArray, axis: int) -> FloatArray:
    return np.asarray(np.sum(y.real**2 + y.imag**2, axis=axis))
