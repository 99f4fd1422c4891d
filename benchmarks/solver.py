"""The embedded solver at the size of a flight model: time and memory of its parts, and the fallback.

python -m benchmarks.solver: 66,256 grids; with SuperLU as argument: 11,077. A process for each, for its peak is that
of the process.
"""

from __future__ import annotations

import json
import resource
import sys

import numpy as np

from tedm_cli.fem.elasticity import ISOTROPIC, isotropic_stiffness
from tedm_cli.fem.linear import SolverName
from tedm_cli.fem.static import StaticSolution
from tedm_cli.fem.structure import LoadCase, SolidBlock, SolidMaterials, Structure

CASES = 80


def bench(cells: tuple[int, int, int]) -> Structure:
    """A block of bubble hexahedra held at three corners."""
    axes = [np.linspace(0.0, 0.01 * n, n + 1) for n in cells]
    position = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 3)
    index = np.arange(len(position)).reshape([n + 1 for n in cells])
    lower = [index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]]
    corners = np.stack([part[..., :-1] for part in lower] + [part[..., 1:] for part in lower], -1).reshape(-1, 8)
    held = [(0, "123"), (int(index[-1, 0, 0]), "23"), (int(index[0, -1, 0]), "3")]
    pairs = np.array([(row, int(digit)) for row, digits in held for digit in digits])
    materials = SolidMaterials(
        stiffness=isotropic_stiffness(7.0e10, 0.33)[None],
        expansion=2.3e-5 * ISOTROPIC[None],
        reference_temperature=np.zeros(1),
    )
    block = SolidBlock(
        card="CHEXA",
        element_id=np.arange(1, len(corners) + 1),
        connectivity=corners,
        material=np.zeros(len(corners), dtype=np.int64),
        materials=materials,
        bubble=True,
    )
    return Structure(
        grid_id=np.arange(1, len(position) + 1),
        position=position,
        solids=(block,),
        spc_grid=pairs[:, 0],
        spc_component=pairs[:, 1],
    )


def measure(solver: SolverName, cells: tuple[int, int, int]) -> dict[str, float | str]:
    """Seconds of each part, and the peak of memory of this process."""
    structure = bench(cells)
    area = np.random.default_rng(1).integers(0, CASES, structure.n_grids)
    solution = StaticSolution(structure, solver=solver)
    loads = (LoadCase(id=k, label="", temperature=(area == k).astype(float)) for k in range(CASES))
    for _ in solution.solve(loads):
        pass
    report = solution.report
    return {
        "solver": report.solver,
        "grids": structure.n_grids,
        "assembly_s": report.assemble_seconds,
        "factorisation_s": report.factor_seconds,
        "solution_s": report.solve_seconds,
        "peak_GB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6,
        "residual": report.max_relative_residual,
    }


if __name__ == "__main__":
    is_fallback = sys.argv[1:] == ["SuperLU"]
    print(json.dumps(measure("superlu", (52, 18, 10)) if is_fallback else measure("auto", (100, 40, 15))))
