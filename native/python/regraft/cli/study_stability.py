"""`regraft study stability`: what offset, scale, stretch and greater steps do to hits."""

from __future__ import annotations

import argparse

from regraft.cli import study_frame
from regraft.cli.console import Console
from regraft.cli.interrupt import Interrupt
from regraft.study import stability, stability_report


def add_parser(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `study stability`."""
    parser = kinds.add_parser(
        "stability",
        help="worst error against offset, scale, aspect ratio and time step",
        description="Trace the first frame far away, huge, tiny and stretched, and all frames "
        "with motion exaggerated; print the worst error of distances in ulps and the first "
        "setting at which a picture changes by more than 1/255. Every answer is compared with "
        "brute force (exit code 1 if one differs).",
    )
    parser.set_defaults(run=run)
    study_frame.add_options(parser, "stability")
    study_frame.add_size(parser, 64)


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft study stability`; raises CommandError. Returns the exit code."""
    study_frame.prepare(args, args.files)
    report = study_frame.start("Numerical stability", picture=f"{args.size}² pixels")
    with Interrupt(console).watching() as interrupt:
        for name, shot in study_frame.shots(args, console, interrupt):
            with study_frame.steps(name, stability.steps(shot), console, interrupt) as tick:
                rows = list(stability.measure(shot, args.size, args.threads, tick))
                rows += stability.measure_steps(shot, args.size, args.threads, tick)
            report.sections.append(stability_report.section(name, rows))
            report.add("stability", rows, name)
    return study_frame.finish(report, args.output, console)
