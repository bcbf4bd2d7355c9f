"""The camera a frame is rendered through: a frozen value, read by attribute from C++."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from regraft import checks

KINDS = (
    "perspective",
    "orthographic",
    "equirectangular",
    "fisheye_equidistant",
    "fisheye_equisolid",
)
Pair = tuple[float, ...]

# From the front (-Y), the right and above: what people call a three-quarter view.
THREE_QUARTER_VIEW = (0.6, -1.0, 0.5)
# Room left round what is framed: the picture is this much wider.
FRAMING_MARGIN = 1.05


@dataclass(frozen=True, eq=False)
class Camera:
    """Where the eye stands, what it sees and how that falls on the picture.

    `matrix` (4,4) float64, camera to world, looking along -Z with Y up; its scale is ignored.
    `window` (left, right, bottom, top): perspective, on the plane one unit before the eye;
    orthographic, in world units; fisheye, relative, (-1, 1, -1, 1) inscribing the circle.
    `clip_near`, `clip_far`: metres along -Z, radial for the panoramic kinds.
    `latitude`, `longitude`: (lo, hi) radians, equirectangular. `fov`: radians, fisheye.

    Raises ValueError naming the attribute that is wrong.
    """

    kind: str
    matrix: npt.NDArray[np.float64]
    window: Pair = (-1.0, 1.0, -1.0, 1.0)
    clip_near: float = 0.01
    clip_far: float = 1e9
    latitude: Pair = (-math.pi / 2, math.pi / 2)
    longitude: Pair = (-math.pi, math.pi)
    fov: float = math.pi

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"Camera.kind: {self.kind!r} is none of {', '.join(KINDS)}")
        # Only a parallel projection has anything to show behind its own plane.
        nearest = -math.inf if self.kind == "orthographic" else 0.0
        plain: dict[str, object] = {
            "matrix": _rotation_and_place(self.matrix),
            "window": _window(self.window),
            "clip_near": checks.number("Camera", "clip_near", self.clip_near, nearest),
            "clip_far": checks.number("Camera", "clip_far", self.clip_far, self.clip_near),
            "latitude": checks.floats("Camera", "latitude", self.latitude, 2),
            "longitude": checks.floats("Camera", "longitude", self.longitude, 2),
            "fov": checks.number("Camera", "fov", self.fov, 1e-6, 100.0),
        }
        for name, value in plain.items():
            object.__setattr__(self, name, value)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Camera):
            return NotImplemented
        return self._key() == other._key()

    def __hash__(self) -> int:
        return hash(self._key())

    def _key(self) -> tuple[object, ...]:
        values = (getattr(self, field.name) for field in fields(self))
        return tuple(v.tobytes() if isinstance(v, np.ndarray) else v for v in values)

    @classmethod
    def perspective(
        cls,
        matrix: npt.ArrayLike,
        fov_degrees: float,
        aspect: float,
        *,
        shift: Pair = (0.0, 0.0),
        clip: Pair = (0.01, 1e9),
    ) -> Camera:
        """A pinhole camera. `fov_degrees` spans the longer side of the picture, `shift` is in
        units of that side, both as in Blender; `aspect` is width / height."""
        degrees = checks.number("Camera", "fov_degrees", fov_degrees, 1e-3, 179.9)
        window = _centred_window(2 * math.tan(math.radians(degrees) / 2), aspect, shift)
        return cls("perspective", np.asarray(matrix, np.float64), window, *_clip(clip))

    @classmethod
    def orthographic(
        cls,
        matrix: npt.ArrayLike,
        width: float,
        aspect: float,
        *,
        shift: Pair = (0.0, 0.0),
        clip: Pair = (0.01, 1e9),
    ) -> Camera:
        """A parallel projection `width` world units wide; `shift` in units of the longer side,
        `aspect` is width / height."""
        span = float(width) * max(1.0, 1.0 / _aspect(aspect))
        window = _centred_window(span, aspect, shift)
        return cls("orthographic", np.asarray(matrix, np.float64), window, *_clip(clip))

    @classmethod
    def framing(cls, bounds: npt.ArrayLike, aspect: float, *, fov_degrees: float = 40.0) -> Camera:
        """A perspective camera that sees the whole box from a three-quarter view, Z up.

        `bounds` (2,3): lowest and highest corner, world frame; a point is seen from one unit away.
        """
        box = np.asarray(bounds, np.float64)
        if box.shape != (2, 3) or not np.isfinite(box).all() or (box[0] > box[1]).any():
            raise ValueError(f"Camera.framing: bounds must be a finite (2, 3) box, got {box}")
        corners = np.array([[box[i >> a & 1, a] for a in range(3)] for i in range(8)])
        return frame_points(corners, aspect, fov_degrees=fov_degrees)


def frame_points(
    points: npt.NDArray[np.float64], aspect: float, *, fov_degrees: float = 40.0
) -> Camera:
    """The nearest perspective camera that sees all points (N,3), world frame, N ≥ 1, from a
    three-quarter view, Z up."""
    matrix = np.eye(4)
    matrix[:3, :3] = _looking_from(np.array(THREE_QUARTER_VIEW))
    centre = (points.min(axis=0) + points.max(axis=0)) / 2
    local = (points - centre) @ matrix[:3, :3]
    eye = _fit(local, aspect, math.radians(fov_degrees))
    matrix[:3, 3] = centre + matrix[:3, :3] @ eye
    nearest, farthest = eye[2] - local[:, 2].max(), eye[2] - local[:, 2].min()
    # Room for what moves towards the eye or away from it later in the shot.
    clip = (nearest / 100, farthest * 10)
    return Camera.perspective(matrix, fov_degrees, aspect, clip=clip)


def _rotation_and_place(value: npt.ArrayLike) -> npt.NDArray[np.float64]:
    matrix = checks.transform("Camera", "matrix", value)
    if not np.linalg.norm(matrix[:3, :3], axis=0).all():
        raise ValueError("Camera.matrix: an axis of length zero has no direction")
    return matrix


def _window(value: Pair) -> Pair:
    left, right, bottom, top = checks.floats("Camera", "window", value, 4)
    if not (left < right and bottom < top):
        raise ValueError(f"Camera.window: (left, right, bottom, top) is empty: {value}")
    return left, right, bottom, top


def _clip(value: Pair) -> tuple[float, float]:
    near, far = value
    return float(near), float(far)


def _aspect(value: float) -> float:
    return checks.number("Camera", "aspect", value, 1e-6, 1e6)


def _centred_window(span: float, aspect: float, shift: Pair) -> Pair:
    """Window whose longer side is `span`, moved by `shift` longer sides."""
    ratio = _aspect(aspect)
    half_x, half_y = span / 2 * min(1.0, ratio), span / 2 * min(1.0, 1.0 / ratio)
    x, y = (span * s for s in checks.floats("Camera", "shift", shift, 2))
    return x - half_x, x + half_x, y - half_y, y + half_y


def _looking_from(direction: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """(3,3) rotation, camera to world, of an eye that looks against `direction`, Z up."""
    back = direction / np.linalg.norm(direction)
    right = np.cross((0.0, 0.0, 1.0), back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back], axis=1)


def _fit(local: npt.NDArray[np.float64], aspect: float, fov: float) -> npt.NDArray[np.float64]:
    """Eye (3,) that just holds all points `local` (N,3), both in the camera's orientation.

    A point p is inside when |p.x - eye.x| <= tan_x * (eye.z - p.z), so the points' extreme values
    of p.x ± tan_x * p.z give eye.x and the least eye.z at once; same in y.
    """
    window = _centred_window(2 * math.tan(fov / 2), aspect, (0.0, 0.0))
    eye, depths = np.zeros(3), []
    for axis, half in ((0, window[1]), (1, window[3])):
        tangent = half / FRAMING_MARGIN
        high = float((local[:, axis] + tangent * local[:, 2]).max())
        low = float((local[:, axis] - tangent * local[:, 2]).min())
        eye[axis] = (high + low) / 2
        depths.append((high - low) / (2 * tangent))
    front, size = float(local[:, 2].max()), float(np.linalg.norm(np.ptp(local, axis=0)))
    distance = max(depths) - front
    # Points in one line of sight would be touched: stand off by their extent, or by one unit.
    eye[2] = front + (distance if distance > 1e-9 * size else size or 1.0)
    return eye
