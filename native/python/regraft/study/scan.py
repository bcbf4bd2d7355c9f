"""Splits of the scan against exact ones: what an error costs, and what avoiding it does.

A scan (Hunt, Mark, Stoll 2006, and the certificate of kdtree/sah_scan.h) either tries a fixed
number of planes in two passes, or goes on until it has proven that no plane is cheaper than 1/(1 +
ε) of the one it chose. Errors are those at the nodes of the tree that exact splits make; times are
those of whole trees over all triangles, and of a picture's rays in them.
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
from regraft.study.shot import Shot
from regraft.study.stability import Rays, camera_rays
from regraft.study.tidy import quartiles

Row = dict[str, Any]
# Planes of a pass and one: doubled, all the planes of before are tried again.
PLANES = (2, 4, 8, 16, 32, 64)
EPSILONS = (0.3, 0.1, 0.03, 0.01, 0.0)
EXACT = "exact"
# What the library takes where nobody asks for anything else.
DEFAULT = "ε = 0.3"


@dataclass(frozen=True)
class Splitter:
    """One way to choose planes; without `planes` until the error is proven to be below ε."""

    epsilon: float = inf
    planes: int | None = None
    is_exact: bool = False

    @property
    def label(self) -> str:
        if self.is_exact:
            return EXACT
        return f"ε = {self.epsilon:g}" if self.planes is None else f"k = {self.planes}"

    @property
    def scan(self) -> tuple[float, int]:
        """Its ε and number of planes a pass, as the library wants them."""
        return self.epsilon, 15 if self.planes is None else self.planes - 1

    def tree(self, scene: regraft.Scene) -> regraft.KdTree:
        """All of a tree over all triangles."""
        epsilon, samples = self.scan
        build = "eager" if self.is_exact else "scan"
        return regraft.KdTree(scene, build, epsilon=epsilon, samples=samples)


SPLITTERS = (
    Splitter(is_exact=True),
    *(Splitter(planes=planes) for planes in PLANES),
    *(Splitter(epsilon) for epsilon in EPSILONS),
)


@dataclass(frozen=True)
class Settings:
    """`size` of the square picture in pixels; `repeats` of all trees, as far as they would end
    within `minutes`, the first excepted; `threads` 0 for all."""

    size: int = 256
    repeats: int = 5
    minutes: float = inf
    threads: int = 0

    def steps(self) -> int:
        """How often `measure` calls `tick`, at most."""
        return 1 + self.repeats * len(SPLITTERS)


def scene_of(shot: Shot, threads: int) -> regraft.Scene:
    """The shot's first frame, for a k-d tree."""
    scene = regraft.Scene(threads=threads)
    shot.apply(0, scene)
    scene.update(structure="kdtree")
    return scene


def errors(scene: regraft.Scene) -> dict[str, Row]:
    """Of each scan by its label: errors over the nodes of the exact tree."""
    scans = [splitter for splitter in SPLITTERS if not splitter.is_exact]
    lazy = regraft.KdTree(scene)
    found = lazy.split_errors([splitter.scan for splitter in scans])
    return {splitter.label: row for splitter, row in zip(scans, found, strict=True)}


def measure(
    scene: regraft.Scene, rays: Rays, settings: Settings, tick: Callable[[object], None]
) -> Iterator[Row]:
    """A row for each tree that is built. Whoever came first in one repeat comes last in the
    next."""
    # The first tree looks into meshes; later ones find that done.
    _measure(scene, SPLITTERS[1], rays)
    racing, started = list(SPLITTERS), perf_counter()
    for repeat in range(settings.repeats):
        if repeat and (perf_counter() - started) * (repeat + 1) / repeat > 60 * settings.minutes:
            return
        for splitter in racing:
            yield {"repeat": repeat, **_measure(scene, splitter, rays)}
            tick(f"repeat {repeat + 1}, {splitter.label}")
        racing = [*racing[1:], racing[0]]


def rays_of(shot: Shot, scene: regraft.Scene, size: int) -> Rays:
    """Through the pixels of the first frame's picture."""
    return camera_rays(shot.camera(0), scene.bounds(), size)


def _measure(scene: regraft.Scene, splitter: Splitter, rays: Rays) -> Row:
    started = perf_counter()
    tree = splitter.tree(scene)
    built = perf_counter()
    hits = tree.closest_hit(rays.origins, rays.directions)
    traced = perf_counter()
    about = tree.statistics()
    return {
        "splits": splitter.label,
        "planes": splitter.planes,
        "epsilon": None if splitter.is_exact or splitter.planes else splitter.epsilon,
        "build_s": built - started,
        "trace_s": traced - built,
        **{name: about[name] for name in ("nodes", "references", "sam_cost", "bytes")},
        **{name: about[name] for name in ("nodes_visited", "triangle_tests")},
        "hits": _fingerprint(hits),
    }


def _fingerprint(hits: regraft.HitBatch) -> str:
    found = (hits.t.view(np.uint32), hits.instance_id, hits.prim_id)
    return blake2b(b"".join(a.tobytes() for a in found), digest_size=8).hexdigest()


def table(rows: Sequence[Row], found: dict[str, Row]) -> list[Row]:
    """A row for each way to choose planes: medians of `measure`, errors of `errors`."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(row["splits"], []).append(row)
    merged = [_merged(groups[s.label]) for s in SPLITTERS if s.label in groups]
    base = next(row for row in merged if row["splits"] == EXACT)
    for row in merged:
        row["sam_ratio"] = row["sam_cost"] / base["sam_cost"] if base["sam_cost"] else 1.0
        row |= found.get(row["splits"], {})
    return merged


def _merged(group: Sequence[Row]) -> Row:
    first = group[0]
    out = {name: first[name] for name in ("splits", "planes", "epsilon")}
    for name in ("build_s", "trace_s"):
        low, middle, high = quartiles([row[name] for row in group])
        out |= {name: middle, f"{name}_low": low, f"{name}_high": high}
    out["total_s"] = out["build_s"] + out["trace_s"]
    names = ("nodes", "references", "sam_cost", "nodes_visited", "triangle_tests")
    return out | {name: first[name] for name in names}


def different_hits(rows: Sequence[Row]) -> list[str]:
    """Labels of those whose picture is not that of the first: there must be none."""
    return [row["splits"] for row in rows if row["hits"] != rows[0]["hits"]]
