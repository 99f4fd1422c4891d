"""Two test masses pull at each other, as published.

Montemurro 2004, section 6.2.3, prints the acceleration of one test mass of LISA Pathfinder by the other, 376 mm apart:
-9.1330e-10 m/s². Both are cubes: the field of the exact kernel is summed over Gauss points in the other cube.
"""

import numpy as np

from tedm_cli.gravity.body_source import field_of_other_test_mass
from tedm_cli.gravity.testmass import TestMass

G_1998 = 6.673e-11  # m³ kg⁻¹ s⁻², the value of the publication


def cube(name: str, x_m: float) -> TestMass:
    return TestMass(name=name, position_m=np.array([x_m, 0.0, 0.0]), side_m=np.full(3, 0.04605), mass_kg=1.935)


field, error = field_of_other_test_mass(cube("TM1", 0.188), cube("TM2", -0.188), G_1998)
acceleration = field.acceleration[0]

print(f"acceleration {acceleration:.5e} m/s^2, published -9.1330e-10; quadrature error {error:.0e}")
assert abs(acceleration - -9.1330e-10) < 0.5e-14  # half the last printed digit
