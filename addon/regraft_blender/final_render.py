"""One final frame: scene → native scene → picture → Blender's render result."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np
import numpy.typing as npt

from . import compat, handlers, session
from .session import Options, Session
from .sync.camera_reader import Picture, read_camera
from .sync.delta import SceneDelta

# Where nothing is, Blender's depth is this and not infinity.
FAR_AWAY = 1e10
OBJECT_INDEX = "Object Index" if bpy.app.version >= (5, 0, 0) else "IndexOB"

Region = tuple[int, int, int, int]
Plane = npt.NDArray[np.float32]


class RenderError(RuntimeError):
    """The frame cannot be rendered; the message tells the user why."""


@dataclass(frozen=True)
class PassKind:
    """A pass: Blender's name for it, the library's, and its channels."""

    name: str
    aov: str
    channels: str
    socket: str = "VALUE"


def wanted_passes(layer: bpy.types.ViewLayer) -> Iterator[PassKind]:
    """The passes that the user asks for in a view layer."""
    yield PassKind("Combined", "combined", "RGBA", "COLOR")
    if layer.use_pass_z:
        yield PassKind("Depth", "depth", "Z")
    if layer.use_pass_normal:
        yield PassKind("Normal", "normal", "XYZ", "VECTOR")
    if layer.use_pass_object_index:
        yield PassKind(OBJECT_INDEX, "object_index", "X")
    if layer.regraft.use_pass_cost:
        yield PassKind("Cost", "cost", "X")


class FinalFrame:
    """Renders one view layer of one frame into the engine's result.

    Raises RenderError where the user can help it, and what the library raises.
    """

    def __init__(self, engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph) -> None:
        self.engine = engine
        self.depsgraph = depsgraph
        self.scene = depsgraph.scene
        self.layer = depsgraph.view_layer
        self.options = Options.of(self.scene)
        self.picture = _picture(self.scene)
        self.region = _region(self.scene.render, self.picture)
        self.passes = list(wanted_passes(self.layer))
        self.camera, self.warning = self._read_camera()

    def render(self) -> None:
        """Do it all, and publish what it cost."""
        evaluate_ms = handlers.evaluation_ms()
        self._say("reading the scene")
        kept = session.session_for(self.depsgraph, self.options)
        delta, extract_ms = kept.synchronise(self.depsgraph, self.options)
        self._say("updating the trees")
        kept.update(self.options, self._frames_left(), self.camera)
        self._say("tracing")
        frame = self._trace(kept)
        self._hand_over(frame)
        statistics = frame.statistics
        statistics.frame = self.scene.frame_current
        statistics.evaluate_ms, statistics.extract_ms = evaluate_ms, extract_ms
        self._add_words(statistics, delta)
        session.publish(statistics)

    def _frames_left(self) -> int:
        """Frames to come, this one included: one, unless an animation is rendered."""
        if not self.engine.is_animation:
            return 1
        return max(1, self.scene.frame_end - self.scene.frame_current + 1)

    def _say(self, text: str) -> None:
        # Without a window every one of these would be a line in the terminal.
        if not bpy.app.background:
            self.engine.update_stats("", f"Regraft: {text}")

    def _read_camera(self) -> tuple[Any, str]:
        ob = self.engine.camera_override or self.scene.camera
        if ob is None or ob.type != "CAMERA":
            raise RenderError(f"scene '{self.scene.name}' has no camera to render through")
        arguments, warning = read_camera(ob.evaluated_get(self.depsgraph), self.picture)
        try:
            return compat.native().Camera(**arguments), warning
        except ValueError as error:
            raise RenderError(f"camera '{ob.name}': {error}") from error

    def _trace(self, kept: Session) -> Any:
        return kept.scene.render(
            self.camera,
            self.picture.width,
            self.picture.height,
            shading=self.options.shading,
            samples=self.options.samples,
            passes=tuple(kind.aov for kind in self.passes),
            region=self.region,
            transparent=self.scene.render.film_transparent,
            progress=self.engine.update_progress,
            cancel=self.engine.test_break,
        )

    def _hand_over(self, frame: Any) -> None:
        """Put the planes into Blender's render result."""
        for kind in self.passes[1:]:
            self.engine.add_pass(
                kind.name, len(kind.channels), kind.channels, layer=self.layer.name
            )
        x0, y0, x1, y1 = self.region
        result = self.engine.begin_result(0, 0, x1 - x0, y1 - y0, layer=self.layer.name)
        aovs = {kind.name: kind.aov for kind in self.passes}
        try:
            for target in result.layers[0].passes:
                if target.name in aovs:
                    _fill(target, self._plane(frame, aovs[target.name]))
        finally:
            self.engine.end_result(result)

    def _plane(self, frame: Any, aov: str) -> Plane:
        plane = frame.passes[aov]
        if aov != "depth":
            return plane
        if self.camera.kind == "perspective":
            plane = plane * _cosines(self.camera.window, self.picture, self.region)
        return np.where(np.isfinite(plane), plane, np.float32(FAR_AWAY))

    def _add_words(self, statistics: Any, delta: SceneDelta) -> None:
        statistics.left_out += delta.left_out
        statistics.warnings += delta.warnings
        if self.warning:
            statistics.warnings += [self.warning]


def _picture(scene: bpy.types.Scene) -> Picture:
    picture = Picture.of(scene.render)
    if picture.width < 1 or picture.height < 1:
        raise RenderError(
            f"scene '{scene.name}': nothing to render at {picture.width} × {picture.height} pixels"
        )
    return picture


def _region(render: bpy.types.RenderSettings, picture: Picture) -> Region:
    """Pixels (x0, y0, x1, y1) to render, from the lower left corner, as Blender rounds them."""
    width, height = picture.width, picture.height
    if not render.use_border:
        return 0, 0, width, height
    # Blender multiplies in single precision and cuts the fraction off.
    xs = np.array([render.border_min_x, render.border_max_x], np.float32) * np.float32(width)
    ys = np.array([render.border_min_y, render.border_max_y], np.float32) * np.float32(height)
    x0, x1, y0, y1 = int(xs[0]), int(xs[1]), int(ys[0]), int(ys[1])
    if x0 >= x1 or y0 >= y1:
        raise RenderError(f"the render border is empty: {x1 - x0} × {y1 - y0} pixels")
    return x0, y0, x1, y1


def _cosines(window: tuple[float, ...], picture: Picture, region: Region) -> Plane:
    """(H,W,1) cosine between each pixel's ray and the view axis, first row on top: turns the
    distance along the ray into the depth along -Z that Blender means."""
    left, right, bottom, top = window
    x0, y0, x1, y1 = region
    x = left + (np.arange(x0, x1) + 0.5) * (right - left) / picture.width
    y = bottom + (np.arange(y1 - 1, y0 - 1, -1) + 0.5) * (top - bottom) / picture.height
    squared = 1 + x[None, :] ** 2 + y[:, None] ** 2
    return (1 / np.sqrt(squared)).astype(np.float32)[:, :, None]


def _fill(target: bpy.types.RenderPass, plane: Plane) -> None:
    """Copy a plane (H,W,C), first row on top, into a pass, whose first row is at the bottom."""
    pixels = np.ascontiguousarray(plane[::-1])
    if compat.FLAT_RESULT_PIXELS:
        target.rect.foreach_set(pixels.ravel())
    else:
        target.rect.foreach_set(pixels.reshape(-1, plane.shape[2]))
