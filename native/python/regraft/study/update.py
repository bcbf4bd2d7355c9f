"""Tree quality against update time: what every policy costs over a shot, and what it is worth.

The shot is replayed several times on fresh scenes; times are medians over the replays, counts are
those of the first. How good a tree is: the tests that the picture's rays needed in it over those
they needed in the tree that `rebuild` has in the same frame, which is a fresh one; and the same for
the tests expected of a random ray (Yoon, Curtis, Manocha, EGSR 2007, Eq. 1), which do not see what
goes wrong in a part that is small beside the scene but fills the picture.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf
from time import perf_counter
from typing import Any

from regraft.study import aging, offers
from regraft.study.shot import Shot
from regraft.study.tidy import quartiles

Row = dict[str, Any]
YARDSTICK = "rebuild"
# How many times as long as rebuilding a policy may take before it is given up.
HOPELESS = 4.0
# Trees that cost up to this many times a fresh one are good enough.
ENOUGH = 1.2
COUNTS = (
    "nodes",
    "nodes_refitted",
    "nodes_rebuilt",
    "pairs_considered",
    "pairs_restructured",
    "rays_primary",
    "rays_shadow",
    "nodes_visited",
    "triangle_tests",
    "culling_efficiency",
    "observed_cost",
    "memory_bytes",
)


@dataclass(frozen=True)
class Settings:
    """What to measure; `size` of the square picture in pixels, `threads` 0 for all. A replay that
    would end after `minutes` is left out, the first excepted."""

    policies: Sequence[str] = ()
    layouts: Sequence[str] = ("two-level",)
    size: int = 256
    repeats: int = 5
    minutes: float = inf
    threads: int = 0

    def contestants(self) -> list[aging.Contestant]:
        """All policies there are if none are named; the yardstick is always there."""
        wanted = self.policies or offers.policies()
        policies = dict.fromkeys([*wanted, YARDSTICK])
        found = [aging.Contestant(p, layout) for layout in self.layouts for p in policies]
        if "kdtree" in offers.structures() and not self.policies:
            found.append(aging.Contestant(YARDSTICK, self.layouts[0], "kdtree"))
        return found


def measure(shot: Shot, settings: Settings, tick: Callable[[int, int], None]) -> Iterator[Row]:
    """A row for each replay, frame and contestant; `tick(repeat, frame)` after each frame.

    Whoever came first in one replay comes last in the next. Who takes `HOPELESS` times as long as
    the yardstick is given up, and not replayed.
    """
    racing, started = settings.contestants(), perf_counter()
    for repeat in range(settings.repeats):
        if repeat and (perf_counter() - started) * (repeat + 1) / repeat > 60 * settings.minutes:
            return
        given_up: set[aging.Contestant] = set()
        for row in _replay(shot, racing, settings, given_up, lambda f, r=repeat: tick(r, f)):  # type: ignore[misc]
            yield {"repeat": repeat, **row}
        racing = [c for c in (*racing[1:], racing[0]) if c not in given_up]


def _replay(
    shot: Shot,
    contestants: Sequence[aging.Contestant],
    settings: Settings,
    given_up: set[aging.Contestant],
    tick: Callable[[int], None],
) -> Iterator[Row]:
    once = aging.Settings(settings.size, 0, settings.threads, fingerprint=True)
    scenes = {contestant: aging.new_scene(once) for contestant in contestants}
    spent_ms = dict.fromkeys(contestants, 0.0)
    for position, frame in enumerate(shot.frames):
        for contestant, scene in scenes.items():
            row = aging.measure_frame(shot, position, scene, contestant, once)
            if position:
                spent_ms[contestant] += row["update_ms"] + row["trace_ms"]
            yield row
        limit = HOPELESS * _yardstick_of(spent_ms) + 1e3
        given_up |= {c for c in scenes if spent_ms[c] > limit and position + 1 < len(shot)}
        scenes = {c: scene for c, scene in scenes.items() if c not in given_up}
        tick(frame)


def _yardstick_of(spent_ms: dict[aging.Contestant, float]) -> float:
    return min(ms for c, ms in spent_ms.items() if c.policy == YARDSTICK and c.structure == "bvh")


def label(row: Row) -> str:
    """How tables and plots call the row's contestant."""
    if row["structure"] == "kdtree":
        return "k-d tree"
    return str(row["policy"]) + (" flat" if row["layout"] == "flat" else "")


def by_frame(rows: Sequence[Row]) -> list[Row]:
    """A row for each contestant and frame, over all replays."""
    groups: dict[tuple[str, str, str, int], list[Row]] = {}
    for row in rows:
        key = (row["structure"], row["layout"], row["policy"], row["frame"])
        groups.setdefault(key, []).append(row)
    merged = [_merged(group) for group in groups.values()]
    fresh = {
        (r["layout"], r["frame"]): r
        for r in merged
        if r["policy"] == YARDSTICK and r["structure"] == "bvh"
    }
    for row in merged:
        best = fresh[row["layout"], row["frame"]]
        is_bvh = row["structure"] == "bvh"
        row["ratio"] = _share(row["observed_cost"], best["observed_cost"]) if is_bvh else None
        row["predicted_ratio"] = (
            _share(row["culling_efficiency"], best["culling_efficiency"]) if is_bvh else None
        )
    order = {name: i for i, name in enumerate(dict.fromkeys(label(r) for r in merged))}
    return sorted(merged, key=lambda r: (order[label(r)], r["frame"]))


def _merged(rows: Sequence[Row]) -> Row:
    first = min(rows, key=lambda row: row["repeat"])
    out = {name: first[name] for name in ("frame", "structure", "layout", "policy")}
    for name in ("update_ms", "trace_ms"):
        low, middle, high = quartiles([row[name] for row in rows])
        out |= {name: middle, f"{name}_low": low, f"{name}_high": high}
    return out | {name: first[name] for name in COUNTS}


def different_hits(rows: Sequence[Row]) -> list[Row]:
    """Rows whose hits are not those of the frame's first row: there must be none."""
    expected: dict[int, str] = {}
    return [row for row in rows if expected.setdefault(row["frame"], row["hits"]) != row["hits"]]


def unsteady_counts(rows: Sequence[Row]) -> list[str]:
    """Labels of contestants whose work differed from replay to replay."""
    seen: dict[tuple[str, int], tuple[Any, ...]] = {}
    found = {}
    for row in rows:
        work = tuple(row[name] for name in ("nodes_refitted", "nodes_rebuilt", "triangle_tests"))
        if seen.setdefault((label(row), row["frame"]), work) != work:
            found[label(row)] = True
    return list(found)


def totals(rows: Sequence[Row]) -> list[Row]:
    """A row for each contestant, from the rows of `measure`. The first frame, which builds
    everything, is stated apart."""
    frames = by_frame(rows)
    first = frames[0]["frame"] if frames else 0
    several = any(row["frame"] != first for row in frames)
    counted = [row for row in rows if row["frame"] != first or not several]
    per_label: dict[str, list[Row]] = {}
    for row in frames:
        per_label.setdefault(label(row), []).append(row)
    result = [
        _total(name, group, [r for r in counted if label(r) == name])
        for name, group in per_label.items()
    ]
    for row in result:
        _compare(row, yardstick(result, row["layout"]))
    return result


def _compare(row: Row, best: Row) -> None:
    is_whole = row["frames"] == best["frames"]
    row["given_up_after"] = None if is_whole else row["last_frame"]
    row["update_share"] = _share(row["update_s"], best["update_s"]) if is_whole else None
    row["speed_up"] = _share(best["total_s"], row["total_s"]) if is_whole else None


def yardstick(rows: Sequence[Row], layout: str = "") -> Row:
    """The row of `totals` that the others are measured by."""
    of_bvh = [r for r in rows if r["policy"] == YARDSTICK and r["structure"] == "bvh"]
    return next((row for row in of_bvh if row["layout"] == layout), of_bvh[0])


def _total(name: str, frames: Sequence[Row], measured: Sequence[Row]) -> Row:
    later = frames[1:] or frames
    ratios = [row["ratio"] for row in later if row["ratio"] is not None]
    worst = max(later, key=lambda row: row["ratio"] or 0.0)
    update, trace = (_seconds(measured, n) for n in ("update_ms", "trace_ms"))
    total = quartiles([u + t for u, t in zip(update, trace, strict=True)])
    return {
        "label": name,
        **{key: frames[0][key] for key in ("policy", "layout", "structure")},
        "frames": len(later),
        "first_update_ms": frames[0]["update_ms"],
        "update_s": quartiles(update)[1],
        "trace_s": quartiles(trace)[1],
        "total_s": total[1],
        "total_s_low": total[0],
        "total_s_high": total[2],
        "last_frame": frames[-1]["frame"],
        "ratio_median": quartiles(ratios)[1] if ratios else None,
        "ratio_worst": worst["ratio"],
        "worst_frame": worst["frame"] if ratios else None,
        "enough_until": _enough_until(frames),
        **{n: sum(row[n] for row in later) for n in COUNTS[1:5]},
    }


def _seconds(rows: Sequence[Row], name: str) -> list[float]:
    """Of each replay: the sum over its frames."""
    sums: dict[int, float] = {}
    for row in rows:
        sums[row["repeat"]] = sums.get(row["repeat"], 0.0) + row[name] / 1e3
    return list(sums.values())


def _enough_until(frames: Sequence[Row]) -> int | None:
    """The last frame before the tree costs more than `ENOUGH`; None if it never does."""
    for before, row in pairwise(frames):
        if (row["ratio"] or 0.0) > ENOUGH:
            return int(before["frame"])
    return None


def _share(part: float, whole: float) -> float | None:
    return part / whole if whole > 0.0 else None
