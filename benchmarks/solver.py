"""The embedded solver at the size of a flight model: assembly against factorisation, memory, and the fallback.

python -m benchmarks.solver [MUMPS|SuperLU]; a process for each, because the peak of memory is that of the process.
"""

from __future__ import annotations

import resource
import sys
import time

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


def main(solver: SolverName, cells: tuple[int, int, int]) -> None:
    structure = bench(cells)
    area = np.random.default_rng(1).integers(0, CASES, structure.n_grids)
    start, processor = time.perf_counter(), time.process_time()
    solution = StaticSolution(structure, solver=solver)
    loads = (LoadCase(id=k, label="", temperature=(area == k).astype(float)) for k in range(CASES))
    for _ in solution.solve(loads):
        pass
    total, processor, report = time.perf_counter() - start, time.process_time() - processor, solution.report
    print(
        f"{report.solver:8} {structure.n_grids:,} grids, {CASES} cases: assembly {report.assemble_seconds:.1f} s,"
        f" factorisation {report.factor_seconds:.1f} s, solution {report.solve_seconds:.1f} s, total {total:.1f} s"
        f" ({processor:.1f} s of processor time),"
        f" peak {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6:.2f} GB, residual"
        f" {report.max_relative_residual:.0e}, assembly / factorisation"
        f" {report.assemble_seconds / report.factor_seconds:.2f}"
    )


if __name__ == "__main__":
    if sys.argv[1:] == ["SuperLU"]:
        main("superlu", (52, 18, 10))
    else:
        main("auto", (100, 40, 15))
        main("auto", (52, 18, 10))
