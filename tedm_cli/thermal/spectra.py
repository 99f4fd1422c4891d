"""Spectra of the nodes of a thermal network: S_T = H S_u Hᴴ, one-sided, and their coherence."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import ComplexArray, FloatArray


def node_factor(transfer: ComplexArray, asd: FloatArray, factor: FloatArray) -> ComplexArray:
    """G [F, n, rank] with S_T = G Gᴴ.

    transfer : H [F, n, u]. asd : [u, F], amplitude spectral densities of the disturbances, K/√Hz or W/√Hz. factor :
    [u, rank], of their correlation R = factor factorᵀ.
    """
    return np.asarray((transfer * asd.T[:, None, :]) @ factor)


def cross_spectra(factor: ComplexArray) -> ComplexArray:
    """S_T [F, n, n] in K²/Hz of `node_factor`; Hermitian to the bit."""
    found = factor @ np.conj(np.swapaxes(factor, 1, 2))
    n = found.shape[1]
    upper = np.triu_indices(n, 1)
    found[:, upper[1], upper[0]] = np.conj(found[:, upper[0], upper[1]])
    found[:, np.arange(n), np.arange(n)] = found[:, np.arange(n), np.arange(n)].real
    return np.asarray(found)


def coherence(psd: ComplexArray) -> ComplexArray:
    """S_ij / √(S_ii S_jj) [F, n, n], complex, of size 0 to 1; 0 with a node that is silent.

    Its square by size is what is called the coherence of two nodes; its phase says which is later.
    """
    power = np.einsum("fii->fi", psd).real
    size = np.sqrt(power[:, :, None] * power[:, None, :])
    return np.asarray(np.divide(psd, size, out=np.zeros_like(psd), where=size > 0.0))
