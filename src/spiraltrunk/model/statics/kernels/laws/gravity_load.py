"""Potential of dead loads on the chain of sections, with gradient and Hessian by the joints' bends.

A field is a constant force direction f with a factor m_n per section and the distance at which it acts along the
section's axis: gravity on the masses, or a force at one section's end. Its energy is -f . sum m_n x_n. With omega_ia
the angular velocity per rate of bend a of joint i, and M_j the sum of m_n (x_n - o_j) over the sections beyond joint j,
the second derivative by a bend of joint i and one of a joint j beyond it is -(f x omega_ia) . (omega_jb x M_j).
"""

from __future__ import annotations

from spiraltrunk.model.statics.kernels import compiled
from spiraltrunk.model.statics.kernels.cholesky import copy_rows
from spiraltrunk.model.statics.kernels.laws.cable_gaps import product


@compiled
def chain(rotations, base, frames):
    """Frames of the sections (n_section, 3, 3) from the base's and the joints' rotations."""
    copy_rows(base, frames[0])
    for n in range(rotations.shape[0]):
        for i in range(3):
            x, y, z = frames[n, i, 0], frames[n, i, 1], frames[n, i, 2]
            for j in range(3):
                frames[n + 1, i, j] = x * rotations[n, 0, j] + y * rotations[n, 1, j] + z * rotations[n, 2, j]


@compiled
def weight_energy(frames, length, field):
    """Energy of all fields [J]; ``field`` is (directions (f, 3), factors (f, n_section), factors x distances)."""
    direction, factor, moment = field
    energy = 0.0
    for f in range(direction.shape[0]):
        beyond = 0.0
        for n in range(length.shape[0] - 1, -1, -1):
            along = 0.0
            for x in range(3):
                along += direction[f, x] * frames[n, x, 0]
            energy -= along * (moment[f, n] + beyond * length[n])
            beyond += factor[f, n]
    return energy


@compiled
def add_weight(work, length, field):
    """Add all fields to the gradient (n_joint, nd) and to the lower triangle of the Hessian."""
    for f in range(field[0].shape[0]):
        _add_field(work, length, field[0][f], field[1][f], field[2][f])
        _add_coupling(work)


@compiled
def _add_field(work, length, direction, factor, moment):
    """The joints' own terms; ``force_cross`` keeps f x omega, ``moment_cross`` omega x M, one row a bend."""
    nd = work.first.shape[1]
    total, near, far, beyond = work.vectors[0], work.vectors[1], work.vectors[2], 0.0
    total[:] = 0.0
    for i in range(work.rotation.shape[0] - 1, -1, -1):
        above, below = work.frames[i], work.frames[i + 1]
        for x in range(3):
            total[x] += (moment[i + 1] + beyond * length[i + 1]) * below[x, 0]
        beyond += factor[i + 1]
        for x in range(3):
            near[x] = above[0, x] * direction[0] + above[1, x] * direction[1] + above[2, x] * direction[2]
            far[x] = below[0, x] * total[0] + below[1, x] * total[1] + below[2, x] * total[2]
        for a in range(nd):
            row = i * nd + a
            work.gradient[i, a] -= product(near, work.first[i, a], far)
            for b in range(a + 1):
                work.hessian[row, i * nd + b] -= product(near, work.second[i, a, b], far)
            w0, w1, w2 = spin(work.first[i, a], work.rotation[i], above)
            work.force_cross[row, 0] = direction[1] * w2 - direction[2] * w1
            work.force_cross[row, 1] = direction[2] * w0 - direction[0] * w2
            work.force_cross[row, 2] = direction[0] * w1 - direction[1] * w0
            work.moment_cross[row, 0] = w1 * total[2] - w2 * total[1]
            work.moment_cross[row, 1] = w2 * total[0] - w0 * total[2]
            work.moment_cross[row, 2] = w0 * total[1] - w1 * total[0]


@compiled
def spin(first, rotation, above):
    """Angular velocity per rate of a bend in world axes: the vector of R' R^T, in the frame ``above`` the joint."""
    x, y, z = 0.0, 0.0, 0.0
    for j in range(3):
        x += first[2, j] * rotation[1, j]
        y += first[0, j] * rotation[2, j]
        z += first[1, j] * rotation[0, j]
    return (
        above[0, 0] * x + above[0, 1] * y + above[0, 2] * z,
        above[1, 0] * x + above[1, 1] * y + above[1, 2] * z,
        above[2, 0] * x + above[2, 1] * y + above[2, 2] * z,
    )


@compiled
def _add_coupling(work):
    nd = work.first.shape[1]
    for row in range(nd, work.hessian.shape[0]):
        x, y, z = work.moment_cross[row, 0], work.moment_cross[row, 1], work.moment_cross[row, 2]
        for column in range(row - row % nd):
            force = work.force_cross[column]
            work.hessian[row, column] -= force[0] * x + force[1] * y + force[2] * z
