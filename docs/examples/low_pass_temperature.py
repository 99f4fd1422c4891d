"""1 mK/√Hz at 1 mHz is a fluctuation of 47 µK.

The temperature noise outside the thermal shield has the published level at 1 mHz. With the assumed low-pass of second
order and its corner at 1 mHz the variance is the integral of A(f)² over all frequencies: A₀² π f_c / √2, a root mean
square of 47.1 µK. The shaping filter that `tedm export-state-space` writes has a stationary state of that variance: it
follows from Lyapunov's equation, without any spectrum being integrated.
"""

import numpy as np

from tedm_cli.noise.shaping.shaping_filter import shaping_filter
from tedm_cli.noise.temperature import ShapedSpectrum

spectrum = ShapedSpectrum(level_K=1e-3, reference_hz=1e-3, corner_hz=1e-3, order=2.0)
filter_ = shaping_filter((spectrum,), band_hz=(1e-4, 0.1), tolerance=0.01)
rms_K = float(np.sqrt((filter_.c @ filter_.covariance() @ filter_.c.T)[0, 0]))
expected_K = 1e-3 * np.sqrt(np.pi * 1e-3 / np.sqrt(2.0))

print(f"level at 1 mHz {spectrum.amplitude(np.array([1e-3]))[0]:.3e} K/sqrt(Hz)")
print(f"root mean square {rms_K * 1e6:.4f} uK, integral of the spectrum {expected_K * 1e6:.4f} uK")
assert abs(rms_K / expected_K - 1.0) < 1e-9
