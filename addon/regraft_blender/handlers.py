"""What has to happen when Blender loads a file, undoes a step, or begins and ends a render."""

from __future__ import annotations

import time

import bpy
from bpy.app.handlers import persistent

from . import session

ENGINE = "REGRAFT"

# Scenes whose persistent data was switched on for the time of a render.
_switched_on: set[str] = set()
_began: dict[str, float] = {}


@persistent
def forget_scenes(*_arguments: object) -> None:
    """After a file load or an undo step nothing read before holds."""
    session.close_all()


@persistent
def begin_render(scene: bpy.types.Scene, *_arguments: object) -> None:
    """Without persistent data Blender makes a new dependency graph a frame and flags everything
    as changed, so switch it on; Blender copies the settings only after this handler."""
    session.clear_history()
    render = scene.render
    if render.engine == ENGINE and not render.use_persistent_data:
        render.use_persistent_data = True
        _switched_on.add(scene.name_full)


@persistent
def end_render(scene: bpy.types.Scene, *_arguments: object) -> None:
    """Put the user's setting back."""
    if scene.name_full in _switched_on:
        _switched_on.discard(scene.name_full)
        scene.render.use_persistent_data = False


@persistent
def begin_frame(*_arguments: object) -> None:
    """Blender evaluates the scene between this and the engine's `update`."""
    _began["frame"] = time.perf_counter()


def evaluation_ms() -> float:
    """Milliseconds since the frame began, once a frame; 0 where no beginning was seen."""
    began = _began.pop("frame", None)
    return 0.0 if began is None else (time.perf_counter() - began) * 1e3


def _wanted() -> list[tuple[list, object]]:
    lists = bpy.app.handlers
    return [
        (lists.load_pre, forget_scenes),
        (lists.load_post, forget_scenes),
        (lists.undo_post, forget_scenes),
        (lists.redo_post, forget_scenes),
        (lists.render_init, begin_render),
        (lists.render_complete, end_render),
        (lists.render_cancel, end_render),
        (lists.render_pre, begin_frame),
    ]


def register() -> None:
    """Put the handlers in, once."""
    for handlers, handler in _wanted():
        if handler not in handlers:
            handlers.append(handler)


def unregister() -> None:
    """Take them out again."""
    for handlers, handler in _wanted():
        if handler in handlers:
            handlers.remove(handler)
