"""The GIL is free while the library works, signals get through, and threads may share a scene."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from types import FrameType

import numpy as np
import pytest

import regraft
from api_shapes import Doubles, moved, rays, soup, square

Action = Callable[[], object]

# So much work that it does not end by itself while a test waits for the interruption.
ENDLESS_SAMPLES = 65536
ENDLESS_RAYS = 200_000_000


def crowded() -> regraft.Scene:
    """20,000 triangles in one mesh, two threads."""
    scene = regraft.Scene(threads=2)
    scene.add_instance(scene.add_mesh(*soup(np.random.default_rng(1), 20_000, size=0.05)))
    scene.update()
    return scene


CAMERA = regraft.Camera.perspective(moved(z=4), 40, 1)


def render(scene: regraft.Scene, samples: int = 16) -> regraft.Frame:
    return scene.render(CAMERA, 256, 256, shading="occlusion", samples=samples)


def rebuild(scene: regraft.Scene) -> object:
    scene.set_vertices(0, soup(np.random.default_rng(2), 20_000, size=0.05)[0])
    return scene.update("rebuild")


def one_ray_again_and_again(count: int) -> tuple[Doubles, Doubles]:
    """(count, 3) origins and directions that take no memory."""
    origin, direction = np.array([0.01, 0.02, 4.0]), np.array([0.0, 0.0, -1.0])
    return np.broadcast_to(origin, (count, 3)), np.broadcast_to(direction, (count, 3))


@pytest.fixture
def ticks() -> Iterator[list[int]]:
    """A number that another Python thread raises whenever it gets the GIL.

    The interpreter is told never to take the GIL away from a thread that does not give it.
    """
    count, end = [0], threading.Event()

    def tick() -> None:
        while not end.wait(0.0002):
            count[0] += 1

    interval = sys.getswitchinterval()
    thread = threading.Thread(target=tick)
    thread.start()
    sys.setswitchinterval(1000)
    yield count
    sys.setswitchinterval(interval)
    end.set()
    thread.join()


@pytest.mark.parametrize(
    "work",
    [
        rebuild,
        render,
        lambda scene: scene.quality(fresh=True),
        lambda scene: scene.closest_hit(*rays(np.random.default_rng(3), 100_000)),
        lambda scene: scene.any_hit(*one_ray_again_and_again(1_000_000)),
    ],
    ids=["update", "render", "quality", "closest_hit", "any_hit"],
)
def test_another_thread_runs_meanwhile(
    ticks: list[int], work: Callable[[regraft.Scene], object]
) -> None:
    scene = crowded()
    for _ in range(50):
        before = ticks[0]
        work(scene)
        if ticks[0] > before:
            return
    pytest.fail("the other thread never ran")


class Interrupted(Exception):
    """Raised by the tests' signal handler."""


@pytest.fixture
def alarm() -> Iterator[None]:
    """SIGALRM raises `Interrupted` in the main thread, 0.3 seconds from now."""

    def handler(_: int, __: FrameType | None) -> None:
        raise Interrupted

    before = signal.signal(signal.SIGALRM, handler)
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    yield
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, before)


@pytest.mark.parametrize(
    "work",
    [
        lambda scene: render(scene, ENDLESS_SAMPLES),
        lambda scene: scene.any_hit(*one_ray_again_and_again(ENDLESS_RAYS)),
    ],
    ids=["render", "any_hit"],
)
def test_a_signal_ends_the_work_without_callbacks(
    alarm: None, work: Callable[[regraft.Scene], object]
) -> None:
    scene = regraft.Scene(threads=2)
    scene.add_instance(scene.add_mesh(*square()))
    scene.update()
    with pytest.raises(Interrupted):
        work(scene)
    signal.setitimer(signal.ITIMER_REAL, 0)
    assert scene.any_hit(*one_ray_again_and_again(1000)).all(), "the scene is as good as before"


def test_ctrl_c_ends_a_render() -> None:
    scene = crowded()
    # A shell's background jobs start with the signal ignored.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            scene.render(CAMERA, 64, 64, progress=lambda _: signal.raise_signal(signal.SIGINT))
    finally:
        signal.signal(signal.SIGINT, before)
    assert not render(scene, 1).cancelled


def run_all(actions: list[Action]) -> list[BaseException]:
    """Runs each action on a thread of its own; what they raised."""
    with ThreadPoolExecutor(len(actions)) as pool:
        futures = [pool.submit(action) for action in actions]
    return [error for error in (future.exception() for future in futures) if error]


def test_threads_may_trace_one_scene_at_the_same_time() -> None:
    scene = crowded()
    origins, directions = rays(np.random.default_rng(5), 20_000)
    want = scene.closest_hit(origins, directions)
    picture = render(scene, 2).passes["combined"]

    def query() -> None:
        for _ in range(5):
            got = scene.closest_hit(origins, directions)
            assert np.array_equal(got.t, want.t)
            assert np.array_equal(got.prim_id, want.prim_id)

    def draw() -> None:
        for _ in range(3):
            assert np.array_equal(render(scene, 2).passes["combined"], picture)

    assert run_all([query, query, draw, draw]) == []


def test_scenes_on_different_threads_do_not_meet() -> None:
    def live(seed: int) -> Action:
        def action() -> None:
            rng = np.random.default_rng(seed)
            scene = regraft.Scene(threads=2)
            vertices, triangles = soup(rng, 300)
            scene.add_instance(scene.add_mesh(vertices, triangles))
            for _ in range(20):
                scene.set_vertices(0, soup(rng, 300)[0])
                scene.update("refit")
                scene.closest_hit(*rays(rng, 1000))

        return action

    assert run_all([live(seed) for seed in range(4)]) == []


def test_a_scene_cannot_be_changed_by_another_thread_while_it_is_traced() -> None:
    scene = crowded()
    raised: list[BaseException] = []

    def meddle() -> bool:
        raised.extend(run_all([lambda: scene.set_visible(0, False), scene.update]))
        return True

    assert scene.render(CAMERA, 16, 16, cancel=meddle).cancelled
    assert [type(error) for error in raised] == [RuntimeError, RuntimeError]
