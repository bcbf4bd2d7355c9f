"""Every kind of geometry arrives, once, where Blender shows it."""

from __future__ import annotations

import math

import bpy
import numpy as np
from harness import add, grid, heights, mesh, native, paint, part, planes, render, run
from mathutils import Matrix


def check_a_mesh_arrives_as_triangles() -> None:
    add("square", mesh("square"), (0, 0, 2))
    statistics = render()
    assert native().counts()["triangles"] == 2, native().counts()
    assert statistics["triangles"] == 2
    assert heights((0.5, 0.5), (3, 3)) == [2.0, None]


def check_modifiers_are_evaluated() -> None:
    ob = add("square", mesh("square"))
    array = ob.modifiers.new("array", "ARRAY")
    array.count = 3
    array.relative_offset_displace = (1, 0, 1)
    ob.modifiers.new("off in renders", "SUBSURF").show_render = False
    solid = ob.modifiers.new("solid", "SOLIDIFY")
    solid.thickness, solid.offset = 1.0, 1.0
    render()
    assert heights((0, 0), (2, 0), (4, 0)) == [1.0, 1.0, 1.0]


def check_objects_that_share_a_mesh_share_the_native_one() -> None:
    shared = mesh("square")
    for x in range(5):
        add(f"square {x}", shared, (3 * x, 0, x))
    add("modified", shared, (-3, 0, 0)).modifiers.new("solid", "SOLIDIFY")
    render()
    counts = native().counts()
    assert (counts["meshes"], counts["instances"]) == (2, 6), counts
    assert heights((0, 0), (12, 0)) == [0.0, 4.0]


def check_curves_text_surfaces_and_metaballs_arrive() -> None:
    bpy.ops.curve.primitive_bezier_circle_add(radius=1, location=(0, 0, 0))
    bpy.context.object.data.bevel_depth = 0.25
    bpy.ops.object.text_add(location=(10, 0, 3))
    bpy.context.object.data.body = "MMM"
    bpy.ops.surface.primitive_nurbs_surface_sphere_add(location=(20, 0, 0))
    bpy.ops.object.metaball_add(type="BALL", radius=2, location=(30, 0, 0))
    bpy.ops.object.metaball_add(type="BALL", radius=2, location=(31, 0, 0))
    statistics = render()
    assert statistics["instances"] == 4, statistics
    ring, hole, sphere, ball = heights((1, 0), (0, 0), (20.1, 0.1), (30.5, 0))
    assert ring is not None
    assert math.isclose(ring, 0.25, abs_tol=0.02), ring
    assert hole is None
    assert sphere is not None
    assert 0.5 < sphere < 1.5, sphere
    assert ball is not None
    assert ball > 0.5
    letters = heights(*[(10 + 0.05 * k, 0.3) for k in range(40)])
    assert 3.0 in letters
    assert None in letters


def check_collection_instances_arrive_nested_and_scaled() -> None:
    inner = bpy.data.collections.new("inner")
    inner.objects.link(bpy.data.objects.new("square", mesh("square")))
    outer = bpy.data.collections.new("outer")
    for x in (0, 4):
        empty = bpy.data.objects.new(f"inner at {x}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", inner
        empty.location.x = x
        outer.objects.link(empty)
    for y, scale in ((0, 1.0), (10, -2.0)):
        empty = add(f"outer at {y}", None, (0, y, 1))
        empty.instance_type, empty.instance_collection = "COLLECTION", outer
        empty.scale = (scale, scale, scale)
    statistics = render()
    assert statistics["instances"] == 4
    assert native().counts()["meshes"] == 1
    assert heights((0, 0), (4, 0), (0, 10), (-8, 10), (8, 10)) == [1.0, 1.0, 1.0, 1.0, None]


def check_vertex_instances_arrive_and_their_hidden_instancer_does_not() -> None:
    parent = add("instancer", grid("grid", 2))
    child = add(
        "square",
        mesh("square", np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) @ [[0.1, 0, 0], [0, 0.1, 0]]),
    )
    child.parent = parent
    parent.instance_type = "VERTS"
    parent.show_instancer_for_render = False
    statistics = render()
    assert statistics["instances"] == 9, statistics
    assert heights((1, 1), (0.75, 0.75)) == [0.0, None]


def check_particle_instances_arrive() -> None:
    emitter = add("emitter", grid("grid", 4))
    shown = add("square", mesh("square"), (0, 0, -50))
    settings = emitter.modifiers.new("particles", "PARTICLE_SYSTEM").particle_system.settings
    settings.count, settings.frame_start, settings.frame_end = 7, 1, 1
    settings.physics_type = "NO"
    settings.lifetime = 100
    settings.render_type, settings.instance_object = "OBJECT", shown
    settings.particle_size = 0.01
    emitter.show_instancer_for_render = False
    render(1)
    statistics = render(2)
    # The seven particles and the object itself.
    assert statistics["instances"] == 8, statistics


def check_geometry_nodes_instances_arrive_nested() -> None:
    ob = add("points", grid("grid", 1), (0, 0, 5))
    ob.modifiers.new("nodes", "NODES").node_group = instancing_nodes(depth=2)
    statistics = render()
    assert statistics["instances"] == 16, statistics
    assert native().counts()["meshes"] == 1
    assert heights((0, 0), (2, 2), (0.5, 0.5)) == [5.05, 5.05, None]


def instancing_nodes(depth: int) -> bpy.types.NodeTree:
    """Puts a small cube on every point, then the whole on every point, `depth` times in all."""
    tree = bpy.data.node_groups.new("instances", "GeometryNodeTree")
    if hasattr(tree, "interface"):
        tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        tree.inputs.new("NodeSocketGeometry", "Geometry")
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    points, out = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    cube = tree.nodes.new("GeometryNodeMeshCube")
    cube.inputs["Size"].default_value = (0.1, 0.1, 0.1)
    shape = cube.outputs["Mesh"]
    for _ in range(depth):
        place = tree.nodes.new("GeometryNodeInstanceOnPoints")
        tree.links.new(points.outputs[0], place.inputs["Points"])
        tree.links.new(shape, place.inputs["Instance"])
        shape = place.outputs["Instances"]
    tree.links.new(shape, out.inputs[0])
    return tree


def check_geometry_made_by_nodes_arrives_with_its_materials() -> None:
    tree = instancing_nodes(depth=1)
    place = next(n for n in tree.nodes if n.type == "INSTANCE_ON_POINTS")
    out = next(n for n in tree.nodes if n.type == "GROUP_OUTPUT")
    brush = tree.nodes.new("GeometryNodeSetMaterial")
    brush.inputs["Material"].default_value = paint("red", (1, 0, 0, 1))
    tree.links.new(place.outputs["Instances"], brush.inputs["Geometry"])
    tree.links.new(brush.outputs["Geometry"], out.inputs[0])
    add("points", grid("grid", 1)).modifiers.new("nodes", "NODES").node_group = tree
    bpy.context.scene.regraft.shading = "direct"
    bpy.context.scene.camera.location = (0, 0, 0.5)
    with planes() as passes:
        render()
    red, green = passes["Combined"][..., 0], passes["Combined"][..., 1]
    assert red.max() > 0.1, red.max()
    assert green.max() == 0.0, green.max()


def check_render_visibility_counts_and_viewport_visibility_does_not() -> None:
    scene = bpy.context.scene
    add("seen", mesh("seen"), (0, 0, 1))
    add("hidden in renders", mesh("b"), (0, 0, 2)).hide_render = True
    add("hidden in viewports", mesh("c"), (5, 0, 3)).hide_viewport = True
    away = bpy.data.collections.new("excluded")
    scene.collection.children.link(away)
    away.objects.link(bpy.data.objects.new("excluded", mesh("d")))
    bpy.context.view_layer.layer_collection.children[0].exclude = True
    render()
    assert heights((0, 0), (5, 0)) == [1.0, 3.0]


def check_lights_cameras_and_empties_are_no_geometry() -> None:
    add("empty", None)
    add("light", bpy.data.lights.new("light", "POINT"))
    assert render()["instances"] == 0


def check_the_hierarchy_becomes_groups() -> None:
    scene = bpy.context.scene
    outer, inner = bpy.data.collections.new("outer"), bpy.data.collections.new("inner")
    scene.collection.children.link(outer)
    outer.children.link(inner)
    parent = bpy.data.objects.new("parent", mesh("a"))
    child = bpy.data.objects.new("child", mesh("b"))
    child.parent = parent
    for ob in (parent, child):
        inner.objects.link(ob)
    render()
    # The scene's collection, outer, inner, and what hangs on the parent.
    assert native().counts()["groups"] == 4


def check_a_very_deep_chain_of_parents_is_no_trouble() -> None:
    above = add("0", None)
    for number in range(1, 1500):
        ob = add(str(number), None)
        ob.parent, above = above, ob
    add("leaf", mesh("leaf")).parent = above
    render()
    assert native().counts()["groups"] == 1501


def check_sheared_and_mirrored_matrices_arrive_exactly() -> None:
    ob = add("square", mesh("square"))
    ob.matrix_world = Matrix(((2, 1, 0, 3), (0, -1, 0, 0), (0, 0.5, 1, 4), (0, 0, 0, 1)))
    shear = Matrix(((1, 0.5, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)))
    ob.matrix_parent_inverse = shear
    render()
    world = np.array(ob.evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world)
    corner = world @ [0.9, 0.9, 0, 1]
    assert heights((corner[0], corner[1]))[0] is not None


def check_too_many_instances_are_cut_off_with_a_warning() -> None:
    objects = part("sync.object_list")
    limit, objects.MAX_INSTANCES = objects.MAX_INSTANCES, 10
    try:
        for number in range(15):
            add(str(number), mesh("square"))
        statistics = render()
    finally:
        objects.MAX_INSTANCES = limit
    assert 0 < statistics["instances"] <= 10
    assert any("first 10 instances" in text for text in statistics["warnings"]), statistics


def check_what_cannot_be_drawn_is_named_once() -> None:
    add("smoke", bpy.data.volumes.new("smoke"))
    add("more smoke", bpy.data.volumes.new("more smoke"))
    haired = add("haired", mesh("square"))
    settings = haired.modifiers.new("hair", "PARTICLE_SYSTEM").particle_system.settings
    settings.type = "HAIR"
    first, second = render(1), render(2)
    warned = [text for text in first["warnings"] if "not drawn" in text]
    assert len(warned) == 2, warned
    assert any("'smoke'" in text for text in warned)
    assert any("'haired'" in text for text in warned)
    assert not any("not drawn" in text for text in second["warnings"])


def check_indirect_only_objects_are_left_out_and_holdouts_warned_of() -> None:
    scene = bpy.context.scene
    for name, flag, height in (("mirror", "indirect_only", 2), ("hole", "holdout", 1)):
        collection = bpy.data.collections.new(name)
        scene.collection.children.link(collection)
        ob = bpy.data.objects.new(name, mesh(name))
        ob.location.z = height
        collection.objects.link(ob)
        setattr(bpy.context.view_layer.layer_collection.children[name], flag, True)
    statistics = render()
    assert heights((0, 0)) == [1.0], heights((0, 0))
    assert any("indirect" in text for text in statistics["left_out"]), statistics
    assert any("holdout" in text for text in statistics["warnings"]), statistics


def check_an_object_in_edit_mode_shows_its_edits() -> None:
    import bmesh

    ob = add("square", mesh("square"))
    bpy.context.view_layer.objects.active = ob
    bpy.ops.object.mode_set(mode="EDIT")
    edited = bmesh.from_edit_mesh(ob.data)
    for vertex in edited.verts:
        vertex.co.z = 3
    bmesh.update_edit_mesh(ob.data)
    render()
    assert heights((0, 0)) == [3.0]
    bpy.ops.object.mode_set(mode="OBJECT")


run(globals())
