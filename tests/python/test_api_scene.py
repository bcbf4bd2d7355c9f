"""The scene's content through the NumPy API: what is taken, what is refused and in which words."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import regraft
from api_shapes import MISS, affine, moved, square

VERTICES, TRIANGLES = square()


@pytest.fixture
def scene() -> regraft.Scene:
    """One mesh "Sign" (id 0) with one instance (id 0)."""
    scene = regraft.Scene(threads=1)
    scene.add_instance(scene.add_mesh(VERTICES, TRIANGLES, name="Sign"), name="Left")
    return scene


def refusal(action: Callable[[], object]) -> str:
    """The message of the ValueError that `action` raises."""
    with pytest.raises(ValueError) as caught:  # noqa: PT011 - the caller compares the whole message
        action()
    return str(caught.value)


def hit_height(scene: regraft.Scene, x: float = 0.5, y: float = 0.2) -> float:
    """World z of what a ray straight down at x, y meets; -inf for nothing."""
    scene.update()
    hits = scene.closest_hit(np.array([[x, y, 10.0]]), np.array([[0.0, 0.0, -1.0]]))
    return round(10.0 - float(hits.t[0]), 5)


def test_ids_count_from_zero_and_are_never_used_again(scene: regraft.Scene) -> None:
    second = scene.add_mesh(VERTICES, TRIANGLES)
    scene.remove_mesh(second)
    assert (second, scene.add_mesh(VERTICES, TRIANGLES)) == (1, 2)


def test_counts_what_exists(scene: regraft.Scene) -> None:
    scene.add_group(name="Top")
    scene.remove_instances([scene.add_instance(0)])
    assert scene.counts() == {"meshes": 1, "instances": 1, "groups": 1, "triangles": 2}


@pytest.mark.parametrize(
    ("vertices", "triangles", "message"),
    [
        (VERTICES.astype(float), TRIANGLES, "vertices: float32 wanted, got float64; convert it"),
        (VERTICES, TRIANGLES.astype(int), "triangles: uint32 wanted, got int64; convert it"),
        (VERTICES.tolist(), TRIANGLES, "vertices: a NumPy array of float32 wanted, got list"),
        (VERTICES[:, :2], TRIANGLES, "vertices: shape (N, 3) wanted, got (4, 2)"),
        (VERTICES, TRIANGLES.ravel(), "triangles: shape (N, 3) wanted, got (6,)"),
        (VERTICES.astype(">f4"), TRIANGLES, "vertices: float32 wanted, got >f4"),
        (VERTICES[:3], TRIANGLES, "triangle 1 names vertex 3, but there are 3 vertices"),
    ],
)
def test_wrong_mesh_arrays_are_named(
    scene: regraft.Scene, vertices: Any, triangles: Any, message: str
) -> None:
    added = refusal(lambda: scene.add_mesh(vertices, triangles, name="Flag"))
    assert 'mesh "Flag": ' in added.replace("mesh 1 ", "mesh ")
    assert message in added
    assert 'mesh 0 "Sign": ' + message in refusal(lambda: scene.set_mesh(0, vertices, triangles))
    assert scene.counts()["meshes"] == 1


@pytest.mark.parametrize(
    ("arrays", "message"),
    [
        ({"slots": np.zeros(2, np.int32)}, "slots: uint16 wanted, got int32"),
        ({"slots": np.zeros(3, np.uint16)}, "slots: shape (2,) wanted, got (3,)"),
        ({"normal_ids": np.zeros((2, 2), np.uint32)}, "normal_ids: shape (2, 3) wanted"),
        ({"normal_ids": np.full((2, 3), 6, np.uint32)}, "normal id 6, below 6 wanted"),
    ],
)
def test_wrong_slots_and_normal_ids_are_named(
    scene: regraft.Scene, arrays: dict[str, Any], message: str
) -> None:
    assert message in refusal(lambda: scene.add_mesh(VERTICES, TRIANGLES, **arrays))
    assert message in refusal(lambda: scene.set_mesh(0, VERTICES, TRIANGLES, **arrays))


def test_arrays_of_any_strides_are_taken_alike() -> None:
    wide = np.zeros((4, 6), np.float32)
    wide[:, ::2] = VERTICES
    packed = np.zeros(4 * 13, np.uint8)
    unaligned: Any = np.ndarray((4, 3), np.float32, packed.data, 1, (13, 4))
    unaligned[:] = VERTICES
    for vertices in (wide[:, ::2], np.asfortranarray(VERTICES), unaligned):
        scene = regraft.Scene(threads=1)
        scene.add_instance(scene.add_mesh(vertices, np.asfortranarray(TRIANGLES)))
        assert hit_height(scene) == 0.0


def test_inputs_are_copied(scene: regraft.Scene) -> None:
    vertices, triangles = square(z=1.0)
    scene.set_mesh(0, vertices, triangles)
    vertices[:] = 99
    assert hit_height(scene) == 1.0


def test_empty_meshes_are_fine() -> None:
    scene = regraft.Scene(threads=1)
    scene.add_instance(scene.add_mesh(np.zeros((0, 3), np.float32), np.zeros((0, 3), np.uint32)))
    scene.add_instance(scene.add_mesh(VERTICES, np.zeros((0, 3), np.uint32)))
    assert hit_height(scene) == -np.inf


def test_set_vertices_wants_as_many(scene: regraft.Scene) -> None:
    message = refusal(lambda: scene.set_vertices(0, VERTICES[:3]))
    assert message == 'mesh 0 "Sign": 3 vertices, 4 wanted; set_mesh changes their number'
    scene.set_vertices(0, square(z=2.0)[0])
    assert hit_height(scene) == 2.0


def test_a_mesh_in_use_cannot_be_removed(scene: regraft.Scene) -> None:
    assert "cannot be removed: 1 instances use it" in refusal(lambda: scene.remove_mesh(0))
    scene.remove_instance(0)
    scene.remove_mesh(0)
    assert refusal(lambda: scene.set_vertices(0, VERTICES)) == "mesh 0 was removed"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s: s.remove_mesh(7), "mesh 7 does not exist; 1 were ever added"),
        (lambda s: s.set_vertices(7, VERTICES), "mesh 7 does not exist"),
        (lambda s: s.set_mesh(7, VERTICES, TRIANGLES), "mesh 7 does not exist"),
        (lambda s: s.add_instance(7), "mesh 7 does not exist"),
        (lambda s: s.add_instance(0, group=3), "group 3 does not exist"),
        (lambda s: s.add_group(3, name="Low"), 'group "Low": its parent, group 3, does not exist'),
        (lambda s: s.set_transform(7, np.eye(4)), "instance 7 does not exist"),
        (lambda s: s.set_visible(7, True), "instance 7 does not exist"),
        (lambda s: s.set_instance_materials(7, ()), "instance 7 does not exist"),
        (lambda s: s.remove_instance(7), "instance 7 does not exist"),
        (lambda s: s.remove_instances([0, 0]), 'instance 0 "Left" cannot be removed twice'),
        (lambda s: s.remove_mesh(-1), "mesh_id: -1 is outside [0, 4294967294]"),
        (lambda s: s.remove_mesh(2**80), f"mesh_id: {2**80} is outside"),
        (lambda s: s.remove_mesh("Sign"), "mesh_id: a whole number wanted, got str"),
        (lambda s: s.remove_mesh(0.0), "mesh_id: a whole number wanted, got float"),
        (lambda s: s.remove_instances("0"), "ids: an array of uint32 or a sequence of ints"),
        (lambda s: s.remove_instances(np.array([0])), "ids: uint32 wanted, got int64"),
        (lambda s: s.add_instance(0, object_index=-4), "object_index: -4 is outside"),
    ],
)
def test_wrong_ids_are_named(
    scene: regraft.Scene, call: Callable[[regraft.Scene], object], message: str
) -> None:
    before = scene.counts()
    assert message in refusal(lambda: call(scene))
    assert scene.counts() == before


def test_numpy_integers_are_ids(scene: regraft.Scene) -> None:
    scene.set_visible(np.uint32(0), False)
    assert hit_height(scene) == -np.inf


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        (np.eye(4, dtype=np.float32), "float64 wanted, got float32"),
        (np.eye(3), "shape (4, 4) wanted, got (3, 3)"),
        (np.full((4, 4), 0.5), "last row of the transform is (0.5"),
    ],
)
def test_wrong_transforms_are_named(scene: regraft.Scene, matrix: Any, message: str) -> None:
    assert message in refusal(lambda: scene.set_transform(0, matrix))
    assert message in refusal(lambda: scene.add_instance(0, matrix))
    assert scene.counts()["instances"] == 1


def test_transforms_are_object_to_world_with_column_vectors(scene: regraft.Scene) -> None:
    matrix = affine(np.random.default_rng(3))
    matrix[:3, 3] = 0, 0, 5
    scene.set_transform(0, matrix)
    scene.update()
    corners = np.c_[VERTICES, np.ones(4)] @ matrix.T
    assert np.allclose(scene.bounds(), [corners[:, :3].min(0), corners[:, :3].max(0)], atol=1e-5)


def test_instances_in_bulk_equal_instances_one_by_one(scene: regraft.Scene) -> None:
    rng = np.random.default_rng(5)
    transforms = np.stack([affine(rng) for _ in range(5)])
    groups = np.array([MISS, 0, 0, MISS, 0], np.uint32)
    scene.add_group()
    ids = scene.add_instances(
        np.zeros(5, np.uint32),
        transforms,
        groups=groups,
        materials=[(), (1,), (1, 2), (), (0,)],
        object_indices=np.arange(5, dtype=np.uint32),
    )
    assert ids.dtype == np.uint32
    assert ids.tolist() == [1, 2, 3, 4, 5]
    scene.remove_instance(0)
    single = regraft.Scene(threads=1)
    single.add_mesh(VERTICES, TRIANGLES)
    for transform in transforms:
        single.add_instance(0, transform)
    scene.update()
    single.update()
    assert np.array_equal(scene.bounds(), single.bounds())


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"transforms": np.zeros((1, 4, 4))}, "transforms: shape (2, 4, 4) wanted"),
        ({"mesh_ids": np.array([0, 9], np.uint32)}, "mesh 9 does not exist"),
        ({"groups": np.array([MISS, 4], np.uint32)}, "group 4 does not exist"),
        ({"groups": np.array([0, 0])}, "groups: uint32 wanted, got int64"),
        ({"materials": [(0,)]}, "materials: one tuple of ids for all, or a list of 2"),
        ({"materials": (-1,)}, "materials: -1 is outside"),
    ],
)
def test_bulk_instances_are_all_or_none(
    scene: regraft.Scene, arguments: dict[str, Any], message: str
) -> None:
    good = {"mesh_ids": np.zeros(2, np.uint32), "transforms": np.stack([np.eye(4)] * 2)}
    assert message in refusal(lambda: scene.add_instances(**{**good, **arguments}))
    assert scene.counts()["instances"] == 1


def test_bulk_transforms_are_all_or_none(scene: regraft.Scene) -> None:
    scene.add_instance(0)
    up = np.stack([moved(z=3), moved(z=4)])
    assert "instance 9 does not exist" in refusal(lambda: scene.set_transforms([0, 9], up))
    assert hit_height(scene) == 0.0
    scene.set_transforms(np.array([0, 1], np.uint32), up)
    assert hit_height(scene) == 4.0


def test_removed_instances_are_gone(scene: regraft.Scene) -> None:
    high = scene.add_instance(0, moved(z=3))
    assert hit_height(scene) == 3.0
    scene.remove_instances(np.array([high], np.uint32))
    assert hit_height(scene) == 0.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((np.zeros((2, 3), np.float32),), "base_color: shape (N, 4) wanted, got (2, 3)"),
        ((np.zeros((2, 4)),), "base_color: float32 wanted, got float64"),
        ((np.zeros((2, 4), np.float32), np.zeros(3, np.float32)), "metallic: shape (2,) wanted"),
        (
            (np.zeros((2, 4), np.float32), None, None, np.zeros((2, 4), np.float32)),
            "emission: shape (2, 3) wanted",
        ),
    ],
)
def test_wrong_materials_are_named(
    scene: regraft.Scene, arguments: tuple[Any, ...], message: str
) -> None:
    assert message in refusal(lambda: scene.set_materials(*arguments))


@pytest.mark.parametrize(
    ("color", "message"),
    [
        ((1, 2), "color: 3 numbers wanted, got 2"),
        ("red", "color: 3 numbers wanted, got str"),
        ((1, 2, "3"), "color: a number wanted, got str"),
        (5, "color: 3 numbers wanted, got int"),
    ],
)
def test_a_wrong_world_is_named(scene: regraft.Scene, color: Any, message: str) -> None:
    assert message in refusal(lambda: scene.set_world(color))


def test_lights_are_read_by_attribute(scene: regraft.Scene) -> None:
    scene.set_lights([regraft.Light("sun"), regraft.Light("area", size=(1, 2))])
    scene.set_lights(())
    assert "Light[0]: has no attribute kind; a regraft.Light wanted" in refusal(
        lambda: scene.set_lights([{"kind": "sun"}])  # type: ignore[list-item]
    )
    assert refusal(lambda: scene.set_lights(3)) == (  # type: ignore[arg-type]
        "lights: a sequence of regraft.Light wanted"
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"threads": -1}, "threads: -1 is outside [0, 1024]"),
        ({"threads": 5000}, "threads: 5000 is outside"),
        ({"threads": 1.5}, "threads: a whole number wanted, got float"),
        ({"isa": "mmx"}, 'isa: "mmx" is none of auto, scalar, sse, avx2, avx512'),
    ],
)
def test_wrong_scene_arguments_are_named(arguments: dict[str, Any], message: str) -> None:
    assert message in refusal(lambda: regraft.Scene(**arguments))
