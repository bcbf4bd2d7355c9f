"""Boxes of nodes over the viewports, in a real window."""

from __future__ import annotations

from typing import Any

import bpy
import numpy as np
from harness import CUBE, SIDES, TEMPORARY, add, blank, mesh, part
from window import Waiting, here, redrawn, region, run, space

YELLOW = np.array((1.0, 0.75, 0.1))


def stage() -> Any:
    """A cube in a rendered viewport that shows nothing else."""
    scene = blank()
    scene.regraft.viewport_samples = 1
    cube = add("cube", mesh("cube", np.array(CUBE), SIDES))
    view = space().region_3d
    view.view_perspective = "PERSP"
    view.view_location, view.view_distance = (0, 0, 0), 8
    space().shading.type = "RENDERED"
    space().overlay.show_overlays = True
    for name in ("show_floor", "show_axis_x", "show_axis_y", "show_cursor", "show_text"):
        setattr(space().overlay, name, False)
    space().show_gizmo = False
    return cube


def screen() -> np.ndarray:
    """What the viewport shows: (H, W, 3), first row at the bottom."""
    path = str(TEMPORARY / "screen.png")
    with here():
        bpy.ops.screen.screenshot(filepath=path)
    image = bpy.data.images.load(path)
    pixels = np.array(image.pixels[:], np.float32).reshape(image.size[1], image.size[0], 4)
    bpy.data.images.remove(image)
    seen = region()
    return pixels[seen.y : seen.y + seen.height, seen.x : seen.x + seen.width, :3]


def yellow() -> int:
    """Pixels in the colour of nodes that were made anew."""
    return int((np.abs(screen() - YELLOW).max(axis=2) < 0.1).sum())


def check_boxes_are_drawn_where_they_are_asked_for() -> Waiting:
    stage()
    yield redrawn()
    assert yellow() == 0
    settings = bpy.context.scene.regraft
    settings.show_nodes = True
    yield redrawn()
    assert yellow() > 100
    space().overlay.show_overlays = False
    yield redrawn()
    assert yellow() == 0
    space().overlay.show_overlays = True
    settings.show_nodes = False
    yield redrawn()
    assert yellow() == 0


def check_boxes_follow_what_moves() -> Waiting:
    cube = stage()
    bpy.context.scene.regraft.show_nodes = True
    yield redrawn()
    cube.location = (0, 0, 3)
    yield redrawn()
    kept = part("session").seen_by(bpy.context.scene, bpy.context.view_layer, space())
    nodes = kept.nodes_at(0)
    assert np.allclose(nodes.boxes, [[(-1, -1, 2), (1, 1, 4)]], atol=1e-3), nodes


run(globals())
