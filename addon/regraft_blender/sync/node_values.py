"""What a shader node's inputs come to when a preview has one value for a whole surface."""

from __future__ import annotations

from typing import Any

import bpy

Colour = tuple[float, float, float]
MAX_NODES_DEEP = 32
# Nodes that change a colour, but not beyond recognition.
PASS_ON = {"HUE_SAT", "BRIGHTCONTRAST", "GAMMA", "CURVE_RGB"}


def uses_nodes(block: bpy.types.Material | bpy.types.World) -> bool:
    """True if a material or world is made of nodes; from 5.0 on all are, and asking warns."""
    return block.node_tree is not None and (bpy.app.version >= (5, 0, 0) or block.use_nodes)


def source(socket: Any) -> Any:
    """The node linked to a socket, past reroutes; None if there is none."""
    for _ in range(MAX_NODES_DEEP):
        if not socket.is_linked or not socket.links:
            return None
        node = socket.links[0].from_node
        if node.type != "REROUTE":
            return node
        socket = node.inputs[0]
    return None


def colour(node: Any, names: tuple[str, ...], instead: Colour) -> Colour:
    """The colour of the node's first input of these names; `instead` where a texture drives it."""
    socket = _input(node, names)
    known = None if socket is None else _constant(socket, MAX_NODES_DEEP)
    return instead if known is None else known


def number(node: Any, names: tuple[str, ...], instead: float) -> float:
    """The number of the node's first input of these names; `instead` where a texture drives it."""
    socket = _input(node, names)
    if socket is None:
        return instead
    feeding = source(socket)
    if feeding is None:
        return float(socket.default_value)
    return float(feeding.outputs[0].default_value) if feeding.type == "VALUE" else instead


def scaled(value: Colour, strength: float) -> Colour:
    """A colour, brighter or darker."""
    return (value[0] * strength, value[1] * strength, value[2] * strength)


def _input(node: Any, names: tuple[str, ...]) -> Any:
    return next((node.inputs[name] for name in names if name in node.inputs), None)


def _constant(socket: Any, depth: int) -> Colour | None:
    """A colour socket's value, or None if it differs over the surface in a way nobody can guess.

    A ramp counts as the mean of its stops; mixed colours as mixed, whatever the blend mode.
    """
    node = source(socket)
    if node is None:
        return _plain(socket.default_value)
    if depth == 0:
        return None
    if node.type == "RGB":
        return _plain(node.outputs[0].default_value)
    if node.type == "VALTORGB":
        return _mean([_plain(stop.color) for stop in node.color_ramp.elements])
    if node.type in PASS_ON:
        return _constant(node.inputs["Color"], depth - 1)
    if node.type in {"MIX", "MIX_RGB"}:
        sides = [_constant(s, depth - 1) for s in node.inputs if s.type == "RGBA"]
        return _mixed(sides, number(node, ("Factor", "Fac"), 0.5))
    return None


def _mixed(sides: list[Colour | None], share: float) -> Colour | None:
    """Two colours mixed; one that is unknown gives way to the other."""
    known = [side for side in sides if side is not None]
    if len(known) < 2:
        return known[0] if known else None
    first, second = known[:2]
    return _mean([scaled(first, 2 * (1 - share)), scaled(second, 2 * share)])


def _mean(colours: list[Colour]) -> Colour:
    sums = [sum(parts) / len(colours) for parts in zip(*colours, strict=True)]
    return sums[0], sums[1], sums[2]


def _plain(value: Any) -> Colour:
    return float(value[0]), float(value[1]), float(value[2])
