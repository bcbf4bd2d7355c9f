"""A small scene traced by the native library and again, ray by ray, in NumPy."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

import regraft
from regraft.cli.errors import SelfCheckError

Floats = npt.NDArray[np.float64]

TRIANGLES, RAYS, SEED = 300, 4000, 20070625
# Rays this close to an edge, in barycentric units, may go either way in another precision.
EDGE, DISTANCE = 1e-4, 1e-4


def run_self_check() -> str:
    """One line of what was checked. Raises SelfCheckError saying where the answers differ."""
    random = np.random.default_rng(SEED)
    vertices = random.normal(size=(3 * TRIANGLES, 3)).astype(np.float32)
    triangles = np.arange(3 * TRIANGLES, dtype=np.uint32).reshape(-1, 3)
    transforms = _transforms(random)
    origins, directions = _rays(random)
    scene = regraft.Scene(threads=0)
    mesh = scene.add_mesh(vertices, triangles)
    for matrix in transforms:
        scene.add_instance(mesh, matrix)
    scene.update()
    _compare(scene, _world_corners(vertices, transforms), origins, directions, "as built")
    moved = (vertices + 0.3 * random.normal(size=vertices.shape)).astype(np.float32)
    scene.set_vertices(mesh, moved)
    scene.update(policy="refit")
    _compare(scene, _world_corners(moved, transforms), origins, directions, "after a refit")
    return f"{2 * RAYS} rays on {2 * TRIANGLES} triangles agree with NumPy, built and refitted"


def _transforms(random: np.random.Generator) -> Floats:
    """(2,4,4): the identity, and a sheared, mirrored, moved copy."""
    matrices = np.stack([np.eye(4), np.eye(4)])
    matrices[1, :3, :3] = np.diag([-1.0, 0.5, 2.0]) + 0.2 * random.normal(size=(3, 3))
    matrices[1, :3, 3] = (2.0, 1.0, -1.0)
    return np.asarray(matrices)


def _rays(random: np.random.Generator) -> tuple[Floats, Floats]:
    origins: Floats = random.normal(size=(RAYS, 3)) * 6
    return origins, random.normal(size=(RAYS, 3)) * 2 - origins


def _world_corners(vertices: npt.NDArray[np.float32], transforms: Floats) -> Floats:
    """(2 * T, 3 corners, 3) float64, the instances one after the other."""
    local = vertices.astype(np.float64)
    world = [local @ m[:3, :3].T + m[:3, 3] for m in transforms]
    corners: Floats = np.concatenate(world).reshape(-1, 3, 3)
    return corners


def _compare(
    scene: regraft.Scene, corners: Floats, origins: Floats, directions: Floats, when: str
) -> None:
    hits = scene.closest_hit(origins, directions)
    t, certain = _brute_force(corners, origins, directions)
    same = np.isclose(hits.t, t, rtol=DISTANCE, atol=DISTANCE) | (np.isinf(hits.t) & np.isinf(t))
    wrong = np.flatnonzero(certain & ~same)
    if wrong.size:
        ray = int(wrong[0])
        raise SelfCheckError(
            f"{wrong.size} of {RAYS} rays differ from NumPy {when}; "
            f"ray {ray}: t = {hits.t[ray]}, NumPy says {t[ray]}"
        )


def _brute_force(
    corners: Floats, origins: Floats, directions: Floats
) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """Nearest t (N,) float64, inf for a miss, and whether no edge makes it doubtful (N,).

    Every ray against every triangle: Möller and Trumbore, "Fast, Minimum Storage Ray/Triangle
    Intersection", Journal of Graphics Tools 2(1), 1997.
    """
    a, edge1, edge2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    nearest, certain = np.full(len(origins), np.inf), np.ones(len(origins), bool)
    for start in range(0, len(origins), 256):
        part = slice(start, start + 256)
        direction = directions[part, None]
        p = np.cross(direction, edge2)
        scale = 1.0 / np.einsum("ntk,tk->nt", p, edge1)
        to_origin = origins[part, None] - a
        u = np.einsum("ntk,ntk->nt", to_origin, p) * scale
        q = np.cross(to_origin, edge1)
        v = np.einsum("nk,ntk->nt", directions[part], q) * scale
        t = np.einsum("tk,ntk->nt", edge2, q) * scale
        inside = np.minimum(np.minimum(u, v), 1 - u - v)
        nearest[part] = np.where((inside >= 0) & (t >= 0), t, np.inf).min(axis=1)
        doubtful = (np.abs(inside) < EDGE) & (t >= 0) & (t <= nearest[part, None])
        certain[part] = ~doubtful.any(axis=1)
    return nearest, certain
