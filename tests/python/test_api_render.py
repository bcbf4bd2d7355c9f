"""render through the NumPy API: its arrays, arguments, callbacks and determinism."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import regraft
from api_shapes import affine, moved, soup, square
from regraft import _regraft

VERTICES, TRIANGLES = square()
CHANNELS = {"combined": 4, "depth": 1, "normal": 3, "object_index": 1, "cost": 1}
FRAME_FIELDS = [
    *("frame", "evaluate_ms", "extract_ms", "update_ms", "trace_ms", "shade_ms", "write_ms"),
    *("total_ms", "policy", "structure", "layout", "triangles", "instances", "moved_instances"),
    *("deformed_meshes", "deformed_triangles", "nodes", "nodes_refitted", "nodes_rebuilt"),
    *("pairs_considered", "pairs_restructured", "late_updates", "late_update_ms"),
    *("rays_primary", "rays_shadow"),
    *("rays_secondary", "nodes_visited", "triangle_tests", "culling_efficiency"),
    *("observed_cost", "cost_ratio", "kdtree_nodes", "kdtree_built_fraction"),
    *("kdtree_unbuilt_nodes", "kdtree_large_leaves", "memory_bytes", "left_out", "warnings"),
]


def looking_down(height: float = 4.0) -> regraft.Camera:
    """From (0, 0, height) along -Z, three units wide at z = 0 and twice as wide as high."""
    return regraft.Camera.orthographic(moved(z=height), 3.0, 2.0)


def small_scene(threads: int = 2, isa: str = "auto") -> regraft.Scene:
    """The square at z = 0 with object index 7, right half only in the picture's upper half."""
    scene = regraft.Scene(threads, isa=isa)
    mesh = scene.add_mesh(VERTICES, TRIANGLES)
    scene.add_instance(mesh, moved(x=0.5, y=1.0), object_index=7)
    scene.update()
    return scene


@pytest.fixture(scope="module")
def scene() -> regraft.Scene:
    return small_scene()


def busy_scene(threads: int, isa: str) -> regraft.Scene:
    """A crowd with smooth normals, materials and lights."""
    rng = np.random.default_rng(21)
    scene = regraft.Scene(threads, isa=isa)
    for _ in range(3):
        vertices, triangles = soup(rng, 30, size=0.5)
        scene.add_mesh(vertices, triangles, normal_ids=triangles)
    scene.set_materials(rng.uniform(0.2, 1, (3, 4)).astype(np.float32))
    for i in range(6):
        scene.add_instance(i % 3, affine(rng), materials=(i % 3,), object_index=i)
    scene.set_lights([regraft.Light("point", (2, 2, 3), energy=300, radius=0.3)])
    scene.update()
    return scene


def test_passes_are_top_row_first_and_contiguous_bottom_up(scene: regraft.Scene) -> None:
    frame = scene.render(looking_down(), 40, 20, passes=tuple(CHANNELS))
    assert list(frame.passes) == list(CHANNELS)
    assert not frame.cancelled
    for name, channels in CHANNELS.items():
        plane = frame.passes[name]
        assert plane.shape == (20, 40, channels)
        assert plane.dtype == np.float32
        assert plane[::-1].flags.c_contiguous
        assert plane.flags.writeable


def test_the_picture_is_the_right_way_up(scene: regraft.Scene) -> None:
    """The square covers x in [-0.5, 1.5] and y in [0, 2] of a picture over ±1.5 by ±0.75."""
    frame = scene.render(looking_down(), 30, 16, passes=("depth", "normal", "object_index"))
    inside = np.zeros((16, 30), bool)
    inside[:8, 10:] = True
    depth = frame.passes["depth"][..., 0]
    assert np.allclose(depth[inside], 4, atol=1e-4)
    assert (depth[~inside] == np.inf).all()
    assert np.allclose(frame.passes["normal"][inside], [0, 0, 1])
    assert (frame.passes["object_index"][..., 0] == np.where(inside, 7, 0)).all()


def test_only_the_passes_asked_for_are_there_in_that_order(scene: regraft.Scene) -> None:
    frame = scene.render(looking_down(), 8, 4, passes=["depth", "combined", "depth"])
    assert list(frame.passes) == ["depth", "combined"]
    assert list(scene.render(looking_down(), 8, 4).passes) == ["combined"]


def test_passes_outlive_the_frame_and_the_scene() -> None:
    own = small_scene()
    plane = own.render(looking_down(), 64, 32).passes["combined"]
    kept = plane.copy()
    del own
    assert np.array_equal(plane, kept)


def test_a_region_equals_that_part_of_the_whole(scene: regraft.Scene) -> None:
    names = tuple(CHANNELS)
    whole = scene.render(looking_down(), 30, 16, passes=names).passes
    part = scene.render(looking_down(), 30, 16, passes=names, region=(3, 5, 20, 16)).passes
    for name in names:
        assert np.array_equal(part[name], whole[name][0:11, 3:20]), name


def test_the_background_is_the_world_or_transparent() -> None:
    own = small_scene()
    own.set_world((0.25, 0.5, 1.0))
    corner = own.render(looking_down(), 30, 16).passes["combined"][-1, 0]
    assert corner.tolist() == [0.25, 0.5, 1.0, 1.0]
    clear = own.render(looking_down(), 30, 16, transparent=True).passes["combined"]
    assert clear[-1, 0, 3] == 0
    assert clear[2, 20, 3] == 1


@pytest.mark.parametrize("shading", ["clay", "occlusion", "direct", "reflection", "cost"])
def test_every_shading_gives_finite_colours(shading: str) -> None:
    frame = busy_scene(2, "auto").render(looking_down(), 48, 24, shading=shading, samples=2)
    assert np.isfinite(frame.passes["combined"]).all()
    assert frame.passes["combined"][..., :3].std() > 0


@pytest.mark.parametrize("isa", _regraft.available_isas())
@pytest.mark.parametrize("shading", ["occlusion", "direct", "reflection"])
def test_pictures_do_not_depend_on_threads_or_instruction_set(isa: str, shading: str) -> None:
    def picture(threads: int, isa: str) -> dict[str, Any]:
        scene = busy_scene(threads, isa)
        names = ("combined", "depth", "normal", "object_index")
        options: dict[str, Any] = {"shading": shading, "samples": 2, "passes": names, "seed": 5}
        return scene.render(looking_down(), 50, 25, **options).passes

    want = picture(1, "scalar")
    for threads in (1, 2, 3):
        got = picture(threads, isa)
        for name, plane in want.items():
            assert np.array_equal(got[name], plane), (name, threads)


def test_seeds_change_the_samples_only() -> None:
    scene = busy_scene(2, "auto")
    first, second, other = (
        scene.render(looking_down(), 40, 20, samples=2, seed=seed).passes["combined"]
        for seed in (1, 1, 2)
    )
    assert np.array_equal(first, second)
    assert not np.array_equal(first, other)


def test_frame_statistics_are_plain_json_in_their_order(scene: regraft.Scene) -> None:
    statistics = scene.render(looking_down(), 40, 20).statistics
    statistics.frame = 12
    statistics.write_ms = 1.5
    line = statistics.as_dict()
    assert list(line) == FRAME_FIELDS
    assert json.loads(json.dumps(line)) == line
    assert (line["frame"], line["rays_primary"]) == (12, 800)
    parts = [line[f"{part}_ms"] for part in ("evaluate", "extract", "update", "trace", "shade")]
    assert line["total_ms"] == pytest.approx(sum(parts) + 1.5)


def test_a_frame_keeps_its_statistics_object(scene: regraft.Scene) -> None:
    frame = scene.render(looking_down(), 8, 4)
    frame.statistics.left_out.append("said by the caller")
    frame.statistics.evaluate_ms = 3.0
    assert frame.statistics.as_dict()["left_out"][-1] == "said by the caller"
    assert frame.statistics.total_ms >= 3.0


def test_the_frame_after_an_update_answers_for_it() -> None:
    scene = small_scene()
    first = scene.render(looking_down(), 8, 4).statistics
    second = scene.render(looking_down(), 8, 4).statistics
    assert first.nodes_rebuilt > 0
    assert (second.nodes_rebuilt, second.update_ms) == (0, 0)


def test_progress_rises_to_one_at_most_on_the_calling_thread(scene: regraft.Scene) -> None:
    seen: list[float] = []
    scene.render(looking_down(), 256, 128, samples=64, progress=seen.append)
    assert seen
    assert seen == sorted(seen)
    assert 0 <= seen[0] <= seen[-1] <= 1


def test_cancel_gives_a_transparent_picture(scene: regraft.Scene) -> None:
    frame = scene.render(looking_down(), 64, 32, passes=("combined", "depth"), cancel=lambda: True)
    assert frame.cancelled
    assert (frame.passes["combined"] == 0).all()


def test_cancel_in_the_middle_keeps_finished_tiles(scene: regraft.Scene) -> None:
    fractions: list[float] = []
    frame = scene.render(
        looking_down(),
        1024,
        512,
        samples=4096,
        progress=fractions.append,
        cancel=lambda: fractions[-1] > 0,
    )
    alpha = frame.passes["combined"][..., 3]
    assert frame.cancelled
    assert 0 < (alpha == 1).mean() < 1
    assert set(np.unique(alpha)) <= {0, 1}


@pytest.mark.parametrize("callback", ["progress", "cancel"])
def test_an_exception_in_a_callback_ends_the_render(scene: regraft.Scene, callback: str) -> None:
    def fail(*_: float) -> bool:
        raise ZeroDivisionError("said by the callback")

    callbacks: dict[str, Any] = {callback: fail}
    with pytest.raises(ZeroDivisionError, match="said by the callback"):
        scene.render(looking_down(), 64, 32, **callbacks)
    assert not scene.render(looking_down(), 64, 32).cancelled


def test_a_callback_cannot_change_the_scene_that_is_rendered() -> None:
    scene = small_scene()
    changes: list[Callable[[], object]] = [
        lambda: scene.add_mesh(VERTICES, TRIANGLES),
        lambda: scene.set_vertices(0, VERTICES),
        lambda: scene.set_transform(0, moved()),
        lambda: scene.set_lights(()),
        lambda: scene.update(),
    ]
    for change in changes:
        callbacks: dict[str, Any] = {"progress": lambda _, change=change: change()}
        with pytest.raises(RuntimeError, match="the scene is being traced"):
            scene.render(looking_down(), 64, 32, **callbacks)
        change()
        scene.update()


def test_a_callback_may_trace_and_render(scene: regraft.Scene) -> None:
    inner: list[Any] = []

    def look(_: float) -> None:
        inner.append(scene.render(looking_down(), 30, 16).passes["combined"])
        assert scene.any_hit(np.array([[0.5, 1, 4]]), np.array([[0, 0, -1.0]])).all()

    outer = scene.render(looking_down(), 30, 16, progress=look).passes["combined"]
    assert np.array_equal(inner[0], outer)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"width": 0}, "width: 0 is outside [1, 65536]"),
        ({"height": -3}, "height: -3 is outside"),
        ({"width": 8.0}, "width: a whole number wanted, got float"),
        ({"samples": 0}, "samples: 0 is outside"),
        ({"seed": -1}, "seed: -1 is outside"),
        ({"shading": "toon"}, 'shading "toon"'),
        ({"passes": ("beauty",)}, 'pass "beauty"'),
        ({"passes": "combined"}, "passes: a sequence of names wanted"),
        ({"passes": ()}, "no pass is asked for"),
        ({"region": (0, 0, 0, 0)}, "region: is empty"),
        ({"region": (4, 0, 2, 4)}, "region (4, 0, 2, 4) is empty"),
        ({"region": (0, 0, 9, 4)}, "not inside the image"),
        ({"region": (0, 0, 4)}, "region: (x0, y0, x1, y1) wanted, got 3"),
        ({"region": (-1, 0, 4, 4)}, "region: -1 is outside"),
        ({"camera": None}, "Camera: has no attribute kind; a regraft.Camera wanted"),
    ],
)
def test_wrong_render_arguments_are_named(
    scene: regraft.Scene, arguments: dict[str, Any], message: str
) -> None:
    good: dict[str, Any] = {"camera": looking_down(), "width": 8, "height": 4}
    with pytest.raises(ValueError, match=re.escape(message)):
        scene.render(**{**good, **arguments})


@pytest.mark.parametrize(
    ("attribute", "value", "message"),
    [
        ("kind", "toy", 'Camera.kind: "toy" is none of perspective, orthographic'),
        ("matrix", np.eye(4, dtype=np.float32), "Camera.matrix: float64 wanted, got float32"),
        ("window", (1, 2, 3), "Camera.window: 4 numbers wanted, got 3"),
        ("clip_near", "close", "Camera.clip_near: a number wanted, got str"),
    ],
)
def test_wrong_camera_attributes_are_named(
    scene: regraft.Scene, attribute: str, value: Any, message: str
) -> None:
    camera = looking_down()
    object.__setattr__(camera, attribute, value)
    with pytest.raises(ValueError, match=re.escape(message)):
        scene.render(camera, 8, 4)
