"""Prediction against observation: does what a tree promises say what rays find?

Promised: C(root), the tests expected of a random ray (Yoon, Curtis, Manocha, EGSR 2007, Eq. 1; they
found correlations of 0.7 to 0.9), end-point overlap (Aila, Karras, Laine, HPG 2013, Eq. 2), and the
cost weighted by p_N, for rays that start in the scene (Fabianowski, Fowler, Dingliana, Eurographics
2009, Eq. 9).
Found: the tests that the picture's rays needed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from regraft.study import aging, offers
from regraft.study.shot import Shot

Row = dict[str, Any]
Numbers = npt.NDArray[np.float64]
# Trees that age in different ways, so that there is something to predict.
POLICIES = ("refit", "selective", "auto", "rebuild")
# Below this correlation the metric is not to be trusted for the shot.
TRUSTED = 0.7
ALL = "all policies"
_RESAMPLES = 2000


@dataclass(frozen=True)
class Correlation:
    """`low` to `high`: the 95 % interval of a bootstrap over the frames."""

    value: float
    low: float
    high: float


def measure(
    shot: Shot, settings: aging.Settings, tick: Callable[[int], None]
) -> Iterator[tuple[Row, list[Row]]]:
    """For each frame and policy a row, and a row for each pair of nodes that was restructured."""
    policies = [policy for policy in POLICIES if policy in offers.policies()]
    scenes = {policy: aging.new_scene(settings) for policy in policies}
    for position, frame in enumerate(shot.frames):
        for policy, scene in scenes.items():
            shot.apply(position, scene, leave_out=frozenset({"set_lights"}))
            updated = scene.update(policy=policy, structure="bvh", frames_left=len(shot) - position)
            picture = scene.render(shot.camera(position), settings.size, settings.size)
            quality = scene.quality()
            yield (
                {
                    "frame": frame,
                    "policy": policy,
                    "predicted": updated.culling_efficiency,
                    "epo": quality["epo"],
                    "origin_cost": quality["origin_cost"],
                    "observed": picture.statistics.observed_cost,
                    "pairs_restructured": updated.pairs_restructured,
                },
                [{"frame": frame, "policy": policy, **row} for row in _operations(updated)],
            )
        tick(frame)


def _operations(updated: Any) -> Iterator[Row]:
    promised, kept = updated.predicted_benefits, updated.realised_savings
    for benefit, saving in zip(promised.tolist(), kept.tolist(), strict=True):
        yield {"predicted_benefit": benefit, "realised_saving": saving}


def pearson(x: Numbers, y: Numbers) -> float | None:
    """Linear correlation; None where either does not vary beyond rounding."""
    if len(x) < 3 or not (_varies(x) and _varies(y)):
        return None
    return float(np.corrcoef(x, y)[0, 1])


def _varies(x: Numbers) -> bool:
    return bool(np.ptp(x) > 1e-9 * np.abs(x).max())


def spearman(x: Numbers, y: Numbers) -> float | None:
    """Correlation of the ranks; equal values share theirs."""
    return pearson(_ranks(x), _ranks(y))


def _ranks(x: Numbers) -> Numbers:
    _, inverse, counts = np.unique(x, return_inverse=True, return_counts=True)
    last = np.cumsum(counts).astype(np.float64)
    ranks: Numbers = (last - (counts - 1) / 2)[inverse.ravel()]
    return ranks


def with_interval(
    of: Callable[[Numbers, Numbers], float | None], x: Numbers, y: Numbers
) -> Correlation | None:
    """`of(x, y)` and how sure it is; None where it says nothing."""
    value = of(x, y)
    if value is None:
        return None
    random = np.random.default_rng(1)
    draws = (random.integers(len(x), size=len(x)) for _ in range(_RESAMPLES))
    found = [r for r in (of(x[draw], y[draw]) for draw in draws) if r is not None]
    low, high = np.quantile(found, (0.025, 0.975)) if found else (value, value)
    return Correlation(value, float(low), float(high))


def best_alpha(cost: Numbers, epo: Numbers, observed: Numbers) -> float:
    """α of the predictor (1−α)·C + α·EPO that correlates best."""
    alphas = np.linspace(0.0, 1.0, 101)
    scores = [pearson((1 - a) * cost + a * epo, observed) for a in alphas]
    return float(alphas[np.argmax([-2.0 if s is None else s for s in scores])])


def summary(rows: Sequence[Row]) -> list[Row]:
    """A row for each policy, and one for all together. First frames, which only build, count."""
    policies = dict.fromkeys(row["policy"] for row in rows)
    groups = {policy: [r for r in rows if r["policy"] == policy] for policy in policies}
    return [_summary(name, group) for name, group in {**groups, ALL: list(rows)}.items()]


def _summary(name: str, rows: Sequence[Row]) -> Row:
    cost, epo, origins, observed = (
        np.array([row[key] for row in rows], np.float64)
        for key in ("predicted", "epo", "origin_cost", "observed")
    )
    alpha = best_alpha(cost, epo, observed)
    linear = with_interval(pearson, cost, observed)
    return {
        "policy": name,
        "measurements": len(rows),
        "pearson": linear and linear.value,
        "pearson_low": linear and linear.low,
        "pearson_high": linear and linear.high,
        "spearman": spearman(cost, observed),
        "pearson_epo": pearson(epo, observed),
        "pearson_origins": pearson(origins, observed),
        "alpha": None if linear is None else alpha,
        "pearson_both": pearson((1 - alpha) * cost + alpha * epo, observed),
    }


def kept_promises(operations: Sequence[Row], within: float = 0.25) -> float | None:
    """Share of the operations whose saving is within `within` of what was promised."""
    ratios = [
        row["realised_saving"] / row["predicted_benefit"]
        for row in operations
        if row["predicted_benefit"] > 0.0
    ]
    return sum(abs(r - 1.0) <= within for r in ratios) / len(ratios) if ratios else None
