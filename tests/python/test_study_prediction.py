"""Correlations of `study prediction`, against what is known of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from regraft.study import aging, prediction, prediction_report
from stand_in_recording import shot_in

Row = dict[str, Any]
RANDOM = np.random.default_rng(3)


def rows(cost: Any, epo: Any, observed: Any, policy: str = "refit") -> list[Row]:
    return [
        {
            "frame": i,
            "policy": policy,
            "predicted": c,
            "epo": e,
            "origin_cost": c - e,
            "observed": o,
        }
        for i, (c, e, o) in enumerate(zip(cost, epo, observed, strict=True), 1)
    ]


def test_spearman_sees_order_only() -> None:
    x = np.array([1.0, 2.0, 3.0, 4.0])
    assert prediction.spearman(x, np.exp(x)) == pytest.approx(1.0)
    assert prediction.spearman(x, -x) == pytest.approx(-1.0)
    # Ties share their ranks: 1, 2.5, 2.5, 4 against 1, 2, 3, 4.
    tied = np.array([0.0, 5.0, 5.0, 9.0])
    assert prediction.spearman(tied, x) == pytest.approx(np.corrcoef([1, 2.5, 2.5, 4], x)[0, 1])


def test_what_does_not_vary_predicts_nothing() -> None:
    still = np.full(10, 3.3)
    assert prediction.pearson(still, np.arange(10.0)) is None
    assert prediction.pearson(still * (1 + 1e-13 * np.arange(10)), np.arange(10.0)) is None
    table = prediction.summary(rows(still, still, np.arange(10.0)))
    assert table[-1]["pearson"] is None
    assert "nothing to predict" in prediction_report.sentence(table, [])


def test_the_interval_holds_the_truth_and_shrinks() -> None:
    widths = []
    for count in (20, 500):
        x = RANDOM.normal(size=count)
        y = 0.8 * x + 0.6 * RANDOM.normal(size=count)
        found = prediction.with_interval(prediction.pearson, x, y)
        assert found
        assert found.low < 0.8 < found.high
        assert found.low <= found.value <= found.high
        widths.append(found.high - found.low)
    assert widths[1] < 0.4 * widths[0]


def test_alpha_is_found() -> None:
    cost, epo = RANDOM.normal(size=(2, 300))
    assert prediction.best_alpha(cost, epo, 0.29 * cost + 0.71 * epo) == pytest.approx(0.71)
    table = prediction.summary(rows(cost, epo, 0.29 * cost + 0.71 * epo))
    assert table[-1]["pearson_both"] == pytest.approx(1.0)


def test_the_cost_of_rays_from_inside_predicts_as_well() -> None:
    cost, epo = RANDOM.normal(size=(2, 50))
    table = prediction.summary(rows(cost, epo, 3.0 * (cost - epo)))
    assert table[-1]["pearson_origins"] == pytest.approx(1.0)


def test_promises_are_kept_within_a_quarter() -> None:
    operations = [
        {"predicted_benefit": 4.0, "realised_saving": saving} for saving in (4.0, 5.0, 3.0, 2.9)
    ]
    assert prediction.kept_promises(operations) == 0.75
    assert prediction.kept_promises([]) is None
    assert prediction.kept_promises([{"predicted_benefit": 0.0, "realised_saving": 1.0}]) is None


@pytest.mark.parametrize(("noise", "start"), [(0.1, "can be trusted"), (9.0, "not to be trusted")])
def test_the_verdict_says_whether_to_trust(noise: float, start: str) -> None:
    cost = RANDOM.normal(size=200)
    table = prediction.summary(rows(cost, cost, cost + noise * RANDOM.normal(size=200)))
    said = prediction_report.sentence(table, [])
    assert start in said
    assert f"r = {table[-1]['pearson']:.2f}" in said


def test_a_shot_is_measured(tmp_path: Path) -> None:
    ticks: list[int] = []
    settings = aging.Settings(size=16, fresh_every=0, threads=1)
    found = list(prediction.measure(shot_in(tmp_path), settings, ticks.append))
    assert ticks == [1, 2, 3]
    policies = list(dict.fromkeys(row["policy"] for row, _ in found))
    assert {"refit", "rebuild"} <= set(policies)
    assert len(found) == 3 * len(policies)
    assert all(row["predicted"] > 1 and row["observed"] > 0 and row["epo"] >= 0 for row, _ in found)
    section = prediction_report.section("x", [row for row, _ in found], [])
    assert len(section.tables[0].rows) == len(policies) + 1
