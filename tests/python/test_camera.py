"""Camera: its constructors see what they promise, and wrong values are refused by name."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given
from hypothesis import strategies as st

from regraft import Camera

Floats = npt.NDArray[np.float64]


def on_picture(camera: Camera, points: Floats) -> Floats:
    """(N,2): where points fall, in window halves from the centre; inside is within ±1."""
    local = (points - camera.matrix[:3, 3]) @ camera.matrix[:3, :3]
    assert (local[:, 2] < 0).all(), "a point lies behind the eye"
    left, right, bottom, top = camera.window
    plane = local[:, :2] / -local[:, 2:]
    centre = np.array([left + right, bottom + top]) / 2
    half = np.array([right - left, top - bottom]) / 2
    return np.asarray((plane - centre) / half)


def corners(box: Floats) -> Floats:
    return np.array([[box[i >> a & 1][a] for a in range(3)] for i in range(8)])


@given(
    st.tuples(*[st.floats(-1e4, 1e4)] * 3),
    st.tuples(*[st.floats(1e-3, 1e4)] * 3),
    st.floats(0.2, 5.0),
    st.floats(5.0, 120.0),
)
def test_framing_sees_the_whole_box_and_little_else(
    low: tuple[float, ...], extent: tuple[float, ...], aspect: float, fov: float
) -> None:
    box = np.array([low, np.add(low, extent)])
    camera = Camera.framing(box, aspect, fov_degrees=fov)
    spots = np.abs(on_picture(camera, corners(box)))
    assert spots.max() <= 1.0
    assert spots.max() > 0.5, "the box does not fill the picture"


def test_framing_keeps_up_upright_and_looks_from_the_front() -> None:
    camera = Camera.framing([[-1, -1, -1], [1, 1, 1]], 1.0)
    assert camera.matrix[2, 1] > 0.5
    assert camera.matrix[0, 3] > 1
    assert camera.matrix[1, 3] < -1
    assert np.allclose(camera.matrix[:3, :3] @ camera.matrix[:3, :3].T, np.eye(3))


def test_framing_clips_nothing_of_the_box() -> None:
    box = np.array([[0, 0, 0], [1000.0, 1, 1]])
    camera = Camera.framing(box, 2.0)
    depth = -((corners(box) - camera.matrix[:3, 3]) @ camera.matrix[:3, 2])
    assert camera.clip_near < depth.min()
    assert depth.max() < camera.clip_far


def test_framing_a_single_point_stands_off_from_it() -> None:
    camera = Camera.framing([[5, 5, 5], [5, 5, 5]], 1.0)
    assert on_picture(camera, np.array([[5.0, 5, 5]])) == pytest.approx(np.zeros((1, 2)))


@pytest.mark.parametrize("aspect", [0.5, 1.0, 16 / 9])
def test_perspective_spans_the_angle_along_the_longer_side(aspect: float) -> None:
    left, right, bottom, top = Camera.perspective(np.eye(4), 90, aspect).window
    assert max(right - left, top - bottom) == pytest.approx(2.0)
    assert (right - left) / (top - bottom) == pytest.approx(aspect)


def test_shift_moves_the_window_by_longer_sides() -> None:
    left, right, bottom, top = Camera.perspective(np.eye(4), 90, 2.0, shift=(0.5, -0.25)).window
    assert (left, right) == pytest.approx((0.0, 2.0))
    assert (bottom, top) == pytest.approx((-1.0, 0.0))


@pytest.mark.parametrize("aspect", [0.5, 2.0])
def test_orthographic_is_as_wide_as_asked(aspect: float) -> None:
    left, right, bottom, top = Camera.orthographic(np.eye(4), 6.0, aspect).window
    assert right - left == pytest.approx(6.0)
    assert top - bottom == pytest.approx(6.0 / aspect)


def test_an_orthographic_camera_may_see_behind_itself() -> None:
    assert Camera.orthographic(np.eye(4), 1, 1, clip=(-10, 10)).clip_near == -10


def test_equal_cameras_are_equal_and_hash_alike() -> None:
    one, other = (Camera.perspective(np.eye(4), 50, 1.5) for _ in range(2))
    moved = np.eye(4)
    moved[0, 3] = 1
    assert one == other
    assert hash(one) == hash(other)
    assert one != Camera.perspective(moved, 50, 1.5)
    assert one != "camera"


def test_the_matrix_is_a_read_only_copy() -> None:
    mine = np.eye(4)
    camera = Camera("perspective", mine)
    mine[0, 3] = 7
    assert camera.matrix[0, 3] == 0
    with pytest.raises(ValueError, match="read-only"):
        camera.matrix[0, 3] = 7


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ({"kind": "pinhole"}, "kind"),
        ({"matrix": np.eye(3)}, "matrix"),
        ({"matrix": np.full((4, 4), math.nan)}, "matrix"),
        ({"matrix": np.diag([1.0, 1, 1, 2])}, "matrix"),
        ({"matrix": np.diag([1.0, 0, 1, 1])}, "matrix"),
        ({"window": (1, -1, -1, 1)}, "window"),
        ({"window": (-1, 1, -1)}, "window"),
        ({"window": (-1, math.inf, -1, 1)}, "window"),
        ({"clip_near": -0.1}, "clip_near"),
        ({"clip_near": math.nan}, "clip_near"),
        ({"clip_near": 2, "clip_far": 1}, "clip_far"),
        ({"latitude": (0,)}, "latitude"),
        ({"longitude": (0, math.nan)}, "longitude"),
        ({"fov": 0}, "fov"),
    ],
)
def test_a_wrong_value_is_refused_by_name(values: dict[str, object], named: str) -> None:
    fitting: dict[str, object] = {"kind": "perspective", "matrix": np.eye(4)}
    with pytest.raises(ValueError, match=rf"Camera\.{named}"):
        Camera(**{**fitting, **values})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "box", [[[0, 0, 0], [-1, 1, 1]], [[0, 0], [1, 1]], np.full((2, 3), np.inf)]
)
def test_a_box_that_is_none_cannot_be_framed(box: npt.ArrayLike) -> None:
    with pytest.raises(ValueError, match="bounds"):
        Camera.framing(box, 1.0)
