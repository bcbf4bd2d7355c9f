"""The lazy k-d tree: what a first picture opens and takes, against what is seen and what is there.

Hunt, Mark, Fussell, Fast and Lazy Build of Acceleration Structures from Scene Hierarchies, 2007,
promise work that grows with the primitives seen, and like log n with
those hidden. Seen: the camera's window is narrowed. Hidden: copies of the scene behind the eye.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

import regraft
from regraft.study.mirror import Mirror, Numbers
from regraft.study.shot import Shot
from regraft.study.stability import camera_rays
from regraft.study.tidy import quartiles

Row = dict[str, Any]
ZOOMS = (1.0, 0.5, 0.25, 0.125, 0.0625)
COPIES = (1, 2, 4, 8)
REPEATS = 5


def steps() -> int:
    """How often `measure` calls `tick`."""
    return len(ZOOMS) + len(COPIES)


def measure(shot: Shot, side: int, threads: int, tick: Callable[[object], None]) -> Iterator[Row]:
    """A row for each window and for each number of copies; the first frame only."""
    stage = _Stage(shot, threads)
    for zoom in ZOOMS:
        yield {"axis": "seen", "zoom": zoom, "copies": 1, **_first_picture(stage, side, zoom, 1)}
        tick(f"window × {zoom:g}")
    for copies in COPIES:
        row = {"axis": "hidden", "zoom": ZOOMS[1], "copies": copies}
        yield row | _first_picture(stage, side, ZOOMS[1], copies)
        tick(f"{copies} copies")


def _first_picture(stage: _Stage, side: int, zoom: float, copies: int) -> Row:
    """Medians over scenes made anew; the second picture finds the tree built."""
    times: dict[str, list[float]] = {}
    found: Row = {}
    camera = stage.camera(zoom)
    for _ in range(REPEATS):
        for structure in ("kdtree", "bvh"):
            mirror = stage.scene(copies)
            done = mirror.update(policy="rebuild", structure=structure)
            update_ms = done.update_ms
            first = mirror.render(camera, side, side, shading="clay").statistics
            again = mirror.render(camera, side, side, shading="clay").statistics
            spent = first.trace_ms + first.shade_ms
            times.setdefault(f"{structure}_first_ms", []).append(update_ms + spent)
            times.setdefault(f"{structure}_again_ms", []).append(again.trace_ms + again.shade_ms)
            if structure == "bvh":
                found["bvh_nodes"] = done.nodes_rebuilt
            elif not found:
                found = _counts(mirror, camera, side, first)
    return found | {name: quartiles(values)[1] for name, values in times.items()}


def _counts(mirror: Mirror, camera: regraft.Camera, side: int, first: Any) -> Row:
    rays = camera_rays(camera, mirror.bounds(), side)
    hits = mirror.closest_hit(rays.origins, rays.directions)
    met = np.isfinite(hits.t)
    seen = np.stack([hits.instance_id[met], hits.prim_id[met]])
    return {
        "triangles": first.triangles,
        "triangles_seen": int(np.unique(seen, axis=1).shape[1]),
        "nodes_opened": first.kdtree_nodes,
        "built_fraction": first.kdtree_built_fraction,
    }


class _Stage:
    """The first frame: scenes in which nothing is built yet, and a camera."""

    def __init__(self, shot: Shot, threads: int) -> None:
        self._shot, self._threads = shot, threads
        whole = self.scene(1)
        whole.update()
        self._bounds = whole.bounds()
        self._camera = shot.camera(0)
        if self._camera.kind != "perspective":
            corners = np.array(np.meshgrid(*self._bounds.T)).reshape(3, -1).T
            self._camera = regraft.camera.frame_points(corners, 1.0)

    def camera(self, zoom: float) -> regraft.Camera:
        return replace(self._camera, window=tuple(zoom * x for x in self._camera.window))

    def scene(self, copies: int) -> Mirror:
        """With that many of everything, all but one behind the eye."""
        mirror = Mirror(regraft.Scene(threads=self._threads))
        self._shot.apply(0, mirror)
        for i in range(1, copies):
            behind = self._camera.matrix[:3, 2]  # it looks along -Z
            size = np.linalg.norm(np.ptp(self._bounds, axis=0))
            mirror.add_copy(_moved(behind * 4.0 * i * size))
        return mirror


def _moved(by: Numbers) -> Numbers:
    m = np.eye(4)
    m[:3, 3] = by
    return m


def slope(rows: Sequence[Row], x: str, y: str) -> float | None:
    """Exponent p of the y ~ x^p that fits best; None if x does not vary."""
    points = [(row[x], row[y]) for row in rows if row[x] > 0 and row[y] > 0]
    logs = np.log(np.array(points).reshape(-1, 2))
    if len(logs) < 2 or np.ptp(logs[:, 0]) < 1e-9:
        return None
    return float(np.polyfit(logs[:, 0], logs[:, 1], 1)[0])
