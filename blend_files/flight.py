"""Makes shards fly: a throw, one bounce and a spin, as formulas of scene time that geometry nodes
evaluate per vertex.

The shards' polygons are triangulated by a source object that does not depend on time, so Blender
does that once a file and a frame costs only the formula.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from field_kit import Field, Graph
from fracture import Shards
from numpy.typing import NDArray
from scene_kit import mesh_from_arrays, quantised, set_attribute

Array = NDArray[np.float64]
GRAVITY = 5.0  # m/s²: half the earth's, which reads as a large blast in slow motion


@dataclass
class Flight:
    """How each shard (S,) moves: velocity and spin (S, 3) in m/s and rad/s; times (S, 3) in
    seconds: when it starts, how long it flies, how long its one bounce lasts."""

    velocity: Array
    spin: Array
    times: Array


def throw(
    places: Array,
    outward: Array,
    landing_height: Callable[[Array], Array],
    rng: np.random.Generator,
) -> Flight:
    """Throws shards at world places (S, 3) along `outward` (S, 3), until they bounce once."""
    count = len(places)
    direction = outward / np.linalg.norm(outward, axis=1, keepdims=True) + rng.normal(
        0, 0.3, (count, 3)
    )
    velocity = direction * np.exp(rng.normal(1.25, 0.55, (count, 1)))
    velocity[:, 2] = np.abs(velocity[:, 2]) * 1.1 + 0.4
    spin = rng.normal(0, 3.0, (count, 3))
    flight_time = np.full(count, 1.0)
    for _ in range(6):  # the landing height depends on where the shard comes down
        drop = np.maximum(
            places[:, 2] - landing_height(places + velocity * flight_time[:, None]), 0
        )
        climb = velocity[:, 2]
        flight_time = (climb + np.sqrt(climb**2 + 2 * GRAVITY * drop)) / GRAVITY
    bounce = 0.6 * (GRAVITY * flight_time - velocity[:, 2]) / GRAVITY
    radius = np.linalg.norm(outward, axis=1)
    start = 0.12 * (1 - radius / radius.max())
    return Flight(velocity, spin, np.stack([start, flight_time, bounce], axis=1))


def shard_mesh(
    name: str, shards: Shards, surface: bpy.types.Material, inside: Sequence[bpy.types.Material]
) -> bpy.types.Mesh:
    """The shards as one mesh of polygons, whole as the solid was; broken faces change material from
    core to surface.
    """
    mesh = mesh_from_arrays(
        name, shards.vertices, shards.corners, (surface, *inside), sizes=shards.sizes
    )
    radius = np.linalg.norm(shards.points - shards.centre, axis=1)
    layer = np.minimum(radius / radius.max() * len(inside), len(inside) - 1).astype(np.int32)
    shard_of_face = shards.shard[shards.corners[np.cumsum(shards.sizes) - 1]]
    mesh.polygons.foreach_set(
        "material_index", np.where(shards.is_surface, 0, 1 + layer[shard_of_face]).astype(np.int32)
    )
    return mesh


def store_flight(mesh: bpy.types.Mesh, shards: Shards, flight: Flight) -> None:
    """Gives every vertex its shard's centre and flight, no finer than the eye needs."""
    for name, values, step in (
        ("centre", shards.points, 1 / 256),
        ("velocity", flight.velocity, 1 / 128),
        ("spin", flight.spin, 1 / 32),
        ("times", flight.times, 1 / 128),
    ):
        set_attribute(mesh, name, quantised(values, step)[shards.shard])


def prepare_shards(source: bpy.types.Object) -> None:
    """Triangulates the shards and stores what of the spin does not depend on time; evaluated once a
    file.

    A point at r from the centre turns to r + (cos a − 1) p + sin a (k × r), with k the axis and p
    the part of r across it.
    """
    graph = Graph("Prepare shards")
    graph.pass_through(graph.node("GeometryNodeTriangulate"), "Mesh")
    spin = graph.named("spin", "vector")
    axis = spin.normalised()
    arm = graph.position() - graph.named("centre", "vector")
    graph.store("across", arm - axis * arm.dot(axis))
    graph.store("turned", axis.cross(arm))
    graph.store("rate", spin.length())
    graph.put_on(source)


def put_flight_on(thing: bpy.types.Object, source: bpy.types.Object, fuse_seconds: float) -> None:
    """Makes `thing` show the source's shards in flight, from `fuse_seconds` of scene time on."""
    prepare_shards(source)
    graph = Graph("Fly apart")
    graph.geometry = graph.object_geometry(source)
    graph.move_by(flight_offset(graph, graph.seconds() - fuse_seconds))
    graph.put_on(thing)


def flight_offset(graph: Graph, seconds: Field) -> Field:
    """The vector by which a shard's vertex has moved `seconds` after the blast."""
    start, flying, bouncing = graph.named("times", "vector").split()
    velocity = graph.named("velocity", "vector")
    after = seconds - start
    throw_time = after.maximum(0.0).minimum(flying)
    bounce_time = (after - flying).maximum(0.0).minimum(bouncing)
    fall = (throw_time * throw_time + bounce_time * (bounce_time - bouncing)) * (-GRAVITY / 2)
    angle = graph.named("rate", "float") * (throw_time + bounce_time)
    ahead = throw_time + bounce_time * 0.45
    across, up, rise = velocity.split()
    flown = graph.vector(across * ahead, up * ahead, rise * throw_time + fall)
    turn = (
        graph.named("across", "vector") * (angle.cosine() - 1.0)
        + graph.named("turned", "vector") * angle.sine()
    )
    return flown + turn
