"""What all studies share on the command line: options, outputs, how they end."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from math import inf
from pathlib import Path
from typing import Any

from regraft.cli import options
from regraft.cli.console import Console
from regraft.cli.errors import (
    EXIT_OK,
    InputError,
    OutputError,
    SelfCheckError,
    describe_write_failure,
)
from regraft.cli.interrupt import Interrupt
from regraft.cli.machine import machine
from regraft.cli.recording import Recording, recorded
from regraft.formats import atomic
from regraft.study import plots
from regraft.study.report import Report
from regraft.study.shot import Shot

REPEATS = 5
MINUTES = 4.0
FACTS = {
    "processor": "processor",
    "cores": "cores",
    "simd": "instruction set",
    "load_average": "load average",
    "regraft": "regraft",
    "commit": "commit",
}


def add_options(parser: argparse.ArgumentParser, kind: str) -> None:
    """FILE…, --frames, --threads, --output, --verbose."""
    parser.add_argument(
        "files", metavar="FILE", type=Path, nargs="+", help="anything Blender reads"
    )
    parser.add_argument("--frames", type=options.frames, metavar="1-100", help="(default: all)")
    parser.add_argument(
        "--threads",
        type=options.whole_number(0, 1024),
        default=0,
        metavar="N",
        help="(default: all cores)",
    )
    add_output(parser, kind)
    parser.add_argument("--verbose", action="store_true", help="let Blender's own output through")


def add_size(parser: argparse.ArgumentParser, pixels: int) -> None:
    """--size."""
    parser.add_argument(
        "--size",
        type=options.whole_number(4, 16384),
        default=pixels,
        metavar="N",
        help="pixels of the square picture's side (default: %(default)s)",
    )


def add_repeats(parser: argparse.ArgumentParser, what: str) -> None:
    """--repeats of `what`."""
    parser.add_argument(
        "--repeats",
        type=options.whole_number(1, 1000),
        metavar="N",
        help=f"{what}; times are their medians (default: {REPEATS}, fewer where that would take "
        f"more than {MINUTES:g} minutes)",
    )


def repeats(args: argparse.Namespace) -> tuple[int, float]:
    """How often to measure, and within how many minutes: just as often as --repeats asks, or as
    time allows."""
    return args.repeats or REPEATS, inf if args.repeats else MINUTES


def add_output(parser: argparse.ArgumentParser, kind: str) -> None:
    """--output, --no-plots."""
    parser.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        default=Path(f"study_{kind}"),
        help="folder for the results (default: %(default)s)",
    )
    parser.add_argument(
        "--no-plots", action="store_true", help="leave figures out; needs no matplotlib"
    )


def prepare(args: argparse.Namespace, files: Sequence[Path]) -> None:
    """Finds out before any work what would stop it at the end. Raises InputError, OutputError."""
    for path in files:
        if not path.is_file():
            raise InputError(f"cannot read {path}: no such file")
    folder: Path = args.output
    plots.are_wanted = not args.no_plots
    try:
        plots.require()
        atomic.prepare_folder(folder)
    except ImportError as error:
        raise OutputError(str(error)) from error
    except OSError as error:
        raise describe_write_failure(folder, error) from error


def names(files: Sequence[Path]) -> list[str]:
    """What reports call the files: their stems, numbered where two would be alike."""
    found: list[str] = []
    for path in files:
        same = sum(name == path.stem or name.startswith(f"{path.stem} (") for name in found)
        found.append(f"{path.stem} ({same + 1})" if same else path.stem)
    return found


def shots(
    args: argparse.Namespace, console: Console, interrupt: Interrupt, shading: str = "clay"
) -> Iterator[tuple[str, Shot]]:
    """Each file's name and shot, recorded as that mode of shading needs it; the shot's folder
    lives until the next is asked for."""
    for name, source in zip(names(args.files), args.files, strict=True):
        wanted = Recording(source, args.frames, shading, args.verbose)
        with recorded(wanted, console, interrupt) as shot:
            yield name, shot


@contextmanager
def steps(
    name: str, count: int, console: Console, interrupt: Interrupt
) -> Iterator[Callable[[object], None]]:
    """Yields what to call after each of `count` steps; it raises InterruptedRunError."""
    with console.progress(count, name) as progress:

        def tick(step: object) -> None:
            progress.step(
                f"{name}, frame {step}" if isinstance(step, int) else str(step), str(step)
            )
            interrupt.check()

        yield tick


def start(title: str, **facts: Any) -> Report:
    """An empty report that knows the machine."""
    about = machine()
    known = {text: about[key] for key, text in FACTS.items() if about[key] not in (None, "")}
    return Report(title, {**facts, **known})


def finish(report: Report, folder: Path, console: Console) -> int:
    """Writes everything and says the verdicts. Raises OutputError; SelfCheckError if something is
    not as it must be."""
    try:
        page = report.write(folder)
    except OSError as error:
        raise describe_write_failure(folder, error) from error
    for section in report.sections:
        console.say(f"{section.title}: {section.verdict}")
    console.say(f"page: {page}")
    if wrong := [section.title for section in report.sections if section.wrong]:
        raise SelfCheckError(f"an identity failed: {', '.join(wrong)}")
    return EXIT_OK
