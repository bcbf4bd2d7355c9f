"""Numerical stability: the same scene far away, huge, tiny, stretched, and in greater steps.

An affine map changes neither what a mapped ray hits nor its t, which counts in lengths of the
ray. So hits of the mapped scene are held against those of the scene as it is, and their t against
the plane of the triangle in double precision.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

import regraft
from regraft.study import key_frames, offers
from regraft.study.mirror import Mirror
from regraft.study.shot import Shot

Row = dict[str, Any]
Numbers = npt.NDArray[np.float64]
# Exponents of two: offsets in sizes of the scene, scales, and stretches of x with z shrunk alike.
EXPONENTS = {
    "offset": (0, 4, 8, 12, 16, 20, 24, 28, 32, 36, 40),
    "scale": (-100, -80, -60, -40, -20, -10, 10, 20, 40, 60, 80, 100),
    "aspect": (2, 4, 6, 8, 10, 12, 14, 16, 20, 24, 28),
}
TIME_STEPS = (1.0, 10.0, 100.0)
# Of a shot that is played in greater steps: frames that are updated, and those in which rays are
# traced as well.
MOST_FRAMES, MOST_LOOKS = 24, 6
# A pixel that differs by more than this has changed.
VISIBLE = 1.0 / 255.0
# Rays times triangles that brute force may test for one row.
_BRUTE_TESTS = 1e7


@dataclass(frozen=True)
class Rays:
    """(N, 3) each, in the world of the scene as it is."""

    origins: Numbers
    directions: Numbers

    def __getitem__(self, chosen: Any) -> Rays:
        return Rays(self.origins[chosen], self.directions[chosen])

    def mapped(self, m: Numbers) -> Rays:
        return Rays(self.origins @ m[:3, :3].T + m[:3, 3], self.directions @ m[:3, :3].T)


def keepings() -> list[tuple[str, str]]:
    """Structure and layout of every way to keep a scene; a k-d tree knows no layouts."""
    bvhs = [("bvh", layout) for layout in offers.LAYOUTS]
    return bvhs + [(s, offers.LAYOUTS[0]) for s in offers.structures() if s != "bvh"]


def camera_rays(camera: regraft.Camera, bounds: Numbers, side: int) -> Rays:
    """Through the centres of side × side pixels, rounded so that offsets add without loss."""
    if camera.kind != "perspective":
        corners = np.array(np.meshgrid(*bounds.T)).reshape(3, -1).T
        camera = regraft.camera.frame_points(corners, 1.0)
    left, right, bottom, top = camera.window
    x = left + (right - left) * (np.arange(side) + 0.5) / side
    y = bottom + (top - bottom) * (np.arange(side) + 0.5) / side
    local = np.stack(np.meshgrid(x, y, [-1.0], indexing="ij"), axis=-1).reshape(-1, 3)
    size = _size(bounds)
    origin = _rounded(camera.matrix[:3, 3], size)
    directions = _rounded(local @ camera.matrix[:3, :3].T * size, size)
    return Rays(np.broadcast_to(origin, directions.shape).copy(), directions)


def _size(bounds: Numbers) -> float:
    """A power of two, at least the longest side."""
    return float(2.0 ** np.ceil(np.log2(max(np.ptp(bounds, axis=0).max(), 1e-30))))


def _rounded(values: Numbers, size: float) -> Numbers:
    grid = size * 2.0**-20
    return np.asarray(np.round(values / grid) * grid)


def place(axis: str, exponent: int, size: float) -> Numbers:
    """The map of a setting."""
    m, by = np.eye(4), 2.0**exponent
    if axis == "offset":
        m[:3, 3] = by * size, -by * size, by * size
    else:
        m[:3, :3] = np.diag([by] * 3 if axis == "scale" else [by, 1.0, 1.0 / by])
    return m


def measure(shot: Shot, side: int, threads: int, tick: Callable[[object], None]) -> Iterator[Row]:
    """A row for each setting and way of keeping the scene, on the shot's first frame."""
    for structure, layout in keepings():
        mirror = Mirror(regraft.Scene(threads=threads))
        shot.apply(0, mirror)
        mirror.update(structure=structure, layout=layout)
        rays = camera_rays(shot.camera(0), mirror.bounds(), side)
        size = _size(mirror.bounds())
        wanted = mirror.closest_hit(rays.origins, rays.directions)
        for axis, exponents in EXPONENTS.items():
            for exponent in exponents:
                m = place(axis, exponent, size)
                mirror.see_through(m)
                mirror.update(structure=structure, layout=layout)
                found = _found(mirror, rays, m)
                yield {
                    "axis": axis,
                    "exponent": exponent,
                    "structure": structure,
                    "layout": layout,
                    "policy": "auto",
                    **found.row(),
                    **_changes(wanted, found.hits, rays, m),
                }
                tick(f"{axis} 2^{exponent}, {structure} {layout}")


@dataclass(frozen=True)
class _Found:
    hits: Any
    ulps: Numbers
    unequal: int

    def row(self) -> Row:
        hit = self.ulps.size > 0
        return {
            "hits": int(self.ulps.size),
            "worst_ulps": float(self.ulps.max()) if hit else None,
            "median_ulps": float(np.median(self.ulps)) if hit else None,
            "differ_from_brute_force": self.unequal,
        }


def _found(mirror: Mirror, rays: Rays, m: Numbers) -> _Found:
    there = rays.mapped(m)
    hits = mirror.closest_hit(there.origins, there.directions)
    return _Found(hits, _errors(mirror, rays, hits, m), _unequal(mirror, there, hits))


def _errors(mirror: Mirror, rays: Rays, hits: Any, m: Numbers) -> Numbers:
    """|t − t of the triangle's plane| for each hit, in ulps of the largest coordinate at hand over
    the direction's length, both where the scene was mapped to by `m`: one such ulp is what a
    corner's rounding may do to t. True ones are taken from the scene as it is."""
    met = np.isfinite(hits.t)
    aimed, there = rays[met], rays[met].mapped(m)
    corners = mirror.corners(hits.instance_id[met], hits.prim_id[met])
    normal = _normals(corners)
    along = np.einsum("ij,ij->i", aimed.directions, normal)
    start = np.einsum("ij,ij->i", corners[:, 0] - aimed.origins, normal)
    mapped = corners @ m[:3, :3].T + m[:3, 3]
    # A grazing ray's t says little: there the error counts across the plane.
    facing = _normals(mapped)
    with np.errstate(all="ignore"):
        facing /= np.linalg.norm(facing, axis=1)[:, None]
        across = np.abs(np.einsum("ij,ij->i", there.directions, facing))
        off = np.abs(hits.t[met] - start / along) * across
        largest = np.maximum(np.abs(there.origins).max(axis=1), np.abs(mapped).max(axis=(1, 2)))
        ulps = off / (largest * 2.0**-23)
    return np.asarray(ulps[np.isfinite(ulps)])


def _normals(corners: Numbers) -> Numbers:
    """(N, 3) of (N, 3, 3) corners, as long as edges that are at most 1: scales of 1e±30 have no
    squares of areas."""
    edges = corners[:, 1:] - corners[:, :1]
    longest = np.abs(edges).max(axis=(1, 2), keepdims=True)
    with np.errstate(all="ignore"):
        edges = edges / longest
    return np.asarray(np.cross(edges[:, 0], edges[:, 1]))


def _unequal(mirror: Mirror, there: Rays, hits: Any) -> int:
    """Of a sample of the rays, those that brute force answers otherwise."""
    count = int(np.clip(_BRUTE_TESTS / max(mirror.counts()["triangles"], 1), 16, len(hits.t)))
    chosen = np.linspace(0, len(hits.t) - 1, count).astype(int)
    aimed = there[chosen]
    true = mirror.closest_hit_brute_force(aimed.origins, aimed.directions)
    same = np.ones(count, bool)
    for name in ("t", "instance_id", "prim_id", "u", "v"):
        a, b = getattr(hits, name)[chosen], getattr(true, name)
        same &= a.view(np.uint32) == b.view(np.uint32)
    return int(count - same.sum())


def _changes(wanted: Any, found: Any, rays: Rays, m: Numbers) -> Row:
    other = (wanted.instance_id != found.instance_id) | (wanted.prim_id != found.prim_id)
    before, after = brightness(wanted, rays, np.eye(4)), brightness(found, rays, m)
    return {
        "other_triangles": int(other.sum()),
        "pixels_changed": int((np.abs(before - after) > VISIBLE).sum()),
    }


def brightness(hits: Any, rays: Rays, m: Numbers) -> Numbers:
    """(N,) of each ray's pixel in the scene as it is, lit from the eye; 0 where nothing is."""
    # Normals of the mapped scene, taken back: they map by the inverse transpose.
    normals = hits.normal.astype(np.float64) @ m[:3, :3]
    lengths = np.linalg.norm(normals, axis=1) * np.linalg.norm(rays.directions, axis=1)
    facing = np.abs(np.einsum("ij,ij->i", normals, rays.directions))
    pixels: Numbers = np.zeros_like(facing)
    np.divide(facing, lengths, out=pixels, where=lengths > 0)
    return pixels


def steps(shot: Shot) -> int:
    """How often `measure` and `measure_steps` together call `tick`."""
    settings = sum(map(len, EXPONENTS.values())) * len(keepings())
    return settings + (len(TIME_STEPS) * len(offers.policies()) if len(shot) > 1 else 0)


def measure_steps(
    shot: Shot, side: int, threads: int, tick: Callable[[object], None]
) -> Iterator[Row]:
    """A row for each time step and policy: the worst of the shot, motion exaggerated."""
    for step in TIME_STEPS if len(shot) > 1 else ():
        for policy in offers.policies():
            worst: Row = {}
            for row in _play(shot, side, threads, step, policy):
                for key, value in row.items():
                    worst[key] = max(worst.get(key) or 0, value or 0)
            yield {"axis": "time step", "exponent": step, "policy": policy, **worst}
            tick(f"time step × {step:g}, {policy}")


def _play(shot: Shot, side: int, threads: int, step: float, policy: str) -> Iterator[Row]:
    """Every frame is updated; rays are traced in some, the last among them."""
    mirror = Mirror(regraft.Scene(threads=threads), step)
    count = min(len(shot), MOST_FRAMES)
    looked_at = {round(i) for i in np.linspace(1, count - 1, min(count - 1, MOST_LOOKS))}
    for position in range(count):
        shot.apply(position, mirror)
        if policy == "shot":
            key_frames.give(shot, mirror.scene, position)
        mirror.update(policy=policy)
        if position in looked_at and mirror.counts()["triangles"]:
            rays = _through(mirror.bounds(), side * side // 4, position)
            yield _found(mirror, rays, np.eye(4)).row()


def _through(bounds: Numbers, count: int, seed: int) -> Rays:
    """Between random points of the box."""
    ends = bounds[0] + np.ptp(bounds, axis=0) * np.random.default_rng(seed).random((2, count, 3))
    return Rays(ends[0], ends[1] - ends[0])


def first_change(rows: Sequence[Row], axis: str) -> Row | None:
    """The setting nearest to the scene as it is whose picture has changed."""
    changed = [r for r in rows if r["axis"] == axis and r.get("pixels_changed")]
    return min(changed, key=lambda row: abs(row["exponent"]), default=None)
