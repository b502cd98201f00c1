"""Cholesky factor of a small matrix in place, and the triangular solves."""

from __future__ import annotations

import math

from spiraltrunk.model.kernels import compiled


@compiled
def factorise(matrix, factor, weight, shift):
    """Lower factor of ``matrix`` (its lower triangle is read) plus ``shift`` times the diagonal ``weight``.

    Returns whether it is positive definite.
    """
    for i in range(matrix.shape[0]):
        for j in range(i + 1):
            rest = matrix[i, j]
            if i == j:
                rest += shift * weight[i]
            for k in range(j):
                rest -= factor[i, k] * factor[j, k]
            if i > j:
                factor[i, j] = rest / factor[j, j]
            elif rest > 1e-13 * weight[i]:
                factor[i, i] = math.sqrt(rest)
            else:
                return False
    return True


@compiled
def solve_factored(factor, right, out):
    """Solve with the lower factor and its transpose."""
    size = factor.shape[0]
    for i in range(size):
        rest = right[i]
        for k in range(i):
            rest -= factor[i, k] * out[k]
        out[i] = rest / factor[i, i]
    for i in range(size - 1, -1, -1):
        out[i] /= factor[i, i]
        for k in range(i):
            out[k] -= factor[i, k] * out[i]


@compiled
def solve_small(matrix, right, count):
    """Solve the leading ``count`` equations, positive definite, by elimination; in place, into ``right``."""
    for j in range(count):
        for i in range(j + 1, count):
            share = matrix[i, j] / matrix[j, j]
            for k in range(j, count):
                matrix[i, k] -= share * matrix[j, k]
            right[i] -= share * right[j]
    for i in range(count - 1, -1, -1):
        for k in range(i + 1, count):
            right[i] -= matrix[i, k] * right[k]
        right[i] /= matrix[i, i]
