"""`regraft bench`: measurements on this machine, as a table for people and JSON for scripts."""

from __future__ import annotations

import argparse
from pathlib import Path

from regraft.cli import (
    bench_kdtree,
    bench_numpy,
    bench_omissions,
    bench_sync,
    bench_trace,
    bench_update,
    options,
)
from regraft.cli.console import Console
from regraft.cli.errors import EXIT_OK, InputError
from regraft.cli.machine import machine, save_result

DEFAULT_FILE = Path("blend_files/explosion.blend")


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `bench` and its benchmarks."""
    bench = commands.add_parser(
        "bench",
        help="measure on this machine",
        description="Measure on this machine: a table for people, JSON for scripts.",
    )
    kinds = bench.add_subparsers(title="benchmarks", required=True, metavar="WHAT")
    _add_sync(kinds)
    bench_update.add_parser(kinds)
    bench_trace.add_parser(kinds)
    bench_numpy.add_parser(kinds)
    bench_kdtree.add_parser(kinds)
    bench_omissions.add_parser(kinds)


def _add_sync(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    parser = kinds.add_parser(
        "sync",
        help="whole frames in Blender: Regraft, Cycles and Workbench",
        description="Render the same frames with Regraft, Cycles (1 sample) and Workbench, each in "
        "a process of its own with persistent data on, taking turns frame by frame, and print "
        "medians. The first frame, which reads and builds everything, is stated apart.",
    )
    parser.set_defaults(run=run_sync)
    parser.add_argument(
        "file",
        metavar="FILE",
        type=Path,
        nargs="?",
        default=DEFAULT_FILE,
        help="(default: %(default)s)",
    )
    parser.add_argument(
        "--frames",
        type=options.whole_number(1, 10000),
        default=20,
        metavar="N",
        help="frames that count, from the middle of the range (default: %(default)s)",
    )
    parser.add_argument(
        "--resolution",
        type=options.resolution,
        metavar="WxH",
        default=(1280, 720),
        help="in pixels (default: 1280x720)",
    )
    parser.add_argument(
        "--output",
        type=options.file_with_suffix(".json"),
        metavar="FILE.json",
        default=Path("bench_sync.json"),
        help="(default: %(default)s)",
    )
    parser.add_argument("--verbose", action="store_true", help="let Blender's own output through")


def run_sync(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft bench sync`; raises CommandError. Returns the exit code."""
    if not args.file.is_file():
        raise InputError(f"cannot read {args.file}: no such file")
    console.note(f"{args.frames} frames of {args.file} with each engine; this takes a while")
    size: tuple[int, int] = args.resolution
    measured = bench_sync.measure(args.file.resolve(), args.frames, size, args.verbose)
    result = {
        "benchmark": "sync",
        "file": args.file.name,
        "frames": args.frames,
        "resolution": list(size),
        **machine(),
        **measured,
    }
    save_result(args.output, result)
    for line in bench_sync.table(result):
        console.say(line)
    console.say(f"JSON: {args.output}")
    return EXIT_OK
