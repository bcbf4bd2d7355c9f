"""A square cloth that falls over a turning ball: extended position-based dynamics on a grid of
particles.

Macklin, Müller, Chentanez, XPBD, MIG 2016, equation 18, with the many small steps of Macklin et
al., Small Steps in Physics Simulation, SCA 2019. Layers keep apart because particles do (spheres
nearly as wide as the grid's spacing). Metres, seconds, Z up; no randomness, so the same cloth falls
every time.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
GRAVITY = 9.81


@dataclass
class Settings:
    """What the cloth is and what it falls on."""

    cells: int = 54
    width: float = 3.1
    start_height: float = 1.36
    start_turn: float = 0.5  # radians about Z
    ball_radius: float = 0.6
    margin: float = 0.012  # metres between the cloth's particles and the ball or the floor
    steps_a_frame: int = 36
    frames_a_second: float = 24.0
    bend_compliance: float = 2e-4  # m²/J per unit mass
    shear_compliance: float = 2e-6
    layer_distance: float = 0.85  # of the grid's spacing
    friction: float = 0.55
    layer_friction: float = 0.25
    drag: float = 0.35  # 1/s

    @property
    def spacing(self) -> float:
        return self.width / self.cells

    @property
    def step(self) -> float:
        return 1 / (self.frames_a_second * self.steps_a_frame)


def simulate(
    settings: Settings, frames: int, ball_turn: Callable[[float], float]
) -> Iterator[Array]:
    """Yields the particles (rows, columns, 3) at each frame; `ball_turn` is the ball's angle
    (radians) at a frame.
    """
    place = _flat(settings)
    before = place.copy()
    links = list(_links(settings))
    pairs = np.empty((0, 2), np.int64)
    for frame in range(frames):
        yield place.copy()
        for step in range(settings.steps_a_frame):
            if step % 6 == 0:
                pairs = _near_pairs(place.reshape(-1, 3), settings)
            now = frame + step / settings.steps_a_frame
            turn = ball_turn(now + 1 / settings.steps_a_frame) - ball_turn(now)
            place, before = _advance(place, before, settings), place
            for link in links:
                link.solve(place)
            _part_layers(place.reshape(-1, 3), before.reshape(-1, 3), pairs, settings)
            _meet_ball(place, before, turn, settings)
            _meet_floor(place, before, settings)


def _flat(settings: Settings) -> Array:
    """The cloth at the start: level, turned, with a ripple below a millimetre so that it folds off
    the symmetry.
    """
    line = np.linspace(-settings.width / 2, settings.width / 2, settings.cells + 1)
    x, y = np.meshgrid(line, line)
    c, s = np.cos(settings.start_turn), np.sin(settings.start_turn)
    ripple = 8e-4 * (np.sin(5.1 * x + 1.3 * y) + np.sin(3.7 * y - 2.2 * x + 1))
    return np.stack(
        [c * x - s * y + 0.03, s * x + c * y - 0.02, settings.start_height + ripple], axis=-1
    )


def _advance(place: Array, before: Array, settings: Settings) -> Array:
    """Verlet prediction under gravity and drag."""
    kept = 1 - settings.drag * settings.step
    ahead = place + (place - before) * kept
    ahead[..., 2] -= GRAVITY * settings.step**2
    return ahead


@dataclass
class _Link:
    """A batch of springs no two of which share a particle: the grid against itself, shifted."""

    first: tuple[slice, slice]
    second: tuple[slice, slice]
    length: float
    softness: float  # compliance over the squared step

    def solve(self, place: Array) -> None:
        a, b = place[self.first], place[self.second]
        apart = b - a
        distance = np.sqrt((apart * apart).sum(axis=-1, keepdims=True))
        pull = apart * ((distance - self.length) / (distance * (2 + self.softness)))
        a += pull
        b -= pull


def _links(settings: Settings) -> Iterator[_Link]:
    """Threads both ways, diagonals, and bending springs over two cells, each split into independent
    batches.
    """
    h, soft = settings.spacing, 1 / settings.step**2
    for rows, columns, compliance in (
        (0, 1, 0.0),
        (1, 0, 0.0),
        (1, 1, settings.shear_compliance),
        (1, -1, settings.shear_compliance),
        (0, 2, settings.bend_compliance),
        (2, 0, settings.bend_compliance),
    ):
        length = h * float(np.hypot(rows, columns))
        for first, second in _batches(rows, columns, settings.cells + 1):
            yield _Link(first, second, length, compliance * soft)


def _batches(
    rows: int, columns: int, size: int
) -> Iterator[tuple[tuple[slice, slice], tuple[slice, slice]]]:
    """Pairs of grid slices `rows` and `columns` apart that together hold every such pair once.

    Links of one batch start a multiple of twice their reach apart, so none of them touch.
    """
    reach = rows or columns
    side = columns if rows else 0
    across = slice(max(-side, 0), size - max(side, 0)), slice(max(side, 0), size + min(side, 0))
    for start in range(2 * reach):
        along = slice(start, size - reach, 2 * reach), slice(start + reach, size, 2 * reach)
        if rows:
            yield (along[0], across[0]), (along[1], across[1])
        else:
            yield (across[0], along[0]), (across[1], along[1])


def _near_pairs(points: Array, settings: Settings) -> NDArray[np.int64]:
    """Pairs (P, 2) of particles that may touch within the next steps and are no grid neighbours."""
    reach = 1.6 * settings.layer_distance * settings.spacing
    single = (points - points.mean(axis=0)).astype(np.float32)
    squares = (single * single).sum(axis=1)
    gaps = squares[:, None] + squares - 2 * (single @ single.T)
    first, second = np.nonzero(gaps < reach * reach)
    size = settings.cells + 1
    rows = np.abs(first // size - second // size)
    columns = np.abs(first % size - second % size)
    chosen = (first < second) & (np.maximum(rows, columns) > 1)
    return np.stack([first[chosen], second[chosen]], axis=1)


def _part_layers(
    points: Array, before: Array, pairs: NDArray[np.int64], settings: Settings
) -> None:
    """Pushes particles of different layers apart and brakes their sliding; all pairs at once,
    averaged.
    """
    wanted = settings.layer_distance * settings.spacing
    apart = points[pairs[:, 1]] - points[pairs[:, 0]]
    distance = np.sqrt((apart * apart).sum(axis=1))
    near = distance < wanted
    pairs, apart, distance = pairs[near], apart[near], distance[near, None]
    normal = apart / np.maximum(distance, 1e-9)
    motion = (points - before)[pairs[:, 1]] - (points - before)[pairs[:, 0]]
    sliding = motion - normal * (motion * normal).sum(axis=1, keepdims=True)
    push = normal * (wanted - distance) / 2 - sliding * (settings.layer_friction / 2)
    count = np.bincount(pairs.ravel(), minlength=len(points))
    weight = 1 / np.maximum(count, 1)
    for axis in range(3):
        both = np.concatenate([-push[:, axis], push[:, axis]])
        total = np.bincount(pairs.T.ravel(), weights=both, minlength=len(points))
        points[:, axis] += total * weight * 1.2


def _meet_ball(place: Array, before: Array, turn: float, settings: Settings) -> None:
    """Keeps particles outside the ball, which stands on the floor and turned by `turn` in this
    step.
    """
    centre = np.array([0, 0, settings.ball_radius])
    away = place - centre
    distance = np.sqrt((away * away).sum(axis=-1))
    inside = distance < settings.ball_radius + settings.margin
    away, distance = away[inside], distance[inside, None]
    normal = away / distance
    depth = settings.ball_radius + settings.margin - distance
    surface = turn * np.stack([-away[:, 1], away[:, 0], 0 * away[:, 0]], axis=1)
    motion = place[inside] - before[inside] - surface
    place[inside] += normal * depth - _friction(motion, normal, depth, settings.friction)


def _meet_floor(place: Array, before: Array, settings: Settings) -> None:
    below = place[..., 2] < settings.margin
    depth = settings.margin - place[below][:, 2:]
    normal = np.array([[0.0, 0.0, 1.0]])
    motion = place[below] - before[below]
    place[below] += normal * depth - _friction(motion, normal, depth, settings.friction)


def _friction(motion: Array, normal: Array, depth: Array, coefficient: float) -> Array:
    """The part of a sliding motion (N, 3) that dry friction takes away, at most coefficient ·
    depth.
    """
    sliding = motion - normal * (motion * normal).sum(axis=1, keepdims=True)
    length = np.sqrt((sliding * sliding).sum(axis=1, keepdims=True))
    taken: Array = sliding * np.minimum(1, coefficient * depth / np.maximum(length, 1e-12))
    return taken
