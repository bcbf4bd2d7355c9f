"""How trees age over a shot: the same frames on scenes that differ in policy and layout only.

All contestants take turns frame by frame, so that whatever else the machine does hits all alike.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import regraft
from regraft.study import fingerprint, key_frames
from regraft.study.shot import Shot

Row = dict[str, Any]
# One shadow ray for every point seen, whatever lights the file has.
SUN = regraft.Light("sun", direction=(0.3, 0.5, -0.8), energy=3.0)
# Statistics that a row takes over, from the update and from the picture.
UPDATE_FIELDS = (
    "update_ms",
    "nodes",
    "nodes_refitted",
    "nodes_rebuilt",
    "pairs_considered",
    "pairs_restructured",
    "culling_efficiency",
    "memory_bytes",
)
TRACE_FIELDS = (
    "trace_ms",
    "rays_primary",
    "rays_shadow",
    "nodes_visited",
    "triangle_tests",
    "observed_cost",
)


@dataclass(frozen=True)
class Contestant:
    """One way to keep a scene."""

    policy: str
    layout: str
    structure: str = "bvh"


@dataclass(frozen=True)
class Settings:
    """`size` of the square picture in pixels; the ratio to a fresh tree is measured on every
    `fresh_every`-th frame (0: never), since it takes a build; `threads` 0 for all; `fingerprint`
    the hits, to compare contestants."""

    size: int = 512
    fresh_every: int = 10
    threads: int = 0
    fingerprint: bool = False


def measure(
    shot: Shot,
    contestants: Sequence[Contestant],
    settings: Settings,
    tick: Callable[[int], None] = lambda _frame: None,
) -> Iterator[Row]:
    """One row for each frame and contestant. `tick` is called after each frame."""
    scenes = [new_scene(settings) for _ in contestants]
    for position, frame in enumerate(shot.frames):
        for contestant, scene in zip(contestants, scenes, strict=True):
            yield measure_frame(shot, position, scene, contestant, settings)
        tick(frame)


def new_scene(settings: Settings) -> regraft.Scene:
    """An empty one, lit by `SUN`."""
    scene = regraft.Scene(threads=settings.threads)
    scene.set_lights([SUN])
    return scene


def measure_frame(
    shot: Shot, position: int, scene: regraft.Scene, contestant: Contestant, settings: Settings
) -> Row:
    """Takes `scene` to the frame at `position` and measures update and trace."""
    shot.apply(position, scene, leave_out=frozenset({"set_lights"}))
    if contestant.policy == "shot":
        key_frames.give(shot, scene, position)
    done = scene.update(
        policy=contestant.policy,
        layout=contestant.layout,
        structure=contestant.structure,
        frames_left=len(shot) - position,
    )
    updated = done.as_dict()
    size, camera = settings.size, shot.camera(position)
    passes = fingerprint.PASSES if settings.fingerprint else ("combined",)
    picture = scene.render(camera, size, size, shading="direct", passes=passes)
    traced = picture.statistics.as_dict()
    row: Row = {"frame": shot.frames[position], **asdict(contestant)}
    row |= {name: updated[name] for name in UPDATE_FIELDS}
    row |= {name: traced[name] for name in TRACE_FIELDS}
    row["select_ms"] = done.select_ms
    predicted, realised = done.predicted_benefits, done.realised_savings
    row["predictions"] = len(predicted)
    row["predictions_right"] = int((abs(predicted - realised) <= 0.25 * realised).sum())
    row["cost_ratio"] = None
    if settings.fresh_every and position % settings.fresh_every == settings.fresh_every - 1:
        row["cost_ratio"] = scene.quality(fresh=True)["cost_ratio"]
    if settings.fingerprint:
        row["hits"] = fingerprint.of(scene, picture, position)
    return row
