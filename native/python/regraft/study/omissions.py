"""What leaving out is worth: the same frames with and without each thing that is not needed.

Every omission is a made scene that is drawn twice. One side lets the library leave something out;
the other makes it do that work by something which no ray can tell: a vertex that no triangle uses,
a mesh behind the camera, a ray of which nobody asks what it hit, a light too faint for any pixel.
Pictures must be the same bit for bit.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from statistics import median
from time import process_time
from typing import Any

import numpy as np

import regraft
from regraft.study import local_motion
from regraft.study.mirror import Numbers
from regraft.study.stability import camera_rays

Row = dict[str, Any]
_SUN = regraft.Light("sun", direction=(0.3, 0.5, -0.8), energy=3.0)
# Beside the ambient light of any pixel this is less than half an ulp.
_FAINT = replace(_SUN, energy=1e-12, direction=(-0.3, 0.5, -0.8))
_AMBIENT = (0.2, 0.2, 0.2)
_WAITING = re.compile(r"(\d+) bytes of trees wait")


@dataclass(frozen=True)
class Settings:
    """`triangles` of the scene, `size` of the square picture in pixels, `frames` of which the
    first does not count."""

    triangles: int = 200_000
    size: int = 256
    frames: int = 12
    threads: int = 0


@dataclass(frozen=True)
class Drawn:
    """A frame: its picture as bits, and the bytes that had to be handed over or kept for it, but
    for those of trees that were left behind."""

    picture: bytes
    bytes: int


# Draws the frame of that number.
Side = Callable[[int], Drawn]


@dataclass(frozen=True)
class Omission:
    """`make(settings, omit)` is one side; `unless` says what the other does instead."""

    name: str
    unless: str
    make: Callable[[Settings, bool], Side]


class _Landscape:
    """Hills, and a camera on them. The last vertex belongs to no triangle."""

    def __init__(self, settings: Settings) -> None:
        self.settings, self.camera = settings, local_motion.view()
        self.scene = regraft.Scene(threads=settings.threads)
        self.handed = 0
        points, self.faces = local_motion.hills(settings.triangles)
        self.points = np.concatenate([points, points[:1]])
        self.mesh = self.scene.add_mesh(self.points, self.faces)
        self.instance = self.scene.add_instance(self.mesh)

    def touch(self) -> None:
        """Says that the mesh has changed, though nothing can be seen of it."""
        self.points[-1] += 1.0
        self.scene.set_vertices(self.mesh, self.points)
        self.handed += self.points.nbytes

    def behind(self, **more: Any) -> tuple[int, int]:
        """A second mesh like the first, behind the camera; its id, and its instance's."""
        away = np.eye(4)
        away[:3, 3] = 20.0 * self.camera.matrix[:3, 2]
        mesh = self.scene.add_mesh(self.points, self.faces, **more)
        return mesh, self.scene.add_instance(mesh, away)

    def deform(self, mesh: int, frame: int) -> None:
        """Shears a mesh."""
        points = self.points.copy()
        points[:, 2] *= 1.0 + 0.01 * frame
        self.scene.set_vertices(mesh, points)

    def look_behind(self) -> None:
        """Sends a ray to the mesh behind the camera."""
        eye, back = self.camera.matrix[:3, 3], self.camera.matrix[:3, 2]
        self.scene.closest_hit(eye[None], back[None])

    def draw(self, look: Callable[[], None] | None = None, **update: Any) -> Drawn:
        """Brings the trees up to date, and draws after a `look`."""
        self.scene.update(**update)
        if look is not None:
            look()
        frame = render(self.scene, self.camera, self.settings.size)
        handed, self.handed = self.handed, 0
        waiting = filter(None, map(_WAITING.search, frame.statistics.left_out))
        kept = frame.statistics.memory_bytes - sum(int(match[1]) for match in waiting)
        return Drawn(frame.passes["combined"].tobytes(), handed + kept)


def render(scene: regraft.Scene, camera: regraft.Camera, size: int) -> regraft.Frame:
    """A square picture with the scene's lights."""
    return scene.render(camera, size, size, shading="direct")


def _still(settings: Settings, omit: bool) -> Side:
    land = _Landscape(settings)

    def draw(_frame: int) -> Drawn:
        if not omit:
            land.touch()
        return land.draw()

    return draw


def _camera_only(settings: Settings, omit: bool) -> Side:
    land = _Landscape(settings)

    def draw(frame: int) -> Drawn:
        matrix = local_motion.view().matrix.copy()
        matrix[0, 3] += 0.01 * frame
        land.camera = replace(land.camera, matrix=matrix)
        if not omit:
            land.touch()
        return land.draw()

    return draw


def _rigid(settings: Settings, omit: bool) -> Side:
    land = _Landscape(settings)

    def draw(frame: int) -> Drawn:
        moved = np.eye(4)
        moved[0, 3] = 0.01 * frame
        land.scene.set_transform(land.instance, moved)
        if not omit:
            land.touch()
        return land.draw()

    return draw


def _hidden(settings: Settings, omit: bool) -> Side:
    land = _Landscape(settings)
    mesh, instance = land.behind()
    land.scene.set_visible(instance, not omit)

    def draw(frame: int) -> Drawn:
        land.deform(mesh, frame)
        return land.draw(None if omit else land.look_behind)

    return draw


def _far(settings: Settings, omit: bool) -> Side:
    land = _Landscape(settings)
    mesh, _ = land.behind()

    def draw(frame: int) -> Drawn:
        land.deform(mesh, frame)
        return land.draw(None if omit else land.look_behind)

    return draw


def _normals(settings: Settings, omit: bool) -> Side:
    land = _Landscape(settings)
    mesh, _ = land.behind(normal_ids=None if omit else land.faces)

    def draw(frame: int) -> Drawn:
        land.deform(mesh, frame)
        return land.draw()

    return draw


def _lights(settings: Settings, omit: bool) -> Side:
    land = _Landscape(settings)
    land.scene.set_world(_AMBIENT)
    land.scene.set_lights([_SUN] if omit else [_SUN, _FAINT])
    return lambda _frame: land.draw()


def _opaque(settings: Settings, omit: bool) -> Side:
    land = _Landscape(settings)
    land.scene.set_lights([_SUN])
    land.scene.set_materials(np.array([[0.8, 0.8, 0.8, 1.0 if omit else 0.5]], np.float32))
    corners = np.eye(3, dtype=np.float32)
    glass = land.scene.add_mesh(corners, np.array([[0, 1, 2]], np.uint32))
    away = np.eye(4)
    away[:3, 3] = 20.0 * land.camera.matrix[:3, 2]
    land.scene.add_instance(glass, away, materials=[0])
    return lambda _frame: land.draw()


def _one_frame(settings: Settings, omit: bool) -> Side:
    def draw(_frame: int) -> Drawn:
        land = _Landscape(settings)
        land.camera = _near(land.camera)
        return land.draw(frames_left=1 if omit else 100, camera=land.camera)

    return draw


def _near(camera: regraft.Camera) -> regraft.Camera:
    return replace(camera, window=tuple(0.25 * value for value in camera.window))


def _tree(settings: Settings, wanted: Callable[[Numbers], dict[str, Any]]) -> Side:
    """A k-d tree a frame, built as `wanted` says of the scene's box, and a picture's rays."""
    land = _Landscape(settings)
    land.scene.update(structure="kdtree")
    bounds = land.scene.bounds()
    rays = camera_rays(_near(land.camera), bounds, settings.size)

    def draw(_frame: int) -> Drawn:
        tree = regraft.KdTree(land.scene, **wanted(bounds))
        hits = tree.closest_hit(rays.origins, rays.directions)
        found = hits.t.tobytes() + hits.instance_id.tobytes() + hits.prim_id.tobytes()
        return Drawn(found, int(tree.statistics()["bytes"]))

    return draw


def _unseen(settings: Settings, omit: bool) -> Side:
    build = "lazy+scan+hierarchy" if omit else "scan+hierarchy"
    return _tree(settings, lambda _bounds: {"build": build})


def _metric(settings: Settings, omit: bool) -> Side:
    metric = "sah" if omit else "regions6"
    return _tree(settings, lambda bounds: {"metric": metric, "origins": bounds})


OMISSIONS = (
    Omission("still scene: no update", "an unused vertex moves", _still),
    Omission("camera alone moves: no update", "an unused vertex moves", _camera_only),
    Omission("rigid motion: no refit", "an unused vertex moves", _rigid),
    Omission("hidden mesh deforms: not updated", "a ray meets it behind the camera", _hidden),
    Omission("no ray near a mesh: only bounded", "a ray meets it behind the camera", _far),
    Omission("flat shading: no normals", "a mesh behind the camera is smooth", _normals),
    Omission("no second light: no shadow rays to it", "there is one too faint to see", _lights),
    Omission("opaque materials: no alpha tests", "one triangle behind is not", _opaque),
    Omission("one frame: no trees for later ones", "99 more are said to follow", _one_frame),
    Omission("nobody sees it: not built", "all of the k-d tree is built", _unseen),
    Omission("no rays from inside: area heuristic", "p_N in place of areas", _metric),
)


def measure(
    omissions: Sequence[Omission], settings: Settings, tick: Callable[[object], None]
) -> Iterator[Row]:
    """A row for each omission; both sides take turns frame by frame. Times are medians of the
    processor's, all threads together."""
    for omission in omissions:
        yield _measure(omission, settings)
        tick(omission.name)


def _measure(omission: Omission, settings: Settings) -> Row:
    sides = {omit: omission.make(settings, omit) for omit in (True, False)}
    times: dict[bool, list[float]] = {True: [], False: []}
    drawn: dict[bool, Drawn] = {}
    different = 0
    for frame in range(settings.frames):
        for omit in (True, False) if frame % 2 else (False, True):
            started = process_time()
            drawn[omit] = sides[omit](frame)
            times[omit].append(1e3 * (process_time() - started))
        different += drawn[True].picture != drawn[False].picture
    with_ms, without_ms = (median(times[omit][1:] or times[omit]) for omit in (True, False))
    return {
        "omission": omission.name,
        "unless": omission.unless,
        "with_ms": with_ms,
        "without_ms": without_ms,
        "saved": 1.0 - with_ms / without_ms,
        "with_bytes": drawn[True].bytes,
        "without_bytes": drawn[False].bytes,
        "pictures_that_differ": different,
    }


def lines(rows: Sequence[Row]) -> Iterator[str]:
    """The rows as a table for people."""
    yield f"{'left out':<40}{'with ms':>9}{'without':>9}{'saved':>7}{'MB less':>9}  same picture"
    for row in rows:
        less = (row["without_bytes"] - row["with_bytes"]) / 1e6
        same = "no" if row["pictures_that_differ"] else "yes"
        yield (
            f"{row['omission']:<40}{row['with_ms']:>9.2f}{row['without_ms']:>9.2f}"
            f"{row['saved']:>7.0%}{less:>9.2f}  {same} (unless {row['unless']})"
        )
