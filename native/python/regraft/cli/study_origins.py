"""`regraft study origins`: whether k-d trees should suppose rays that start inside the scene."""

from __future__ import annotations

import argparse

from regraft.cli import study_frame
from regraft.cli.console import Console
from regraft.cli.interrupt import Interrupt
from regraft.study import origins, origins_report


def add_parser(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `study origins`."""
    parser = kinds.add_parser(
        "origins",
        help="k-d trees: by which chances to split, given where rays start",
        description="Build k-d trees of the first frame by the surface area heuristic and by four "
        "ways to compute p_N, the chance that a ray which starts inside the scene visits a box; "
        "count what primary rays, shadow rays to a light inside and outside, and reflected ones "
        "take in each. All trees must hit the same (exit code 1).",
    )
    parser.set_defaults(run=run)
    study_frame.add_options(parser, "origins")
    study_frame.add_size(parser, 64)
    study_frame.add_repeats(parser, "builds of every tree")


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft study origins`; raises CommandError. Returns the exit code."""
    study_frame.prepare(args, args.files)
    report = study_frame.start(
        "Where rays start", threads=args.threads or "all cores", picture=f"{args.size}² pixels"
    )
    repeats, minutes = study_frame.repeats(args)
    settings = origins.Settings(args.size, repeats, minutes)
    with Interrupt(console).watching() as interrupt:
        for name, shot in study_frame.shots(args, console, interrupt):
            with study_frame.steps(name, settings.steps(), console, interrupt) as tick:
                room = origins.room_of(shot, args.size, args.threads)
                rows = list(origins.measure(room, settings, tick))
            table = origins.table(rows)
            report.sections.append(origins_report.section(name, room, rows, table))
            report.add("origins", rows, name)
            report.add("origins_metrics", table, name)
    return study_frame.finish(report, args.output, console)
