"""Temperatures that stand for a correlation case: what its noise looks like when an output moves."""

from __future__ import annotations

import numpy as np

from tedm_cli.arrays import FloatArray


def typical_pattern(row: FloatArray, amplitude: FloatArray, correlation: FloatArray, asd: float) -> FloatArray:
    """Temperatures [k] that go with one standard amplitude of an output, on average: E[ΔT | y = σ] = C g / σ.

    With C = A R A and σ² = g C g, the output of the pattern is σ again: no other choice among the moments of a case
    depends on the output alone. Where the case has delays, this is the part in phase with the output.

    Parameters
    ----------
    row : g [k], the output per kelvin. amplitude : A [k], K/√Hz, zero for silent areas.
    correlation : [k, k], real part of R at the frequency. asd : σ, the output's amplitude spectral density there.
    """
    if asd == 0.0:
        return np.zeros(len(row))
    pattern: FloatArray = amplitude * (correlation @ (amplitude * row)) / asd
    return pattern
