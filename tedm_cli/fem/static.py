"""Linear-static displacements: one factorisation, any number of temperature fields and other loads."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import islice

import numpy as np
import scipy.sparse as sp

from tedm_cli.arrays import FloatArray
from tedm_cli.errors import PhysicsError
from tedm_cli.fem.adjoint import TemperatureSensitivity, ThermalForces
from tedm_cli.fem.assembly import Operators, assemble
from tedm_cli.fem.bending import bending_change
from tedm_cli.fem.drilling import DrillingChange, drilling_change
from tedm_cli.fem.element_loads import ElementLoads, element_loads
from tedm_cli.fem.linear import MemoryNeed, SolverName, block_bytes
from tedm_cli.fem.mass import weight_per_acceleration
from tedm_cli.fem.other_elements import BatchLoads, RandomSums
from tedm_cli.fem.reduced import reduced_stiffness
from tedm_cli.fem.stability import factorise_supported, require_supported
from tedm_cli.fem.structure import LoadCase, Structure
from tedm_cli.fem.supports import Supports

Progress = Callable[[int, int, str], None]

# Right-hand sides solved together: enough for the solver's blocked substitution, few enough to bound the memory. Of
# 168,000 unknowns, blocks of 16, 32 and 80 took 1.7, 1.4 and 1.1 s for 80.
_BATCH = 32
_MAX_RESIDUAL = 1e-6


@dataclass(frozen=True, kw_only=True)
class StaticReport:
    """What a solution took and how good it is.

    Attributes
    ----------
    n_dof : unknowns after all constraints.
    solver : library that factorised the stiffness.
    needed_bytes : memory that it said it would need for its factors and the blocks of load cases; 0 without unknowns.
    assemble_seconds, factor_seconds, solve_seconds : wall time of elements and constraints, of the factorisation,
        and of all load cases.
    max_relative_residual : largest |K u - f| / |f| (2-norms) over the load cases.
    expansion_residual : |K x - f| / max |f| of free uniform expansion over all elements, largest entry; rounding only,
        unless the elements are wrong.
    smallest_scaled_eigenvalue : estimate for the stiffness scaled to a unit diagonal; the inverse of its
        condition number.
    unattached_grids : ids of grids without any stiffness (displacement written as zero).
    """

    n_dof: int
    solver: str
    needed_bytes: int
    assemble_seconds: float
    factor_seconds: float
    solve_seconds: float
    max_relative_residual: float
    expansion_residual: float
    smallest_scaled_eigenvalue: float
    unattached_grids: tuple[int, ...]


class StaticSolution:
    """A factorised structure.

    Parameters
    ----------
    structure : the structure.
    mass : sparse [6 N, 6 N] (see `tedm_cli.fem.mass`), which accelerations pull on; None where no load case has any.
    progress : called as (done, total, what), or None.
    told : called with the memory that the factors need, before they are computed, or None.
    solver : see `tedm_cli.fem.linear.factorise`.

    Raises
    ------
    InputError
        If the rigid elements contradict each other or the constraints.
    PhysicsError
        If the structure is not held, is a mechanism, or holds an impossible element.
    MemoryShortError
        If the factors need more memory than is left.
    """

    def __init__(
        self,
        structure: Structure,
        *,
        mass: sp.csr_matrix | None = None,
        progress: Progress | None = None,
        told: Callable[[MemoryNeed], None] | None = None,
        solver: SolverName = "auto",
    ) -> None:
        self._progress = progress or (lambda done, total, what: None)
        self._progress(0, 3, "assemble")
        start = time.perf_counter()
        self._structure = structure
        operators = assemble(structure)
        self._expansion_residual = _expansion_residual(structure, operators)

        self._progress(1, 3, "constrain")
        reduced = reduced_stiffness(structure, operators.stiffness)
        self._thermal, self._warming = operators.thermal, operators.warming
        self._element_loads: ElementLoads | None = None  # made for the first case that needs them
        del operators  # the unconstrained stiffness is as large as the constrained one
        require_supported(structure, reduced.matrix, reduced.active, reduced.constrained, reduced.measure)
        free, held = reduced.free, reduced.constrained
        rows = reduced.matrix[free]
        self._stiffness = rows[:, free]
        self._transform = reduced.transform[:, free]
        self._supports = Supports(held, rows[:, held], reduced.transform[:, held])
        self._weight = None if mass is None else weight_per_acceleration(mass)
        attached = np.unique(np.concatenate([reduced.active, reduced.dependent]) // 6)
        self._unattached = np.delete(structure.grid_id, attached)
        self._assemble_seconds = time.perf_counter() - start

        self._progress(2, 3, "factorise")
        start = time.perf_counter()
        self._needed_bytes = 0

        def need(memory: MemoryNeed) -> None:
            self._needed_bytes = memory.needed_bytes
            if told is not None:
                told(memory)

        block = block_bytes(len(free), structure.n_grids, _BATCH)
        self._factors, self._eigenvalue = factorise_supported(
            structure, self._stiffness, free, solver, beside_bytes=block, told=need
        )
        self._factor_seconds = time.perf_counter() - start
        self._solve_seconds = 0.0
        self._residual = 0.0
        self._sums = RandomSums.none(len(free), structure.n_grids)
        self._progress(3, 3, "factorise")

    def solve(self, load_cases: Iterable[LoadCase]) -> Iterator[tuple[int, FloatArray]]:
        """Displacements of each load case, in order, a few cases at a time.

        Yields
        ------
        The case's id and [N, 6]: translations in m and rotations in rad, in the frame of the positions. Motions that
        nothing resists (rotations of grids of solids) are zero.

        Raises
        ------
        PhysicsError
            If the relative residual of a case exceeds 1e-6, elements have temperatures that the structure lacks,
            motions are enforced that no constraint holds, or an acceleration pulls where no mass was given.
        """
        total = len(load_cases) if isinstance(load_cases, list | tuple) else 0
        cases, done = iter(load_cases), 0
        while batch := list(islice(cases, _BATCH)):
            motion = self._solve_batch(batch)
            for column, case in enumerate(batch):
                yield case.id, motion[:, column].reshape(self._structure.n_grids, 6)
            done += len(batch)
            self._progress(done, total or done, "solve")

    def _solve_batch(self, batch: list[LoadCase]) -> FloatArray:
        start = time.perf_counter()
        loads, moved = self._loads(batch)
        force = self._thermal.forces(loads.temperature, loads.amount)
        if loads.own is not None and self._element_loads is not None:
            force += self._element_loads.forces(loads.own)
        if loads.force is not None:
            force += loads.force
        load = self._transform.T @ force
        if moved is not None:
            load -= self._supports.stiffness @ moved
        unknown = self._unknowns(load, [f"load case {case.id} ({case.label})" for case in batch])
        self._sums.add(unknown, loads)
        motion = np.asarray(self._transform @ unknown)
        if loads.held is not None:
            motion += loads.held
        self._solve_seconds += time.perf_counter() - start
        return motion

    def _loads(self, batch: list[LoadCase]) -> tuple[BatchLoads, FloatArray | None]:
        """The loads of some cases, and the motions [S, m] of the supports, None where none moves."""
        still = np.zeros(self._structure.n_grids)
        moved = self._supports.motions(batch)
        loads = BatchLoads(
            temperature=np.stack([still if c.temperature is None else c.temperature for c in batch], axis=1),
            amount=np.array([float(c.temperature is not None) for c in batch]),
            own=self._own(batch),
            force=self._forces(batch),
            held=None if moved is None else np.asarray(self._supports.transform @ moved),
        )
        return loads, moved

    def _forces(self, batch: list[LoadCase]) -> FloatArray | None:
        """Forces and moments [6 N, m] of forces and accelerations."""
        if all(case.force is None and case.acceleration is None for case in batch):
            return None
        out = np.zeros((6 * self._structure.n_grids, len(batch)))
        for column, case in enumerate(batch):
            if case.force is not None:
                np.add.at(out[:, column], case.force.dof, case.force.value)
            if case.acceleration is not None:
                if self._weight is None:
                    fact = f"load case {case.id} ({case.label}): an acceleration pulls on mass, and there is none"
                    raise PhysicsError(fact, hint="give the materials densities")
                out[:, column] += self._weight @ case.acceleration
        return out

    def _unknowns(self, load: FloatArray, names: Sequence[str]) -> FloatArray:
        """Unknowns under forces [n, m] on them, which have the `names` [m]."""
        unknown = self._factors.solve(load)
        size = np.linalg.norm(load, axis=0)
        error = np.linalg.norm(self._stiffness @ unknown - load, axis=0)
        residual = np.divide(error, size, out=np.zeros_like(error), where=size != 0.0)
        worst = int(residual.argmax())
        if not residual[worst] <= _MAX_RESIDUAL:
            raise PhysicsError(
                f"{names[worst]}: relative residual {residual[worst]:.1e}",
                hint="the stiffness is too badly conditioned; look for elements much stiffer than their neighbours",
            )
        self._residual = max(self._residual, float(residual[worst]))
        return unknown

    def adjoint(self, outputs: FloatArray, names: Sequence[str]) -> TemperatureSensitivity:
        """What every temperature does to r outputs; see `tedm_cli.fem.adjoint`.

        Parameters
        ----------
        outputs : [6 N, r], the outputs as nodal forces and moments, by the degrees of freedom of all grids in the frame
            of the positions: an output is the product of its column with the displacements in m and rad.
        names : of the outputs, for messages.

        Raises
        ------
        PhysicsError
            If the relative residual of a solution exceeds 1e-6.
        """
        start = time.perf_counter()
        motions = np.empty((6 * self._structure.n_grids, len(names)))
        for first in range(0, len(names), _BATCH):
            some = slice(first, first + _BATCH)
            motions[:, some] = self._transform @ self._unknowns(self._transform.T @ outputs[:, some], names[some])
            self._progress(min(first + _BATCH, len(names)), len(names), "solve")
        found = ThermalForces.of(self._structure, self._thermal.coupling, self._warming).sensitivity(motions)
        self._solve_seconds += time.perf_counter() - start
        return found

    def _own(self, batch: list[LoadCase]) -> FloatArray | None:
        """Temperatures of elements [5 L, m] of the cases; None where none has any."""
        if all(case.elements is None for case in batch):
            return None
        if self._element_loads is None:
            self._element_loads = element_loads(self._structure)
        loads = self._element_loads
        still = np.zeros(self._structure.n_grids)
        return np.stack(
            [loads.own(still if c.temperature is None else c.temperature, c.elements) for c in batch], axis=1
        )

    def bending_change(self) -> float | None:
        """How much bubble functions would change the cases solved so far; see `tedm_cli.fem.bending`."""
        return bending_change(self._structure, self._transform, self._factors, self._sums)

    def drilling_change(self) -> DrillingChange | None:
        """How much a stiffer tie of the rotations about shells' normals would; see `tedm_cli.fem.drilling`."""
        return drilling_change(self._structure, self._transform, self._factors, self._sums)

    @property
    def report(self) -> StaticReport:
        """Figures of the factorisation and of the cases solved so far."""
        return StaticReport(
            n_dof=self._stiffness.shape[0],
            solver=self._factors.name,
            needed_bytes=self._needed_bytes,
            assemble_seconds=self._assemble_seconds,
            factor_seconds=self._factor_seconds,
            solve_seconds=self._solve_seconds,
            max_relative_residual=self._residual,
            expansion_residual=self._expansion_residual,
            smallest_scaled_eigenvalue=self._eigenvalue,
            unattached_grids=tuple(int(grid) for grid in self._unattached),
        )


def _expansion_residual(structure: Structure, operators: Operators) -> float:
    expansion = np.zeros((structure.n_grids, 6))
    expansion[:, :3] = structure.position - structure.position.mean(axis=0)
    force = operators.expansion_load
    error = np.abs(operators.stiffness @ expansion.reshape(-1) - force).max(initial=0.0)
    return float(error / (np.abs(force).max(initial=0.0) or 1.0))
