"""The rendered viewport in a real window, and the buttons that render in the background."""

from __future__ import annotations

import math
from typing import Any

import bpy
import numpy as np
from bpy_extras.view3d_utils import location_3d_to_region_2d
from harness import CUBE, SIDES, TEMPORARY, add, blank, grid, mesh, paint, part
from mathutils import Quaternion, Vector
from window import (
    Waiting,
    area,
    centre,
    here,
    is_finished,
    picture,
    redrawn,
    region,
    run,
    space,
    viewport,
)

PLACE = Vector((0.7, 0.4, 0.3))


def stage() -> Any:
    """A small cube on a transparent background, seen askew in a rendered viewport."""
    scene = blank()
    scene.render.film_transparent = True
    scene.regraft.viewport_samples = 1
    cube = add("cube", mesh("cube", np.array(CUBE) * 0.15, SIDES))
    cube.location = PLACE
    view = space().region_3d
    view.view_perspective = "PERSP"
    view.view_location, view.view_distance = (0.5, 0, 0), 6
    view.view_rotation = Quaternion((0.8, 0.5, 0.2, 0.25)).normalized()
    space().shading.type = "RENDERED"
    space().overlay.show_overlays = False
    return cube


def expected(place: Vector = PLACE) -> np.ndarray:
    """Where Blender says that a place is in the region."""
    return np.array(location_3d_to_region_2d(region(), space().region_3d, place))


def check_perspective_and_parallel_views() -> Waiting:
    stage()
    yield redrawn()
    assert picture().shape == (region().height, region().width, 4)
    assert np.abs(centre() - expected()).max() < 4
    space().region_3d.view_perspective = "ORTHO"
    yield redrawn()
    assert np.abs(centre() - expected()).max() < 4


def check_views_through_the_camera_with_zoom_and_offset() -> Waiting:
    stage()
    camera = bpy.context.scene.camera
    camera.location, camera.rotation_euler = (2, -5, 3), (1.1, 0.1, 0.3)
    camera.data.shift_x = 0.1
    view = space().region_3d
    view.view_perspective = "CAMERA"
    for kind, zoom, offset in (
        ("PERSP", 0, (0, 0)), ("PERSP", 20, (0.1, -0.05)), ("ORTHO", -10, (0, 0.1)),
    ):  # fmt: skip
        camera.data.type, view.view_camera_zoom, view.view_camera_offset = kind, zoom, offset
        yield redrawn()
        assert np.abs(centre() - expected()).max() < 5, (kind, zoom, centre(), expected())


def check_a_panoramic_camera_is_traced_as_one() -> Waiting:
    stage()
    scene = bpy.context.scene
    camera = scene.camera
    camera.location, camera.rotation_euler = (0, 0, 0), (math.pi / 2, 0, 0)
    camera.data.type = "PANO"
    camera.data.cycles.panorama_type = "EQUIRECTANGULAR"
    scene.render.resolution_x, scene.render.resolution_y = 200, 100
    view = space().region_3d
    view.view_perspective, view.view_camera_zoom = "CAMERA", 0
    view.view_camera_offset = (0, 0)
    yield redrawn()
    assert viewport()._job.request.camera.kind == "equirectangular"
    direction = PLACE.normalized()
    longitude = math.atan2(direction.x, direction.y)
    corners = [camera.matrix_world @ v for v in camera.data.view_frame(scene=scene)]
    flat = np.array([location_3d_to_region_2d(region(), view, c) for c in corners])
    low, high = flat.min(axis=0), flat.max(axis=0)
    shares = np.array([0.5 + longitude / math.tau, 0.5 + math.asin(direction.z) / math.pi])
    assert np.abs(picture().shape[1] - (high - low)[0]) <= 2, "only the frame is traced"
    assert np.abs(centre() - shares * (high - low)).max() < 8


def check_what_moves_is_seen_to_move() -> Waiting:
    cube = stage()
    yield redrawn()
    before, session = centre(), viewport()._session
    cube.location.x += 0.5
    yield redrawn()
    assert np.abs(centre() - before).max() > 10
    assert np.abs(centre() - expected(cube.location)).max() < 4
    assert viewport()._session is session
    bpy.data.objects.remove(cube)
    yield redrawn()
    assert picture()[..., 3].max() == 0


def check_colours_reach_the_screen() -> Waiting:
    cube = stage()
    bpy.context.scene.view_settings.view_transform = "Standard"
    cube.location, cube.scale = space().region_3d.view_location, (20, 20, 20)
    material = paint("light", (0, 0, 0, 1))
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    light, out = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
    light.inputs["Color"].default_value = (1.0, 0.25, 0.0, 1)
    material.node_tree.links.new(light.outputs[0], out.inputs["Surface"])
    cube.data.materials.append(material)
    bpy.context.scene.regraft.shading = "direct"
    yield redrawn()
    path = str(TEMPORARY / "screen.png")
    with here():
        bpy.ops.screen.screenshot(filepath=path)
    image = bpy.data.images.load(path)
    pixels = np.array(image.pixels[:]).reshape(image.size[1], image.size[0], 4)
    x, y = region().x + region().width // 2, region().y + region().height // 2
    assert np.abs(pixels[y, x, :3] - (1.0, 0.537, 0.0)).max() < 0.02, pixels[y, x]


def check_samples_come_one_after_another() -> Waiting:
    stage()
    bpy.context.scene.regraft.viewport_samples = 12
    yield redrawn()
    assert viewport()._drawn.samples == 12
    alpha = picture()[..., 3]
    assert ((alpha > 0.1) & (alpha < 0.9)).any(), "edges are smooth"


def check_borders_restrict_the_picture() -> Waiting:
    stage()
    view = space()
    view.use_render_border = True
    view.render_border_min_x, view.render_border_max_x = 0.25, 0.75
    view.render_border_min_y, view.render_border_max_y = 0.5, 1.0
    yield redrawn()
    width, height = region().width, region().height
    assert abs(picture().shape[1] - width / 2) <= 1
    assert abs(picture().shape[0] - height / 2) <= 1
    view.use_render_border = False
    scene = bpy.context.scene
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.0, 0.5
    scene.render.border_min_y, scene.render.border_max_y = 0.0, 1.0
    view.region_3d.view_perspective = "CAMERA"
    yield redrawn()
    assert picture().shape[1] < width / 2


def check_another_size_and_local_view() -> Waiting:
    stage()
    other = add("other", mesh("other", np.array(CUBE) * 0.1, SIDES), (-0.6, 0, 0))
    yield redrawn()
    both, wide = (picture()[..., 3] > 0).sum(), picture().shape[1]
    space().show_region_toolbar = not space().show_region_toolbar
    space().show_region_ui = not space().show_region_ui
    with here():
        bpy.ops.screen.screen_full_area()
    yield redrawn()
    assert picture().shape[:2] == (region().height, region().width)
    assert picture().shape[1] != wide
    with here():
        bpy.ops.screen.back_to_previous()
    yield redrawn()
    for ob in bpy.context.scene.objects:
        ob.select_set(ob is other)
    with here():
        bpy.ops.view3d.localview(frame_selected=False)
    yield redrawn()
    alone = (picture()[..., 3] > 0).sum()
    assert 0 < alone < both
    with here():
        bpy.ops.view3d.localview(frame_selected=False)
    yield redrawn()
    space().show_object_viewport_mesh = False
    yield redrawn()
    assert picture()[..., 3].max() == 0
    space().show_object_viewport_mesh = True


def check_playback_shows_frames() -> Waiting:
    cube = stage()
    wave = cube.modifiers.new("array", "ARRAY")
    wave.relative_offset_displace = (2, 0, 0)
    driver = wave.driver_add("count").driver
    driver.type, driver.expression = "SCRIPTED", "1 + frame % 5"
    for frame, x in ((1, 0), (20, 1)):
        cube.location.x = x
        cube.keyframe_insert("location", frame=frame)
    yield redrawn()
    start = bpy.context.scene.frame_current
    with here():
        bpy.ops.screen.animation_play()
    yield lambda: bpy.context.scene.frame_current > start + 5
    with here():
        bpy.ops.screen.animation_cancel(restore_frame=False)
    yield redrawn()
    assert picture()[..., 3].max() > 0


def check_undo_is_followed() -> Waiting:
    cube = stage()
    with here():
        bpy.ops.ed.undo_push(message="before")
    yield redrawn()
    before = centre()
    cube.location.x += 0.5
    with here():
        bpy.ops.ed.undo_push(message="after")
    yield redrawn()
    assert np.abs(centre() - before).max() > 10
    with here():
        bpy.ops.ed.undo()
    yield redrawn()
    assert np.abs(centre() - before).max() < 2


def busy() -> None:
    """Give the viewport work for minutes."""
    settings = bpy.context.scene.regraft
    settings.shading, settings.viewport_samples = "occlusion", 4096
    add("grid", grid("grid", 200))
    area().tag_redraw()


def check_loading_a_file_while_a_viewport_renders() -> Waiting:
    stage()
    path = str(TEMPORARY / "viewport.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    yield redrawn()
    busy()
    yield lambda: viewport()._job.is_running()
    old = viewport()
    bpy.ops.wm.open_mainfile(filepath=path, load_ui=False)
    yield lambda: not old._job.is_running()
    yield redrawn()
    assert viewport()._job.request.samples == 1


def check_leaving_the_rendered_view_stops_the_thread() -> Waiting:
    stage()
    yield redrawn()
    busy()
    yield lambda: viewport()._job.is_running()
    job = viewport()._job
    space().shading.type = "SOLID"
    yield lambda: not job.is_running()
    yield lambda: not part("session")._sessions


def check_an_error_is_written_into_the_viewport_and_overcome() -> Waiting:
    cube = stage()
    yield redrawn()
    engine = viewport()._engine()
    delta = part("sync.delta")
    apply = delta.SceneMirror.apply

    def broken(*_arguments: object) -> None:
        raise ValueError("pretended")

    delta.SceneMirror.apply = broken
    cube.location.x += 0.2
    area().tag_redraw()
    yield lambda: "pretended" in engine._complaint
    delta.SceneMirror.apply = apply
    yield redrawn()
    assert np.abs(centre() - expected(cube.location)).max() < 4


def check_the_buttons_render_in_the_background() -> Waiting:
    stage()
    scene = bpy.context.scene
    space().shading.type = "SOLID"
    scene.render.engine, scene.render.use_persistent_data = "BLENDER_WORKBENCH", False
    session = part("session")
    with here():
        bpy.ops.regraft.render_preview("INVOKE_DEFAULT")
    yield lambda: not bpy.app.is_job_running("RENDER") and bool(session.last_statistics())
    yield lambda: scene.render.engine == "BLENDER_WORKBENCH"
    assert scene.render.use_persistent_data is False
    scene.frame_start, scene.frame_end = 1, 3
    with here():
        bpy.ops.regraft.preview_animation("INVOKE_DEFAULT")
    yield lambda: not bpy.app.is_job_running("RENDER") and len(session.history()) == 3
    yield lambda: scene.render.engine == "BLENDER_WORKBENCH"


def check_disabling_while_a_viewport_renders() -> Waiting:
    stage()
    yield redrawn()
    busy()
    yield lambda: viewport()._job.is_running()
    job = viewport()._job
    part().unregister()
    assert not job.is_running()
    yield lambda: True
    area().tag_redraw()
    yield lambda: True
    part().register()
    bpy.context.scene.render.engine = "REGRAFT"
    bpy.context.scene.regraft.viewport_samples = 1
    space().shading.type = "RENDERED"
    yield redrawn()
    assert is_finished()


run(globals())
