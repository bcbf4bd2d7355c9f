"""Meshes as they are read against what Blender says element by element."""

from __future__ import annotations

import bpy
import numpy as np
from harness import add, grid, mesh, part, raises, run

OLD_AUTO_SMOOTH = bpy.app.version < (4, 1, 0)


def evaluated(ob: bpy.types.Object) -> bpy.types.Mesh:
    """The evaluated mesh; valid until the scene is evaluated again."""
    return ob.evaluated_get(bpy.context.evaluated_depsgraph_get()).data


def read(data: bpy.types.Mesh) -> tuple:
    """(MeshData, Shape) of an evaluated mesh."""
    reader = part("sync.mesh_reader")
    shape = reader.read_shape(data)
    return reader.read_mesh(data, shape, reader.read_positions(data)), shape


def mixed_faces() -> bpy.types.Object:
    """Triangles, quads, a pentagon and loose vertices, with slots and flat faces among them."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=7, ring_count=5)
    ob = bpy.context.object
    bpy.ops.mesh.primitive_cylinder_add(vertices=5, location=(3, 0, 0))
    cylinder = bpy.context.object
    cylinder.select_set(True)
    ob.select_set(True)
    bpy.context.view_layer.objects.active = ob
    bpy.ops.object.join()
    for number in range(3):
        ob.data.materials.append(bpy.data.materials.new(f"paint {number}"))
    for number, face in enumerate(ob.data.polygons):
        face.material_index = number % 3
        face.use_smooth = number % 4 != 0
    ob.data.vertices.add(2)
    ob.data.update()
    return ob


def check_positions_triangles_and_slots_equal_blenders() -> None:
    data = evaluated(mixed_faces())
    got, _ = read(data)
    data.calc_loop_triangles()
    assert np.array_equal(got.vertices, [v.co for v in data.vertices])
    assert got.triangles.tolist() == [list(t.vertices) for t in data.loop_triangles]
    assert got.slots is not None
    assert got.slots.tolist() == [t.material_index for t in data.loop_triangles]


def check_triangles_only_and_quads_only_equal_blenders() -> None:
    for modifier in (None, "TRIANGULATE"):
        ob = add("grid", grid("grid", 7))
        if modifier:
            ob.modifiers.new("m", modifier)
        data = evaluated(ob)
        got, _ = read(data)
        data.calc_loop_triangles()
        assert got.triangles.tolist() == [list(t.vertices) for t in data.loop_triangles]
        assert got.slots is None


def check_the_fallback_reads_the_same() -> None:
    data = evaluated(mixed_faces())
    fast, fast_shape = read(data)
    memory = part("sync.raw_memory")
    view = memory.view

    def refuse(*_arguments: object) -> None:
        raise memory.LayoutError("pretended")

    memory.view = refuse
    try:
        slow, slow_shape = read(data)
    finally:
        memory.view = view
    assert fast_shape.differs_in(slow_shape) == []
    for name in ("vertices", "triangles", "slots", "normal_ids"):
        assert np.array_equal(getattr(fast, name), getattr(slow, name)), name


def check_a_wrong_memory_layout_is_noticed() -> None:
    memory = part("sync.raw_memory")
    data = evaluated(add("grid", grid("grid", 3)))
    data.calc_loop_triangles()
    wide = np.dtype([("corners", "<i4", (5,))])
    message = raises(
        memory.LayoutError, lambda: memory.view(data.loop_triangles, wide, lambda *_: True)
    )
    assert "size" in message
    narrow = np.dtype([("x", "V1")])
    raises(memory.LayoutError, lambda: memory.view(data.loop_triangles, narrow, lambda *_: True))
    size = data.loop_triangles[1].as_pointer() - data.loop_triangles[0].as_pointer()
    right = np.dtype([("x", f"V{size}")])
    message = raises(
        memory.LayoutError, lambda: memory.view(data.loop_triangles, right, lambda *_: False)
    )
    assert "contents" in message


def check_a_smooth_mesh_shares_normals_by_vertex_and_a_flat_one_has_none() -> None:
    bpy.ops.mesh.primitive_uv_sphere_add()
    ob = bpy.context.object
    flat, _ = read(evaluated(ob))
    assert flat.normal_ids is None
    for face in ob.data.polygons:
        face.use_smooth = True
    ob.data.update()
    smooth, _ = read(evaluated(ob))
    assert smooth.normal_ids is smooth.triangles


def corner_normals(data: bpy.types.Mesh) -> list[tuple[float, ...]]:
    """Blender's own normal of every corner."""
    if hasattr(data, "corner_normals"):
        return [tuple(n.vector) for n in data.corner_normals]
    data.calc_normals_split()
    return [tuple(loop.normal) for loop in data.loops]


def check_fans_part_corners_as_blenders_split_normals_do() -> None:
    ob = mixed_faces()
    data = ob.data
    for number, face in enumerate(data.polygons):
        face.use_smooth = number != 3
    for number, edge in enumerate(data.edges):
        edge.use_edge_sharp = number % 5 == 0
    if OLD_AUTO_SMOOTH:
        data.use_auto_smooth, data.auto_smooth_angle = True, 3.2
    # Nothing lies flat, so that different fans have different normals.
    noise = np.random.default_rng(1).normal(scale=0.05, size=(len(data.vertices), 3))
    for vertex, push in zip(data.vertices, noise, strict=True):
        vertex.co = np.array(vertex.co) + push
    data.update()
    shown = evaluated(ob)
    got, _ = read(shown)
    assert got.normal_ids is not None
    normals = corner_normals(shown)
    shown.calc_loop_triangles()
    by_fan: dict[int, set] = {}
    by_normal: dict[tuple, set] = {}
    for triangle, ids in zip(shown.loop_triangles, got.normal_ids.tolist(), strict=True):
        for loop, vertex, number in zip(triangle.loops, triangle.vertices, ids, strict=True):
            if number != 0xFFFFFFFF:
                rounded = tuple(round(x, 4) for x in normals[loop])
                by_fan.setdefault(number, set()).add((vertex, rounded))
                by_normal.setdefault((vertex, rounded), set()).add(number)
    assert all(len(kinds) == 1 for kinds in by_fan.values())
    assert all(len(kinds) == 1 for kinds in by_normal.values())
    flat = {
        t.polygon_index
        for t in shown.loop_triangles
        if not shown.polygons[t.polygon_index].use_smooth
    }
    marked = {
        t.polygon_index
        for t, ids in zip(shown.loop_triangles, got.normal_ids.tolist(), strict=True)
        if ids == [0xFFFFFFFF] * 3
    }
    assert flat == marked


def check_an_angle_parts_a_cube_but_not_a_sphere() -> None:
    counts = []
    for make in (bpy.ops.mesh.primitive_cube_add, bpy.ops.mesh.primitive_ico_sphere_add):
        make()
        ob = bpy.context.object
        for face in ob.data.polygons:
            face.use_smooth = True
        if OLD_AUTO_SMOOTH:
            ob.data.use_auto_smooth, ob.data.auto_smooth_angle = True, 1.0
        else:
            ob.data.set_sharp_from_angle(angle=1.0)
        got, shape = read(evaluated(ob))
        assert got.normal_ids is not None
        counts.append((len(np.unique(got.normal_ids)), shape.vertex_count))
    assert counts[0] == (24, 8), counts
    assert counts[1][0] == counts[1][1], counts


def check_shapes_differ_in_what_was_changed() -> None:
    ob = mixed_faces()
    _, before = read(evaluated(ob))
    assert read(evaluated(ob))[1].differs_in(before) == []
    ob.data.polygons[0].material_index = 1
    ob.data.update()
    assert read(evaluated(ob))[1].differs_in(before) == ["slots"]
    ob.data.polygons[0].material_index = 0
    ob.data.polygons[0].use_smooth = True
    ob.data.update()
    assert read(evaluated(ob))[1].differs_in(before) == ["flat_faces"]
    ob.data.polygons[0].use_smooth = False
    ob.data.vertices[0].co.x += 1
    ob.data.update()
    assert read(evaluated(ob))[1].differs_in(before) == []


def check_a_mesh_of_nothing_is_read() -> None:
    got, shape = read(evaluated(add("none", mesh("none", [], []))))
    assert got.vertices.shape == (0, 3)
    assert got.triangles.shape == (0, 3)
    assert shape.differs_in(shape) == []


def check_the_library_takes_every_such_mesh() -> None:
    scene = part("compat").native().Scene()
    for ob in (mixed_faces(), add("none", mesh("none", [], [])), add("grid", grid("grid", 4))):
        got, _ = read(evaluated(ob))
        scene.add_mesh(
            got.vertices,
            got.triangles,
            name=got.name,
            slots=got.slots,
            normal_ids=got.normal_ids,
        )
    assert scene.counts()["meshes"] == 3


run(globals())
