"""A few letters for all that rays hit: equal for two scenes exactly when every bit is."""

from __future__ import annotations

import hashlib

import numpy as np

import regraft

# What tells hits apart: shadows, distances, triangles, objects.
PASSES = ("combined", "depth", "normal", "object_index")
# Rays that look where the camera does not.
RAYS = 1024


def of(scene: regraft.Scene, picture: regraft.Frame, seed: int) -> str:
    """Of a picture with `PASSES` and of random rays through the whole scene (equal seeds give
    equal rays)."""
    digest = hashlib.blake2b(digest_size=8)
    for name in PASSES:
        digest.update(picture.passes[name].tobytes())
    if picture.statistics.triangles:
        hits = scene.closest_hit(*_rays(scene, seed))
        for field in (hits.t, hits.instance_id, hits.prim_id, hits.u, hits.v):
            digest.update(field.tobytes())
    return digest.hexdigest()


def _rays(scene: regraft.Scene, seed: int) -> tuple[np.ndarray, np.ndarray]:  # type: ignore[type-arg]
    """Origins and directions, (RAYS, 3) float64: between random points of the scene's box."""
    lo, hi = scene.bounds()
    ends = lo + (hi - lo) * np.random.default_rng(seed).random((2, RAYS, 3))
    return ends[0], ends[1] - ends[0]
