"""Compares hits on an animated file with brute force, bit for bit.

    .venv/bin/python tests/check_hits.py FILE … [--rays 1000000] [--frames 10] [--policy refit]

Each file is opened, its first frames are stepped through with every tree kept up to date, and then
random rays through the boxes of its objects (half of them from inside the scene, half from around
it) must hit exactly what testing
every triangle gives: distance, instance, triangle and weights, on 1 and on 2 threads, in both
layouts and through the k-d tree. Exit code 1 names the first ray that does not.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

import regraft_blender
import regraft_blender.session as sessions

Rays = tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]
SETUPS = {
    "k-d tree": {"structure": "kdtree"},
    "two-level": {"layout": "two-level"},
    "flat": {"layout": "flat"},
}
FIELDS = ("t", "instance_id", "prim_id", "u", "v")


def object_corners() -> npt.NDArray[np.float64]:
    """(N, 8, 3) corners of the boxes of everything instanced, world frame."""
    corners = []
    for instance in bpy.context.evaluated_depsgraph_get().object_instances:
        box = np.array(instance.object.bound_box)
        matrix = np.array(instance.matrix_world)
        corners.append(box @ matrix[:3, :3].T + matrix[:3, 3])
    return np.array(corners)


def random_rays(bounds: npt.NDArray[np.float64], count: int, seed: int = 1) -> Rays:
    """Origins inside the box, or on a sphere round it; directions to random points of objects."""
    random = np.random.default_rng(seed)
    centre, size = bounds.mean(axis=0), bounds[1] - bounds[0]
    corners = object_corners()
    weights = random.dirichlet(np.full(8, 0.5), count)
    targets = np.einsum("ij,ijk->ik", weights, corners[random.integers(len(corners), size=count)])
    inside = bounds[0] + random.random((count, 3)) * size
    around = random.normal(size=(count, 3))
    around *= np.linalg.norm(size) / np.linalg.norm(around, axis=1, keepdims=True)
    origins = np.where((np.arange(count) % 2 == 0)[:, None], inside, centre + around)
    return origins, targets - origins


def animated_sessions(path: Path, frames: int, policy: str) -> dict[str, Any]:
    """Native scenes after `frames` frames of motion, by the name of their settings."""
    bpy.ops.wm.open_mainfile(filepath=str(path), use_scripts=False)
    scene = bpy.context.scene
    kept: dict[str, Any] = {}
    for threads in (1, 2):
        for setup in SETUPS:
            kept[f"{threads} threads, {setup}"] = sessions.Session(threads)
    first = scene.frame_start
    for frame in range(first, first + frames + 1):
        scene.frame_set(frame)
        depsgraph = bpy.context.evaluated_depsgraph_get()
        for name, session in kept.items():
            session.synchronise(depsgraph, options(policy), everything=True)
            session.scene.update(policy=policy, **SETUPS[name.split(", ")[1]])
    return kept


def options(policy: str) -> sessions.Options:
    return sessions.Options("direct", 1, policy, "auto", "two-level", 0, False)


def first_difference(found: Any, wanted: Any) -> str:
    """Which ray and field differ first, or an empty text."""
    for field in FIELDS:
        a, b = getattr(found, field), getattr(wanted, field)
        wrong = np.flatnonzero(a.view(np.uint32) != b.view(np.uint32))
        if wrong.size:
            return (
                f"{wrong.size} rays differ in {field}; "
                f"ray {wrong[0]}: {a[wrong[0]]}, not {b[wrong[0]]}"
            )
    return ""


def check(path: Path, arguments: argparse.Namespace) -> bool:
    """Whether all settings agree with brute force on this file; prints a line."""
    kept = animated_sessions(path, arguments.frames, arguments.policy)
    oracle = next(reversed(kept.values())).scene
    origins, directions = random_rays(oracle.bounds(), arguments.rays)
    began = time.perf_counter()
    wanted = oracle.closest_hit_brute_force(origins, directions)
    seconds = time.perf_counter() - began
    errors = []
    for name, session in kept.items():
        found = session.scene.closest_hit(origins, directions)
        occluded = session.scene.any_hit(origins, directions)
        error = first_difference(found, wanted)
        if not error and not np.array_equal(occluded, np.isfinite(wanted.t)):
            error = "any_hit and closest_hit disagree"
        if error:
            errors.append(f"  {name}: {error}")
    counts = oracle.counts()
    hit = int(np.isfinite(wanted.t).sum())
    print(
        f"{path.name}: {arguments.rays} rays, {hit} hits, {counts['triangles']} triangles in "
        f"{counts['instances']} instances, brute force {seconds:.1f} s: "
        f"{'equal' if not errors else 'DIFFERENT'}",
        *errors,
        sep="\n",
        flush=True,
    )
    return not errors


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("files", type=Path, nargs="+")
    parser.add_argument("--rays", type=int, default=1_000_000)
    parser.add_argument("--frames", type=int, default=10)
    parser.add_argument("--policy", default="auto")
    arguments = parser.parse_args()
    regraft_blender.register()
    equal = [check(path.resolve(), arguments) for path in arguments.files]
    return 0 if all(equal) else 1


if __name__ == "__main__":
    sys.exit(main())
