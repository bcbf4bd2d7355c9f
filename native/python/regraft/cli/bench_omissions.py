"""`regraft bench omissions`: what each thing that a frame leaves out saves."""

from __future__ import annotations

import argparse
import re
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from regraft.cli import bench_sync, options
from regraft.cli.backend_subprocess import SubprocessBackend
from regraft.cli.console import Console
from regraft.cli.errors import EXIT_OK, InputError, SelfCheckError
from regraft.cli.interrupt import Interrupt
from regraft.cli.job import RenderJob
from regraft.cli.machine import machine, machine_line, save_result
from regraft.formats import images
from regraft.study import omissions

Row = dict[str, Any]
FILE = Path("blend_files/robots.blend")
READING = "unchanged objects and matrices: not read"
_SIZE = (320, 180)
_BYTES = re.compile(r"([\d,]+) of ([\d,]+) bytes of geometry not read")


def add_parser(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `bench omissions`."""
    parser = kinds.add_parser(
        "omissions",
        help="what each thing that a frame leaves out saves: same picture, less time",
        description="Draw made scenes with and without each thing that frames leave out, taking "
        "turns frame by frame, and print time and bytes saved; then frames of FILE in Blender, "
        "reading what changed and reading everything. Pictures must be the same bit for bit (exit "
        "code 1).",
    )
    parser.set_defaults(run=run)
    parser.add_argument(
        "file",
        metavar="FILE",
        type=Path,
        nargs="?",
        help=f"anything Blender reads (default: {FILE}, if it is there)",
    )
    for name, low, high, default, text in (
        ("triangles", 1000, 50_000_000, 200_000, "triangles of the made scenes"),
        ("size", 1, 16384, 256, "pixels of the square picture's side"),
        ("frames", 2, 10_000, 12, "frames, of which the first does not count"),
        ("threads", 0, 1024, 0, "0: all cores"),
    ):
        parser.add_argument(
            f"--{name}",
            type=options.whole_number(low, high),
            default=default,
            metavar="N",
            help=f"{text} (default: %(default)s)",
        )
    parser.add_argument(
        "--output",
        type=options.file_with_suffix(".json"),
        metavar="FILE.json",
        default=Path("bench_omissions.json"),
        help="(default: %(default)s)",
    )
    parser.add_argument("--verbose", action="store_true", help="let Blender's own output through")


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft bench omissions`; raises CommandError. Returns the exit code."""
    if args.file and not args.file.is_file():
        raise InputError(f"cannot read {args.file}: no such file")
    result: Row = {"benchmark": "omissions", "triangles": args.triangles, **machine()}
    console.say(machine_line(result))
    settings = omissions.Settings(args.triangles, args.size, args.frames, args.threads)
    source = args.file or (FILE if FILE.is_file() else None)
    with Interrupt(console).watching() as interrupt:
        with console.progress(len(omissions.OMISSIONS), "omissions") as progress:

            def tick(name: object) -> None:
                progress.step(str(name), str(name))
                interrupt.check()

            rows = list(omissions.measure(omissions.OMISSIONS, settings, tick))
        if source:
            console.note(f"reading {source}")
            rows.append(measure_reading(source.resolve(), args.frames, args.verbose))
    save_result(args.output, result | {"rows": rows})
    for line in omissions.lines(rows):
        console.say(line)
    console.say(f"JSON: {args.output}")
    if wrong := [row["omission"] for row in rows if row["pictures_that_differ"]]:
        raise SelfCheckError(f"pictures differ: {', '.join(wrong)}")
    return EXIT_OK


def measure_reading(source: Path, count: int, verbose: bool) -> Row:
    """A row like those of `omissions.measure`, for what is read of Blender's scene."""
    job = RenderJob(str(source), *_SIZE, policy="refit")
    drawn: dict[bool, list[Row]] = {True: [], False: []}
    different = 0
    backends: dict[bool, SubprocessBackend] = {}
    with tempfile.TemporaryDirectory() as folder:
        pictures = {omit: Path(folder, f"{omit}.png") for omit in (True, False)}
        try:
            for omit in (True, False):
                backends[omit] = SubprocessBackend(bench_sync.worker_command(), verbose)
                frames = backends[omit].open(job).frames[:count]
            backends[False].read_everything()
            for frame in frames:
                for omit, backend in backends.items():
                    drawn[omit].append(backend.render(frame, pictures[omit]))
                one, other = (images.read_rgb8(path).tobytes() for path in pictures.values())
                different += one != other
        finally:
            for backend in backends.values():
                backend.close()
    return _reading_row(drawn, different)


def _reading_row(drawn: Mapping[bool, Sequence[Row]], different: int) -> Row:
    times = {o: median(r["extract_ms"] for r in rows[1:] or rows) for o, rows in drawn.items()}
    unread = {omit: _bytes(rows[-1])[0] for omit, rows in drawn.items()}
    total = _bytes(drawn[True][-1])[1]
    return {
        "omission": READING,
        "unless": "everything is",
        "with_ms": times[True],
        "without_ms": times[False],
        "saved": 1.0 - times[True] / times[False],
        "with_bytes": total - unread[True],
        "without_bytes": total - unread[False],
        "pictures_that_differ": different,
    }


def _bytes(row: Row) -> tuple[int, int]:
    """Of geometry: those that were not read, and all that there are; both 0 if all were read."""
    for match in filter(None, map(_BYTES.search, row["left_out"])):
        return int(match[1].replace(",", "")), int(match[2].replace(",", ""))
    return 0, 0
