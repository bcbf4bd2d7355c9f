"""Objects are looked through one by one only where Blender cannot say which of them changed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import bpy
from harness import add, grid, heights, mesh, part, render, run


@contextmanager
def walks() -> Iterator[list[object]]:
    """Within the block, every walk over the objects adds an entry."""
    walked: list[object] = []
    module = part("sync.object_list")
    walk, module.Walk._walk = module.Walk._walk, lambda *a: walked.append(a) or walk(*a)
    try:
        yield walked
    finally:
        module.Walk._walk = walk


@contextmanager
def frame_handler(handler: Callable[..., None]) -> Iterator[None]:
    """Within the block, `handler` runs before every change of frame."""
    bpy.app.handlers.frame_change_pre.append(handler)
    try:
        yield
    finally:
        bpy.app.handlers.frame_change_pre.remove(handler)


def animate(last: int) -> None:
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, last
    bpy.ops.render.render(animation=True)


def check_a_scene_that_is_flagged_causes_no_walk() -> None:
    """As by a property of the scene with a key, or by a handler that writes one."""
    moving = add("moving", mesh("square"), (0, 0, 1))
    for frame, height in ((1, 1.0), (3, 3.0)):
        moving.location.z = height
        moving.keyframe_insert("location", frame=frame)

    def flag(scene: bpy.types.Scene, *_arguments: object) -> None:
        scene["counter"] = scene.frame_current
        scene.gravity = (0, 0, -scene.frame_current)

    render(1)
    with frame_handler(flag), walks() as walked:
        render(2)
        statistics = render(3)
    assert walked == []
    assert statistics["moved_instances"] == 1
    assert heights((0, 0)) == [3.0]


def check_an_object_replaced_while_a_frame_handler_runs_is_the_new_one() -> None:
    add("square", mesh("square"), (0, 0, 1))

    def replace(scene: bpy.types.Scene, *_arguments: object) -> None:
        if scene.frame_current == 2:
            bpy.data.objects.remove(bpy.data.objects["square"])
            add("square", mesh("other"), (0, 0, 2))

    with frame_handler(replace):
        animate(3)
    assert heights((0, 0)) == [2.0]
    assert len(part("session").history()) == 3


def check_an_object_deleted_while_a_frame_handler_runs_is_gone() -> None:
    add("stays", mesh("stays"), (5, 0, 0))
    add("goes", mesh("goes"))

    def delete(scene: bpy.types.Scene, *_arguments: object) -> None:
        if scene.frame_current == 2 and "goes" in bpy.data.objects:
            bpy.data.objects.remove(bpy.data.objects["goes"])

    with frame_handler(delete):
        animate(3)
    assert heights((0, 0), (5, 0)) == [None, 0.0]
    assert len(part("session").history()) == 3


def check_nodes_that_move_their_instances_cause_no_walk() -> None:
    tree = scattering_nodes()
    target = add("cube", mesh("square"), (0, 0, -50))
    tree.nodes["Object Info"].inputs["Object"].default_value = target
    points = add("points", grid("grid", 3))
    points.modifiers.new("nodes", "NODES").node_group = tree
    factor = tree.nodes["Transform"].inputs["Translation"]
    for frame, height in ((1, 0.0), (3, 4.0)):
        factor.default_value = (0, 0, height)
        factor.keyframe_insert("default_value", frame=frame)
    render(1)
    with walks() as walked:
        statistics = render(3)
    assert walked == []
    assert statistics["moved_instances"] == 16, statistics
    assert heights((0, 0), (1, 1)) == [4.0, 4.0]
    points.show_instancer_for_render = False
    render(3)
    points.show_instancer_for_render = True
    for vertex in target.data.vertices:
        vertex.co.z = 1
    target.data.update()
    render(3)
    assert heights((0, 0), (1, 1)) == [5.0, 5.0]


def scattering_nodes() -> bpy.types.NodeTree:
    """An object on every point, all moved together."""
    tree = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
    if hasattr(tree, "interface"):
        tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    else:
        tree.inputs.new("NodeSocketGeometry", "Geometry")
        tree.outputs.new("NodeSocketGeometry", "Geometry")
    kinds = ("NodeGroupInput", "GeometryNodeObjectInfo", "GeometryNodeInstanceOnPoints",
             "GeometryNodeTransform", "NodeGroupOutput")  # fmt: skip
    points, info, place, move, out = (tree.nodes.new(kind) for kind in kinds)
    info.name, move.name = "Object Info", "Transform"
    info.inputs["As Instance"].default_value = True
    tree.links.new(points.outputs[0], place.inputs["Points"])
    tree.links.new(info.outputs["Geometry"], place.inputs["Instance"])
    tree.links.new(place.outputs["Instances"], move.inputs["Geometry"])
    tree.links.new(move.outputs[0], out.inputs[0])
    return tree


run(globals())
