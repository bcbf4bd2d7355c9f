"""`regraft study prediction`: whether the metric says what rays find."""

from __future__ import annotations

import argparse
from typing import Any

from regraft.cli import study_frame
from regraft.cli.console import Console
from regraft.cli.interrupt import Interrupt
from regraft.study import aging, prediction, prediction_report
from regraft.study.shot import Shot

Row = dict[str, Any]


def add_parser(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `study prediction`."""
    parser = kinds.add_parser(
        "prediction",
        help="predicted cost against the tests that rays need",
        description="Replay each shot under policies that age trees in different ways and "
        "correlate, frame by frame, what the surface area heuristic and end-point overlap "
        "predict with the tests that rays need; and what restructuring promised with what it "
        "saved. Only counts are measured: the result is the same on every machine.",
    )
    parser.set_defaults(run=run)
    study_frame.add_options(parser, "prediction")
    study_frame.add_size(parser, 128)


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft study prediction`; raises CommandError. Returns the exit code."""
    study_frame.prepare(args, args.files)
    report = study_frame.start("Prediction against observation", picture=f"{args.size}² pixels")
    settings = aging.Settings(args.size, 0, args.threads)
    with Interrupt(console).watching() as interrupt:
        for name, shot in study_frame.shots(args, console, interrupt):
            rows, operations = _measure(name, shot, settings, console, interrupt)
            report.sections.append(prediction_report.section(name, rows, operations))
            report.add("prediction", rows, name)
            report.add("prediction_operations", operations, name)
            report.add("prediction_summary", prediction.summary(rows), name)
    return study_frame.finish(report, args.output, console)


def _measure(
    name: str, shot: Shot, settings: aging.Settings, console: Console, interrupt: Interrupt
) -> tuple[list[Row], list[Row]]:
    rows: list[Row] = []
    operations: list[Row] = []
    with study_frame.steps(name, len(shot), console, interrupt) as tick:
        for row, done in prediction.measure(shot, settings, tick):
            rows.append(row)
            operations += done
    return rows, operations
