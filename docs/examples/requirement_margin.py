"""How a verdict is reached: white noise of 2 pm/√Hz against the read-out requirement of LISA Pathfinder.

The requirement on one noise source of the interferometer (Montemurro 2004, eq. 10.12) is 1 pm/√Hz from 3 mHz on and
grows as 1/f² below, in a band from 1 to 30 mHz. White noise is furthest beyond it where the requirement is lowest. With
a safety factor of 2 its ratio is 2 x 2 pm / 1 pm = 4 and its margin a quarter, first reached at 3 mHz.
"""

import numpy as np

from tedm_cli.noise.requirement_presets import PRESETS
from tedm_cli.noise.requirements import frequency_grid, judge

requirement = PRESETS["lpf_readout_item"]
frequency_hz = frequency_grid(1e-4, 0.1, 301, [requirement.grid_hz])
noise = np.full(len(frequency_hz), 2e-12)  # m/√Hz

verdict = judge(noise, frequency_hz, requirement, 2.0, kind="displacement", output="A_TM1_x")

print(f"ratio {verdict.ratio:.3f} at {verdict.binding_hz * 1e3:g} mHz, margin {verdict.margin:.3f}, {verdict.passed=}")
assert abs(verdict.ratio - 4.0) < 1e-12
