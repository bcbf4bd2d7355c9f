"""Between two frames only what changed is read, and all of what changed."""

from __future__ import annotations

import bpy
import numpy as np
from harness import add, grid, heights, mesh, native, paint, part, reads, render, run

WORDS = "objects unchanged: not read"


def animated(ob: bpy.types.Object, path: str, *keys: tuple[int, object]) -> None:
    """Key a property of an object at frames."""
    for frame, value in keys:
        setattr(ob, path, value)
        ob.keyframe_insert(path, frame=frame)


def check_nothing_is_read_when_nothing_changed() -> None:
    for x in range(20):
        add(str(x), mesh(str(x)), (x, 0, 0))
    render(1)
    assert reads().read == 20
    statistics = render(2)
    assert reads().read == 0
    assert statistics["nodes_refitted"] == statistics["nodes_rebuilt"] == 0
    assert f"20 of 20 {WORDS}" in statistics["left_out"], statistics


def check_a_camera_that_moves_reads_nothing() -> None:
    for x in range(20):
        add(str(x), mesh(str(x)), (x, 0, 0))
    camera = bpy.context.scene.camera
    animated(camera, "location", (1, (0, 0, 10)), (3, (4, 0, 12)))
    render(1)
    (kept,) = part("session")._sessions.values()
    listed = kept._reader._listing
    statistics = render(3)
    assert kept._reader._listing is listed
    (said,) = (words for words in statistics["left_out"] if "bytes of geometry" in words)
    unread, _, of_all, *_ = said.split()
    assert unread == of_all
    bpy.data.objects["3"].location.z = 2
    statistics = render(3)
    assert kept._reader._listing is not listed
    assert heights((3, 0)) == [2.0]
    (said,) = (words for words in statistics["left_out"] if "bytes of geometry" in words)
    unread, _, of_all, *_ = said.split()
    assert unread != of_all


def check_only_what_moved_is_moved() -> None:
    for x in range(20):
        add(str(x), mesh(str(x)), (3 * x, 0, 0))
    animated(bpy.data.objects["7"], "location", (1, (21, 0, 0)), (3, (21, 0, 4)))
    render(1)
    statistics = render(3)
    assert reads().read == 0
    assert statistics["moved_instances"] == 1
    assert f"19 of 20 {WORDS}" in statistics["left_out"], statistics
    assert heights((21, 0), (18, 0)) == [4.0, 0.0]


def check_only_what_deformed_is_read_and_refitted() -> None:
    for x in range(5):
        add(str(x), grid(str(x), 10), (x, 0, 0))
    wave = add("wave", grid("wave", 10), (8, 0, 0)).modifiers.new("wave", "WAVE")
    wave.height = 2
    render(10)
    before = heights((8.45, 0.45))
    statistics = render(20)
    assert reads().read == 1
    assert (statistics["deformed_meshes"], statistics["deformed_triangles"]) == (1, 200)
    assert heights((8.45, 0.45)) != before
    assert f"5 of 6 {WORDS}" in statistics["left_out"], statistics


def check_of_a_mesh_that_keeps_its_shape_positions_alone_are_read() -> None:
    ob = add("wave", grid("wave", 10))
    ob.modifiers.new("wave", "WAVE").height = 2
    render(10)
    assert reads().bytes > 2 * 12 * 121
    render(20)
    assert reads().bytes == 12 * 121
    finer = ob.modifiers.new("finer", "SUBSURF")
    finer.levels = finer.render_levels = 1
    for frame in (21, 22):
        assert render(frame)["triangles"] == 800
    assert reads().bytes == 12 * 441
    finer.levels = finer.render_levels = 2
    assert render(23)["triangles"] == 3200


def check_what_else_shapes_a_mesh_is_read_as_soon_as_it_changes() -> None:
    ob = add("wave", grid("wave", 10))
    ob.modifiers.new("wave", "WAVE").height = 0.01
    for name, z in (("low", 0.0), ("high", 1.0)):
        ob.data.materials.append(paint(name, (z, z, z, 1.0)))
    assert render(10)["triangles"] == 200
    ob.data.polygons.foreach_set("material_index", [1] * 100)
    ob.data.update()
    render(11)
    assert reads().bytes > 2 * 12 * 121, "slots"
    ob.data.polygons.foreach_set("use_smooth", [True] * 100)
    ob.data.update()
    render(12)
    assert reads().bytes > 2 * 12 * 121, "smoothness"
    more = ob.modifiers.new("more", "ARRAY")
    assert render(13)["triangles"] == 400
    render(14)
    assert reads().bytes > 2 * 12 * 242, "modifiers that make faces"
    ob.modifiers.remove(more)
    assert render(15)["triangles"] == 200
    old, ob.data = ob.data, grid("other", 10)
    bpy.data.meshes.remove(old)
    ob.data.polygons.foreach_set("use_smooth", [True] * 100)
    render(16)
    assert reads().bytes > 2 * 12 * 121, "another mesh"
    render(17)
    assert reads().bytes == 12 * 121


def check_a_whole_animation_reads_static_objects_once_whatever_the_users_setting() -> None:
    scene = bpy.context.scene
    scene.render.use_persistent_data = False
    for x in range(5):
        add(str(x), mesh(str(x)), (x, 0, 0))
    animated(add("mover", mesh("mover")), "location", (1, (0, 9, 0)), (4, (0, 9, 4)))
    scene.frame_start, scene.frame_end = 1, 4
    bpy.ops.render.render(animation=True)
    rows = part("session").history()
    assert [row["frame"] for row in rows] == [1, 2, 3, 4]
    for row in rows[1:]:
        assert f"5 of 6 {WORDS}" in row["left_out"], row
    assert scene.render.use_persistent_data is False


def check_flags_that_say_too_much_cause_no_refit() -> None:
    scene = bpy.context.scene
    scene.render.use_persistent_data = False
    add("square", mesh("square"))
    render()
    statistics = render()
    assert reads().read == reads().unchanged == 1
    assert statistics["nodes_refitted"] == statistics["nodes_rebuilt"] == 0
    assert "1 meshes read but unchanged: no refit" in statistics["left_out"]


def check_animated_visibility_hides_and_shows_without_reading() -> None:
    ob = add("square", mesh("square"))
    animated(ob, "hide_render", (1, False), (2, True), (3, False))
    add("floor", mesh("floor"), (0, 0, -1))
    render(1)
    assert heights((0, 0)) == [0.0]
    render(2)
    assert heights((0, 0)) == [-1.0]
    render(3)
    assert heights((0, 0)) == [0.0]
    assert reads().read == 0


def check_two_objects_that_swap_visibility_by_drivers_are_noticed() -> None:
    for name, expression, x in (("early", "frame >= 3", 0), ("late", "frame < 3", 5)):
        driver = add(name, mesh(name), (x, 0, 0)).driver_add("hide_render").driver
        driver.type, driver.expression = "SCRIPTED", expression
    render(2)
    assert heights((0, 0), (5, 0)) == [0.0, None]
    render(3)
    assert heights((0, 0), (5, 0)) == [None, 0.0]


def check_a_hidden_object_that_deforms_is_read_when_it_comes_back() -> None:
    ob = add("rising", mesh("rising"))
    ob.shape_key_add(name="basis")
    key = ob.shape_key_add(name="up")
    for point in key.data:
        point.co.z = 4
    for frame, value in ((1, 0.0), (3, 1.0)):
        key.value = value
        key.keyframe_insert("value", frame=frame)
    animated(ob, "hide_render", (1, False), (2, True), (5, False))
    for frame in (1, 2, 3, 4, 5):
        render(frame)
    assert heights((0, 0)) == [4.0]


def check_topology_may_change_in_every_frame() -> None:
    ob = add("array", mesh("array"))
    array = ob.modifiers.new("array", "ARRAY")
    array.relative_offset_displace = (1, 0, 0)
    driver = array.driver_add("count").driver
    driver.type, driver.expression = "SCRIPTED", "frame"
    for frame in (3, 5, 1):
        assert render(frame)["triangles"] == 2 * frame
        places = [(2 * k, 0) for k in range(6)]
        assert heights(*places) == [0.0 if k < frame else None for k in range(6)]


def check_a_mesh_may_become_empty_and_come_back() -> None:
    ob = add("mask", grid("mask", 2))
    ob.vertex_groups.new(name="none")
    mask = ob.modifiers.new("mask", "MASK")
    mask.vertex_group = "none"
    for frame, shown in ((1, False), (2, True), (3, False)):
        mask.show_render = shown
        mask.keyframe_insert("show_render", frame=frame)
    assert [render(frame)["triangles"] for frame in (1, 2, 3)] == [8, 0, 8]


def check_a_deleted_object_is_gone_and_its_mesh_with_it() -> None:
    for x in range(3):
        add(str(x), mesh(str(x)), (3 * x, 0, 0))
    render()
    bpy.data.objects.remove(bpy.data.objects["1"])
    render()
    assert heights((0, 0), (3, 0), (6, 0)) == [0.0, None, 0.0]
    assert native().counts()["meshes"] == 2, native().counts()


def check_an_object_replaced_by_one_of_the_same_name_is_the_new_one() -> None:
    ob = add("square", mesh("square"), (0, 0, 1))
    render()
    bpy.data.objects.remove(ob)
    add("square", grid("other", 3), (0, 0, 2))
    statistics = render()
    assert statistics["triangles"] == 18
    assert heights((0.5, 0.5)) == [2.0]


def check_an_object_that_takes_another_mesh_shows_it_and_leaves_the_other_users() -> None:
    shared = mesh("shared")
    one, _ = add("one", shared), add("other", shared, (5, 0, 0))
    render()
    one.data = mesh("high", [(-1, -1, 3), (1, -1, 3), (1, 1, 3), (-1, 1, 3)])
    render()
    assert heights((0, 0), (5, 0)) == [3.0, 0.0]


def check_a_modifier_on_one_of_two_users_deforms_only_that_one() -> None:
    shared = mesh("shared")
    one, _ = add("one", shared), add("other", shared, (5, 0, 0))
    render()
    one.modifiers.new("move", "DISPLACE").strength = 2
    render()
    assert heights((0, 0), (5, 0)) == [1.0, 0.0]
    one.modifiers.clear()
    render()
    assert heights((0, 0), (5, 0)) == [0.0, 0.0]


def check_an_edited_mesh_is_read_for_all_its_users() -> None:
    shared = mesh("shared")
    add("one", shared)
    add("other", shared, (5, 0, 0))
    render()
    for vertex in shared.vertices:
        vertex.co.z = 2
    shared.update()
    render()
    assert heights((0, 0), (5, 0)) == [2.0, 2.0]


def check_a_collection_that_is_hidden_or_excluded_goes_and_comes_back() -> None:
    collection = bpy.data.collections.new("some")
    bpy.context.scene.collection.children.link(collection)
    collection.objects.link(bpy.data.objects.new("square", mesh("square")))
    layer = bpy.context.view_layer.layer_collection.children[0]
    seen = []
    for hidden, excluded in ((False, False), (True, False), (False, False), (False, True)):
        collection.hide_render, layer.exclude = hidden, excluded
        render()
        seen += heights((0, 0))
    assert seen == [0.0, None, 0.0, None]


def check_instances_follow_their_instancer_and_their_original() -> None:
    collection = bpy.data.collections.new("some")
    inside = bpy.data.objects.new("square", mesh("square"))
    collection.objects.link(inside)
    empty = add("empty", None)
    empty.instance_type, empty.instance_collection = "COLLECTION", collection
    render()
    empty.location.x = 5
    render()
    assert heights((5, 0)) == [0.0]
    inside.location.z = 2
    render()
    assert heights((5, 0)) == [2.0]
    for vertex in inside.data.vertices:
        vertex.co.z = 1
    inside.data.update()
    render()
    assert heights((5, 0)) == [3.0]
    inside.hide_render = True
    render()
    assert heights((5, 0)) == [None]


def check_particles_are_born_and_die() -> None:
    emitter = add("emitter", grid("grid", 4))
    shown = add("square", mesh("square"), (0, 0, -50))
    settings = emitter.modifiers.new("particles", "PARTICLE_SYSTEM").particle_system.settings
    settings.count, settings.frame_start, settings.frame_end, settings.lifetime = 20, 1, 10, 5
    settings.render_type, settings.instance_object = "OBJECT", shown
    settings.use_dead = settings.show_unborn = False
    emitter.show_instancer_for_render = False
    counts = [render(frame)["instances"] for frame in range(1, 20)]
    assert counts[0] < counts[5] > counts[-1], counts
    assert counts[-1] == 1, counts


def check_materials_are_read_when_they_change() -> None:
    def base(name: str) -> tuple[float, ...]:
        (kept,) = part("session")._sessions.values()
        materials = kept._reader.objects.materials
        row = materials._rows[bpy.data.materials[name].as_pointer()]
        return tuple(round(c, 3) for c in materials._looks[row].base_color)

    data = mesh("square")
    first = paint("paint", (0, 1, 0, 1))
    data.materials.append(first)
    ob = add("square", data)
    for frame, colour in ((1, (0, 1, 0, 1)), (3, (1, 0, 0, 1))):
        first.diffuse_color = colour
        first.keyframe_insert("diffuse_color", frame=frame)
    render(1)
    assert base("paint") == (0, 1, 0, 1)
    statistics = render(3)
    assert base("paint") == (1, 0, 0, 1)
    assert reads().read == 0
    assert statistics["nodes_refitted"] == 0
    other = paint("other", (0, 0, 1, 1))
    ob.material_slots[0].link = "OBJECT"
    ob.material_slots[0].material = other
    render(3)
    (kept,) = part("session")._sessions.values()
    objects = kept._reader.objects
    rows = kept._reader.table.rows
    (used,) = {objects.material_sets[index] for index in rows.materials.tolist()}
    assert used == (objects.materials._rows[other.as_pointer()],)


def check_lights_and_world_are_read_when_they_change() -> None:
    bpy.context.scene.regraft.shading = "direct"
    add("square", mesh("square"))
    light = bpy.data.lights.new("sun", "SUN")
    ob = add("sun", light)
    for frame, value in ((1, 1.0), (3, 5.0)):
        light.energy = value
        light.keyframe_insert("energy", frame=frame)
    animated(ob, "location", (1, (0, 0, 0)), (3, (0, 0, 7)))
    seen = []
    for frame in (1, 3):
        render(frame)
        (kept,) = part("session")._sessions.values()
        seen += kept._reader._lights
    assert [one.energy for one in seen] == [1.0, 5.0]
    assert [one.position[2] for one in seen] == [0.0, 7.0]
    ob.hide_render = True
    statistics = render()
    assert any("headlight" in text for text in statistics["left_out"]), statistics
    world = bpy.context.scene.world = bpy.data.worlds.new("world")
    if world.node_tree is None:
        world.color = (0.25, 0.5, 0.75)
    else:
        world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.25, 0.5, 0.75, 1)
    render()
    (kept,) = part("session")._sessions.values()
    assert kept._reader._world == (0.25, 0.5, 0.75)


def check_the_pass_index_follows() -> None:
    ob = add("square", mesh("square"))
    render()
    ob.pass_index = 7
    render()
    hit = native().closest_hit(np.array([[0.0, 0, 9]]), np.array([[0.0, 0, -1]]))
    assert hit.t[0] == 9.0
    (kept,) = part("session")._sessions.values()
    assert kept._reader.table.rows.object_indices.tolist() == [7]


def check_vertices_that_are_no_numbers_are_left_out_and_named() -> None:
    ob = add("broken", grid("broken", 2))
    ob.data.vertices[0].co = (float("nan"), 0, 0)
    statistics = render()
    assert statistics["triangles"] < 8 or any("finite" in t for t in statistics["warnings"])
    assert any("broken" in text for text in statistics["warnings"]), statistics


def check_a_matrix_that_is_not_finite_is_left_out_and_said() -> None:
    add("square", mesh("square"), (float("inf"), 0, 0))
    add("good", mesh("good"), (5, 0, 0))
    statistics = render()
    assert statistics["instances"] == 1
    assert any("not finite" in text for text in statistics["warnings"]), statistics
    assert heights((5, 0)) == [0.0]


def check_an_empty_scene_renders() -> None:
    statistics = render()
    assert statistics["triangles"] == 0


run(globals())
