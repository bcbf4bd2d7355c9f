"""`study compare`: which frames differ, and what explains it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from regraft.cli import main
from regraft.study import compare

Row = dict[str, Any]


def row(frame: int, update_ms: float = 2.0, trace_ms: float = 10.0, **more: Any) -> Row:
    times = {"update_ms": update_ms, "trace_ms": trace_ms, "shade_ms": 1.0}
    return {"frame": frame, **times, "total_ms": update_ms + trace_ms + 1.0, **more}


A = [row(i, nodes_refitted=1000, nodes_rebuilt=0) for i in range(1, 6)]
B = [
    row(i, 30.0 if i == 4 else 2.5, nodes_refitted=1000, nodes_rebuilt=900 if i == 4 else 0)
    for i in range(2, 7)
]


def test_the_frame_that_differs_most_comes_first_with_its_cause() -> None:
    rows = compare.differences(compare.pair(A, B))
    assert sorted(r["frame"] for r in rows) == [2, 3, 4, 5]
    worst = rows[0]
    assert (worst["frame"], worst["stage"]) == (4, "update")
    assert worst["difference_ms"] == pytest.approx(28.0)
    assert worst["why"] == "nodes_rebuilt 0 → 900"
    assert rows[1]["why"] == "no count differs: the machine"
    said = compare.sentence(rows)
    assert said.startswith(
        "B takes 1.04× the time of A over 4 frames (median 13.5 against 13.0 ms)"
    )
    assert "frame 4 differs most: +28.0 ms, update: nodes_rebuilt 0 → 900" in said


def test_what_only_one_run_left_out_is_a_cause() -> None:
    (found,) = compare.differences(
        [(row(1, left_out=["a", "b"]), row(1, 9.0, left_out=["b"], warnings=["hot"]))]
    )
    assert found["why"] == "only A left out: a; only B warned: hot"


def test_several_rows_a_frame_are_paired_by_policy() -> None:
    a = [row(f, policy=p) for f in (1, 2) for p in ("refit", "auto")]
    pairs = compare.pair(a, list(reversed(a)))
    assert len(pairs) == 4
    assert all(x is y for x, y in pairs)


def test_runs_of_different_policies_are_paired_by_frame() -> None:
    assert len(compare.pair([row(1, policy="refit")], [row(1, policy="auto")])) == 1


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    monkeypatch.chdir(tmp_path)
    for name, rows in (("a.jsonl", A), ("b.jsonl", B), ("other.jsonl", [row(99)])):
        Path(name).write_text("".join(json.dumps(r) + "\n" for r in rows))
    Path("empty.jsonl").write_text("not json\n")
    assert main(("study", "compare", "a.jsonl", "b.jsonl")) == 0
    verdict = compare.sentence(compare.differences(compare.pair(A, B)))
    assert verdict in capsys.readouterr().out
    assert verdict in Path("study_compare", "index.html").read_text("utf-8")
    assert main(("study", "compare", "a.jsonl", "other.jsonl")) == 3
    assert main(("study", "compare", "a.jsonl", "empty.jsonl")) == 3
    assert main(("study", "compare", "a.jsonl", "missing.jsonl")) == 3


def test_nothing_that_the_library_does_explains_time_outside_of_it() -> None:
    a = row(1, left_out=["a"]) | {"write_ms": 1.0, "total_ms": 11.0}
    b = row(1) | {"write_ms": 9.0, "total_ms": 19.0}
    (found,) = compare.differences([(a, b)])
    assert (found["stage"], found["why"]) == ("write", "no count differs: the machine")
