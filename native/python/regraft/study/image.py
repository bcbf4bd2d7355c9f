"""Image error against time: every mode of shading and number of samples beside a reference.

The reference is the mean of two halves of many samples with seeds of their own; half the root mean
square of their difference is its own error, below which nothing can be seen. Seconds hold the
update that the frame needs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import regraft
from regraft.study import image_error
from regraft.study.image_error import Picture
from regraft.study.shot import Shot
from regraft.study.tidy import quartiles

Row = dict[str, Any]
# The fullest mode, which the others come near to.
TRUE_MODE = "reflection"
MODES = ("clay", "occlusion", "direct", "reflection")
ERRORS = ("rmse", "relative_mse", "flip")
# Errors of which the time to reach them is told.
THRESHOLDS = {"rmse": (0.1, 0.03, 0.01), "flip": (0.2, 0.1, 0.05)}


@dataclass(frozen=True)
class Settings:
    """`most_samples` of a preview; `reference_samples` of each half of the reference."""

    width: int = 256
    height: int = 144
    most_samples: int = 64
    reference_samples: int = 512
    repeats: int = 5
    threads: int = 0

    def samples(self) -> list[int]:
        """1, 2, 4, …"""
        return [1 << k for k in range(self.most_samples.bit_length())]


@dataclass(frozen=True)
class Reference:
    picture: Picture
    floor: dict[str, float]


def scene_at(shot: Shot, settings: Settings) -> tuple[regraft.Scene, float]:
    """The shot's last frame on a scene that lived through the ones before, and the milliseconds
    of its last update."""
    scene = regraft.Scene(threads=settings.threads)
    spent = 0.0
    for position in range(len(shot)):
        shot.apply(position, scene)
        spent = scene.update(frames_left=len(shot) - position).update_ms
    return scene, spent


def reference(shot: Shot, scene: regraft.Scene, settings: Settings) -> Reference:
    """What the pictures are held against, and its own error in each measure."""
    halves = [
        _render(shot, scene, settings, TRUE_MODE, settings.reference_samples, seed)[0]
        for seed in (101, 202)
    ]
    mean: Picture = (halves[0] + halves[1]) / 2
    half_rmse = image_error.rmse(*halves) / 2
    floor = {
        "rmse": half_rmse,
        "relative_mse": image_error.relative_mse(*halves) / 4,
        "flip": image_error.flip(halves[0], mean),
    }
    return Reference(mean, floor)


def measure(shot: Shot, settings: Settings, tick: Callable[[object], None]) -> Iterator[Row]:
    """A row for each mode and number of samples; the reference's own error is the first."""
    scene, update_ms = scene_at(shot, settings)
    tick("reference")
    true = reference(shot, scene, settings)
    yield {"mode": "reference", "samples": 2 * settings.reference_samples, **true.floor}
    for mode in MODES:
        for samples in settings.samples():
            repeats = [
                _render(shot, scene, settings, mode, samples, seed)
                for seed in range(settings.repeats)
            ]
            low, middle, high = quartiles([ms for _, ms in repeats])
            picture = repeats[0][0]
            yield {
                "mode": mode,
                "samples": samples,
                "update_s": update_ms / 1e3,
                "seconds": (update_ms + middle) / 1e3,
                "seconds_low": (update_ms + low) / 1e3,
                "seconds_high": (update_ms + high) / 1e3,
                "rmse": image_error.rmse(picture, true.picture),
                "relative_mse": image_error.relative_mse(picture, true.picture),
                "flip": image_error.flip(picture, true.picture),
            }
            tick(f"{mode}, {samples} samples")


def _render(
    shot: Shot, scene: regraft.Scene, settings: Settings, mode: str, samples: int, seed: int
) -> tuple[Picture, float]:
    """The picture, and the milliseconds of tracing and shading."""
    camera = shot.camera(len(shot) - 1)
    size = (settings.width, settings.height)
    frame = scene.render(camera, *size, shading=mode, samples=samples, seed=seed)
    spent = frame.statistics.trace_ms + frame.statistics.shade_ms
    return frame.passes["combined"][..., :3], spent


def times_to_reach(rows: Sequence[Row]) -> list[Row]:
    """For each mode the least seconds after which an error is at most each threshold, or None."""
    found = []
    for mode in dict.fromkeys(r["mode"] for r in rows if r["mode"] != "reference"):
        row: Row = {"mode": mode}
        for error, limits in THRESHOLDS.items():
            for limit in limits:
                good = [r["seconds"] for r in rows if r["mode"] == mode and r[error] <= limit]
                row[f"{error} {limit:g}"] = min(good, default=None)
        found.append(row)
    return found


def bias(rows: Sequence[Row], mode: str) -> float:
    """The RMSE that more samples do not mend: E² = bias² + noise²/n, from the last two."""
    last, most = sorted((r for r in rows if r["mode"] == mode), key=lambda r: r["samples"])[-2:]
    share = most["samples"] / last["samples"]
    square = (share * most["rmse"] ** 2 - last["rmse"] ** 2) / (share - 1)
    return float(max(square, 0.0) ** 0.5)
