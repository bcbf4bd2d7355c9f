"""`regraft bench kdtree`: what lazy building, scanning and the scene's hierarchy each bring."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from regraft.cli import bench_kdtree_file, native_program, options
from regraft.cli.console import Console
from regraft.cli.errors import EXIT_OK, InputError
from regraft.cli.interrupt import Interrupt
from regraft.cli.machine import machine, machine_line, save_result
from regraft.cli.recording import Recording, recorded

PROGRAM = native_program.FOLDER / "regraft_bench_kdtree"
# The configurations are no option of the NumPy API: a native program measures them.
BEST = "lazy+scan+hierarchy"
# Kind of row: what grows, the column it is plotted against, what it says.
GROWTHS = {
    "growth_eager": ("triangles", "all built at once, against triangles"),
    "growth_hidden": ("triangles", "built lazily, against triangles most of which are hidden"),
    "growth_visible": ("visible", "built lazily, against triangles seen"),
}
# What is compared between metrics, and how wide its numbers are.
ORIGIN_COLUMNS = {"nodes_visited": 10, "triangle_tests": 7, "trace_s": 7}
Row = dict[str, Any]


def add_parser(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `bench kdtree`."""
    parser = kinds.add_parser(
        "kdtree",
        help="the k-d tree: build and trace, eight ways to build, growth",
        description="Build the k-d tree of two made scenes, near and far, in all eight ways: "
        "lazily or at once, by scanning or sorting, from the scene's hierarchy or from its "
        "triangles; let the scene, what is hidden and what is seen grow; split by where rays "
        "start. Processor time of one thread. The measuring program comes from `make bench`. "
        "With FILE: the eight ways for its first frame, from its camera and from three quarters of "
        "the way to what that looks at.",
    )
    parser.set_defaults(run=run)
    parser.add_argument(
        "files", metavar="FILE", type=Path, nargs="*", help="anything Blender reads"
    )
    parser.add_argument(
        "--triangles",
        type=options.whole_number(20000, 100_000_000),
        default=541_000,
        metavar="N",
        help="of the larger made scene (default: %(default)s)",
    )
    parser.add_argument(
        "--program", type=Path, default=PROGRAM, metavar="FILE", help="(default: %(default)s)"
    )
    parser.add_argument(
        "--output",
        type=options.file_with_suffix(".json"),
        metavar="FILE.json",
        default=Path("bench_kdtree.json"),
        help="(default: %(default)s)",
    )
    parser.add_argument("--verbose", action="store_true", help="let Blender's own output through")


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft bench kdtree`; raises CommandError. Returns the exit code."""
    if args.files:
        rows = list(_measure_files(args, console))
    else:
        console.note(f"{args.triangles} triangles, eight ways; this takes minutes")
        rows = list(measure(args.program, str(args.triangles)))
    result = {"benchmark": "kdtree", **machine(), "rows": rows, "exponents": exponents(rows)}
    save_result(args.output, result)
    for line in table(result):
        console.say(line)
    console.say(f"JSON: {args.output}")
    return EXIT_OK


def _measure_files(args: argparse.Namespace, console: Console) -> Iterator[Row]:
    for path in args.files:
        if not path.is_file():
            raise InputError(f"cannot read {path}: no such file")
    with Interrupt(console).watching() as interrupt:
        for path in args.files:
            wanted = Recording(path, verbose=args.verbose, only_first=True)
            with recorded(wanted, console, interrupt) as shot, TemporaryDirectory() as folder:
                scene = Path(folder, "scene.bin")
                bench_kdtree_file.write(shot, scene)
                yield from measure(args.program, path.stem, str(scene))


def measure(program: Path, *arguments: str) -> Iterator[Row]:
    """What the native program prints, a row a measurement. Raises InputError, SelfCheckError."""
    for line in native_program.lines(program, *arguments):
        yield json.loads(line)


def exponents(rows: Sequence[Row]) -> dict[str, float]:
    """Slope of each growth: build time goes with that power of what grows."""
    found = {}
    for kind, (column, _) in GROWTHS.items():
        points = [(r[column], r["build_s"]) for r in rows if r["kind"] == kind]
        if len({x for x, _ in points}) > 1:
            found[kind] = slope(points)
    return found


def slope(points: Sequence[tuple[float, float]]) -> float:
    """Of the least-squares line through the logarithms."""
    logs = [(math.log(x), math.log(max(y, 1e-9))) for x, y in points]
    mean_x = sum(x for x, _ in logs) / len(logs)
    mean_y = sum(y for _, y in logs) / len(logs)
    return sum((x - mean_x) * (y - mean_y) for x, y in logs) / sum(
        (x - mean_x) ** 2 for x, _ in logs
    )


def table(result: dict[str, Any]) -> Iterator[str]:
    """The result as lines for people: the paper's Table 1, the growths, the metrics."""
    rows: list[Row] = result["rows"]
    yield machine_line(result)
    pictures = dict.fromkeys((r["scene"], r["view"]) for r in rows if r["kind"] == "table")
    for scene, view in pictures:
        wanted = ("table", scene, view)
        group = [r for r in rows if (r["kind"], r["scene"], r.get("view")) == wanted]
        yield from _picture_lines(group)
    for kind, (column, text) in GROWTHS.items():
        points = [r for r in rows if r["kind"] == kind]
        if points:
            yield from _growth_lines(points, column, text, result["exponents"].get(kind))
    yield from _origin_lines([r for r in rows if r["kind"] == "origins"])


def _picture_lines(rows: Sequence[Row]) -> Iterator[str]:
    first = rows[0]
    best = next(r["build_s"] for r in rows if r["configuration"] == BEST)
    yield ""
    yield (
        f"{first['scene']}, {first['view']}: n = {first['triangles']}, v = {first['visible']}, 512²"
    )
    yield (
        f"{'':<22}{'build s':>10}{'× best':>9}{'trace s':>10}{'singly':>10}{'nodes':>11}"
        f"{'unbuilt':>11}{'large':>7}{'q':>8}{'node visits':>14}"
    )
    for row in rows:
        yield (
            f"{row['configuration']:<22}{row['build_s']:>10.4f}"
            f"{row['build_s'] / max(best, 1e-9):>9.1f}{row['trace_s']:>10.4f}"
            f"{row['trace_singly_s']:>10.4f}{row['nodes']:>11}{row['unbuilt']:>11}"
            f"{row['large_leaves']:>7}{_quality(row):>8}{row['nodes_visited']:>14}"
        )


def _quality(row: Row) -> str:
    """The tree's q: only of a whole one, and of more than one triangle."""
    quality = row["quality"]
    return "–" if quality is None or row["unbuilt"] else f"{quality:.3f}"


def _growth_lines(
    rows: Sequence[Row], column: str, text: str, exponent: float | None
) -> Iterator[str]:
    yield ""
    power = "" if exponent is None else f": grows with its {exponent:.2f}th power"
    yield f"build, {text}{power}"
    for row in rows:
        yield f"{row[column]:>12}{row['build_s']:>10.4f} s{row['nodes']:>11} nodes"


def _origin_lines(rows: Sequence[Row]) -> Iterator[str]:
    """What each metric saves of what the surface area heuristic (`sah`) needs."""
    plain = {(r["scene"], r["rays"]): r for r in rows if r["metric"] == "sah"}
    for (scene, rays), base in plain.items():
        yield ""
        yield f"{scene}, {rays}: trees split by where rays start, against sah"
        yield f"{'':<12}{'node visits':>12}{'tests':>9}{'trace':>9}{'build s':>10}"
        for row in rows:
            if (row["scene"], row["rays"]) == (scene, rays):
                changes = (_change(row, base, name) for name in ORIGIN_COLUMNS)
                yield f"{row['metric']:<12}{''.join(changes)}{row['build_s']:>10.2f}"


def _change(row: Row, base: Row, name: str) -> str:
    return f"{100 * (row[name] / max(base[name], 1e-9) - 1):>+{ORIGIN_COLUMNS[name]}.1f} %"
