"""Small meshes, rays and an oracle for the tests of the NumPy API."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float32]
Doubles = npt.NDArray[np.float64]
Ints = npt.NDArray[np.uint32]

MISS = 0xFFFFFFFF


def square(size: float = 1.0, z: float = 0.0) -> tuple[Floats, Ints]:
    """Two triangles over [-size, size]² at height z, facing +Z."""
    corners = [[-size, -size, z], [size, -size, z], [size, size, z], [-size, size, z]]
    return np.array(corners, np.float32), np.array([[0, 1, 2], [0, 2, 3]], np.uint32)


def soup(
    rng: np.random.Generator, count: int, size: float = 0.3, spread: float = 1.0
) -> tuple[Floats, Ints]:
    """`count` triangles that share no vertex, anywhere in a cube of half-edge `spread`."""
    centres = rng.uniform(-spread, spread, (count, 1, 3))
    vertices = (centres + rng.normal(0, size, (count, 3, 3))).reshape(-1, 3)
    return vertices.astype(np.float32), np.arange(3 * count, dtype=np.uint32).reshape(-1, 3)


def rays(rng: np.random.Generator, count: int) -> tuple[Doubles, Doubles]:
    """Origins and directions anywhere round the unit cube; directions are no unit vectors."""
    return rng.uniform(-2, 2, (count, 3)), rng.normal(0, 1, (count, 3))


def moved(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Doubles:
    """(4, 4) translation."""
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def affine(rng: np.random.Generator) -> Doubles:
    """(4, 4) shear, scale of either sign and translation, never near singular."""
    matrix = np.eye(4)
    matrix[:3, :3] = rng.normal(0, 0.2, (3, 3)) + np.diag(rng.choice([-1.0, 1.0], 3))
    matrix[:3, 3] = rng.uniform(-1, 1, 3)
    return matrix


@dataclass
class Oracle:
    """Brute force over world triangles in float64; `near_edge` marks rays it cannot decide."""

    t: Doubles
    triangle: npt.NDArray[np.int64]
    near_edge: npt.NDArray[np.bool_]


def brute_force(triangles: Doubles, origins: Doubles, directions: Doubles) -> Oracle:
    """Nearest triangle of (T, 3, 3) for each ray, from a linear system each; -1 and inf: a miss."""
    a, edges = triangles[:, 0], triangles[:, 1:] - triangles[:, :1]
    # Columns e1, e2, -d; unknowns u, v, t.
    columns = [np.broadcast_to(e, (len(origins), *e.shape)) for e in (edges[:, 0], edges[:, 1])]
    minus_d = np.broadcast_to(-directions[:, None], columns[0].shape)
    matrix = np.stack([*columns, minus_d], -1)
    right = (origins[:, None] - a[None])[..., None]
    u, v, t = np.moveaxis(np.linalg.solve(matrix, right)[..., 0], -1, 0)
    margin = np.minimum(np.minimum(u, v), 1 - u - v)
    t_hit = np.where((margin >= 0) & (t >= 0), t, np.inf)
    nearest = t_hit.argmin(1)
    best = t_hit.min(1)
    undecided = (np.abs(margin) < 1e-4) & (t > -1e-4) & (t <= best[:, None] + 1e-4)
    ties = (np.isfinite(t_hit) & (t_hit <= best[:, None] + 1e-5)).sum(1) > 1
    return Oracle(best, np.where(np.isfinite(best), nearest, -1), undecided.any(1) | ties)
