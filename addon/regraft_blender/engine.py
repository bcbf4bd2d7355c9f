"""The render engine REGRAFT: what Blender calls, each call handed on at once."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager

import bpy

from . import compat, handlers
from .final_render import FinalFrame, RenderError, wanted_passes
from .viewport import Viewport

log = logging.getLogger(__name__)


class RegraftEngine(bpy.types.RenderEngine):
    """Previews of animated scenes, traced with structures that stay alive between frames.

    Blender makes and drops instances as it likes, so an instance holds nothing worth keeping:
    scenes live in `session`.
    """

    bl_idname = handlers.ENGINE
    bl_label = "Regraft"
    bl_use_preview = False
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False

    # No __init__: throw-away instances are made often, and its arguments differ by version.
    _viewport: Viewport | None = None
    _complaint = ""

    def __del__(self) -> None:
        try:
            if self._viewport is not None:
                self._viewport.close()
        except ReferenceError:
            # Blender freed its side first; the viewport's thread stops at its next look.
            log.debug("engine freed before its viewport was closed")

    def update(self, _data: bpy.types.BlendData, _depsgraph: bpy.types.Depsgraph) -> None:
        """Blender has evaluated the scene; everything else happens in `render`."""

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        """Render one view layer of one frame."""
        with self._reporting():
            FinalFrame(self, depsgraph).render()

    def update_render_passes(
        self, scene: bpy.types.Scene, renderlayer: bpy.types.ViewLayer
    ) -> None:
        """Tell the compositor which passes there will be."""
        for kind in wanted_passes(renderlayer):
            self.register_pass(
                scene, renderlayer, kind.name, len(kind.channels), kind.channels, kind.socket
            )

    def view_update(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """The scene changed while a viewport shows it."""
        with self._reporting():
            self._opened_viewport(context).update(context, depsgraph)

    def view_draw(self, context: bpy.types.Context, depsgraph: bpy.types.Depsgraph) -> None:
        """Draw what there is of the picture, and go on with it."""
        with self._reporting():
            self._opened_viewport(context).draw(context, depsgraph)

    def _opened_viewport(self, context: bpy.types.Context) -> Viewport:
        if self._viewport is None:
            self._viewport = Viewport(self, context.space_data)
        return self._viewport

    @contextmanager
    def _reporting(self) -> Iterator[None]:
        """Nothing raised may leave an engine's callback: Blender would call the render finished.

        What the user can help is reported in words; anything else leaves a traceback in the log.
        """
        try:
            yield
        except (RenderError, compat.NativeMissingError) as error:
            self._complain(str(error))
        except Exception as error:
            first_line = str(error).strip().partition("\n")[0]
            message = f"{type(error).__name__}: {first_line}"
            if message != self._complaint:
                log.exception("Regraft failed")
            self._complain(message)

    def _complain(self, message: str) -> None:
        """Tell the user; a viewport, which is drawn again and again, says it in its corner."""
        self._complaint = message
        if self._viewport is None:
            self.report({"ERROR"}, f"Regraft: {message}")
        else:
            self.update_stats("", f"Regraft: {message}")
