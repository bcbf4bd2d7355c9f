"""Where rays start: what k-d trees split by p_N are worth to every kind of ray.

The surface area heuristic takes rays for lines from far away. p_N supposes that they start anywhere
in a box (Fabianowski, Fowler, Dingliana, A cost metric for scene-interior ray origins, Eurographics
2009); it can pay only where they do. Each metric's tree is built by the rays of one picture, which
are then traced again and counted.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from hashlib import blake2b
from math import inf
from time import perf_counter
from typing import Any

import numpy as np

import regraft
from regraft.study.mirror import Numbers
from regraft.study.shot import Shot
from regraft.study.stability import Rays, camera_rays
from regraft.study.tidy import quartiles

Row = dict[str, Any]
SAH = "sah"
# Computed as fast as the surface area heuristic, or nearly: those that the library chooses among.
CHEAP = (SAH, "regions6")
ALL = "all rays"
METRICS = (*CHEAP, "regions26", "faces", "exact")
# A triangle test in units of a node visited, as kernels that test four at once take it.
TEST = 0.4
# Of the way to a light, so that the light itself is not hit.
_NEARLY = 0.999
# One ray in so many says where rays start.
_PILOT = 100


@dataclass(frozen=True)
class RaySet:
    """Rays of one kind; `any_hit`: whether anything is hit up to their ends, else the nearest."""

    name: str
    rays: Rays
    any_hit: bool = False

    def trace(self, tree: regraft.KdTree) -> bytes:
        """What they hit, as bits."""
        rays = self.rays
        if self.any_hit:
            return tree.any_hit(rays.origins, rays.directions, 0.0, _NEARLY).tobytes()
        hits = tree.closest_hit(rays.origins, rays.directions)
        return hits.t.tobytes() + hits.instance_id.tobytes() + hits.prim_id.tobytes()


@dataclass(frozen=True)
class Room:
    """A scene with all that its rays are: `box` (2, 3), where they start; `chosen`, the metric that
    the library would take for them."""

    scene: regraft.Scene
    sets: Sequence[RaySet]
    box: Numbers
    chosen: str


@dataclass(frozen=True)
class Settings:
    """`size` of the square picture in pixels; `repeats` of all trees, as far as they would end
    within `minutes`, the first excepted."""

    size: int = 64
    repeats: int = 5
    minutes: float = inf

    def steps(self) -> int:
        """How often `measure` calls `tick`, at most."""
        return self.repeats * len(METRICS)


def room_of(shot: Shot, size: int, threads: int) -> Room:
    """The shot's first frame, and the rays of its picture."""
    scene = regraft.Scene(threads=threads)
    shot.apply(0, scene)
    scene.update(structure="kdtree")
    bounds = scene.bounds()
    sets = ray_sets(scene, camera_rays(shot.camera(0), bounds, size), bounds)
    inside = lights(bounds)[0]
    # Rays to the light inside may be taken from there; the light outside is another question.
    starts = [s.rays.origins for s in sets if not s.any_hit]
    starts.append(np.broadcast_to(inside, sets[1].rays.origins.shape))
    pilot = np.concatenate(starts)[::_PILOT]
    camera = sets[0].rays.origins[0]
    metric, box = regraft.KdTree(scene).choose_metric(pilot, camera)
    has_volume = bool(np.all(box[1] > box[0]))
    return Room(scene, sets, box if has_volume else bounds, metric)


def lights(bounds: Numbers) -> tuple[Numbers, Numbers]:
    """One in the middle of the scene's box, and one outside, two sizes from it."""
    middle = bounds.mean(axis=0)
    away = np.array([0.5, -0.25, 0.8]) * 2.0 * float(np.linalg.norm(np.ptp(bounds, axis=0)))
    return middle, middle + away


def ray_sets(scene: regraft.Scene, primary: Rays, bounds: Numbers) -> list[RaySet]:
    """The picture's rays, and those from what they hit to both lights and into mirrors."""
    hits = scene.closest_hit(primary.origins, primary.directions)
    met = np.isfinite(hits.t)
    seen, normals = primary[met], hits.normal[met].astype(np.float64)
    facing = np.einsum("ij,ij->i", seen.directions, normals)
    normals *= -np.sign(facing)[:, None]
    off = 1e-4 * float(np.linalg.norm(np.ptp(bounds, axis=0)))
    points = seen.origins + seen.directions * hits.t[met, None] + off * normals
    mirrored = seen.directions + 2.0 * np.abs(facing)[:, None] * normals
    inside, outside = lights(bounds)
    return [
        RaySet("primary", primary),
        RaySet("shadow, light inside", Rays(points, inside - points), any_hit=True),
        RaySet("shadow, light outside", Rays(points, outside - points), any_hit=True),
        RaySet("reflection", Rays(points, mirrored)),
    ]


def measure(room: Room, settings: Settings, tick: Callable[[object], None]) -> Iterator[Row]:
    """A row for each tree and kind of ray. Whoever came first in one repeat comes last in the
    next; counts do not change."""
    racing, started = list(METRICS), perf_counter()
    for repeat in range(settings.repeats):
        if repeat and (perf_counter() - started) * (repeat + 1) / repeat > 60 * settings.minutes:
            return
        for metric in racing:
            for row in _measure(room, metric):
                yield {"repeat": repeat, **row}
            tick(f"repeat {repeat + 1}, {metric}")
        racing = [*racing[1:], racing[0]]


def _measure(room: Room, metric: str) -> Iterator[Row]:
    started = perf_counter()
    tree = regraft.KdTree(room.scene, metric=metric, origins=room.box)
    found = [rays.trace(tree) for rays in room.sets]
    first_s = perf_counter() - started
    rows: list[Row] = []
    for rays, before in zip(room.sets, found, strict=True):
        counted, started = tree.statistics(), perf_counter()
        again = rays.trace(tree)
        spent, now = perf_counter() - started, tree.statistics()
        work = {n: int(now[n] - counted[n]) for n in ("nodes_visited", "triangle_tests")}
        rows.append(
            {
                "metric": metric,
                "rays": rays.name,
                "count": len(rays.rays.origins),
                **work,
                "cost": work["nodes_visited"] + TEST * work["triangle_tests"],
                "trace_s": spent,
                "is_same": again == before,
                "hits": _digest(again),
            }
        )
    build_s = max(first_s - sum(row["trace_s"] for row in rows), 0.0)
    nodes = int(tree.statistics()["nodes"])
    yield from ({**row, "build_s": build_s, "nodes": nodes} for row in rows)


def _digest(hits: bytes) -> str:
    return blake2b(hits, digest_size=8).hexdigest()


def table(rows: Sequence[Row]) -> list[Row]:
    """A row for each metric and kind of ray, and one for all kinds together: medians, and the cost
    beside that of the surface area heuristic."""
    merged = []
    for metric in METRICS:
        mine = [row for row in rows if row["metric"] == metric]
        kinds = dict.fromkeys(row["rays"] for row in mine)
        groups = [[row for row in mine if row["rays"] == kind] for kind in kinds]
        merged += (parts := [_merged(group) for group in groups])
        merged.append(_all(parts))
    base = {row["rays"]: row["cost"] for row in merged if row["metric"] == SAH}
    for row in merged:
        row["cost_ratio"] = row["cost"] / base[row["rays"]] if base[row["rays"]] else 1.0
    return merged


def _merged(group: Sequence[Row]) -> Row:
    first = group[0]
    names = ("metric", "rays", "count", "nodes_visited", "triangle_tests", "cost", "nodes")
    out = {name: first[name] for name in names}
    for name in ("build_s", "trace_s"):
        low, middle, high = quartiles([row[name] for row in group])
        out |= {name: middle, f"{name}_low": low, f"{name}_high": high}
    return out


def _all(parts: Sequence[Row]) -> Row:
    names = ("count", "nodes_visited", "triangle_tests", "cost", "trace_s")
    sums = {name: sum(row[name] for row in parts) for name in names}
    shared = {name: parts[0][name] for name in ("metric", "nodes", "build_s")}
    return {**shared, "rays": ALL, **sums}


def different_hits(rows: Sequence[Row]) -> list[str]:
    """Metrics whose rays do not hit what those of the first metric hit: there must be none."""
    expected: dict[str, str] = {}
    return [
        row["metric"]
        for row in rows
        if expected.setdefault(row["rays"], row["hits"]) != row["hits"] or not row["is_same"]
    ]
