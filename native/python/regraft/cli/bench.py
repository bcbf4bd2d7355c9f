"""`regraft bench`: measurements on this machine, as a table for people and JSON for scripts."""

from __future__ import annotations

import argparse
import os
import subprocess
from pathlib import Path
from typing import Any

import regraft
from regraft.cli import bench_sync, options
from regraft.cli.console import Console
from regraft.cli.doctor import available_isas, usable_cores
from regraft.cli.errors import EXIT_OK, InputError, describe_write_failure
from regraft.formats import atomic, jsonl

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
    try:
        atomic.write_bytes(args.output, jsonl.encode(result))
    except OSError as error:
        raise describe_write_failure(args.output, error) from error
    for line in bench_sync.table(result):
        console.say(line)
    console.say(f"JSON: {args.output}")
    return EXIT_OK


def machine() -> dict[str, Any]:
    """What a measurement must be read with."""
    return {
        "regraft": regraft.__version__,
        "commit": _commit(),
        "processor": _processor(),
        "cores": usable_cores(),
        "simd": available_isas()[-1],
        "load_average": os.getloadavg()[0] if hasattr(os, "getloadavg") else None,
    }


def _commit() -> str:
    """Commit of regraft's checkout that this package lies in, `+` for changes; else ""."""
    folder = Path(regraft.__file__).parent
    top = _git(folder, "rev-parse", "--show-toplevel")
    if not top or not Path(top, "native", "regraft").is_dir():
        return ""
    return _git(folder, "describe", "--always", "--dirty=+", "--exclude=*")


def _git(folder: Path, *words: str) -> str:
    try:
        done = subprocess.run(
            ["git", "-C", str(folder), *words], capture_output=True, text=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return ""
    return done.stdout.strip()


def _processor() -> str:
    """Name of the processor where the system tells it, else its architecture."""
    import platform

    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()
