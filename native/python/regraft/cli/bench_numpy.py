"""`regraft bench numpy`: rays asked for from Python, beside Blender's BVHTree and embreex."""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
import numpy.typing as npt

import regraft
from regraft.cli import options
from regraft.cli.console import Console
from regraft.cli.doctor import usable_cores
from regraft.cli.errors import EXIT_OK
from regraft.cli.machine import machine, machine_line, save_result
from regraft.study import local_motion

Row = dict[str, Any]
Rows = npt.NDArray[np.float32]
BVHTREE, EMBREEX = "BVHTree", "embreex"
# BVHTree is asked for so many rays only: it takes one a call.
FEW = 20_000


@dataclass(frozen=True)
class Rays:
    """Origins and directions, (N, 3) each."""

    name: str
    origins: Rows
    directions: Rows

    def of(self, most: int | None) -> tuple[Rows, Rows]:
        """About `most` of them, evenly; None: all."""
        step = max(1, len(self.origins) // (most or len(self.origins)))
        return self.origins[::step], self.directions[::step]


@dataclass(frozen=True)
class Contender:
    """`shoot` returns how many of the rays hit; of more than `most` it is given some, evenly."""

    name: str
    shoot: Callable[[Rows, Rows], int]
    most: int | None = None


def add_parser(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `bench numpy`."""
    parser = kinds.add_parser(
        "numpy",
        help="rays asked for from Python, beside BVHTree and embreex",
        description="Ask for the nearest hits of rays in NumPy arrays: ours with one and all "
        "threads, and where they are installed Blender's mathutils.BVHTree (one ray a call, "
        f"{FEW} of them) and embreex (`pip install embreex`; one thread), taking turns.",
    )
    parser.set_defaults(run=run)
    for name, default, most in (
        ("triangles", 250_000, 20_000_000),
        ("rays", 1_000_000, 100_000_000),
    ):
        parser.add_argument(
            f"--{name}",
            type=options.whole_number(2, most),
            default=default,
            metavar="N",
            help="(default: %(default)s)",
        )
    parser.add_argument(
        "--rounds",
        type=options.whole_number(1, 1000),
        default=5,
        metavar="N",
        help="of which medians are taken (default: %(default)s)",
    )
    parser.add_argument(
        "--output",
        type=options.file_with_suffix(".json"),
        metavar="FILE.json",
        default=Path("bench_numpy.json"),
        help="(default: %(default)s)",
    )


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft bench numpy`; raises CommandError. Returns the exit code."""
    points, faces = local_motion.hills(args.triangles)
    contenders = [*_ours(points, faces), *_bvhtree(points, faces), *_embreex(points, faces)]
    rows = [row for rays in sets(args.rays) for row in race(rays, contenders, args.rounds)]
    asked = {"triangles": len(faces), "rays": args.rays, "rounds": args.rounds}
    result = {"benchmark": "numpy", **machine(), **asked, "rows": rows}
    save_result(args.output, result)
    for line in table(result):
        console.say(line)
    console.say(f"JSON: {args.output}")
    return EXIT_OK


def sets(count: int) -> Iterator[Rays]:
    """A picture of the hills, row by row; its rays in any order; from anywhere to anywhere."""
    side = max(1, round(count**0.5))
    camera = local_motion.view()
    left, right, bottom, top = camera.window
    x = left + (np.arange(side) + 0.5) / side * (right - left)
    y = bottom + (np.arange(side) + 0.5) / side * (top - bottom)
    seen = np.stack([*np.meshgrid(x, y), np.full((side, side), -1.0)], axis=-1).reshape(-1, 3)
    directions = (seen @ camera.matrix[:3, :3].T).astype(np.float32)
    origins = np.tile(camera.matrix[:3, 3].astype(np.float32), (len(directions), 1))
    yield Rays("picture", origins, directions)
    random = np.random.default_rng(3)
    order = random.permutation(len(directions))
    yield Rays("picture, any order", origins, directions[order])
    starts = random.random((count, 3)) * (1.0, 1.0, 0.3)
    ways = random.normal(size=(count, 3))
    yield Rays("everywhere", starts.astype(np.float32), ways.astype(np.float32))


def race(rays: Rays, contenders: Sequence[Contender], rounds: int) -> Iterator[Row]:
    """A row a contender: medians over rounds in which they take turns."""
    times: dict[str, list[tuple[float, float]]] = {c.name: [] for c in contenders}
    hits: dict[str, int] = {}
    for _ in range(rounds):
        for c in contenders:
            origins, directions = rays.of(c.most)
            wall, cpu = time.perf_counter(), time.process_time()
            hits[c.name] = c.shoot(origins, directions)
            times[c.name].append((time.perf_counter() - wall, time.process_time() - cpu))
    for c in contenders:
        wall, cpu = (median(column) for column in zip(*times[c.name], strict=True))
        count = len(rays.of(c.most)[0])
        about = {"rays": rays.name, "contender": c.name, "count": count, "hits": hits[c.name]}
        yield {**about, "seconds": wall, "cpu_seconds": cpu}


def _ours(points: Rows, faces: npt.NDArray[np.uint32]) -> Iterator[Contender]:
    for threads in sorted({1, usable_cores()}):
        scene = regraft.Scene(threads=threads)
        scene.add_instance(scene.add_mesh(points, faces))
        scene.update(policy="rebuild")

        def shoot(origins: Rows, directions: Rows, scene: regraft.Scene = scene) -> int:
            return int(np.isfinite(scene.closest_hit(origins, directions).t).sum())

        yield Contender(f"regraft {threads}", shoot)


def _bvhtree(points: Rows, faces: npt.NDArray[np.uint32]) -> Iterator[Contender]:
    try:
        import bpy  # noqa: F401  (brings mathutils)
        from mathutils.bvhtree import BVHTree
    except ImportError:
        return
    tree = BVHTree.FromPolygons(points.tolist(), faces.tolist(), all_triangles=True)

    def shoot(origins: Rows, directions: Rows) -> int:
        pairs = zip(origins.tolist(), directions.tolist(), strict=True)
        return sum(tree.ray_cast(o, d)[2] is not None for o, d in pairs)

    yield Contender(BVHTREE, shoot, FEW)


def _embreex(points: Rows, faces: npt.NDArray[np.uint32]) -> Iterator[Contender]:
    try:
        from embreex.mesh_construction import TriangleMesh
        from embreex.rtcore_scene import EmbreeScene
    except ImportError:
        return
    scene = EmbreeScene()
    mesh = TriangleMesh(scene, points, faces.astype(np.int32))

    def shoot(origins: Rows, directions: Rows, _kept: Any = mesh) -> int:
        return int((scene.run(origins, directions, output=1)["primID"] >= 0).sum())

    yield Contender(EMBREEX, shoot)


def table(result: dict[str, Any]) -> Iterator[str]:
    """The result as lines for people."""
    yield machine_line(result)
    yield f"{result['triangles']} triangles, {result['rays']} rays; millions a second"
    names = list(dict.fromkeys(row["contender"] for row in result["rows"]))
    peers = [name for name in (BVHTREE, EMBREEX) if name in names]
    heads = (*names, *(f"/ {name}" for name in peers))
    yield f"{'':<20}{''.join(f'{head:>12}' for head in heads)}"
    for rays in dict.fromkeys(row["rays"] for row in result["rows"]):
        rates = {r["contender"]: _rate(r) for r in result["rows"] if r["rays"] == rays}
        best = max(rate for name, rate in rates.items() if name not in peers)
        numbers = (*rates.values(), *(best / rates[name] for name in peers))
        yield f"{rays:<20}{''.join(f'{number:>12.2f}' for number in numbers)}"


def _rate(row: Row) -> float:
    return float(row["count"] / row["seconds"] / 1e6)
