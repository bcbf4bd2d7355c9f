"""`regraft study update`: every policy over whole shots, and which one to use."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from typing import Any

from regraft.cli import options, study_frame
from regraft.cli.console import Console
from regraft.cli.interrupt import Interrupt
from regraft.cli.job import LAYOUTS, POLICIES
from regraft.study import aging_table, update, update_report
from regraft.study.report import Report
from regraft.study.shot import Shot

Row = dict[str, Any]


def add_parser(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `study update`."""
    parser = kinds.add_parser(
        "update",
        help="tree quality against update time: which policy a shot needs",
        description="Replay each shot on scenes that differ in policy and layout only, taking "
        "turns frame by frame, and say which policy to use, where refitting stops being enough "
        "and what rebuilding would cost.",
    )
    parser.set_defaults(run=run)
    study_frame.add_options(parser, "update")
    parser.add_argument(
        "--policies",
        type=options.list_of(POLICIES),
        default=(),
        metavar="A,B,…",
        help=f"of {', '.join(POLICIES)} (default: all; rebuild is always there)",
    )
    parser.add_argument(
        "--layouts",
        type=options.list_of(LAYOUTS),
        default=("two-level",),
        metavar="A,B",
        help=f"of {', '.join(LAYOUTS)} (default: two-level)",
    )
    study_frame.add_size(parser, 256)
    study_frame.add_repeats(parser, "replays of the shot")


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft study update`; raises CommandError. Returns the exit code."""
    study_frame.prepare(args, args.files)
    repeats, minutes = study_frame.repeats(args)
    settings = update.Settings(
        args.policies,
        args.layouts,
        args.size,
        repeats,
        minutes,
        args.threads,
    )
    report = study_frame.start(
        "Tree quality against update time",
        threads=args.threads or "all cores",
        picture=f"{args.size} × {args.size} pixels, a primary and a shadow ray each",
    )
    with Interrupt(console).watching() as interrupt:
        for name, shot in study_frame.shots(args, console, interrupt):
            _add(report, name, _measure(name, shot, settings, console, interrupt), console)
    return study_frame.finish(report, args.output, console)


def _measure(
    name: str, shot: Shot, settings: update.Settings, console: Console, interrupt: Interrupt
) -> list[Row]:
    with study_frame.steps(name, len(shot) * settings.repeats, console, interrupt) as tick:
        return list(
            update.measure(
                shot,
                settings,
                lambda repeat, frame: tick(f"{name}, replay {repeat + 1}, frame {frame}"),
            )
        )


def _add(report: Report, name: str, rows: list[Row], console: Console) -> None:
    totals = update.totals(rows)
    report.sections.append(update_report.section(name, rows))
    report.add("update", rows, name)
    report.add("update_totals", totals, name)
    report.lines.setdefault("update", []).extend(
        {"scene": name, **r} for r in update.by_frame(rows)
    )
    for line in _lines(name, totals):
        console.say(line)


def _lines(name: str, totals: list[Row]) -> Iterator[str]:
    yield (
        f"  {name:<18}{'total s':>9}{'update s':>10}{'trace s':>9}{'share':>8}{'tests/fresh':>11}"
        f"{'worst':>8}{'enough until':>14}"
    )
    for row in totals:
        numbers = (
            aging_table.number(row[k], w) for k, w in (("ratio_median", 11), ("ratio_worst", 8))
        )
        share = f"{row['update_share']:>8.1%}" if row["update_share"] is not None else f"{'–':>8}"
        yield (
            f"    {row['label']:<16}{row['total_s']:>9.3f}{row['update_s']:>10.3f}"
            f"{row['trace_s']:>9.3f}{share}{''.join(numbers)}"
            f"{row['enough_until'] if row['enough_until'] is not None else '–':>14}"
        )
