"""`regraft bench trace`: rays against made scenes, beside Embree where it is installed."""

from __future__ import annotations

import argparse
import json
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from regraft.cli import native_program, options
from regraft.cli.console import Console
from regraft.cli.errors import EXIT_OK
from regraft.cli.machine import machine, machine_line, save_result

PROGRAM = native_program.FOLDER / "regraft_bench_trace"
SCENES = ("sheet 250k", "sheet 1M", "balls 250k", "balls 1M", "chunks 250k", "chunks 1M")
# Each column takes the fastest of the contenders whose names begin so.
COLUMNS = {
    "packets": "regraft packets",
    "single": "regraft single",
    "Embree": "embree robust",
    "fast": "embree",
}
Row = dict[str, Any]


def add_parser(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `bench trace`."""
    parser = kinds.add_parser(
        "trace",
        help="rays a second, beside Embree's",
        description="Shoot primary, shadow and occlusion rays at made scenes, in packets and one "
        "by one, and where Embree is installed the same rays with it in the same run: one, 8 and "
        "16 at once, static and dynamic scenes. The measuring program comes from `make bench`.",
    )
    parser.set_defaults(run=run)
    parser.add_argument("--scene", choices=SCENES, help="only this one (default: all)")
    parser.add_argument(
        "--image",
        type=options.whole_number(8, 8192),
        default=512,
        metavar="N",
        help="pixels along an edge of the square image (default: %(default)s)",
    )
    parser.add_argument(
        "--rounds",
        type=options.whole_number(1, 1000),
        default=7,
        metavar="N",
        help="of which medians are taken (default: %(default)s)",
    )
    parser.add_argument(
        "--threads",
        type=options.whole_number(1, 1024),
        default=1,
        metavar="N",
        help="of one, processor time is taken; of several, elapsed time (default: %(default)s)",
    )
    parser.add_argument(
        "--program", type=Path, default=PROGRAM, metavar="FILE", help="(default: %(default)s)"
    )
    parser.add_argument(
        "--output",
        type=options.file_with_suffix(".json"),
        metavar="FILE.json",
        default=Path("bench_trace.json"),
        help="(default: %(default)s)",
    )


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft bench trace`; raises CommandError. Returns the exit code."""
    console.note(f"{args.scene or 'six scenes'}, {args.image}² rays; this takes minutes")
    settings = {"image": args.image, "rounds": args.rounds, "threads": args.threads}
    if args.scene:
        settings["scene"] = args.scene
    rows = measure(args.program, settings)
    result = {"benchmark": "trace", **machine(), **settings, "rows": rows}
    save_result(args.output, result)
    for line in table(result):
        console.say(line)
    console.say(f"JSON: {args.output}")
    return EXIT_OK


def measure(program: Path, settings: dict[str, Any]) -> list[Row]:
    """What the native program measures, a row for every scene, kind of rays and contender.

    Raises InputError, SelfCheckError.
    """
    with tempfile.TemporaryDirectory() as folder:
        written = Path(folder) / "rays.json"
        arguments = ["--json", str(written)]
        for name, value in settings.items():
            arguments += [f"--{name}", str(value)]
        for _ in native_program.lines(program, *arguments):
            pass
        rows: list[Row] = json.loads(written.read_text())["lines"]
    return rows


def table(result: dict[str, Any]) -> Iterator[str]:
    """The result as lines for people."""
    rows: list[Row] = result["rows"]
    yield machine_line(result)
    yield "millions of rays a second; Embree: its best with ROBUST, fast: its best of all"
    heads = "".join(f"{name:>10}" for name in COLUMNS)
    yield f"{'':<14}{'':<20}{heads}{'/ Embree':>10}"
    for scene, rays in dict.fromkeys((r["scene"], r["rays"]) for r in rows):
        group = [r for r in rows if (r["scene"], r["rays"]) == (scene, rays)]
        rates = [fastest(group, prefix) for prefix in COLUMNS.values()]
        ours, peer = max(rates[:2]), rates[2]
        ratio = f"{ours / peer:>10.2f}" if peer else f"{'–':>10}"
        cells = "".join(f"{rate:>10.2f}" if rate else f"{'–':>10}" for rate in rates)
        yield f"{scene:<14}{rays:<20}{cells}{ratio}"


def fastest(rows: Sequence[Row], prefix: str) -> float:
    """Millions of rays a second of the fastest contender whose name begins so; 0: none."""
    found = (r for r in rows if r["contender"].startswith(prefix))
    return max((r["count"] / r["median_ms"] / 1e3 for r in found), default=0.0)
