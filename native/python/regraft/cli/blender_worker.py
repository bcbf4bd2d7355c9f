"""Renders frames of a file with Blender. Runs inside Blender: bpy is imported on use."""

from __future__ import annotations

import time
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from regraft.cli import blender_engine, blender_file, blender_view
from regraft.cli.blender_simulation import RunUp
from regraft.cli.errors import InputError, OutputError, describe_write_failure
from regraft.cli.job import RenderJob, SceneInfo
from regraft.study.shot import Recorder, Shot, ShotWriter

# What Blender calls each format: media type (5.0 on), file format, colour mode, depth in bits.
_FORMATS = {
    "png": ("IMAGE", "PNG", "RGB", "8"),
    "jpeg": ("IMAGE", "JPEG", "RGB", "8"),
    "exr": ("IMAGE", "OPEN_EXR", "RGBA", "16"),
    "exr multi-layer": ("MULTI_LAYER_IMAGE", "OPEN_EXR_MULTILAYER", "RGBA", "32"),
}
# Pixels of the longer side while a shot is recorded.
_SMALL = 64
_PASS_SWITCHES = {
    "depth": "use_pass_z",
    "normal": "use_pass_normal",
    "object_index": "use_pass_object_index",
}


class BlenderWorker:
    """One file, opened once, rendered frame by frame with persistent data."""

    def __init__(self) -> None:
        self._scene: Any = None
        self._engine: blender_engine.Engine | None = None
        self._run_up: RunUp | None = None
        self._recording: _Recording | None = None
        self._percentage = 100

    def open(self, job: RenderJob) -> SceneInfo:
        """Opens and sets up the file. Raises InputError naming what is wrong with it."""
        import bpy

        notes = blender_file.open_file(Path(job.source))
        self._scene = scene = bpy.context.scene
        if not blender_view.has_geometry(scene):
            raise InputError(f"{job.source}: scene {scene.name!r} holds no geometry to render")
        self._engine = blender_engine.Engine(job.engine)
        notes += self._set_up(job)
        width, height = _set_size(scene, job)
        notes += blender_view.ensure_camera(scene, width / height)
        self._run_up = RunUp(scene)
        if self._run_up.needed:
            notes.append("simulations are not baked: every frame from the first on is evaluated")
        _work_from_an_empty_scene()
        frames = range(scene.frame_start, scene.frame_end + 1, scene.frame_step)
        fps = scene.render.fps / scene.render.fps_base
        return SceneInfo(
            bpy.app.version_string,
            tuple(frames),
            width,
            height,
            fps,
            _library_paths(),
            tuple(notes),
        )

    def render(self, frame: int, path: Path) -> dict[str, Any]:
        """Renders one frame into `path`; returns its statistics (docs/statistics.md).

        Raises InputError if the engine fails, OutputError if Blender cannot write.
        """
        assert self._engine
        assert self._run_up
        started = time.perf_counter()
        self._engine.begin_frame(self._scene)
        self._run_up.to(frame)
        row = self._engine.render(self._scene, frame)
        rendered = time.perf_counter()
        _save(self._scene, path)
        row["frame"] = frame
        row["write_ms"] = (time.perf_counter() - rendered) * 1e3
        row["total_ms"] = (time.perf_counter() - started) * 1e3
        return row

    def read_everything(self) -> None:
        """From here on frames read what has not changed as well: for benchmarks."""
        assert self._engine
        self._engine.read_everything()

    def begin_recording(self, folder: Path) -> None:
        """From here on frames are written down as a shot in `folder`, which exists.

        The engine must be REGRAFT and have rendered nothing yet. Raises OutputError.
        """
        assert self._engine
        try:
            writer = ShotWriter(folder)
        except OSError as error:
            raise describe_write_failure(folder, error) from error
        self._recording = _Recording(folder, writer, self._engine.watched(writer))
        self._percentage = self._scene.render.resolution_percentage
        _draw_small(self._scene.render)

    def record_frame(self, frame: int) -> None:
        """Renders the frame and writes down all that the library was told for it.

        Raises InputError, OutputError.
        """
        assert self._engine
        assert self._run_up
        assert self._recording
        self._recording.recorder.next_frame = frame
        self._engine.begin_frame(self._scene)
        self._run_up.to(frame)
        try:
            self._engine.render(self._scene, frame)
        except OSError as error:
            raise describe_write_failure(self._recording.folder, error) from error

    def end_recording(self, is_complete: bool) -> None:
        """Finishes the shot; one that is not complete can not be read. Raises OutputError."""
        assert self._recording
        recording, self._recording = self._recording, None
        self._scene.render.resolution_percentage = self._percentage
        try:
            recording.close(is_complete)
        except OSError as error:
            raise describe_write_failure(recording.folder, error) from error

    def plan(self, folder: Path) -> None:
        """From here on frames are rendered anew, by policy "shot"; the shot in `folder`, recorded
        before, holds its key frames."""
        assert self._engine
        self._engine.plan(Shot(folder))
        self._run_up = RunUp(self._scene)

    def probe(self) -> dict[str, Any]:
        """Versions, and which of the file formats this Blender reads."""
        import platform

        import bpy

        readable = [s for s in blender_file.IMPORTERS if blender_file.find_importer(s)]
        return {
            "blender": bpy.app.version_string,
            "python": platform.python_version(),
            "formats": [".blend", *readable],
        }

    def close(self) -> None:
        """Takes out of Blender what was put in: bpy 4.x does not survive its exit otherwise."""
        if self._engine:
            self._engine.close()
            self._engine = None

    def _set_up(self, job: RenderJob) -> list[str]:
        assert self._engine
        _choose_format(self._scene, job)
        layer, notes = _only_one_layer(self._scene)
        for name, switch in _PASS_SWITCHES.items():
            setattr(layer, switch, name in job.passes)
        notes += _leave_out_post_processing(self._scene)
        self._engine.set_up(self._scene, layer, job)
        return notes


class _Recording:
    """A shot that is being written: what the library is told goes to the disk as well."""

    def __init__(
        self, folder: Path, writer: ShotWriter, watched: AbstractContextManager[Recorder]
    ) -> None:
        self.folder, self._writer, self._watched = folder, writer, watched
        self.recorder = watched.__enter__()

    def close(self, is_complete: bool) -> None:
        self._watched.__exit__(None, None, None)
        self._writer.close(is_complete=is_complete)


def _set_size(scene: Any, job: RenderJob) -> tuple[int, int]:
    render = scene.render
    if job.width:
        render.resolution_x, render.resolution_y = job.width, job.height
        render.resolution_percentage = 100
    share = render.resolution_percentage / 100
    width, height = int(render.resolution_x * share), int(render.resolution_y * share)
    if width < 1 or height < 1:
        raise InputError(f"{job.source} asks for a picture of {width} x {height} pixels")
    return width, height


def _draw_small(render: Any) -> None:
    """Pictures that nobody looks at take some thousand rays."""
    longest = max(render.resolution_x, render.resolution_y)
    small = max(1, 100 * _SMALL // longest)
    render.resolution_percentage = min(render.resolution_percentage, small)


def _choose_format(scene: Any, job: RenderJob) -> None:
    several = job.format == "exr" and job.passes != ("combined",)
    media, file_format, mode, depth = _FORMATS["exr multi-layer" if several else job.format]
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = media
    settings.file_format = file_format
    transparent = scene.render.film_transparent and job.format == "png"
    settings.color_mode = "RGBA" if transparent else mode
    settings.color_depth = depth
    # Noise against banding would make equal pictures differ from version to version.
    scene.render.dither_intensity = 0.0


def _only_one_layer(scene: Any) -> tuple[Any, list[str]]:
    """Switches off every view layer but the first that renders; returns it, and a note."""
    used = [layer for layer in scene.view_layers if layer.use] or [scene.view_layers[0]]
    for layer in scene.view_layers:
        layer.use = layer == used[0]
    if len(used) == 1:
        return used[0], []
    return used[0], [f"{len(used)} view layers: only {used[0].name!r} is rendered"]


def _leave_out_post_processing(scene: Any) -> list[str]:
    render, notes = scene.render, []
    if render.use_compositing and scene.use_nodes and _has_nodes(scene):
        notes.append("compositing nodes are not run")
    if render.use_sequencer and scene.sequence_editor and _has_strips(scene.sequence_editor):
        notes.append("the video sequencer is not run")
    render.use_compositing = render.use_sequencer = False
    render.use_multiview = render.use_border = False
    return notes


def _has_nodes(scene: Any) -> bool:
    # 5.0 moved the tree; a file may also say it uses nodes and have none.
    tree = getattr(scene, "compositing_node_group", None) or getattr(scene, "node_tree", None)
    return bool(tree and len(tree.nodes))


def _has_strips(editor: Any) -> bool:
    return len(editor.strips if hasattr(editor, "strips") else editor.sequences) > 0


def _work_from_an_empty_scene() -> None:
    """After a render Blender evaluates the scene of the window once more; let that be nothing."""
    import bpy

    if bpy.context.window:
        bpy.context.window.scene = bpy.data.scenes.new("regraft empty")


def _save(scene: Any, path: Path) -> None:
    import bpy

    try:
        bpy.data.images["Render Result"].save_render(str(path), scene=scene)
    except RuntimeError as error:
        cause = blender_engine.report_words(error)
        raise OutputError(f"Blender cannot write the picture: {cause}") from error


def _library_paths() -> tuple[str, ...]:
    import bpy

    return tuple(sorted(bpy.path.abspath(library.filepath) for library in bpy.data.libraries))
