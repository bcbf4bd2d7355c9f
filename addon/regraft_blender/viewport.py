"""The rendered viewport: what it looks at, and the picture that is traced for it meanwhile."""

from __future__ import annotations

import logging
import weakref
from typing import Any

import bpy
import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d

from . import compat, session
from .progressive import Picture, ProgressiveJob, Region, Request
from .session import Options, Session
from .sync import camera_reader
from .sync.camera_reader import CameraArguments, Window

log = logging.getLogger(__name__)

# Seconds between two looks whether there is a better picture.
POLL = 0.02
# How long a redraw may wait for its first picture; more while an animation plays, because the
# next frame would otherwise give every picture up before it is seen.
PATIENCE = 0.03
PATIENCE_PLAYING = 0.5


class Viewport:
    """One viewport's engine instance: its session, its job and its texture."""

    def __init__(self, engine: bpy.types.RenderEngine, space: bpy.types.SpaceView3D) -> None:
        self._engine = weakref.ref(engine)
        self._purpose = space.as_pointer()
        self._session: Session | None = None
        self._job: ProgressiveJob | None = None
        self._drawn: Picture | None = None
        self._texture: Any = None
        self._hiding: tuple[object, ...] = ()
        self._is_stale = True

    def update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Read what changed in the scene."""
        options = Options.of(depsgraph.scene)
        kept = session.session_for(depsgraph, options, self._purpose)
        is_new = kept is not self._session
        hiding = _hiding(context.space_data)
        kept.stop_tracing = self._stop
        delta, _ = kept.synchronise(
            depsgraph,
            options,
            view=context.space_data,
            everything=is_new or hiding != self._hiding,
        )
        self._session, self._hiding = kept, hiding
        self._is_stale = self._is_stale or is_new or not delta.is_empty()

    def draw(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Draw the best picture there is, and see to it that it gets better."""
        if self._must_read(context, depsgraph):
            self.update(context, depsgraph)
        assert self._session is not None
        request = _request(context, depsgraph)
        if self._is_stale or self._job is None or not self._job.serves(request):
            self._job = self._start(self._session, request)
            playing = bool(context.screen and context.screen.is_animation_playing)
            self._job.wait_for_picture(PATIENCE_PLAYING if playing else PATIENCE)
        self._show(request.region)
        self._say()

    def close(self) -> None:
        """Stop the thread and let go of the session; without an engine nobody sees its picture."""
        if self._session is not None:
            session.close(self._session)
        self._stop()
        self._session = None

    def _must_read(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> bool:
        """True if the session was dropped (undo, another number of threads) or the viewport hides
        other objects; Blender announces neither."""
        if self._session is None or not self._session.is_open:
            return True
        if self._session.threads != Options.of(depsgraph.scene).threads:
            return True
        return self._hiding != _hiding(context.space_data)

    def _start(self, kept: Session, request: Request) -> ProgressiveJob:
        self._stop()
        self._is_stale = False
        if not bpy.app.timers.is_registered(self._poll):
            bpy.app.timers.register(self._poll, first_interval=POLL)
        return ProgressiveJob(kept.scene, request)

    def _stop(self) -> None:
        if self._job is not None:
            self._job.stop()

    def _poll(self) -> float | None:
        """Ask for a redraw whenever there is something new to draw."""
        engine, job = self._engine(), self._job
        if engine is None or job is None or self._session is None:
            return None
        try:
            if job.picture is not self._drawn or job.error is not None:
                engine.tag_redraw()
        except ReferenceError:
            self.close()
            return None
        return POLL if job.is_running() or job.picture is not self._drawn else None

    def _show(self, region: Region) -> None:
        """Draw the newest picture over the region (x0, y0, x1, y1) of the viewport."""
        picture = self._job.picture if self._job is not None else None
        if picture is not None and picture is not self._drawn:
            self._texture, self._drawn = _texture(picture), picture
        if self._texture is None:
            return
        x0, y0, x1, y1 = region
        gpu.state.blend_set("ALPHA_PREMULT")
        draw_texture_2d(self._texture, (x0, y0), x1 - x0, y1 - y0)
        gpu.state.blend_set("NONE")

    def _say(self) -> None:
        """Show the state of the picture in the viewport's corner."""
        engine, job = self._engine(), self._job
        if engine is None or job is None:
            return
        if job.error is not None:
            raise job.error
        done = job.picture.samples if job.picture is not None else 0
        engine.update_stats("", f"Regraft: {done} of {job.request.samples} samples")


def _texture(picture: Picture) -> Any:
    height, width = picture.pixels.shape[:2]
    pixels = gpu.types.Buffer("FLOAT", width * height * 4, picture.pixels.ravel())
    return gpu.types.GPUTexture((width, height), format="RGBA16F", data=pixels)


def _request(context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> Request:
    scene, options = depsgraph.scene, Options.of(depsgraph.scene)
    width, height = context.region.width, context.region.height
    camera = compat.native().Camera(**_camera(context, depsgraph))
    return Request(
        camera=camera,
        width=width,
        height=height,
        region=_region(context, scene),
        shading=options.shading,
        samples=scene.regraft.viewport_samples,
        transparent=scene.render.film_transparent,
        policy=options.policy,
        structure=options.structure,
        layout=options.layout,
    )


def _camera(context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> CameraArguments:
    view, space = context.region_data, context.space_data
    looked_through = _camera_object(context)
    if looked_through is None:
        return camera_reader.read_view(view, (space.clip_start, space.clip_end))
    camera = looked_through.evaluated_get(depsgraph)
    if camera.data.type == "PANO":
        left, right, bottom, top = _camera_frame(context, camera)
        # The viewport's outline in units of the camera's frame.
        outline = (
            -left / (right - left),
            (1 - left) / (right - left),
            -bottom / (top - bottom),
            (1 - bottom) / (top - bottom),
        )
        picture = camera_reader.Picture.of(depsgraph.scene.render)
        return camera_reader.read_panoramic_view(camera, picture, outline)[0]
    return camera_reader.read_view(view, (camera.data.clip_start, camera.data.clip_end))


def _camera_object(context: bpy.types.Context) -> bpy.types.Object | None:
    """The camera that the viewport looks through, if it does."""
    if context.region_data.view_perspective != "CAMERA":
        return None
    space = context.space_data
    ob = space.camera if space.use_local_camera else context.scene.camera
    return ob if ob is not None and ob.type == "CAMERA" else None


def _camera_frame(context: bpy.types.Context, camera: bpy.types.Object) -> Window:
    """(left, right, bottom, top) of the camera's frame in shares of the viewport."""
    corners = np.array(camera.data.view_frame(scene=context.scene), np.float64)
    projection = np.array(context.region_data.window_matrix, np.float64)
    clip = np.c_[corners, np.ones(4)] @ projection.T
    shares = (clip[:, :2] / clip[:, 3:] + 1) / 2
    (left, bottom), (right, top) = shares.min(axis=0), shares.max(axis=0)
    return float(left), float(right), float(bottom), float(top)


def _region(context: bpy.types.Context, scene: bpy.types.Scene) -> Region:
    """Pixels of the viewport to trace: all of it, the user's border, or a panorama's frame,
    beyond which it would only repeat itself."""
    width, height = context.region.width, context.region.height
    left, right, bottom, top = _border(context, scene.render)
    x0, y0 = max(0, int(left * width)), max(0, int(bottom * height))
    x1, y1 = min(width, int(right * width)), min(height, int(top * height))
    # A border outside the viewport leaves nothing to trace; one pixel keeps it simple.
    x0, y0 = min(x0, width - 1), min(y0, height - 1)
    return x0, y0, max(x1, x0 + 1), max(y1, y0 + 1)


def _border(context: bpy.types.Context, render: bpy.types.RenderSettings) -> Window:
    """(left, right, bottom, top) of what is to be traced, in shares of the viewport."""
    space, camera = context.space_data, _camera_object(context)
    whole = 0.0, 1.0, 0.0, 1.0
    if camera is None:
        if not space.use_render_border:
            return whole
        xs = space.render_border_min_x, space.render_border_max_x
        return (*xs, space.render_border_min_y, space.render_border_max_y)
    if not render.use_border and camera.data.type != "PANO":
        return whole
    frame = _camera_frame(context, camera)
    if not render.use_border:
        return frame
    across, up = frame[1] - frame[0], frame[3] - frame[2]
    return (
        frame[0] + across * render.border_min_x,
        frame[0] + across * render.border_max_x,
        frame[2] + up * render.border_min_y,
        frame[2] + up * render.border_max_y,
    )


def _hiding(space: bpy.types.SpaceView3D) -> tuple[object, ...]:
    """What decides which objects this viewport alone hides."""
    local = space.local_view
    kinds = [
        getattr(space, name) for name in dir(space) if name.startswith("show_object_viewport_")
    ]
    return (local.as_pointer() if local else 0, space.use_local_collections, *kinds)
