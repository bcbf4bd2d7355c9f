"""`regraft bench update`: every policy over whole shots, update and trace apart."""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from regraft.cli import bench_peers, job, options
from regraft.cli.console import Console
from regraft.cli.doctor import usable_cores
from regraft.cli.errors import EXIT_OK, InputError
from regraft.cli.interrupt import Interrupt
from regraft.cli.machine import machine, machine_line, save_result
from regraft.cli.recording import Recording, recorded
from regraft.study import aging, aging_table, local_motion, size_scaling
from regraft.study.shot import Shot

POLICIES, LAYOUTS = (*job.POLICIES, "shot"), job.LAYOUTS
FILES = tuple(
    Path("blend_files", f"{name}.blend")
    for name in ("explosion", "n_body", "cloth", "robots", "mixed")
)
# Triangles of the made scene, how many of them move, frames.
LOCAL_MOTION = (1_000_000, 16_000, 40)


def add_parser(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `bench update`."""
    parser = kinds.add_parser(
        "update",
        help="every policy over whole shots: update and trace, tree quality",
        description="Replay shots on scenes that differ in policy and layout only, taking turns "
        "frame by frame; print seconds of updating and tracing, the trees' cost beside fresh "
        "ones, and what was mended. Without FILE: explosion, n_body, cloth, robots, mixed from "
        "blend_files/ and a landscape of 1,000,000 triangles of which 16,000 move; then what "
        "mending costs in landscapes of growing size. With --peers a program from `make bench` "
        "plays the shots to Embree as well, in each of its ways.",
    )
    parser.set_defaults(run=run)
    parser.add_argument(
        "files", metavar="FILE", type=Path, nargs="*", help="anything Blender reads"
    )
    parser.add_argument(
        "--policies",
        type=options.list_of(POLICIES),
        default=POLICIES,
        metavar="A,B,…",
        help=f"of {', '.join(POLICIES)} (default: all)",
    )
    parser.add_argument(
        "--layouts",
        type=options.list_of(LAYOUTS),
        default=LAYOUTS,
        metavar="A,B",
        help=f"of {', '.join(LAYOUTS)} (default: both)",
    )
    parser.add_argument(
        "--sizes",
        type=options.list_of_numbers(1_000, 20_000_000),
        metavar="N,N,…",
        help="triangles of the growing landscapes; with FILE none (default: "
        f"{','.join(map(str, size_scaling.SIZES))})",
    )
    parser.add_argument("--frames", type=options.frames, metavar="1-100", help="(default: all)")
    parser.add_argument(
        "--size",
        type=options.whole_number(1, 16384),
        default=512,
        metavar="N",
        help="pixels of the square picture's side (default: %(default)s)",
    )
    parser.add_argument(
        "--threads",
        type=options.whole_number(0, 1024),
        default=0,
        metavar="N",
        help="(default: all cores)",
    )
    _add_peers(parser)
    parser.add_argument(
        "--output",
        type=options.file_with_suffix(".json"),
        metavar="FILE.json",
        default=Path("bench_update.json"),
        help="(default: %(default)s)",
    )
    parser.add_argument("--verbose", action="store_true", help="let Blender's own output through")


def _add_peers(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--peers", action="store_true", help="beside Embree, without policy `shot` and --sizes"
    )
    parser.add_argument(
        "--repeats",
        type=options.whole_number(1, 1000),
        default=3,
        metavar="N",
        help="with --peers: replays, of which medians are taken (default: %(default)s)",
    )
    parser.add_argument(
        "--program",
        type=Path,
        default=bench_peers.PROGRAM,
        metavar="FILE",
        help="with --peers (default: %(default)s)",
    )


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft bench update`; raises CommandError. Returns the exit code."""
    for path in args.files:
        if not path.is_file():
            raise InputError(f"cannot read {path}: no such file")
    args.threads = args.threads or usable_cores()
    settings = {"size": args.size, "threads": args.threads}
    result: dict[str, Any] = {"benchmark": "update", **settings, **machine(), "shots": {}}
    console.say(machine_line(result))
    measure = bench_peers.measure if args.peers else _measure
    with Interrupt(console).watching() as interrupt:
        for name, shot in _shots(args, console, interrupt):
            result["shots"][name] = measure(name, shot, args, console, interrupt)
            save_result(args.output, result)
        sizes = args.sizes or (() if args.files else size_scaling.SIZES)
        if sizes and not args.peers:
            result["sizes"] = _sizes(sizes, args, console, interrupt)
            save_result(args.output, result)
    if args.peers:
        for line in bench_peers.summary(result["shots"]):
            console.say(line)
    console.say(f"JSON: {args.output}")
    return EXIT_OK


def _measure(
    name: str, shot: Shot, args: argparse.Namespace, console: Console, interrupt: Interrupt
) -> dict[str, Any]:
    contestants = [aging.Contestant(p, layout) for layout in args.layouts for p in args.policies]
    settings = aging.Settings(size=args.size, threads=args.threads)
    with console.progress(len(shot), name) as progress:

        def tick(frame: int) -> None:
            progress.step(f"{name}, frame {frame}", str(frame))
            interrupt.check()

        rows = list(aging.measure(shot, contestants, settings, tick))
    totals = aging_table.totals(rows)
    console.say(f"{name}, {args.size}² primary and shadow rays, {len(shot)} frames")
    for line in aging_table.lines(totals):
        console.say(line)
    return {"totals": totals, "rows": rows}


def _sizes(
    sizes: Sequence[int], args: argparse.Namespace, console: Console, interrupt: Interrupt
) -> dict[str, Any]:
    with console.progress(len(sizes), "sizes") as progress:

        def tick(size: int) -> None:
            progress.step(f"{size} triangles", str(size))
            interrupt.check()

        rows = list(size_scaling.measure(sizes, args.threads, tick))
    console.say(f"mending {size_scaling.MOVING} moving triangles in larger and larger models")
    for line in size_scaling.lines(rows):
        console.say(line)
    slope = size_scaling.slope(rows, "select_total_ms") if len(rows) > 1 else None
    return {"rows": rows, "slope": slope}


def _shots(
    args: argparse.Namespace, console: Console, interrupt: Interrupt
) -> Iterator[tuple[str, Shot]]:
    """Each shot with its name; its folder lives until the next is asked for."""
    for source in args.files or FILES:
        wanted = Recording(source, args.frames, verbose=args.verbose)
        with recorded(wanted, console, interrupt) as shot:
            yield source.stem, shot
    if not args.files:
        with tempfile.TemporaryDirectory() as folder:
            yield "local motion", local_motion.make(Path(folder), *LOCAL_MOTION)
