"""A free bar grows by alpha L per kelvin.

A row of CHEXA elements is held so that nothing hinders its expansion, and warmed by 1 K: a unit load. The motion of its
free end per kelvin, an entry of the distortion matrix [D], is the expansion coefficient times the length.
"""

import numpy as np

from tedm_cli.fem.elasticity import isotropic_stiffness
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase, SolidBlock, SolidMaterials, Structure

ALPHA, LENGTH_M, WIDTH_M, CELLS = 2.3e-5, 0.4, 0.02, 8  # aluminium

x = np.linspace(0.0, LENGTH_M, CELLS + 1)
section = WIDTH_M * np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
position = np.array([[along, *yz] for along in x for yz in section])
first = 4 * np.arange(CELLS)[:, None]
aluminium = SolidMaterials(
    stiffness=isotropic_stiffness(7.0e10, 0.33)[None],
    expansion=np.array([[ALPHA, ALPHA, ALPHA, 0.0, 0.0, 0.0]]),
    reference_temperature=np.array([20.0]),
)
hexahedra = SolidBlock(
    card="CHEXA",
    element_id=np.arange(1, CELLS + 1),
    connectivity=first + np.arange(8),
    material=np.zeros(CELLS, dtype=np.int64),
    materials=aluminium,
)
held = np.array([(0, 1), (0, 2), (0, 3), (1, 1), (1, 3), (3, 1)])  # (grid, component): six, so free of stress
bar = Structure(
    grid_id=np.arange(1, len(position) + 1),
    position=position,
    spc_grid=held[:, 0],
    spc_component=held[:, 1],
    solids=(hexahedra,),
)

unit_load = LoadCase(id=1, label="BAR", temperature=np.full(len(position), 21.0))
((_, motion),) = StaticSolution(bar).solve([unit_load])
per_kelvin = motion[-1, 0] / 1.0

print(f"[D] of the free end: {per_kelvin:.9e} m/K, alpha L = {ALPHA * LENGTH_M:.9e} m/K")
assert abs(per_kelvin / (ALPHA * LENGTH_M) - 1.0) < 1e-9
