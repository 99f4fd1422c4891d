"""A bimetal cantilever bends as Timoshenko found.

A Nastran deck of CHEXA elements with bubble functions: two metals, one upon the other, held at one end and warmed by
1 K. S. Timoshenko (J. Opt. Soc. Am. 11, 1925, eq. 4) gives the curvature κ of such a strip from beam theory; the tip of
a cantilever then moves by κ L² / 2. The deck is read and solved as `tedm solve` does it. The held section stays plane
but may grow, since beam theory knows of no clamp that hinders it.
"""

import tempfile
from pathlib import Path

import numpy as np

from tedm_cli.fem.static import StaticSolution
from tedm_cli.nastran.structure.deck import read_solver_deck

LENGTH_M, WIDTH_M, THICKNESS_M = 0.1, 0.002, 0.002
YOUNG_PA, ALPHA = (7.0e10, 1.1e11), (2.3e-5, 1.0e-5)  # of the lower and the upper metal
CELLS = (50, 1, 2)

CONTROL = """SOL 101
CEND
SPC = 1
DISPLACEMENT(PLOT) = ALL
SUBCASE 1
  LABEL = STRIP
  TEMPERATURE(LOAD) = 2
BEGIN BULK
"""


def deck() -> str:
    axes = [np.linspace(0.0, size, n + 1) for size, n in zip((LENGTH_M, WIDTH_M, THICKNESS_M), CELLS, strict=True)]
    grid = 1 + np.arange(np.prod([n + 1 for n in CELLS])).reshape([n + 1 for n in CELLS])
    cards = [
        f"GRID,{grid[i, j, k]},,{x:.7f},{y:.7f},{z:.7f}"
        for i, x in enumerate(axes[0])
        for j, y in enumerate(axes[1])
        for k, z in enumerate(axes[2])
    ]
    for number, (i, j, k) in enumerate(np.ndindex(CELLS), start=1):
        lower, upper = (
            [grid[i, j, h], grid[i + 1, j, h], grid[i + 1, j + 1, h], grid[i, j + 1, h]] for h in (k, k + 1)
        )
        nodes = ",".join(str(n) for n in [*lower, *upper[:2]])
        cards.append(f"CHEXA,{number},{k + 1},{nodes}\n,{upper[2]},{upper[3]}")
    for metal, (young, alpha) in enumerate(zip(YOUNG_PA, ALPHA, strict=True), start=1):
        cards += [f"PSOLID,{metal},{metal}", f"MAT1,{metal},{young:.3E},,0.3,2700.,{alpha:.3E},20."]
    cards += [f"SPC1,1,1,{g}" for g in grid[0].ravel()]
    cards += [f"SPC1,1,23,{grid[0, 0, 0]}", f"SPC1,1,3,{grid[0, 1, 0]}", "TEMPD,2,21.0", "PARAM,AUTOSPC,YES"]
    return CONTROL + "\n".join(cards) + "\nENDDATA\n"


with tempfile.TemporaryDirectory() as folder:
    path = Path(folder) / "strip.bdf"
    path.write_text(deck(), encoding="utf-8")
    structure, load_cases = read_solver_deck(path)
((_, motion),) = StaticSolution(structure).solve(load_cases)
tip = (structure.position[:, 0] > LENGTH_M - 1e-9) & (structure.position[:, 2] < 1e-9)  # lower edge, as it is held
deflection = motion[tip, 2].mean()

ratio = YOUNG_PA[0] / YOUNG_PA[1]
curvature = 24.0 * (ALPHA[0] - ALPHA[1]) / (THICKNESS_M * (12.0 + (1.0 + ratio) * (1.0 + 1.0 / ratio)))
theory = curvature * LENGTH_M**2 / 2.0

print(f"tip deflection {deflection * 1e6:.3f} um/K, Timoshenko {theory * 1e6:.3f} um/K")
assert abs(deflection / theory - 1.0) < 0.002
