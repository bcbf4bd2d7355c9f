"""The viewport's picture, improving in another thread."""

from __future__ import annotations

import threading
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np

import regraft
from regraft_blender.progressive import DRAFT_SCALE, ProgressiveJob, Request

REQUEST = Request(
    camera=regraft.Camera.perspective(np.eye(4), 50, 2.0),
    width=64,
    height=32,
    region=(0, 0, 64, 32),
    shading="clay",
    samples=1,
    transparent=False,
    policy="refit",
    structure="auto",
    layout="two-level",
)


class Scene:
    """Draws the seed as a grey value, and can be made to wait in the middle of a picture."""

    def __init__(self) -> None:
        self.calls: list[tuple[int, int, int, int]] = []
        self.is_tracing = threading.Event()
        self.waits_at = -1

    def update(self, *_policy: str) -> None:
        self.calls.append((0, 0, 0, 0))

    def render(self, _camera: Any, width: int, height: int, **more: Any) -> Any:
        self.calls.append((width, height, more["samples"], more["seed"]))
        x0, y0, x1, y1 = more["region"]
        cancelled = False
        if len(self.calls) == self.waits_at:
            self.is_tracing.set()
            while not more["cancel"]():
                pass
            cancelled = True
        pixels = np.full((y1 - y0, x1 - x0, 4), more["seed"], np.float32)
        return SimpleNamespace(passes={"combined": pixels}, cancelled=cancelled)


def finished(scene: Any, request: Request) -> ProgressiveJob:
    job = ProgressiveJob(scene, request)
    job._thread.join(30)
    assert not job.is_running()
    return job


def test_trees_first_then_a_draft_then_the_picture() -> None:
    scene = Scene()
    job = finished(scene, REQUEST)
    draft = 64 // DRAFT_SCALE, 32 // DRAFT_SCALE
    assert scene.calls == [(0, 0, 0, 0), (*draft, 1, 0), (64, 32, 1, 0)]
    assert job.picture is not None
    assert job.picture.samples == 1
    assert job.picture.pixels.shape == (32, 64, 4)


def test_samples_are_averaged_without_the_centred_first_one() -> None:
    scene = Scene()
    job = finished(scene, replace(REQUEST, samples=10))
    batches = [call[2:] for call in scene.calls[3:]]
    assert batches == [(4, 1), (4, 5), (2, 9)]
    assert job.picture is not None
    assert job.picture.samples == 10
    assert np.allclose(job.picture.pixels, (4 * 1 + 4 * 5 + 2 * 9) / 10)


def test_a_stopped_job_leaves_the_scene_alone_and_serves_nobody() -> None:
    scene = Scene()
    scene.waits_at = 3
    job = ProgressiveJob(scene, REQUEST)
    assert scene.is_tracing.wait(30)
    assert job.serves(REQUEST)
    job.stop()
    assert not job.is_running()
    assert not job.serves(REQUEST)
    assert len(scene.calls) == 3
    assert job.picture is not None
    assert job.picture.samples == 0


def test_a_failure_is_handed_over() -> None:
    job = finished(SimpleNamespace(), REQUEST)
    assert isinstance(job.error, AttributeError)
    job.wait_for_picture(30)


def test_a_small_region_still_has_pixels_in_the_draft() -> None:
    job = finished(Scene(), replace(REQUEST, region=(1, 1, 2, 2)))
    assert job.picture is not None
    assert job.picture.pixels.shape == (1, 1, 4)


def test_many_samples_of_a_real_scene_come_close_to_rendering_them_at_once() -> None:
    scene = regraft.Scene(threads=1)
    mesh = scene.add_mesh(
        np.array([[-1, -1, -3], [1, -1, -3], [0, 1, -3]], np.float32),
        np.array([[0, 1, 2]], np.uint32),
    )
    scene.add_instance(mesh)
    job = finished(scene, replace(REQUEST, samples=64))
    at_once = scene.render(REQUEST.camera, 64, 32, shading="clay", samples=64)
    assert job.error is None
    assert job.picture is not None
    difference = job.picture.pixels - at_once.passes["combined"][::-1]
    assert np.abs(difference).max() < 0.2
    assert np.abs(difference).mean() < 0.005
