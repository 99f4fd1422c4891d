"""How S changes when a test mass is not where it should be: by fields at either side of its place."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from tedm_cli.arrays import FloatArray
from tedm_cli.config.model.file import ModelConfig
from tedm_cli.config.uncertainty import AXES
from tedm_cli.contracts import DISTORTION
from tedm_cli.files.blocks import node_blocks
from tedm_cli.files.store import Reader
from tedm_cli.gravity.compensation import CompensationMass, field_of_compensation_masses
from tedm_cli.gravity.masses import MassDistribution
from tedm_cli.gravity.operator import contract
from tedm_cli.gravity.structure import stack_rows, structure_gravity
from tedm_cli.gravity.testmass import TestMass
from tedm_cli.gravity.ties import TiedOperator
from tedm_cli.progress import Step, counter
from tedm_cli.results.gravity.ties import Ties
from tedm_cli.stages.gravity.tied_blocks import tied_operators
from tedm_cli.threads import side_by_side

# m, to either side. On the full sample the change is within 3e-4 (of accelerations) and 1e-3 (of angular ones) of that
# by smaller steps. On the small one, whose few elements a quadrature of 1e-4 cuts anew at either side, within 5e-3.
_STEP = 5e-4


def position_sensitivity(
    config: ModelConfig,
    masses: MassDistribution,
    blocks: Sequence[CompensationMass],
    ties: Ties,
    distortion: Reader,
    step: Step,
) -> FloatArray:
    """∂S/∂x [6 t, 3, k] of each row by the position of its own test mass, along axes of the basic frame.

    S = -G D, and D does not know the test masses: the change is that of G. It is a central difference of G at positions
    1 mm apart, with compensation masses that are tied to grids. Test masses whose positions are not uncertain have 0.
    """
    areas = distortion.dataset(DISTORTION.D_TRANSLATION).shape[0]
    changes = (_contracted(rates, distortion) for _, _, rates in moved_operators(config, masses, blocks, ties, step))
    return position_columns(config, np.concatenate([np.zeros((0, areas)), *changes]))


def position_columns(config: ModelConfig, rows: FloatArray) -> FloatArray:
    """∂S/∂x [6 t, 3, k] from the rows [6 m, k] of the m moves of `moved_operators`."""
    count, areas = len(config.test_masses()), rows.shape[1]
    out = np.zeros((2, count, 3, 3, areas))
    for number, (t, axis) in enumerate(_moves(config)):
        out[:, t, :, axis] = rows[6 * number : 6 * number + 6].reshape(2, 3, areas)
    return out.reshape(6 * count, 3, areas)


def moved_operators(
    config: ModelConfig, masses: MassDistribution, blocks: Sequence[CompensationMass], ties: Ties, step: Step
) -> Iterator[tuple[int, int, list[FloatArray]]]:
    """(test mass, axis, changes [6, N, 3] and [6, L, 3] of its rows of G per metre) of every uncertain position."""
    test_masses, moves = config.test_masses(), _moves(config)
    elements = sum(len(block.id) for block in masses.elements)
    advance = counter(step, 2 * len(moves) * elements, "moving the test masses")
    g, tolerance = config.gravity.gravitational_constant_m3_kg_s2, config.gravity.quadrature_tolerance

    def operators(tm: TestMass, on: Callable[[int], None]) -> list[FloatArray]:
        """Rows of G [6, N, 3] by displacements, and [6, L, 3] by rotations."""
        found = structure_gravity(masses, tm, tolerance=tolerance, G=g, advance=on)
        rows = [stack_rows([part]) for part in (found.operator, found.rotation)]
        tied = _tied(config, tm, blocks, ties, masses)
        for row, at, more in zip(rows, (tied.row, tied.lever), (tied.operator, tied.rotation), strict=True):
            row[:, at] += stack_rows([more])
        return rows

    for t, axis in moves:
        ends = [_moved(test_masses[t], axis, shift) for shift in (-_STEP, _STEP)]
        low, high = side_by_side(operators, ends, advance)
        yield t, axis, [(after - before) / (2.0 * _STEP) for before, after in zip(low, high, strict=True)]


def _moves(config: ModelConfig) -> list[tuple[int, int]]:
    """(test mass, axis) of the positions that are uncertain."""
    named = [(table.test_mass, axis) for table in config.uncertainty.test_mass for axis in table.axes]
    masses = enumerate(config.test_masses())
    return [(t, i) for t, tm in masses for i, axis in enumerate(AXES) if (tm.name, axis) in named]


def _moved(tm: TestMass, axis: int, shift: float) -> TestMass:
    position = np.array(tm.position_m)
    position[axis] += shift
    return TestMass(name=tm.name, position_m=position, mass_kg=tm.mass_kg, body=tm.body, axes=tm.axes)


def _tied(
    config: ModelConfig, tm: TestMass, blocks: Sequence[CompensationMass], ties: Ties, masses: MassDistribution
) -> TiedOperator:
    """What tied compensation masses add to the operator of a test mass."""
    g, tolerance = config.gravity.gravitational_constant_m3_kg_s2, config.gravity.compensation_tolerance
    quadrature = field_of_compensation_masses(tm, blocks, g, tolerance=tolerance)[2] if blocks else []
    return tied_operators([tm], blocks, quadrature, ties, masses.position, masses.lever_node)[0]


def _contracted(operators: Sequence[FloatArray], distortion: Reader) -> FloatArray:
    """-G D [6, k] of operators [6, N, 3] and [6, L, 3]; [D] is read area by area, in parts."""
    areas = distortion.dataset(DISTORTION.D_TRANSLATION).shape[0]
    out = np.zeros((len(operators[0]), areas))
    for rows, path in zip(operators, (DISTORTION.D_TRANSLATION, DISTORTION.D_ROTATION), strict=True):
        d = distortion.dataset(path)
        for area in range(areas):
            for block in node_blocks(d.shape[1]):
                out[:, area : area + 1] += contract(rows[:, block], d[area, block][None])
    return out
