"""The add-on among Blender's own comings and goings: enabling, loading, undo, handlers."""

from __future__ import annotations

from types import SimpleNamespace

import bpy
from harness import TEMPORARY, add, heights, mesh, native, part, raises, render, run


def sessions() -> dict:
    return part("session")._sessions


def handlers() -> list:
    """Our functions in Blender's handler lists."""
    package = part().__name__
    return [
        function
        for name in dir(bpy.app.handlers)
        if isinstance(getattr(bpy.app.handlers, name), list)
        for function in getattr(bpy.app.handlers, name)
        if getattr(function, "__module__", "").startswith(package)
    ]


def check_enabled_twice_is_as_good_as_once() -> None:
    before = len(handlers())
    assert before > 0
    part().register()
    assert len(handlers()) == before
    add("square", mesh("square"))
    render()


def check_disabled_leaves_nothing_and_can_be_enabled_again() -> None:
    scene = bpy.context.scene
    add("square", mesh("square"))
    render()
    scene.regraft.samples = 3
    part().unregister()
    assert not sessions()
    assert not handlers()
    assert not hasattr(bpy.types.Scene, "regraft")
    assert not hasattr(bpy.types.ViewLayer, "regraft")
    assert not hasattr(bpy.types, "REGRAFT_PT_preview")
    compatible = [
        panel
        for panel in bpy.types.Panel.__subclasses__()
        if "REGRAFT" in getattr(panel, "COMPAT_ENGINES", ())
    ]
    assert compatible == []
    part().unregister()
    part().register()
    assert scene.regraft.samples == 3, "settings stay in the file"
    scene.render.engine = "REGRAFT"
    render()


def check_blenders_own_panels_show() -> None:
    shown = {
        panel.__name__
        for panel in bpy.types.Panel.__subclasses__()
        if "REGRAFT" in getattr(panel, "COMPAT_ENGINES", ())
    }
    for name in ("RENDER_PT_format", "RENDER_PT_output", "DATA_PT_lens", "DATA_PT_camera"):
        assert name in shown, (name, sorted(shown))
    assert any("light" in name.lower() for name in shown), sorted(shown)
    assert "VIEWLAYER_PT_layer_passes" not in shown


def check_panels_of_ours_know_when_to_show() -> None:
    panel = part("ui.panels").REGRAFT_PT_render
    assert panel.poll(SimpleNamespace(engine="REGRAFT"))
    assert not panel.poll(SimpleNamespace(engine="CYCLES"))


def check_loading_a_file_drops_the_sessions() -> None:
    scene = bpy.context.scene
    add("square", mesh("square"), (0, 0, 1))
    render()
    assert sessions()
    path = str(TEMPORARY / "saved.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    scene = bpy.context.scene
    bpy.data.objects["square"].location.z = 5
    render()
    assert heights((0, 0)) == [5.0]
    bpy.ops.wm.open_mainfile(filepath=path)
    assert not sessions()
    render()
    assert heights((0, 0)) == [1.0]
    assert bpy.context.scene.render.engine == "REGRAFT"
    del scene


def check_undo_drops_the_sessions() -> None:
    add("square", mesh("square"))
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.ed.undo_push(message="before")
    bpy.data.objects["square"].location.z = 3
    bpy.ops.ed.undo_push(message="after")
    render()
    assert heights((0, 0)) == [3.0]
    bpy.ops.ed.undo()
    assert not sessions()
    render()
    assert heights((0, 0)) == [0.0]
    bpy.ops.ed.redo()
    assert not sessions()
    render()
    assert heights((0, 0)) == [3.0]


def check_the_session_outlives_frames_and_engines() -> None:
    scene = bpy.context.scene
    add("square", mesh("square"))
    kept = []
    for persistent in (True, True, False, False):
        scene.render.use_persistent_data = persistent
        render()
        kept.append(native())
    assert all(one is kept[0] for one in kept)


def check_another_scene_has_a_session_of_its_own() -> None:
    add("square", mesh("square"), (0, 0, 1))
    render()
    first = bpy.context.scene
    second = bpy.data.scenes.new("second")
    second.camera = first.camera
    second.render.engine = "REGRAFT"
    second.render.resolution_x = second.render.resolution_y = 16
    bpy.ops.render.render(scene="second")
    assert len(sessions()) == 2
    counts = sorted(one.scene.counts()["instances"] for one in sessions().values())
    assert counts == [0, 1]


def check_persistent_data_is_put_back_when_a_render_fails() -> None:
    scene = bpy.context.scene
    scene.render.use_persistent_data = False
    scene.camera.data.clip_start, scene.camera.data.clip_end = 5, 1
    raises(RuntimeError, bpy.ops.render.render)
    assert scene.render.use_persistent_data is False
    assert not part("handlers")._switched_on


def check_another_engines_settings_are_left_alone() -> None:
    scene = bpy.context.scene
    scene.render.use_persistent_data = False
    scene.render.engine = "CYCLES"
    part("handlers").begin_render(scene)
    assert scene.render.use_persistent_data is False
    part("handlers").end_render(scene)
    assert scene.render.use_persistent_data is False


def check_a_preview_borrows_the_engine() -> None:
    scene = bpy.context.scene
    scene.render.engine = "BLENDER_WORKBENCH"
    add("square", mesh("square"))
    assert bpy.ops.regraft.render_preview() == {"FINISHED"}
    assert scene.render.engine == "BLENDER_WORKBENCH"
    assert part("session").last_statistics()["triangles"] == 2
    scene.camera.data.clip_start, scene.camera.data.clip_end = 5, 1
    raises(RuntimeError, bpy.ops.regraft.render_preview)
    assert scene.render.engine == "BLENDER_WORKBENCH"
    scene.camera = None
    assert not bpy.ops.regraft.render_preview.poll()


def check_a_previewed_animation_writes_its_frames() -> None:
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.frame_start, scene.frame_end = 3, 5
    scene.render.filepath = str(TEMPORARY / "animation_")
    add("square", mesh("square"))
    assert bpy.ops.regraft.preview_animation() == {"FINISHED"}
    assert scene.render.engine == "CYCLES"
    names = sorted(path.name for path in TEMPORARY.glob("animation_*"))
    assert names == [f"animation_000{n}.png" for n in (3, 4, 5)]
    assert [row["frame"] for row in part("session").history()] == [3, 4, 5]


def check_settings_have_the_names_the_library_knows() -> None:
    settings = bpy.context.scene.regraft
    scene = part("compat").native().Scene()
    triangle = [(0, 0, 0), (1, 0, 0), (0, 1, 0)]
    import numpy as np

    scene.add_instance(scene.add_mesh(np.array(triangle, np.float32), np.uint32([[0, 1, 2]])))
    choices = {
        name: settings.bl_rna.properties[name].enum_items.keys()
        for name in ("policy", "structure", "layout")
    }
    for name, values in choices.items():
        for value in values:
            scene.update(**{name: value})


def check_what_the_panels_write() -> None:
    panels = part("ui.panels")
    assert panels.wrapped("a bc def", 4) == ["a bc", "def"]
    assert panels.wrapped("unbreakable", 4) == ["unbreakable"]
    assert panels.wrapped("", 9) == [""]
    assert panels.readable("trace_ms", 1234.5) == "1,234 ms"
    assert panels.words("memory_bytes") == "Memory"
    assert panels.words("kdtree_built_fraction") == "K-d tree built fraction"
    assert panels.readable("trace_ms", 12.345) == "12.35 ms"
    assert panels.readable("memory_bytes", 3 * 2**20) == "3.0 MiB"
    assert panels.readable("triangles", 1234567) == "1,234,567"
    assert panels.readable("kdtree_built_fraction", 0.25) == "25.0%"
    assert panels.readable("policy", "refit") == "refit"


def check_every_statistic_is_on_the_panel() -> None:
    add("square", mesh("square"))
    statistics = render()
    panels = part("ui.panels")
    shown = {name for _, names in panels.GROUPS for name in names} | set(panels.TIMES)
    shown |= {"frame", "total_ms", "left_out", "warnings"}
    assert shown == set(statistics), shown ^ set(statistics)


run(globals())
