"""`regraft study scan`: what errors of split planes cost, and what avoiding them does."""

from __future__ import annotations

import argparse

from regraft.cli import study_frame
from regraft.cli.console import Console
from regraft.cli.interrupt import Interrupt
from regraft.study import scan, scan_report


def add_parser(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `study scan`."""
    parser = kinds.add_parser(
        "scan",
        help="k-d trees: error of split planes against build time",
        description="Build k-d trees of the first frame with exact split planes, with those of a "
        "scan of 2 to 64 planes, and with a scan that proves its error to be below ε; print errors "
        "at nodes, cost of trees, and seconds of building and tracing. All trees must hit the "
        "same (exit code 1).",
    )
    parser.set_defaults(run=run)
    study_frame.add_options(parser, "scan")
    study_frame.add_size(parser, 256)
    study_frame.add_repeats(parser, "builds of every tree")


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft study scan`; raises CommandError. Returns the exit code."""
    study_frame.prepare(args, args.files)
    report = study_frame.start(
        "Error of split planes against build time",
        threads=args.threads or "all cores",
        picture=f"{args.size}² pixels",
    )
    repeats, minutes = study_frame.repeats(args)
    settings = scan.Settings(args.size, repeats, minutes, args.threads)
    with Interrupt(console).watching() as interrupt:
        for name, shot in study_frame.shots(args, console, interrupt):
            with study_frame.steps(name, settings.steps(), console, interrupt) as tick:
                scene = scan.scene_of(shot, args.threads)
                rays = scan.rays_of(shot, scene, args.size)
                errors = scan.errors(scene)
                tick("errors at nodes")
                rows = list(scan.measure(scene, rays, settings, tick))
            table = scan.table(rows, errors)
            report.sections.append(scan_report.section(name, rows, table))
            report.add("scan", rows, name)
            report.add("scan_settings", table, name)
    return study_frame.finish(report, args.output, console)
