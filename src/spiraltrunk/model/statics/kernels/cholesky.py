"""Dense linear algebra of small matrices: copies, sums, Cholesky factor, triangular solves, elimination."""

from __future__ import annotations

import math

from spiraltrunk.model.statics.kernels import compiled


@compiled
def copy(vector, out):
    """``out`` = ``vector``, without a temporary copy."""
    for i in range(vector.shape[0]):
        out[i] = vector[i]


@compiled
def copy_rows(matrix, out):
    """``out`` = ``matrix``."""
    for i in range(matrix.shape[0]):
        for j in range(matrix.shape[1]):
            out[i, j] = matrix[i, j]


@compiled
def column_sum(matrix, column):
    """Sum of one column."""
    total = 0.0
    for i in range(matrix.shape[0]):
        total += matrix[i, column]
    return total


@compiled
def dot(a, b):
    """Sum of products."""
    total = 0.0
    for row in range(a.shape[0]):
        total += a[row] * b[row]
    return total


@compiled
def factorise(matrix, factor, weight, shift):
    """Upper factor U of the matrix U^T U = ``matrix`` + ``shift`` diag(``weight``); only lower triangles are read.

    Four rows at a time are subtracted from the next, so that the loop vectorises. Returns whether U exists.
    """
    size = matrix.shape[0]
    for k in range(size):
        row = factor[k]
        for j in range(k, size):
            row[j] = matrix[j, k]
        row[k] += shift * weight[k]
        m = 0
        while m + 3 < k:
            a, b, c, d = factor[m, k], factor[m + 1, k], factor[m + 2, k], factor[m + 3, k]
            for j in range(k, size):
                row[j] -= a * factor[m, j] + b * factor[m + 1, j] + c * factor[m + 2, j] + d * factor[m + 3, j]
            m += 4
        for above in range(m, k):
            a = factor[above, k]
            for j in range(k, size):
                row[j] -= a * factor[above, j]
        if not row[k] > 1e-13 * weight[k]:
            return False
        row[k] = math.sqrt(row[k])
        per = 1.0 / row[k]
        for j in range(k + 1, size):
            row[j] *= per
    return True


@compiled
def solve_factored(factor, right, out):
    """Solve U^T U ``out`` = ``right``."""
    size = factor.shape[0]
    for i in range(size):
        out[i] = right[i]
    for i in range(size):
        out[i] /= factor[i, i]
        value = out[i]
        for j in range(i + 1, size):
            out[j] -= value * factor[i, j]
    for i in range(size - 1, -1, -1):
        rest = out[i]
        for j in range(i + 1, size):
            rest -= factor[i, j] * out[j]
        out[i] = rest / factor[i, i]


@compiled
def solve_columns(factor, columns):
    """Solve for the columns of ``columns`` (size, m) in place, m a multiple of four; bitwise equal to `solve_factored`.

    Four columns are interleaved, since the running sum of one is bound by latency.
    """
    size = factor.shape[0]
    for k in range(0, columns.shape[1], 4):
        for i in range(size):
            per = factor[i, i]
            a, b, c, d = columns[i, k] / per, columns[i, k + 1] / per, columns[i, k + 2] / per, columns[i, k + 3] / per
            columns[i, k], columns[i, k + 1], columns[i, k + 2], columns[i, k + 3] = a, b, c, d
            for j in range(i + 1, size):
                share = factor[i, j]
                columns[j, k] -= a * share
                columns[j, k + 1] -= b * share
                columns[j, k + 2] -= c * share
                columns[j, k + 3] -= d * share
        for i in range(size - 1, -1, -1):
            a, b, c, d = columns[i, k], columns[i, k + 1], columns[i, k + 2], columns[i, k + 3]
            for j in range(i + 1, size):
                share = factor[i, j]
                a -= share * columns[j, k]
                b -= share * columns[j, k + 1]
                c -= share * columns[j, k + 2]
                d -= share * columns[j, k + 3]
            per = factor[i, i]
            columns[i, k], columns[i, k + 1], columns[i, k + 2], columns[i, k + 3] = a / per, b / per, c / per, d / per


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
