"""`regraft study lazy`: what a first picture costs when only what is seen is built."""

from __future__ import annotations

import argparse

from regraft.cli import study_frame
from regraft.cli.console import Console
from regraft.cli.errors import UsageError
from regraft.cli.interrupt import Interrupt
from regraft.study import lazy, lazy_report, offers


def add_parser(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `study lazy`."""
    parser = kinds.add_parser(
        "lazy",
        help="the lazy k-d tree: work against what is seen and what is hidden",
        description="Make the first picture of the first frame with the lazy k-d tree and with a "
        "BVH while the window narrows and while hidden copies of the scene are added; fit how "
        "the nodes made grow with triangles seen and hidden.",
    )
    parser.set_defaults(run=run)
    study_frame.add_options(parser, "lazy")
    study_frame.add_size(parser, 128)


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft study lazy`; raises CommandError. Returns the exit code."""
    if "kdtree" not in offers.structures():
        raise UsageError("this version of the library has no k-d tree")
    study_frame.prepare(args, args.files)
    report = study_frame.start(
        "The lazy k-d tree", threads=args.threads or "all cores", picture=f"{args.size}² pixels"
    )
    with Interrupt(console).watching() as interrupt:
        for name, shot in study_frame.shots(args, console, interrupt):
            with study_frame.steps(name, lazy.steps(), console, interrupt) as tick:
                rows = list(lazy.measure(shot, args.size, args.threads, tick))
            report.sections.append(lazy_report.section(name, rows))
            report.add("lazy", rows, name)
    return study_frame.finish(report, args.output, console)
