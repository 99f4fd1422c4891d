"""Uncorrelated areas add as the root of the sum of squares, correlated ones as they are.

Two thermal areas with the same temperature noise move an output by 3 and by 4 pm/K. If their temperatures fluctuate
independently the output is 5 pm per kelvin of noise, if they fluctuate as one it is 7 pm.
"""

import numpy as np

from tedm_cli.noise.propagation import output_psd
from tedm_cli.noise.temperature import TemperatureModel, WhiteSpectrum

LEVEL_K = 1e-4  # K/√Hz
rows = 1e-12 * np.array([[3.0, 4.0]])  # m/K
temperature = TemperatureModel.from_spectra([WhiteSpectrum(LEVEL_K)] * 2)
frequency_hz = np.array([1e-3])


def noise(coefficient: float) -> float:
    """Amplitude spectral density in m/√Hz for a correlation coefficient."""
    correlation = np.array([[1.0, coefficient], [coefficient, 1.0]])
    return float(np.sqrt(output_psd(rows, temperature, correlation, frequency_hz)[0, 0]))


print(f"uncorrelated {noise(0.0):.3e} m/sqrt(Hz), correlated {noise(1.0):.3e} m/sqrt(Hz)")
assert abs(noise(1.0) / noise(0.0) - 7.0 / 5.0) < 1e-12
