"""Spectra on logarithmically spaced frequencies, by the optional library speckit."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import UsageError
from tedm_cli.noise.spectral_estimate import Estimate, Window

_LOWEST_BIN = 8  # below it the window's main lobe would reach the mean of each segment
_SIDE_LOBES_DB = 200


def require_speckit() -> None:
    """Raise `UsageError` where speckit is not installed."""
    try:
        import speckit  # noqa: F401
    except ImportError as exc:
        raise UsageError(
            'spectrum = "log" needs speckit, which is not installed',
            hint="install it with `pip install 'tedm[spectra]'`, or take spectrum = \"welch\"",
        ) from exc


def log_estimate(series: FloatArray, rate_hz: float) -> tuple[Estimate, Window]:
    """One-sided PSD [1, F] of a series [T] (Kaiser's window, side lobes at -200 dB, bins from 8 on), and the window."""
    import speckit
    from speckit.utils import kaiser_alpha

    found = speckit.compute_spectrum(series, rate_hz, win="kaiser", psll=_SIDE_LOBES_DB, bmin=_LOWEST_BIN, order=-1)
    window = Window(rate_hz / found.L, np.pi * kaiser_alpha(_SIDE_LOBES_DB))
    return Estimate(found.f, found.Gxx[None], found.nu), window
