"""Cameras see what Blender's see: points fall on the pixels that Blender says."""

from __future__ import annotations

import itertools
import math
from types import SimpleNamespace

import bpy
import numpy as np
from bpy_extras.object_utils import world_to_camera_view
from harness import add, heights, mesh, part, planes, render, run
from mathutils import Euler, Matrix, Vector


def dot(place: Vector, size: float) -> None:
    """A small tetrahedron round a place."""
    points = [place + Vector(v) * size for v in ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1))]
    faces = [(0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)]
    add("dot", mesh("dot", [tuple(p) for p in points], faces))


def seen_at() -> np.ndarray:
    """Centre of what is seen, in shares of the picture from the lower left corner."""
    with planes() as passes:
        render()
    rows, columns = np.nonzero(passes["Combined"][..., 3])
    assert len(rows), "nothing is seen"
    height, width = passes["Combined"].shape[:2]
    return np.array([(columns.mean() + 0.5) / width, (rows.mean() + 0.5) / height])


def stage(width: int, height: int) -> bpy.types.Object:
    """A camera that looks askew, and a transparent background."""
    scene = bpy.context.scene
    scene.render.film_transparent = True
    scene.render.resolution_x, scene.render.resolution_y = width, height
    camera = scene.camera
    camera.location, camera.rotation_euler = (3, -4, 2), Euler((1.2, 0.3, 0.5))
    bpy.context.view_layer.update()
    return camera


def ahead(camera: bpy.types.Object, x: float, y: float, distance: float = 5) -> Vector:
    """A point in front of the camera."""
    return camera.matrix_world @ Vector((x, y, -distance))


def check_perspective_with_shift_fit_and_pixel_aspect() -> None:
    render_settings = bpy.context.scene.render
    cases = itertools.product(("AUTO", "HORIZONTAL", "VERTICAL"), ((160, 90), (90, 160)), (1, 2))
    camera = stage(160, 90)
    dot(ahead(camera, 0.3, 0.2), 0.05)
    camera.data.lens, camera.data.shift_x, camera.data.shift_y = 30, 0.1, -0.05
    camera.data.sensor_width, camera.data.sensor_height = 30, 20
    for fit, (width, height), aspect in cases:
        camera.data.sensor_fit = fit
        render_settings.resolution_x, render_settings.resolution_y = width, height
        render_settings.pixel_aspect_x, render_settings.pixel_aspect_y = aspect, 1
        bpy.context.view_layer.update()
        expected = world_to_camera_view(bpy.context.scene, camera, ahead(camera, 0.3, 0.2))
        assert np.allclose(seen_at(), expected[:2], atol=0.02), (fit, width, aspect)
        arguments, _ = part("sync.camera_reader").read_camera(
            camera, part("sync.camera_reader").Picture.of(render_settings)
        )
        corners = np.array(camera.data.view_frame(scene=bpy.context.scene))
        corners = corners[:, :2] / -corners[:, 2:]
        left, right, bottom, top = arguments["window"]
        assert np.allclose(corners.min(axis=0), (left, bottom), atol=1e-5), (fit, width, aspect)
        assert np.allclose(corners.max(axis=0), (right, top), atol=1e-5), (fit, width, aspect)


def check_orthographic_with_shift() -> None:
    camera = stage(120, 80)
    camera.data.type, camera.data.ortho_scale = "ORTHO", 6
    camera.data.shift_x, camera.data.shift_y = -0.1, 0.2
    dot(ahead(camera, 0.5, 1.0), 0.2)
    expected = world_to_camera_view(bpy.context.scene, camera, ahead(camera, 0.5, 1.0))
    assert np.allclose(seen_at(), expected[:2], atol=0.01)


def check_a_scaled_camera_sees_as_one_that_is_not() -> None:
    camera = stage(120, 80)
    place = ahead(camera, 0.5, 0.4)
    dot(place, 0.15)
    before = seen_at()
    camera.scale = (3, 0.5, 2)
    assert np.allclose(seen_at(), before, atol=0.01)


def check_clipping() -> None:
    camera = stage(60, 60)
    for distance in (2, 6, 20):
        dot(ahead(camera, 0, 0, distance), 0.3)
    camera.data.clip_start, camera.data.clip_end = 3, 10
    bpy.context.view_layer.use_pass_z = True
    with planes() as passes:
        render()
    depth = passes["Depth"][30, 30, 0]
    assert 5.5 < depth < 6.5, depth


def set_panorama(camera: bpy.types.Camera, **settings: object) -> None:
    """Set Cycles' panorama settings where this version keeps them."""
    camera.type = "PANO"
    holder = camera if hasattr(camera, "panorama_type") else camera.cycles
    for name, value in settings.items():
        setattr(holder, name, value)


def direction(longitude: float, latitude: float) -> Vector:
    """Direction in the camera's frame; longitude to the right of -Z, latitude up."""
    return Vector(
        (
            math.sin(longitude) * math.cos(latitude),
            math.sin(latitude),
            -math.cos(longitude) * math.cos(latitude),
        )
    )


def check_equirectangular() -> None:
    camera = stage(200, 100)
    set_panorama(camera.data, panorama_type="EQUIRECTANGULAR")
    dot(camera.matrix_world @ (direction(1.0, 0.5) * 5), 0.1)
    expected = (0.5 + 1.0 / math.tau, 0.5 + 0.5 / math.pi)
    assert np.allclose(seen_at(), expected, atol=0.01)


def check_part_of_an_equirectangular_picture() -> None:
    camera = stage(200, 100)
    set_panorama(
        camera.data,
        panorama_type="EQUIRECTANGULAR",
        longitude_min=-0.5, longitude_max=1.5, latitude_min=0.0, latitude_max=1.0,
    )  # fmt: skip
    dot(camera.matrix_world @ (direction(1.0, 0.5) * 5), 0.05)
    assert np.allclose(seen_at(), (0.75, 0.5), atol=0.01)


def check_fisheye_equidistant() -> None:
    camera = stage(100, 100)
    set_panorama(camera.data, panorama_type="FISHEYE_EQUIDISTANT", fisheye_fov=math.pi)
    dot(camera.matrix_world @ (direction(1.0, 0.0) * 5), 0.1)
    expected = (0.5 + 1.0 / math.pi, 0.5)
    assert np.allclose(seen_at(), expected, atol=0.01)


def check_fisheye_equisolid() -> None:
    camera = stage(150, 100)
    camera.data.sensor_width = 36
    set_panorama(
        camera.data, panorama_type="FISHEYE_EQUISOLID", fisheye_fov=math.pi, fisheye_lens=10.5
    )
    dot(camera.matrix_world @ (direction(0.8, 0.0) * 5), 0.1)
    expected = (0.5 + 2 * 10.5 * math.sin(0.4) / 36, 0.5)
    assert np.allclose(seen_at(), expected, atol=0.01)


def check_a_panorama_we_lack_is_drawn_as_another_and_said() -> None:
    camera = stage(40, 20)
    set_panorama(camera.data, panorama_type="MIRRORBALL")
    statistics = render()
    assert any("equirectangular" in text for text in statistics["warnings"]), statistics


def check_panorama_settings_without_the_add_on_that_owns_them() -> None:
    reader = part("sync.camera_reader")
    stored = {"cycles": {"panorama_type": 0, "fisheye_fov": 2.0}}
    bare = SimpleNamespace(get=stored.get)
    assert reader._cycles(bare, "panorama_type") == "EQUIRECTANGULAR"
    assert reader._cycles(bare, "fisheye_fov") == 2.0
    assert reader._cycles(bare, "latitude_max") == math.pi / 2


def check_the_border_shows_the_same_pixels_as_the_whole() -> None:
    scene = bpy.context.scene
    camera = stage(64, 48)
    for x in range(-3, 4):
        dot(ahead(camera, x * 0.4, x * 0.3), 0.2)
    with planes() as passes:
        render()
    whole = passes["Combined"]
    scene.render.use_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.8
    scene.render.border_min_y, scene.render.border_max_y = 0.4, 0.9
    for crop in (False, True):
        scene.render.use_crop_to_border = crop
        with planes() as passes:
            render()
        x0, x1 = int(np.float32(0.25) * 64), int(np.float32(0.8) * 64)
        y0, y1 = int(np.float32(0.4) * 48), int(np.float32(0.9) * 48)
        assert np.array_equal(passes["Combined"], whole[y0:y1, x0:x1])


def check_resolution_percentage_and_odd_sizes() -> None:
    scene = bpy.context.scene
    stage(101, 67)
    scene.render.resolution_percentage = 29
    with planes() as passes:
        render()
    assert passes["Combined"].shape == (67 * 29 // 100, 101 * 29 // 100, 4)


def view(camera_matrix: Matrix, projection: Matrix) -> SimpleNamespace:
    """As much of a viewport as its camera is read from."""
    return SimpleNamespace(view_matrix=camera_matrix.inverted(), window_matrix=projection)


def check_viewports_are_read_from_their_projection() -> None:
    reader = part("sync.camera_reader")
    camera = stage(160, 90)
    camera.data.lens, camera.data.shift_x, camera.data.shift_y = 30, 0.1, -0.05
    camera.data.clip_start, camera.data.clip_end = 0.1, 100
    depsgraph = bpy.context.evaluated_depsgraph_get()
    picture = reader.Picture(160, 90)
    for kind in ("PERSP", "ORTHO"):
        camera.data.type = kind
        depsgraph.update()
        projection = camera.calc_matrix_camera(depsgraph, x=160, y=90, scale_x=1, scale_y=1)
        shown = reader.read_view(view(camera.matrix_world, projection), (0.1, 100.0))
        final, _ = reader.read_camera(camera.evaluated_get(depsgraph), picture)
        assert shown["kind"] == final["kind"]
        assert np.allclose(shown["window"], final["window"], atol=1e-5)
        assert np.allclose(shown["matrix"], final["matrix"], atol=1e-5)
        assert np.allclose((shown["clip_near"], shown["clip_far"]), (0.1, 100), rtol=1e-3)


def check_a_panoramic_viewport_shows_more_than_the_frame() -> None:
    reader = part("sync.camera_reader")
    camera = stage(200, 100)
    set_panorama(camera.data, panorama_type="EQUIRECTANGULAR")
    ob = camera.evaluated_get(bpy.context.evaluated_depsgraph_get())
    outline = (-0.5, 1.5, 0.0, 1.0)
    arguments, _ = reader.read_panoramic_view(ob, reader.Picture(200, 100), outline)
    assert np.allclose(arguments["longitude"], (-math.tau, math.tau))
    assert np.allclose(arguments["latitude"], (-math.pi / 2, math.pi / 2))


def check_the_timelines_bound_camera_is_used() -> None:
    scene = bpy.context.scene
    add("square", mesh("square"))
    scene.render.film_transparent = True
    first, other = scene.camera, add("other", bpy.data.cameras.new("other"), (500, 0, 10))
    scene.timeline_markers.new("start", frame=1).camera = first
    scene.timeline_markers.new("cut", frame=5).camera = other
    alphas = []
    with planes() as passes:
        render(1)
        alphas.append(passes["Combined"][..., 3].max())
        render(5)
        alphas.append(passes["Combined"][..., 3].max())
    assert alphas == [1.0, 0.0], alphas
    assert heights((0, 0)) == [0.0]


run(globals())
