"""Boxes of the trees' nodes over the viewport, coloured by what is lost in them."""

from __future__ import annotations

import logging
from typing import Any

import bpy
import gpu
import numpy as np
import numpy.typing as npt
from gpu_extras.batch import batch_for_shader

from .. import session

log = logging.getLogger(__name__)

# The worst of more boxes than this are drawn; more would hide one another.
MOST_BOXES = 4096
# Colours of a node without damage and of one that costs twice what it should, and of one that is
# new in this frame.
SOUND = np.array((0.25, 0.55, 0.90, 0.45), np.float32)
DAMAGED = np.array((0.95, 0.15, 0.10, 0.95), np.float32)
REBUILT = np.array((1.00, 0.75, 0.10, 1.00), np.float32)
WORST = 0.5
# Corners of a box by (x, y, z) in {lowest, highest}, and its twelve edges.
CORNERS = np.array([(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)])
EDGES = np.array(
    [(a, b) for a in range(8) for b in range(a) if np.abs(CORNERS[a] - CORNERS[b]).sum() == 1]
)
SHADER = "FLAT_COLOR" if bpy.app.version >= (4, 0, 0) else "3D_FLAT_COLOR"

_handlers: list[Any] = []
# What is drawn: the nodes it was made of, and the batch. One entry a viewport.
_batches: dict[int, tuple[object, Any]] = {}


def edges(boxes: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """Ends of the edges of boxes (N, 2, 3): (N, 12, 2, 3)."""
    corners = boxes[:, CORNERS, np.arange(3)]
    return np.ascontiguousarray(corners[:, EDGES], np.float32)


def colours(damage: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """One colour a node, from sound to damaged: (N, 4)."""
    share = np.clip(np.nan_to_num(damage) / WORST, 0.0, 1.0).astype(np.float32)[:, None]
    return SOUND + share * (DAMAGED - SOUND)


def worst(damage: npt.NDArray[np.float64], most: int = MOST_BOXES) -> npt.NDArray[np.intp]:
    """Which nodes are drawn, the most damaged last so that they are on top."""
    return np.argsort(damage, kind="stable")[-most:]


def lines(nodes: session.Nodes) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]:
    """Ends of lines (M, 3) and their colours (M, 4)."""
    chosen = worst(nodes.damage)
    rebuilt = nodes.rebuilt[:MOST_BOXES]
    boxes = np.concatenate((nodes.boxes[chosen], rebuilt))
    colour = np.concatenate(
        (colours(nodes.damage[chosen]), np.broadcast_to(REBUILT, (len(rebuilt), 4)))
    )
    points = edges(boxes).reshape(-1, 3)
    return points, np.repeat(colour, 24, axis=0)


def draw() -> None:
    """Draws over the viewport that is just being drawn."""
    context = bpy.context
    settings = context.scene.regraft
    if not settings.show_nodes or not context.space_data.overlay.show_overlays:
        return
    kept = session.seen_by(context.scene, context.view_layer, context.space_data)
    nodes = kept.nodes_at(settings.node_depth) if kept is not None else None
    if nodes is None or not len(nodes.boxes) + len(nodes.rebuilt):
        return
    gpu.state.blend_set("ALPHA")
    gpu.state.depth_test_set("NONE")
    shader, batch = _batch(context.space_data.as_pointer(), nodes)
    shader.bind()
    batch.draw(shader)
    gpu.state.blend_set("NONE")


def _batch(viewport: int, nodes: session.Nodes) -> tuple[Any, Any]:
    shader = gpu.shader.from_builtin(SHADER)
    known = _batches.get(viewport)
    if known is None or known[0] is not nodes:
        points, colour = lines(nodes)
        batch = batch_for_shader(shader, "LINES", {"pos": points, "color": colour})
        known = _batches[viewport] = (nodes, batch)
    return shader, known[1]


def attach() -> None:
    """Draw over all viewports from now on."""
    if not _handlers:
        _handlers.append(bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", "POST_VIEW"))


def detach() -> None:
    """Stop drawing."""
    while _handlers:
        bpy.types.SpaceView3D.draw_handler_remove(_handlers.pop(), "WINDOW")
    _batches.clear()
