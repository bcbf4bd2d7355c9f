"""What the measurements over a shot add up to."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from regraft.study import aging, aging_table, local_motion, size_scaling


def row(frame: int, policy: str, update: float, trace: float, **more: Any) -> dict[str, Any]:
    names = ("pairs_considered", "pairs_restructured", "nodes_rebuilt", "select_ms")
    counts = dict.fromkeys((*names, "predictions", "predictions_right"), 0)
    costs = {"culling_efficiency": 10.0 + frame, "observed_cost": 20.0 + 2 * frame}
    times = {"update_ms": update, "trace_ms": trace, "cost_ratio": None}
    about = {"frame": frame, "policy": policy, "layout": "flat"}
    return {**about, **times, **counts, **costs, **more}


def test_the_first_frame_does_not_count() -> None:
    rows = [row(1, "refit", 900, 5), row(2, "refit", 2, 5), row(3, "refit", 4, 7)]
    (total,) = aging_table.totals(rows)
    assert total["first_update_ms"] == 900
    assert total["update_s"] == pytest.approx(0.006)
    assert total["total_s"] == pytest.approx(0.018)
    assert (total["update_median_ms"], total["update_worst_ms"]) == (3, 4)
    assert total["correlation"] == pytest.approx(1.0)


def test_ratios_come_from_the_frames_that_have_one() -> None:
    rows = [row(i, "refit", 1, 1, cost_ratio=ratio) for i, ratio in enumerate((1.0, None, 1.5))]
    (total,) = aging_table.totals(rows)
    assert (total["ratio_mean"], total["ratio_worst"]) == (1.25, 1.5)


def test_what_does_not_vary_has_no_correlation() -> None:
    still = [row(i, "refit", 1, 1, culling_efficiency=3.0) for i in range(4)]
    assert aging_table.correlation(still) is None
    assert aging_table.correlation([row(1, "refit", 1, 1)]) is None


def test_the_papers_speed_ups_stand_beside_ours() -> None:
    rows = [row(i, p, ms, 1) for i in (1, 2) for p, ms in (("selective", 1), ("rebuild", 3))]
    lines = list(aging_table.lines(aging_table.totals(rows)))
    assert "selective is 2.00x as fast as rebuild" in lines[-2]
    assert "correlation of predicted and observed tests –" in lines[-1]
    assert "8.5 / 1.81 / 4.69 / 1.14" in lines[-2]


def test_contestants_take_turns_on_the_same_frames(tmp_path: Path) -> None:
    shot = local_motion.make(tmp_path, 4_000, 400, 3)
    contestants = [aging.Contestant("refit", "two-level"), aging.Contestant("rebuild", "flat")]
    ticks: list[int] = []
    settings = aging.Settings(size=16, fresh_every=2, threads=1)
    rows = list(aging.measure(shot, contestants, settings, ticks.append))
    assert ticks == [1, 2, 3]
    assert [(r["frame"], r["policy"]) for r in rows[:3]] == [
        (1, "refit"),
        (1, "rebuild"),
        (2, "refit"),
    ]
    assert all(r["rays_primary"] == 256 and 0 < r["rays_shadow"] <= 256 for r in rows)
    assert [r["cost_ratio"] is None for r in rows] == [True, True, False, False, True, True]
    assert rows[3]["cost_ratio"] == pytest.approx(1.0, abs=1e-6), "a rebuilt tree is a fresh one"
    assert all((r["nodes_rebuilt"] > 0) == (r["policy"] == "rebuild") for r in rows[2:])


def test_the_slope_of_a_power_is_its_exponent() -> None:
    rows = [{"triangles": n, "ms": 3.0 * n**0.5} for n in (100, 1000, 50_000)]
    assert size_scaling.slope(rows, "ms") == pytest.approx(0.5)


def test_sizes_are_measured_one_by_one() -> None:
    ticks: list[int] = []
    rows = list(size_scaling.measure((5_000, 8_000), 1, ticks.append))
    assert [row["triangles"] for row in rows] == ticks == [5_000, 8_000]
    assert len(list(size_scaling.lines(rows))) == 4
