"""Materials and worlds, reduced to what a preview shows: one colour and a few numbers each."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import bpy
import numpy as np

from .delta import MaterialTable
from .node_values import MAX_NODES_DEEP, Colour, colour, number, scaled, source, uses_nodes

BLACK: Colour = (0.0, 0.0, 0.0)
UNSEEN = {"BSDF_TRANSPARENT", "HOLDOUT"}
MIRRORS = {"BSDF_GLOSSY", "BSDF_ANISOTROPIC"}
CLEAR = {"BSDF_GLASS", "BSDF_REFRACTION"}


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
    if not uses_nodes(material):
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
    if not uses_nodes(world):
        return plain
    shader = _surface_shader(world.node_tree, "OUTPUT_WORLD")
    if shader is None:
        return BLACK
    return scaled(colour(shader, ("Color",), plain), number(shader, ("Strength",), 1.0))


def _look_of(shader: Any, plain: Look, depth: int) -> Look | None:
    """The look of a shader node, or None if it tells nothing."""
    if shader is None or depth == 0:
        return None
    if shader.type == "BSDF_PRINCIPLED":
        return _principled(shader, plain)
    if shader.type == "EMISSION":
        light = scaled(colour(shader, ("Color",), BLACK), number(shader, ("Strength",), 1.0))
        return Look((0.0, 0.0, 0.0, 1.0), emission=light)
    if shader.type in {"MIX_SHADER", "ADD_SHADER"}:
        parts = [_look_of(source(s), plain, depth - 1) for s in shader.inputs if s.type == "SHADER"]
        return _combined(parts, _weights(shader))
    if shader.type in UNSEEN:
        return None
    if "Color" in shader.inputs:
        return _coloured(shader, plain)
    return None


def _principled(shader: Any, plain: Look) -> Look:
    base = colour(shader, ("Base Color",), plain.base_color[:3])
    emission = colour(shader, ("Emission Color", "Emission"), BLACK)
    return Look(
        (*base, number(shader, ("Alpha",), 1.0)),
        number(shader, ("Metallic",), plain.metallic),
        number(shader, ("Roughness",), plain.roughness),
        scaled(emission, number(shader, ("Emission Strength",), 0.0)),
    )


def _coloured(shader: Any, plain: Look) -> Look:
    """Diffuse, glossy, glass and their like; roughness 1 is what the library calls diffuse."""
    base = colour(shader, ("Color",), plain.base_color[:3])
    if shader.type in MIRRORS:
        return Look((*base, 1.0), 1.0, number(shader, ("Roughness",), 0.5))
    is_clear = shader.type in CLEAR
    return Look((*base, 1.0), 0.0, number(shader, ("Roughness",), 0.5) if is_clear else 1.0)


def _weights(shader: Any) -> tuple[float, float]:
    """How much of its two inputs a mix or add shader takes."""
    if shader.type == "ADD_SHADER":
        return 1.0, 1.0
    share = number(shader, ("Fac", "Factor"), 0.5)
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
    base = both(first.base_color, second.base_color)[:3]
    numbers = both((first.metallic, first.roughness), (second.metallic, second.roughness))
    return Look(
        (*base, 1.0),
        numbers[0] / total,
        numbers[1] / total,
        both(first.emission, second.emission),
    )


def _surface_shader(tree: Any, output_type: str) -> Any:
    """The node that feeds the surface of the active output, or None."""
    outputs = [node for node in tree.nodes if node.type == output_type]
    outputs.sort(key=lambda node: not node.is_active_output)
    return source(outputs[0].inputs["Surface"]) if outputs else None
