"""What `aging` measured, as totals for each policy and as lines for people."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from statistics import fmean, median
from typing import Any

Row = dict[str, Any]
# Speed-ups of selective restructuring over the others in Yoon, Curtis, Manocha 2007, Table 2:
# exploding dragon, n-body, cloth, BART.
PAPER = {
    "lm": (2.16, 1.36, 1.29, 1.11),
    "rtdeform": (1.65, 1.25, 1.03, 2.5),
    "refit": (11.0, 80.0, 0.96, 28.0),
    "rebuild": (8.5, 1.81, 4.69, 1.14),
}
OURS = "selective"


def totals(rows: Sequence[Row]) -> list[Row]:
    """One row for each layout and policy, in order of appearance. The first frame, which builds
    every tree, is stated apart."""
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        groups.setdefault((row["layout"], row["policy"]), []).append(row)
    return [_total(layout, policy, group) for (layout, policy), group in groups.items()]


def _total(layout: str, policy: str, rows: Sequence[Row]) -> Row:
    later = rows[1:] or rows
    updates = [row["update_ms"] for row in later]
    traces = [row["trace_ms"] for row in later]
    ratios = [row["cost_ratio"] for row in rows if row["cost_ratio"] is not None]
    return {
        "layout": layout,
        "policy": policy,
        "frames": len(later),
        "first_update_ms": rows[0]["update_ms"],
        "update_s": sum(updates) / 1e3,
        "trace_s": sum(traces) / 1e3,
        "total_s": (sum(updates) + sum(traces)) / 1e3,
        "update_median_ms": median(updates),
        "update_worst_ms": max(updates),
        "ratio_mean": fmean(ratios) if ratios else None,
        "ratio_worst": max(ratios) if ratios else None,
        "pairs_considered": sum(row["pairs_considered"] for row in later),
        "pairs_restructured": sum(row["pairs_restructured"] for row in later),
        "nodes_rebuilt": sum(row["nodes_rebuilt"] for row in later),
        "correlation": correlation(later),
        "select_share": sum(row["select_ms"] for row in later) / max(sum(updates + traces), 1e-9),
        "predictions": sum(row["predictions"] for row in later),
        "predictions_right": sum(row["predictions_right"] for row in later),
    }


def correlation(rows: Sequence[Row]) -> float | None:
    """Pearson's r of predicted (`culling_efficiency`) and observed tests a ray; None if either
    does not vary."""
    from statistics import StatisticsError
    from statistics import correlation as pearson

    pairs = [(row["culling_efficiency"], row["observed_cost"]) for row in rows]
    try:
        return pearson(*zip(*pairs, strict=True))
    except (StatisticsError, TypeError):
        return None


def lines(totalled: Sequence[Row]) -> Iterator[str]:
    """A table for each layout."""
    for layout in dict.fromkeys(row["layout"] for row in totalled):
        yield (
            f"  {layout:<16}{'total s':>9}{'update s':>10}{'trace s':>9}{'median ms':>11}"
            f"{'worst ms':>10}{'C/C fresh':>11}{'worst':>8}{'pairs':>8}{'mended':>8}{'rebuilt':>10}"
        )
        for row in totalled:
            if row["layout"] == layout:
                yield _line(row)
        yield from _speed_ups([row for row in totalled if row["layout"] == layout])
        yield from _metric([row for row in totalled if row["layout"] == layout])


def _line(row: Row) -> str:
    ratios = (number(row["ratio_mean"], 11), number(row["ratio_worst"], 8))
    return (
        f"    {row['policy']:<14}{row['total_s']:>9.3f}{row['update_s']:>10.3f}"
        f"{row['trace_s']:>9.3f}{row['update_median_ms']:>11.2f}{row['update_worst_ms']:>10.2f}"
        f"{ratios[0]}{ratios[1]}{row['pairs_considered']:>8}{row['pairs_restructured']:>8}"
        f"{row['nodes_rebuilt']:>10}"
    )


def number(value: float | None, width: int) -> str:
    """`value` to three decimals, right-aligned; a dash for None."""
    return f"{'–':>{width}}" if value is None else f"{value:>{width}.3f}"


def _metric(rows: Sequence[Row]) -> Iterator[str]:
    """How well the metric told what rays would do."""
    for row in rows:
        if row["policy"] != OURS:
            continue
        r = "–" if row["correlation"] is None else f"{row['correlation']:.3f}"
        yield (
            f"    {OURS}: correlation of predicted and observed tests {r}; "
            f"{row['predictions_right']} of {row['predictions']} benefits within 25 %; "
            f"mending is {row['select_share']:.1%} of update and trace"
        )


def _speed_ups(rows: Sequence[Row]) -> Iterator[str]:
    """Ours beside Table 2 of the paper."""
    by_policy = {row["policy"]: row["total_s"] for row in rows}
    if OURS not in by_policy:
        return
    for other, paper in PAPER.items():
        if other in by_policy:
            quoted = " / ".join(f"{value:g}" for value in paper)
            yield (
                f"    {OURS} is {by_policy[other] / by_policy[OURS]:.2f}x as fast as {other}"
                f" (paper: dragon / n-body / cloth / BART {quoted})"
            )
