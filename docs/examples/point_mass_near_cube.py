"""A cube pulls almost like a point.

A kilogram stands on the axis of a cubic test mass. Seen from far away the cube is a point mass, and the gradient of the
acceleration along the axis is 2 G m / r³. A cube has no quadrupole moment; what it has first is a hexadecapole, which
takes 7/32 (s/r)⁴ off that gradient, s the edge of the cube (by expanding 1/r in Legendre polynomials up to degree 4).

The test mass is that of LISA Pathfinder. The number is the 7/32.
"""

import numpy as np

from tedm_cli.gravity.constants import G_CODATA_2018
from tedm_cli.gravity.field import self_gravity
from tedm_cli.gravity.testmass import TestMass

SIDE_M, DISTANCE_M = 0.046, 0.5
test_mass = TestMass(name="TM1", position_m=np.zeros(3), side_m=np.full(3, SIDE_M), mass_kg=1.96)

field = self_gravity([[DISTANCE_M, 0.0, 0.0]], [1.0], test_mass)
of_a_point = 2.0 * G_CODATA_2018 / DISTANCE_M**3
coefficient = (1.0 - field.gamma_lin[0, 0] / of_a_point) * (DISTANCE_M / SIDE_M) ** 4

print(f"gradient {field.gamma_lin[0, 0]:.6e} 1/s^2, of a point {of_a_point:.6e} 1/s^2")
print(f"the cube lacks {coefficient:.5f} (s/r)^4 of it; 7/32 = {7 / 32:.5f}")
assert abs(coefficient / (7.0 / 32.0) - 1.0) < 0.01
