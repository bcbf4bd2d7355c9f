"""What `study update` measures, and that its verdict says what its table says."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from regraft.study import aging, local_motion, update, update_report, update_verdict

Row = dict[str, Any]
SMALL = update.Settings(policies=("refit", "auto"), size=16, repeats=2, threads=1)


def row(policy: str, frame: int, update_ms: float, tests: float, **more: Any) -> Row:
    """As `update.measure` yields it; a test a ray takes 1 ms of tracing."""
    about = {
        "repeat": 0,
        "frame": frame,
        "policy": policy,
        "layout": "two-level",
        "structure": "bvh",
    }
    counts = dict.fromkeys(update.COUNTS, 1)
    costs = {"observed_cost": tests, "culling_efficiency": tests, "hits": f"of frame {frame}"}
    return {**about, **counts, **costs, "update_ms": update_ms, "trace_ms": tests, **more}


def shot(**updates: tuple[float, list[float]]) -> list[Row]:
    """For each policy its update in ms and the tests a ray of every frame."""
    return [
        row(policy.replace("_", "+"), frame, update_ms, tests)
        for policy, (update_ms, costs) in updates.items()
        for frame, tests in enumerate(costs, 1)
    ]


AGES = shot(
    refit=(2.0, [10, 10, 11, 15, 30]),
    rebuild=(50.0, [10, 10, 10, 10, 10]),
    selective=(3.0, [10, 10, 10, 10.4, 10.2]),
    auto=(3.1, [10, 10, 10, 10.5, 10.1]),
)


def test_the_first_frame_is_stated_apart() -> None:
    rows = [row("rebuild", 1, 900.0, 10), row("rebuild", 2, 5.0, 10), row("rebuild", 3, 7.0, 10)]
    (total,) = update.totals(rows)
    assert total["first_update_ms"] == 900.0
    assert total["update_s"] == pytest.approx(0.012)
    assert total["total_s"] == pytest.approx(0.032)


def test_times_are_medians_over_the_replays() -> None:
    rows = [
        row("rebuild", frame, ms, 10, repeat=repeat)
        for repeat, ms in enumerate((5.0, 90.0, 6.0))
        for frame in (1, 2, 3)
    ]
    assert [r["update_ms"] for r in update.by_frame(rows)] == [6.0] * 3
    (total,) = update.totals(rows)
    assert total["update_s"] == pytest.approx(0.012)
    assert total["total_s_low"] < total["total_s"] < total["total_s_high"]


def test_the_verdict_repeats_the_table() -> None:
    totals = {r["label"]: r for r in update.totals(AGES)}
    said = update_verdict.sentence(list(totals.values()))
    chosen = totals["auto"]
    assert said.startswith("auto keeps this shot within 1.05× of a fresh tree at 6 % of")
    assert chosen["ratio_worst"] == pytest.approx(1.05)
    assert chosen["update_share"] == pytest.approx(0.062)
    assert totals["refit"]["enough_until"] == 3
    assert "refit is not enough after frame 3 " in said
    assert "at worst 3.00×" in said
    found = re.search(r"use auto: ([\d.]+)×", said)
    assert found
    assert float(found[1]) == pytest.approx(chosen["speed_up"], abs=0.005)


def test_a_much_faster_policy_is_preferred_to_auto() -> None:
    slow = [dict(r, update_ms=9.0) if r["policy"] == "auto" else r for r in AGES]
    totals = update.totals([r for r in slow if r["policy"] != "refit"])
    assert update_verdict.choose(totals)["label"] == "selective"
    saved = 1 - (4 * 3.0 + 40.6) / (4 * 9.0 + 40.6)
    assert f"choose selective, which saves {saved:.0%}".replace("%", " %") in (
        update_verdict.sentence(totals)
    )


def test_a_tree_let_go_is_not_called_kept() -> None:
    spoilt = [
        dict(r, observed_cost=90.0, trace_ms=1.0) if (r["policy"], r["frame"]) == ("auto", 4) else r
        for r in AGES
    ]
    said = update_verdict.sentence(update.totals(spoilt))
    assert "auto is the fastest for this shot, at 6 % of the time of rebuilding" in said
    assert "(at worst 9.00×, in frame 4)" in said


def test_where_nothing_changes_any_policy_will_do() -> None:
    still = [dict(r, nodes_refitted=0, nodes_rebuilt=0) for r in AGES]
    assert "any policy will do" in update_verdict.sentence(update.totals(still))


def test_who_was_given_up_is_not_recommended() -> None:
    short = [r for r in AGES if r["policy"] != "selective" or r["frame"] < 3]
    totals = update.totals(short)
    given_up = next(r for r in totals if r["label"] == "selective")
    assert (given_up["given_up_after"], given_up["speed_up"]) == (2, None)
    assert given_up["total_s"] < min(r["total_s"] for r in totals if r is not given_up)
    assert update_verdict.choose(totals)["label"] == "auto"
    notes = " ".join(update_report.notes(short, totals))
    assert "Given up for taking more than 4 times as long as rebuilding: selective" in notes


def test_hits_that_differ_are_the_verdict() -> None:
    wrong = [dict(r, hits="else") if (r["policy"], r["frame"]) == ("auto", 4) else r for r in AGES]
    assert [r["frame"] for r in update.different_hits(wrong)] == [4]
    said, is_wrong = update_report.verdict(wrong, update.totals(wrong))
    assert is_wrong
    assert "in frame 4 auto hits other things" in said
    assert not update_report.verdict(AGES, update.totals(AGES))[1]


def test_work_that_differs_between_replays_is_named() -> None:
    again = [dict(r, repeat=1, triangle_tests=7 if r["policy"] == "auto" else 1) for r in AGES]
    assert update.unsteady_counts([*AGES, *again]) == ["auto"]


def test_policies_take_turns_and_hit_the_same(tmp_path: Path) -> None:
    ticks: list[tuple[int, int]] = []
    made = local_motion.make(tmp_path, 3_000, 400, 3)
    rows = list(update.measure(made, SMALL, lambda *at: ticks.append(at)))
    assert ticks == [(0, 1), (0, 2), (0, 3), (1, 1), (1, 2), (1, 3)]
    assert [r["policy"] for r in rows[:3]] == ["refit", "auto", "rebuild"]
    assert [r["policy"] for r in rows[9:12]] == ["auto", "rebuild", "refit"]
    assert update.different_hits(rows) == []
    assert update.unsteady_counts(rows) == []
    rebuilt = [r for r in update.by_frame(rows) if r["policy"] == "rebuild"]
    assert [(r["ratio"], r["predicted_ratio"]) for r in rebuilt] == [(1.0, 1.0)] * 3


def test_a_hopeless_policy_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def frame(*args: Any) -> Row:
        position, contestant = args[1], args[3]
        slow = contestant.policy == "refit"
        return row(contestant.policy, position + 1, 2_000.0 if slow else 1.0, 10)

    monkeypatch.setattr(aging, "measure_frame", frame)
    made = local_motion.make(tmp_path, 400, 200, 4)
    rows = list(update.measure(made, SMALL, lambda *_: None))
    assert [(r["repeat"], r["frame"]) for r in rows if r["policy"] == "refit"] == [(0, 1), (0, 2)]
    assert sum(r["policy"] == "auto" for r in rows) == 8


def test_a_verdict_for_refit_does_not_call_it_not_enough_as_well() -> None:
    rows = shot(
        refit=(2.0, [10, 10, 10, 13]), rebuild=(50.0, [10, 10, 10, 10]), auto=(9.0, [10] * 4)
    )
    said = update_verdict.sentence(update.totals(rows))
    assert said.startswith("refit keeps this shot within 1.30× of a fresh tree")
    assert "not enough" not in said
    assert "choose refit" in said
