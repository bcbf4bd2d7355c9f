"""`regraft study compare A.jsonl B.jsonl`: the frames that differ most, and why."""

from __future__ import annotations

import argparse
from pathlib import Path

from regraft.cli import study_frame
from regraft.cli.console import Console
from regraft.cli.errors import InputError
from regraft.formats import jsonl
from regraft.study import compare, plots
from regraft.study.page import Section, Table

_SHOWN = 10
_COLUMNS = {
    "frame": "frame",
    "a_ms": "A ms",
    "b_ms": "B ms",
    "difference_ms": "difference ms",
    "stage": "mostly in",
    "why": "why",
}


def add_parser(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `study compare`."""
    parser = kinds.add_parser(
        "compare",
        help="two statistics files of one shot: the frames that differ most, and why",
        description="Compare two statistics files (regraft render --statistics, study update) "
        "frame by frame: which frames differ most, in which stage, and what counts explain it.",
    )
    parser.set_defaults(run=run)
    for name in ("A", "B"):
        parser.add_argument(name.lower(), metavar=f"{name}.jsonl", type=Path)
    study_frame.add_output(parser, "compare")


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft study compare`; raises CommandError. Returns the exit code."""
    study_frame.prepare(args, [args.a, args.b])
    pairs = compare.pair(_read(args.a), _read(args.b))
    if not pairs:
        raise InputError(f"{args.a} and {args.b} have no frame in common")
    rows = compare.differences(pairs)
    section = Section(f"{args.a.name} and {args.b.name}", compare.sentence(rows))
    section.tables.append(Table(_COLUMNS, rows[:_SHOWN]))
    _draw(sorted(rows, key=lambda row: row["frame"]), section.plots)
    report = study_frame.start("Two runs compared", A=args.a, B=args.b)
    report.sections.append(section)
    report.tables["compare"] = list(rows)
    for row in rows[:_SHOWN]:
        console.say(
            f"  frame {row['frame']:>5}  {row['a_ms']:>9.2f} → {row['b_ms']:>9.2f} ms  "
            f"{row['stage']}: {row['why']}"
        )
    return study_frame.finish(report, args.output, console)


def _read(path: Path) -> list[compare.Row]:
    try:
        rows = [row for row in jsonl.read(path) if isinstance(row.get("frame"), int)]
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"cannot read {path}: {error}") from error
    if not rows:
        raise InputError(f"{path} holds no statistics of frames")
    return rows


def _draw(rows: list[compare.Row], into: list[plots.Plot]) -> None:
    frames = [row["frame"] for row in rows]
    with plots.drawing("compare_total", "Each frame of both runs.", into) as axes:
        totals = {name: (frames, [r[f"{name.lower()}_ms"] for r in rows]) for name in ("A", "B")}
        plots.lines(axes, totals)
        axes.set(xlabel="frame", ylabel="ms")
    caption = "Where the difference comes from: above 0, B is slower."
    with plots.drawing("compare_stages", caption, into) as axes:
        stages = {s.removesuffix("_ms"): (frames, [r[s] for r in rows]) for s in compare.STAGES}
        plots.lines(axes, stages)
        axes.set(xlabel="frame", ylabel="B − A, ms")
