"""Final frames: passes, progress, cancelling, and what happens when something is wrong."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy as np
from harness import (
    TEMPORARY,
    add,
    grid,
    mesh,
    native,
    part,
    planes,
    raises,
    render,
    run,
)

OBJECT_INDEX = "Object Index" if bpy.app.version >= (5, 0, 0) else "IndexOB"


def all_passes() -> None:
    layer = bpy.context.view_layer
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_object_index = True
    layer.regraft.use_pass_cost = True


def check_passes_hold_what_blender_means_by_them() -> None:
    all_passes()
    add("square", mesh("square"), (0, 0, 2)).pass_index = 5
    with planes() as passes:
        render()
    assert set(passes) == {"Combined", "Depth", "Normal", OBJECT_INDEX, "Cost"}
    seen = passes[OBJECT_INDEX][..., 0] == 5
    assert 0 < seen.sum() < seen.size
    # Depth is along the view axis, so a plane that faces the camera has one.
    assert np.allclose(passes["Depth"][seen], 8.0, atol=1e-4)
    assert (passes["Depth"][~seen] == 1e10).all()
    assert np.allclose(passes["Normal"][seen], (0, 0, 1), atol=1e-5)
    assert (passes["Normal"][~seen] == 0).all()
    assert (passes[OBJECT_INDEX][~seen] == 0).all()
    assert (passes["Cost"][seen] > 0).all()
    assert (passes["Combined"][..., 3] == 1).all()


def check_only_the_passes_asked_for_are_made() -> None:
    add("square", mesh("square"))
    with planes() as passes:
        render()
    assert set(passes) == {"Combined"}


def check_the_first_row_is_at_the_bottom() -> None:
    bpy.context.scene.render.film_transparent = True
    add("upper", mesh("upper"), (0, 2, 0))
    with planes() as passes:
        render()
    alpha = passes["Combined"][..., 3]
    assert alpha[12:].sum() > 0
    assert alpha[:10].sum() == 0


def check_a_transparent_film_and_an_opaque_one() -> None:
    scene = bpy.context.scene
    world = scene.world = bpy.data.worlds.new("world")
    if world.node_tree is None:
        world.color = (0.25, 0.5, 0.75)
    else:
        world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.25, 0.5, 0.75, 1)
    scene.regraft.shading = "direct"
    add("square", mesh("square"))
    corners = []
    for transparent in (False, True):
        scene.render.film_transparent = transparent
        with planes() as passes:
            render()
        corners.append(passes["Combined"][0, 0].tolist())
    assert corners == [[0.25, 0.5, 0.75, 1.0], [0.0, 0.0, 0.0, 0.0]]


def check_every_shading_and_policy_and_layout_works() -> None:
    scene = bpy.context.scene
    add("square", grid("grid", 5))
    settings = scene.regraft
    for name in ("shading", "policy", "structure", "layout"):
        for value in settings.bl_rna.properties[name].enum_items.keys():  # noqa: SIM118
            setattr(settings, name, value)
            statistics = render()
            assert statistics["triangles"] == 50
    settings.samples = 4
    assert render()["rays_primary"] == 4 * 32 * 24


def check_a_headlight_on_request() -> None:
    scene = bpy.context.scene
    scene.regraft.shading = "direct"
    add("square", mesh("square"))
    light = bpy.data.lights.new("sun", "SUN")
    light.energy = 0
    add("sun", light)
    levels = []
    for headlight in (False, True):
        scene.regraft.use_headlight = headlight
        with planes() as passes:
            render()
        levels.append(float(passes["Combined"][12, 16, 0]))
    assert levels[0] == 0.0
    assert levels[1] > 0.1


def check_the_number_of_threads_is_taken_over() -> None:
    scene = bpy.context.scene
    add("square", mesh("square"))
    render()
    first = native()
    scene.regraft.threads = 1
    render()
    assert native() is not first
    options = part("session").Options
    scene.regraft.threads = 0
    scene.render.threads_mode, scene.render.threads = "FIXED", 3
    assert options.of(scene).threads == 3
    scene.render.threads_mode = "AUTO"
    assert options.of(scene).threads == 0


def check_a_png_file_is_what_was_traced() -> None:
    scene = bpy.context.scene
    scene.view_settings.view_transform = "Standard"
    add("square", mesh("square"), (0, 0, 3))
    scene.render.image_settings.file_format = "PNG"
    scene.render.filepath = str(TEMPORARY / "picture.png")
    with planes() as passes:
        bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(scene.render.filepath)
    got = np.array(image.pixels[:]).reshape(24, 32, 4)[..., 0]
    linear = passes["Combined"][..., 0]
    encoded = np.where(linear <= 0.0031308, linear * 12.92, 1.055 * linear ** (1 / 2.4) - 0.055)
    assert np.abs(got - encoded).max() < 1.5 / 255


def check_every_view_layer_gets_its_own_picture() -> None:
    scene = bpy.context.scene
    scene.render.film_transparent = True
    away = bpy.data.collections.new("away")
    scene.collection.children.link(away)
    away.objects.link(bpy.data.objects.new("square", mesh("square")))
    scene.view_layers.new("empty").layer_collection.children["away"].exclude = True
    with planes() as passes:
        render()
    assert len(part("session")._sessions) == 2
    assert passes["Combined"][..., 3].max() == 0.0, "the last layer is the empty one"
    assert [row["instances"] for row in part("session").history()] == [1, 0]


class Engine:
    """What a FinalFrame needs of an engine, in a Python process without a window to press ESC in:
    everything goes to the real engine but `test_break`."""

    def __init__(self, engine: bpy.types.RenderEngine) -> None:
        self.engine = engine
        self.fractions: list[float] = []

    def __getattr__(self, name: str) -> object:
        return getattr(self.engine, name)

    def update_progress(self, fraction: float) -> None:
        self.fractions.append(fraction)

    def test_break(self) -> bool:
        return bool(self.fractions)


def check_esc_cancels_and_leaves_what_is_finished() -> None:
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 640, 480
    scene.regraft.shading, scene.regraft.samples = "occlusion", 256
    add("grid", grid("grid", 40))
    engine, final = part("engine").RegraftEngine, part("final_render").FinalFrame
    render_method, engines = engine.render, []

    def cancelled(self: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph) -> None:
        engines.append(Engine(self))
        final(engines[0], depsgraph).render()

    engine.render = cancelled
    try:
        statistics = render()
    finally:
        engine.render = render_method
    assert engines[0].fractions, "no progress was told"
    assert max(engines[0].fractions) < 1
    assert statistics["rays_primary"] < 256 * 640 * 480
    scene.regraft.samples = 1
    assert render()["rays_primary"] == 640 * 480


def check_no_camera_is_an_error_that_says_so() -> None:
    scene = bpy.context.scene
    add("square", mesh("square"))
    scene.camera = None
    assert "camera" in raises(RuntimeError, bpy.ops.render.render)
    # Blender asks for a camera itself; the engine must not rely on it.
    frame = part("final_render")
    engine = SimpleNamespace(camera_override=None)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    message = raises(frame.RenderError, lambda: frame.FinalFrame(engine, depsgraph))
    assert scene.name in message
    assert "no camera" in message
    scene.camera = add("cube", mesh("cube"))
    depsgraph.update()
    raises(frame.RenderError, lambda: frame.FinalFrame(engine, depsgraph))


def check_a_camera_that_cannot_be_is_named() -> None:
    scene = bpy.context.scene
    add("square", mesh("square"))
    scene.camera.data.clip_start, scene.camera.data.clip_end = 5, 1
    message = raises(RuntimeError, bpy.ops.render.render)
    assert "camera" in message
    assert "clip" in message
    scene.camera.data.clip_end = 100
    render()


def check_a_picture_without_pixels_is_an_error() -> None:
    scene = bpy.context.scene
    final = part("final_render")
    scene.render.resolution_x = scene.render.resolution_y = 4
    scene.render.resolution_percentage = 1
    assert "0 × 0" in raises(final.RenderError, lambda: final._picture(scene))
    raises(RuntimeError, bpy.ops.render.render)
    scene.render.resolution_percentage = 100
    scene.render.use_border = True
    scene.render.border_min_x = scene.render.border_max_x = 0.5
    picture = final._picture(scene)
    assert "empty" in raises(final.RenderError, lambda: final._region(scene.render, picture))


def check_a_failure_inside_is_reported_and_the_next_frame_is_right() -> None:
    add("square", mesh("square"))
    render()
    delta = part("sync.delta")
    apply = delta.SceneMirror.apply

    def broken(*_arguments: object) -> None:
        raise ValueError('mesh 3 "square": pretended')

    bpy.data.objects["square"].location.z = 1
    delta.SceneMirror.apply = broken
    try:
        message = raises(RuntimeError, bpy.ops.render.render)
    finally:
        delta.SceneMirror.apply = apply
    assert "pretended" in message
    assert not part("session")._sessions, "a session that failed half way must go"
    statistics = render()
    assert statistics["triangles"] == 2
    assert native().bounds()[1, 2] > 0.99


def check_a_missing_library_is_reported_in_words() -> None:
    compat = part("compat")
    compat._state.clear()
    compat._state["problem"] = "The native library 'regraft' could not be loaded: pretended"
    try:
        assert "could not be loaded" in raises(RuntimeError, bpy.ops.render.render)
        assert not bpy.ops.regraft.render_preview.poll()
        assert "pretended" in compat.problem()
    finally:
        compat.forget()
    assert compat.problem() == ""
    render()


def check_statistics_reach_listeners_and_the_file() -> None:
    session = part("session")
    add("square", mesh("square"))
    rows = []

    def broken(_statistics: object) -> None:
        raise RuntimeError("a listener's own fault")

    def listener(statistics: object) -> None:
        rows.append(dict(statistics.as_dict()))

    for function in (broken, listener):
        session.add_frame_listener(function)
    try:
        render(3)
    finally:
        for function in (broken, listener, listener):
            session.remove_frame_listener(function)
    assert [row["frame"] for row in rows] == [3]
    assert rows[0] == session.last_statistics()
    for name in ("extract_ms", "evaluate_ms", "trace_ms"):
        assert rows[0][name] > 0, name
    path = TEMPORARY / "statistics.jsonl"
    assert bpy.ops.regraft.save_statistics(filepath=str(path)) == {"FINISHED"}
    assert [json.loads(line) for line in path.read_text().splitlines()] == rows


def check_statistics_that_cannot_be_saved_leave_nothing_behind() -> None:
    add("square", mesh("square"))
    render()
    missing = TEMPORARY / "missing" / "statistics.jsonl"
    assert str(missing) in raises(
        RuntimeError, lambda: bpy.ops.regraft.save_statistics(filepath=str(missing))
    )
    operators = part("ui.operators")
    path = TEMPORARY / "kept.jsonl"
    path.write_text("old\n")

    def fails(*_arguments: object) -> None:
        raise OSError(28, "No space left on device")

    replace, os.replace = os.replace, fails
    try:
        raises(OSError, lambda: operators.write_lines(path, [{"frame": 1}]))
    finally:
        os.replace = replace
    assert path.read_text() == "old\n"
    assert not list(TEMPORARY.glob(".kept*"))


def check_numbers_that_json_cannot_write_become_null() -> None:
    path = Path(TEMPORARY / "odd.jsonl")
    part("ui.operators").write_lines(path, [{"a": math.inf, "b": 1.5, "c": ["x"], "d": math.nan}])
    assert json.loads(path.read_text()) == {"a": None, "b": 1.5, "c": ["x"], "d": None}


def check_no_statistics_before_the_first_frame() -> None:
    assert not bpy.ops.regraft.save_statistics.poll()
    assert part("session").last_statistics() is None


run(globals())
