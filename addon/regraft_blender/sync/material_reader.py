"""Materials and worlds, reduced to what a preview shows: one colour and a few numbers each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from .delta import MaterialTable

Colour = tuple[float, float, float]
BLACK: Colour = (0.0, 0.0, 0.0)
MAX_NODES_DEEP = 32
UNSEEN = {"BSDF_TRANSPARENT", "HOLDOUT"}


@dataclass(frozen=True)
class Look:
    """How a surface looks; linear colours."""

    base_color: tuple[float, float, float, float] = (0.8, 0.8, 0.8, 1.0)
    metallic: float = 0.0
    roughness: float = 0.5
    emission: Colour = BLACK


class Materials:
    """The scene's materials in a table; row 0 is the look of a surface without a material."""

    def __init__(self) -> None:
        self._looks = [Look()]
        self._rows: dict[int, int] = {}
        self._is_new = True

    def handle(self, material: bpy.types.Material | None) -> int:
        """Row of `material`, original or evaluated; read when first met."""
        if material is None:
            return 0
        address = material.original.as_pointer()
        row = self._rows.get(address)
        if row is None:
            row = self._rows[address] = len(self._looks)
            self._looks.append(read_look(material))
            self._is_new = True
        return row

    def refresh(self, material: bpy.types.Material) -> None:
        """Read a material again, if it is in the table at all."""
        row = self._rows.get(material.original.as_pointer())
        if row is None:
            return
        look = read_look(material)
        if look != self._looks[row]:
            self._looks[row] = look
            self._is_new = True

    def take_table(self) -> MaterialTable | None:
        """The table, if it changed since it was last taken."""
        if not self._is_new:
            return None
        self._is_new = False
        return MaterialTable(
            np.array([look.base_color for look in self._looks], np.float32),
            np.array([look.metallic for look in self._looks], np.float32),
            np.array([look.roughness for look in self._looks], np.float32),
            np.array([look.emission for look in self._looks], np.float32),
        )


def materials_of(ob: bpy.types.Object, mesh: bpy.types.Mesh) -> list[bpy.types.Material | None]:
    """The material of each slot of `mesh` as `ob` shows it: a slot linked to the object wins over
    the mesh's own."""
    materials = list(mesh.materials)
    for index, slot in enumerate(ob.material_slots):
        if index >= len(materials):
            materials.append(slot.material)
        elif slot.link == "OBJECT":
            materials[index] = slot.material
    return materials


def read_look(material: bpy.types.Material) -> Look:
    """The look of a material: its surface shader's unlinked values, else its viewport colours."""
    plain = Look(tuple(material.diffuse_color), material.metallic, material.roughness)
    if not material.use_nodes or material.node_tree is None:
        return plain
    shader = _surface_shader(material.node_tree, "OUTPUT_MATERIAL")
    look = _look_of(shader, plain, MAX_NODES_DEEP)
    return plain if look is None else look


def read_world(world: bpy.types.World | None) -> Colour:
    """Background radiance, linear: the background shader's colour times its strength, and the
    world's viewport colour where that is linked to a texture."""
    if world is None:
        return BLACK
    plain = tuple(world.color)
    if not world.use_nodes or world.node_tree is None:
        return plain
    shader = _surface_shader(world.node_tree, "OUTPUT_WORLD")
    if shader is None:
        return BLACK
    return _scaled(_colour(shader, ("Color",), plain), _number(shader, ("Strength",), 1.0))


def _look_of(shader: Any, plain: Look, depth: int) -> Look | None:
    """The look of a shader node, or None if it tells nothing."""
    if shader is None or depth == 0:
        return None
    if shader.type == "BSDF_PRINCIPLED":
        return _principled(shader, plain)
    if shader.type == "EMISSION":
        light = _scaled(_colour(shader, ("Color",), BLACK), _number(shader, ("Strength",), 1.0))
        return Look((0.0, 0.0, 0.0, 1.0), emission=light)
    if shader.type in {"MIX_SHADER", "ADD_SHADER"}:
        parts = [
            _look_of(_source(s), plain, depth - 1) for s in shader.inputs if s.type == "SHADER"
        ]
        return _combined(parts, _weights(shader))
    if shader.type in UNSEEN:
        return None
    if "Color" in shader.inputs:
        return _coloured(shader, plain)
    return None


def _principled(shader: Any, plain: Look) -> Look:
    colour = _colour(shader, ("Base Color",), plain.base_color[:3])
    emission = _colour(shader, ("Emission Color", "Emission"), BLACK)
    return Look(
        (*colour, _number(shader, ("Alpha",), 1.0)),
        _number(shader, ("Metallic",), plain.metallic),
        _number(shader, ("Roughness",), plain.roughness),
        _scaled(emission, _number(shader, ("Emission Strength",), 0.0)),
    )


def _coloured(shader: Any, plain: Look) -> Look:
    """Diffuse, glossy, glass and their like."""
    colour = _colour(shader, ("Color",), plain.base_color[:3])
    metallic = 1.0 if shader.type in {"BSDF_GLOSSY", "BSDF_ANISOTROPIC"} else 0.0
    return Look((*colour, 1.0), metallic, _number(shader, ("Roughness",), 0.5))


def _weights(shader: Any) -> tuple[float, float]:
    """How much of its two inputs a mix or add shader takes."""
    if shader.type == "ADD_SHADER":
        return 1.0, 1.0
    share = _number(shader, ("Fac", "Factor"), 0.5)
    return 1.0 - share, share


def _combined(parts: list[Look | None], weights: tuple[float, float]) -> Look | None:
    """Two looks together; one that tells nothing (transparent, say) gives way to the other."""
    known = [part for part in parts if part is not None]
    if len(known) < 2:
        return known[0] if known else None

    def both(one: Any, other: Any) -> Any:
        return tuple(a * weights[0] + b * weights[1] for a, b in zip(one, other, strict=True))

    first, second = known[:2]
    total = weights[0] + weights[1]
    colour = both(first.base_color, second.base_color)[:3]
    numbers = both((first.metallic, first.roughness), (second.metallic, second.roughness))
    return Look(
        (*colour, 1.0),
        numbers[0] / total,
        numbers[1] / total,
        both(first.emission, second.emission),
    )


def _surface_shader(tree: Any, output_type: str) -> Any:
    """The node that feeds the surface of the active output, or None."""
    outputs = [node for node in tree.nodes if node.type == output_type]
    outputs.sort(key=lambda node: not node.is_active_output)
    return _source(outputs[0].inputs["Surface"]) if outputs else None


def _source(socket: Any) -> Any:
    """The node linked to a socket, past reroutes; None if there is none."""
    for _ in range(MAX_NODES_DEEP):
        if not socket.is_linked or not socket.links:
            return None
        node = socket.links[0].from_node
        if node.type != "REROUTE":
            return node
        socket = node.inputs[0]
    return None


def _socket(node: Any, names: tuple[str, ...]) -> Any:
    return next((node.inputs[name] for name in names if name in node.inputs), None)


def _colour(node: Any, names: tuple[str, ...], instead: Colour) -> Colour:
    """Value of the first socket of these names; `instead` where a texture drives it."""
    socket = _socket(node, names)
    if socket is None:
        return instead
    source = _source(socket)
    if source is None:
        return tuple(socket.default_value)[:3]
    return tuple(source.outputs[0].default_value)[:3] if source.type == "RGB" else instead


def _number(node: Any, names: tuple[str, ...], instead: float) -> float:
    socket = _socket(node, names)
    if socket is None:
        return instead
    source = _source(socket)
    if source is None:
        return float(socket.default_value)
    return float(source.outputs[0].default_value) if source.type == "VALUE" else instead


def _scaled(colour: Colour, strength: float) -> Colour:
    return (colour[0] * strength, colour[1] * strength, colour[2] * strength)
