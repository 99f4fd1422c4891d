"""A test mass that moves by x changes the optical path by 2 x cos(4.5°).

The measurement beam of the shipped bench meets the test masses at 4.5° from their normal. A mirror that backs away by x
along its normal makes the reflected path longer by 2 x cos(angle); one that comes nearer makes it shorter. Here the
beams are traced through the whole layout twice, with the first test mass moved by 1 µm along x, forwards and backwards.
What the photodiode reads is the path of the measurement beam minus that of the reference beam.
"""

import numpy as np

from tedm_cli.config.optics.layout import load_layout
from tedm_cli.optics.law import law_matrix
from tedm_cli.optics.trace import nominal_poses, trace
from tedm_cli.samples.shipped import root

STEP_M = 1e-6
_, layout = load_layout(root() / "configs" / "optics.toml")

motion = np.zeros((len(layout.elements), 6))
motion[layout.index("TM1"), 0] = STEP_M
poses, law = nominal_poses(layout), law_matrix(layout)
ahead, behind = (law @ trace(layout, poses.moved(sign * motion)).ravel() for sign in (1.0, -1.0))
gain = ((ahead - behind) / (2.0 * STEP_M))[layout.laser_rows(("PD1A",))][0]
expected = -2.0 * np.cos(np.radians(4.5))

print(f"PD1A reads {gain:.7f} m per metre of TM1; -2 cos(4.5 deg) = {expected:.7f}")
assert abs(gain - expected) < 1e-7
