"""`regraft bench update --peers`: whole shots, ours and Embree's in one run."""

from __future__ import annotations

import argparse
import json
import math
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from statistics import geometric_mean, median
from typing import Any

from regraft.cli import native_program, peer_shot_file
from regraft.cli.console import Console
from regraft.cli.interrupt import Interrupt
from regraft.study.shot import Shot

PROGRAM = native_program.FOLDER / "regraft_bench_peers"
Row = dict[str, Any]
# Rays in packets and one by one: a contender is given the better of both.
WAYS = (("primary", "shadow"), ("primary_single", "shadow_single"))
PEER, AUTO = "embree", "regraft auto"


def measure(
    name: str, shot: Shot, args: argparse.Namespace, console: Console, interrupt: Interrupt
) -> dict[str, Any]:
    """Plays the shot `args.repeats` times and prints its table. Raises CommandError."""
    policies = [policy for policy in args.policies if policy != "shot"]
    with (
        tempfile.TemporaryDirectory() as folder,
        console.progress(len(shot) * args.repeats, name) as progress,
    ):
        path = Path(folder, "shot.bin")
        peer_shot_file.write(shot, path)
        settings = map(str, (path, args.size, args.threads, args.repeats))
        lists = (",".join(policies), ",".join(args.layouts))

        def tick(row: Row) -> None:
            text = f"{name}, replay {row['repeat'] + 1}, frame {row['frame']}"
            progress.step(text, str(row["frame"]))
            interrupt.check()

        rows = list(_rows(args.program, [*settings, *lists], tick))
    totalled = totals(rows)
    console.say(
        f"{name}, {args.size}² primary and shadow rays, {len(shot)} frames, {args.threads} threads"
    )
    for line in lines(totalled):
        console.say(line)
    return {"totals": totalled, "ratios": ratios(totalled), "rows": rows}


def _rows(program: Path, arguments: Sequence[str], tick: Callable[[Row], None]) -> Iterator[Row]:
    """A row a frame and contender; `tick` is called with the first of a frame."""
    before = None
    for line in native_program.lines(program, *arguments):
        row: Row = json.loads(line)
        if (row["repeat"], row["frame"]) != before:
            before = (row["repeat"], row["frame"])
            tick(row)
        yield row


def totals(rows: Sequence[Row]) -> list[Row]:
    """One row a contender, fastest first: over the frames after the first, which builds every
    tree, sums of the medians of all replays."""
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(row["contender"], []).append(row)
    return sorted((_total(*group) for group in groups.items()), key=lambda row: row["total_s"])


def _total(contender: str, rows: Sequence[Row]) -> Row:
    frames = list(dict.fromkeys(row["frame"] for row in rows))
    later = frames[1:] or frames

    def medians(column: str) -> list[float]:
        return [median(row[column] for row in rows if row["frame"] == f) for f in later]

    total: Row = {"contender": contender, "frames": len(later), "bytes": rows[-1]["bytes"]}
    for clock in ("", "_cpu"):
        updates = medians(f"update{clock}_ms")
        traces = [sum(sum(medians(f"{rays}{clock}_ms")) for rays in way) for way in WAYS]
        total |= {
            f"update{clock}_s": sum(updates) / 1e3,
            f"trace{clock}_s": min(traces) / 1e3,
            f"total{clock}_s": (sum(updates) + min(traces)) / 1e3,
            f"update{clock}_worst_ms": max(updates),
        }
    return total


def ratios(totalled: Sequence[Row]) -> dict[str, float]:
    """How many times as fast as the best of Embree's ways the best `auto` and the best of all ours
    are, by the clock and by processor time; nothing without Embree."""
    found: dict[str, float] = {}
    for clock in ("", "_cpu"):
        column = f"total{clock}_s"

        def best(prefix: str, column: str = column) -> float:
            return min(
                (r[column] for r in totalled if r["contender"].startswith(prefix)), default=math.nan
            )

        peer = best(PEER)
        found |= {f"auto{clock}": peer / best(AUTO), f"best{clock}": peer / best("regraft")}
    return {name: ratio for name, ratio in found.items() if math.isfinite(ratio)}


def lines(totalled: Sequence[Row]) -> Iterator[str]:
    """A table, and how far we are ahead."""
    yield (
        f"  {'':<34}{'total s':>9}{'update s':>10}{'trace s':>9}{'worst ms':>10}{'cpu s':>9}"
        f"{'MB':>8}"
    )
    for row in totalled:
        yield (
            f"    {row['contender']:<32}{row['total_s']:>9.3f}{row['update_s']:>10.3f}"
            f"{row['trace_s']:>9.3f}{row['update_worst_ms']:>10.2f}{row['total_cpu_s']:>9.3f}"
            f"{row['bytes'] / 1e6:>8.1f}"
        )
    if found := ratios(totalled):
        yield f"    against Embree's best way: {_described(found)}"


def summary(shots: dict[str, Any]) -> Iterator[str]:
    """The geometric means over all shots."""
    every = [shot["ratios"] for shot in shots.values() if shot["ratios"]]
    if every:
        means = {name: geometric_mean(ratios[name] for ratios in every) for name in every[0]}
        yield f"geometric mean of {len(every)} shots against Embree's best: {_described(means)}"


def _described(found: dict[str, float]) -> str:
    texts = []
    for who, text in (("auto", "auto"), ("best", "our best")):
        if who in found:
            cpu = f" ({found[who + '_cpu']:.2f} in processor time)"
            texts.append(f"{text} {found[who]:.2f}x as fast{cpu}")
    return ", ".join(texts)
