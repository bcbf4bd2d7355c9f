"""What the shape of an evaluated mesh follows from, where modifiers make no other.

As long as that is the same, and Blender flags the data behind it as unchanged, only positions have
to be read: about a third of a mesh's bytes.
"""

from __future__ import annotations

from dataclasses import dataclass

import bpy

# Those that Blender calls deforming only, which keep vertices, edges, faces and their attributes;
# and subdivision, whose result follows from what it is given but for a level that its size tells.
KEEPING = {
    *("ARMATURE", "CAST", "CLOTH", "COLLISION", "CORRECTIVE_SMOOTH", "CURVE", "DISPLACE", "HOOK"),
    *("LAPLACIANDEFORM", "LAPLACIANSMOOTH", "LATTICE", "MESH_CACHE", "MESH_DEFORM"),
    *("PARTICLE_SYSTEM", "SHRINKWRAP", "SIMPLE_DEFORM", "SMOOTH", "SOFT_BODY", "SUBSURF"),
    *("SURFACE_DEFORM", "WARP", "WAVE"),
}
# In others the mesh that is shown is made by a tool.
PLAIN_MODES = {"OBJECT", "POSE"}


@dataclass(frozen=True)
class ShapeOrigin:
    """`data` is the address and the number of the original mesh, `modifiers` the kinds of the
    object's modifiers and where each is shown, `counts` tell the evaluated mesh's size."""

    data: tuple[int, int]
    modifiers: tuple[tuple[str, bool, bool], ...]
    counts: tuple[int, int, int, int]


def origin_of(ob: bpy.types.Object, mesh: bpy.types.Mesh) -> ShapeOrigin | None:
    """That of evaluated `mesh` which `ob` shows; None if something else may shape it too."""
    data = ob.original.data
    if ob.data != mesh or ob.mode not in PLAIN_MODES or not isinstance(data, bpy.types.Mesh):
        return None
    modifiers = tuple((m.type, m.show_viewport, m.show_render) for m in ob.modifiers)
    if any(kind not in KEEPING for kind, *_ in modifiers):
        return None
    return ShapeOrigin(
        data=(data.as_pointer(), getattr(data, "session_uid", 0)),
        modifiers=modifiers,
        counts=(len(mesh.vertices), len(mesh.edges), len(mesh.loops), len(mesh.polygons)),
    )
