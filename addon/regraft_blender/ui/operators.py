"""Render preview, preview animation, save statistics."""

# mypy: disable-error-code="valid-type"
# Blender's properties are calls where Python expects types.

from __future__ import annotations

import json
import math
import os
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

import bpy
from bpy.props import StringProperty

from .. import compat, session
from ..handlers import ENGINE

Result = set[str]

# Seconds between two looks whether a render in the background has ended.
LOOK_EVERY = 0.2


class PreviewOperator:
    """What the two render buttons share. They render with Regraft whatever engine the scene is
    set to, and put that setting back when the render has ended."""

    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context: bpy.types.Context) -> bool:
        """There must be a library, a scene with a camera, and no render under way."""
        if compat.problem():
            return _refuse(cls, compat.problem())
        if context.scene is None or context.scene.camera is None:
            return _refuse(cls, "The scene has no camera")
        if bpy.app.is_job_running("RENDER"):
            return _refuse(cls, "A render is running")
        return True


class REGRAFT_OT_render_preview(PreviewOperator, bpy.types.Operator):
    """Render the current frame with Regraft"""

    bl_idname = "regraft.render_preview"
    bl_label = "Render Preview"

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> Result:
        """Render in the background of the interface; ESC cancels."""
        return _render(self, context, "INVOKE_DEFAULT")

    def execute(self, context: bpy.types.Context) -> Result:
        """Render at once."""
        return _render(self, context, "EXEC_DEFAULT")


class REGRAFT_OT_preview_animation(PreviewOperator, bpy.types.Operator):
    """Render the whole animation with Regraft, to the scene's output path"""

    bl_idname = "regraft.preview_animation"
    bl_label = "Preview Animation"

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> Result:
        """Render in the background of the interface; ESC cancels."""
        return _render(self, context, "INVOKE_DEFAULT", animation=True)

    def execute(self, context: bpy.types.Context) -> Result:
        """Render at once."""
        return _render(self, context, "EXEC_DEFAULT", animation=True)


class REGRAFT_OT_save_statistics(bpy.types.Operator):
    """Save the statistics of the frames rendered last, one JSON object a line"""

    bl_idname = "regraft.save_statistics"
    bl_label = "Save Statistics"
    bl_options = {"REGISTER"}

    filepath: StringProperty(name="File", subtype="FILE_PATH", default="//statistics.jsonl")
    filter_glob: StringProperty(default="*.jsonl", options={"HIDDEN"})

    @classmethod
    def poll(cls, _context: bpy.types.Context) -> bool:
        """There must be statistics."""
        return bool(session.last_statistics()) or _refuse(cls, "Nothing was rendered yet")

    def invoke(self, context: bpy.types.Context, _event: bpy.types.Event) -> Result:
        """Ask where to."""
        if self.filepath.startswith("//") and not bpy.data.filepath:
            self.filepath = "statistics.jsonl"
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, _context: bpy.types.Context) -> Result:
        """Write the file, all of it or none."""
        path = Path(bpy.path.abspath(self.filepath))
        rows = session.history()
        try:
            write_lines(path, rows)
        except OSError as error:
            self.report({"ERROR"}, f"{path}: {error.strerror or error}")
            return {"CANCELLED"}
        self.report({"INFO"}, f"{len(rows)} frames written to {path}")
        return {"FINISHED"}


def write_lines(path: Path, rows: list[dict[str, Any]]) -> None:
    """Write one JSON object a line; the file appears only when it is complete. Raises OSError."""
    descriptor, name = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
    try:
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            file.writelines(json.dumps(finite(row), allow_nan=False) + "\n" for row in rows)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(name, 0o666 & ~_umask())
        os.replace(name, path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise


def finite(row: dict[str, Any]) -> dict[str, Any]:
    """The row with None for numbers that JSON cannot write."""
    return {
        name: None if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in row.items()
    }


def _umask() -> int:
    """The process's file mode mask, which can only be read by setting it."""
    mask = os.umask(0o077)
    os.umask(mask)
    return mask


def _refuse(operator: Any, reason: str) -> bool:
    operator.poll_message_set(reason)
    return False


def _render(
    operator: bpy.types.Operator,
    context: bpy.types.Context,
    mode: str,
    *,
    animation: bool = False,
) -> Result:
    """Render the scene with Regraft, and give it its own engine back when that has ended."""
    scene, engine = context.scene, context.scene.render.engine
    if engine != ENGINE:
        scene.render.engine = ENGINE
    try:
        result = bpy.ops.render.render(mode, animation=animation)
    except RuntimeError as error:
        operator.report({"ERROR"}, str(error).removeprefix("Error: ").strip())
        result = {"CANCELLED"}
    give_back = partial(_give_back, scene.name, engine)
    if "RUNNING_MODAL" in result:
        bpy.app.timers.register(give_back, first_interval=LOOK_EVERY)
    else:
        give_back()
    return {"CANCELLED"} if "CANCELLED" in result else {"FINISHED"}


def _give_back(scene_name: str, engine: str) -> float | None:
    """Set a scene's engine unless it is being rendered; then seconds until the next try.

    Blender's handlers would tell when the render ends, but from the thread that rendered: changing
    the engine there crashes the viewports.
    """
    if bpy.app.is_job_running("RENDER"):
        return LOOK_EVERY
    scene = bpy.data.scenes.get(scene_name)
    if scene is not None and scene.render.engine != engine:
        scene.render.engine = engine
    return None


CLASSES = (
    REGRAFT_OT_render_preview,
    REGRAFT_OT_preview_animation,
    REGRAFT_OT_save_statistics,
)
