"""Gauss points of cells: measure, shape functions, position, and what they leave at the nodes, point by point."""

from __future__ import annotations

import math

import numpy as np

from tedm_cli.arrays import FloatArray, IntArray
from tedm_cli.gravity.compiled import compiled, inlined


@compiled
def put_measures(
    powers: IntArray, slopes: FloatArray, xi: FloatArray, element: IntArray, nodes: FloatArray, measure: FloatArray
) -> None:
    """Write the volume (signed), area or length per unit of ξ at the points of cells, as `fem.shapes.measure` has it.

    Parameters
    ----------
    powers : [k, d] of ξ in each monomial; slopes : [d, k, n], coefficients of the derivatives of the shape functions
        (`fem.shapes.polynomials`).
    xi : [c or 1, q, d], coordinates of the points in their elements.
    element : [c], rows of `nodes` [E, n, 3], m.
    measure : [c, q], receives it.
    """
    cells, count = measure.shape
    dimension, terms, corners = slopes.shape
    monomial = np.empty(terms)
    slope = np.empty((count, dimension, corners))
    column = np.empty((3, corners))
    jacobian = np.zeros((3, 3))
    for c in range(cells):
        if c < xi.shape[0]:
            for q in range(count):
                _put_monomials(powers, xi[c, q], monomial)
                for axis in range(dimension):
                    _contract(monomial, slopes[axis], slope[q, axis])
        for n in range(corners):
            for i in range(3):
                column[i, n] = nodes[element[c], n, i]
        for q in range(count):
            for axis in range(dimension):
                x = y = z = 0.0
                for n in range(corners):
                    value = slope[q, axis, n]
                    x += value * column[0, n]
                    y += value * column[1, n]
                    z += value * column[2, n]
                jacobian[axis, 0], jacobian[axis, 1], jacobian[axis, 2] = x, y, z
            x, y, z = jacobian[0, 0], jacobian[0, 1], jacobian[0, 2]
            if dimension > 1:
                u, v, w = jacobian[1, 0], jacobian[1, 1], jacobian[1, 2]
                x, y, z = y * w - z * v, z * u - x * w, x * v - y * u
            if dimension == 3:
                measure[c, q] = x * jacobian[2, 0] + y * jacobian[2, 1] + z * jacobian[2, 2]
            else:
                measure[c, q] = math.sqrt(x * x + y * y + z * z)


@compiled
def put_points(
    powers: IntArray,
    functions: FloatArray,
    xi: FloatArray,
    element: IntArray,
    nodes: FloatArray,
    values: FloatArray,
    position: FloatArray,
) -> None:
    """Write the shape functions [c or 1, q, n] and positions [c, q, 3] of the points of cells.

    functions : [k, n], coefficients of the shape functions; the others as of `put_measures`.
    """
    cells, count = position.shape[:2]
    terms, corners = functions.shape
    monomial = np.empty(terms)
    for c in range(cells):
        row = min(c, xi.shape[0] - 1)
        for q in range(count):
            if c == row:
                _put_monomials(powers, xi[c, q], monomial)
                _contract(monomial, functions, values[c, q])
            x = y = z = 0.0
            for n in range(corners):
                value = values[row, q, n]
                x += value * nodes[element[c], n, 0]
                y += value * nodes[element[c], n, 1]
                z += value * nodes[element[c], n, 2]
            position[c, q, 0], position[c, q, 1], position[c, q, 2] = x, y, z


@compiled
def put_coefficients(
    gamma_lin: FloatArray,
    omega_lin: FloatArray,
    force: FloatArray,
    torque: FloatArray,
    axes: FloatArray,
    mass: FloatArray,
    values: FloatArray,
    out: FloatArray,
) -> None:
    """Write ``Σ_q m_q N_n(x_q) [Γ_lin A, Ω_lin A, F, T](x_q)`` of cells, [c, n, 24].

    Parameters
    ----------
    gamma_lin, omega_lin, force, torque : [c q, 3, 3], [c q, 3], the field at the points of the cells, one cell after
        the other; axes : [3, 3], A.
    mass : [c, q]; values : [c or 1, q, n], shape functions.
    """
    row = np.empty(24)
    cells, count = mass.shape
    for c in range(cells):
        shared = min(c, values.shape[0] - 1)
        for n in range(out.shape[1]):
            for k in range(24):
                out[c, n, k] = 0.0
        for q in range(count):
            point = c * count + q
            m = mass[c, q]
            for i in range(3):
                for j in range(3):
                    row[3 * i + j] = m * (
                        gamma_lin[point, i, 0] * axes[0, j]
                        + gamma_lin[point, i, 1] * axes[1, j]
                        + gamma_lin[point, i, 2] * axes[2, j]
                    )
                    row[9 + 3 * i + j] = m * (
                        omega_lin[point, i, 0] * axes[0, j]
                        + omega_lin[point, i, 1] * axes[1, j]
                        + omega_lin[point, i, 2] * axes[2, j]
                    )
                row[18 + i], row[21 + i] = m * force[point, i], m * torque[point, i]
            for n in range(out.shape[1]):
                value = values[shared, q, n]
                for k in range(24):
                    out[c, n, k] += value * row[k]


@compiled
def add_rows(target: FloatArray, index: IntArray, values: FloatArray) -> None:
    """``target[index] += values``, in turn, of rows that repeat; [N, k], [m], [m, k]."""
    for i in range(index.size):
        n = index[i]
        for k in range(values.shape[1]):
            target[n, k] += values[i, k]


@inlined
def _put_monomials(powers: IntArray, xi: FloatArray, monomial: FloatArray) -> None:
    for k in range(monomial.size):
        product = 1.0
        for axis in range(xi.size):
            x = xi[axis]
            power = powers[k, axis]
            product *= x * x if power == 2 else (x if power == 1 else 1.0)
        monomial[k] = product


@inlined
def _contract(monomial: FloatArray, coefficients: FloatArray, out: FloatArray) -> None:
    """``out[n] = Σ_k monomial[k] coefficients[k, n]``."""
    for n in range(out.size):
        out[n] = coefficients[0, n]
    for k in range(1, monomial.size):
        factor = monomial[k]
        for n in range(out.size):
            out[n] += factor * coefficients[k, n]
