"""A made shot: a large still landscape of which a small part moves, in one flat mesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from regraft import Camera
from regraft.camera import frame_points
from regraft.study.shot import Shot, ShotWriter

Points = npt.NDArray[np.float32]


def make(folder: Path, triangles: int, moving: int, frames: int) -> Shot:
    """`triangles` of hills over the unit square, `moving` of which tumble about in chunks of 200,
    as a shot in `folder`, which exists."""
    ground, ground_faces = hills(triangles - moving)
    debris, debris_faces = _chunks(moving)
    faces = np.concatenate([ground_faces, debris_faces + np.uint32(len(ground))])
    with ShotWriter(folder) as writer:
        writer.add_call("add_mesh", (np.concatenate([ground, debris.reshape(-1, 3)]), faces), {})
        writer.add_call("add_instance", (0, np.eye(4)), {})
        for frame in range(frames):
            if frame:
                moved = _tumble(debris, frame).reshape(-1, 3)
                writer.add_call("set_vertices", (0, np.concatenate([ground, moved])), {})
            writer.end_frame(frame + 1, view())
    return Shot(folder)


def view() -> Camera:
    """Of the middle of the square."""
    middle = (0.2, 0.8)
    corners = np.array([[x, y, z] for x in middle for y in middle for z in (0.0, 0.2)])
    return frame_points(corners, 1.0)


def hills(triangles: int) -> tuple[Points, npt.NDArray[np.uint32]]:
    """About as many triangles over the unit square: vertices (V, 3), triangles (T, 3)."""
    side = max(1, round((triangles / 2) ** 0.5))
    axis = np.linspace(0.0, 1.0, side + 1)
    x, y = np.meshgrid(axis, axis, indexing="xy")
    z = 0.05 * np.sin(9 * x) * np.cos(7 * y) + 0.01 * np.sin(61 * x + 3 * y) * np.cos(53 * y)
    corner = (np.arange(side)[:, None] * (side + 1) + np.arange(side)).ravel()
    right, above = corner + 1, corner + side + 1
    low, high = np.stack([corner, right, above], 1), np.stack([right, above + 1, above], 1)
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    return points.astype(np.float32), np.concatenate([low, high]).astype(np.uint32)


def _chunks(triangles: int) -> tuple[Points, npt.NDArray[np.uint32]]:
    """(C,K,3) points of C chunks that begin side by side, and their triangles."""
    of_each = min(200, triangles)
    count = triangles // of_each
    random = np.random.default_rng(7)
    shape = random.normal(size=(of_each, 3, 3)) * 0.1 + random.normal(size=(of_each, 1, 3))
    places = np.stack(
        [0.4 + 0.2 * random.random(count), 0.4 + 0.2 * random.random(count), np.full(count, 0.1)], 1
    )
    points = places[:, None, :] + 0.004 * shape.reshape(-1, 3)[None, :, :]
    return points.astype(np.float32), np.arange(count * of_each * 3, dtype=np.uint32).reshape(-1, 3)


def _tumble(debris: Points, frame: int) -> Points:
    """Each chunk on a path of its own about the middle of the square."""
    index = np.arange(len(debris))
    angle, radius = 0.12 * frame + 2.4 * index, 0.02 + 0.2 * (index * 0.618 % 1.0)
    grown = min(1.0, frame / 10)
    target = np.stack(
        [
            0.5 + radius * np.cos(angle),
            0.5 + radius * np.sin(angle),
            0.1 + 0.08 * np.sin(0.2 * frame + index),
        ],
        axis=1,
    )
    centres = debris.mean(axis=1)
    moved: Points = debris + (grown * (target - centres))[:, None, :].astype(np.float32)
    return moved
