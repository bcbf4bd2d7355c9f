"""Checks shared by the value types: each returns the value in plain form or raises ValueError."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt


def floats(owner: str, name: str, value: Iterable[float], count: int) -> tuple[float, ...]:
    """`count` finite floats as a tuple; `owner.name` is what the message calls them."""
    try:
        numbers = tuple(float(x) for x in value)
    except TypeError as error:
        raise ValueError(f"{owner}.{name}: {count} numbers wanted, got {value!r}") from error
    if len(numbers) != count:
        raise ValueError(f"{owner}.{name}: {count} numbers wanted, got {len(numbers)}")
    if not all(math.isfinite(x) for x in numbers):
        raise ValueError(f"{owner}.{name}: not finite: {numbers}")
    return numbers


def unit_vector(owner: str, name: str, value: Iterable[float]) -> tuple[float, ...]:
    """Three finite floats scaled to length one; a zero vector is refused."""
    vector = floats(owner, name, value, 3)
    length = math.hypot(*vector)
    if length == 0.0:
        raise ValueError(f"{owner}.{name}: a direction cannot be the zero vector")
    return tuple(x / length for x in vector)


def number(owner: str, name: str, value: float, low: float, high: float = math.inf) -> float:
    """One float in the closed range [low, high]; NaN is refused."""
    result = float(value)
    if not low <= result <= high:
        raise ValueError(f"{owner}.{name}: {result} is outside [{low:g}, {high:g}]")
    return result


def transform(owner: str, name: str, value: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """A (4,4) float64 affine matrix, column vectors, read-only copy; finite, invertible."""
    matrix = np.array(value, dtype=np.float64)
    if matrix.shape != (4, 4):
        raise ValueError(f"{owner}.{name}: shape (4, 4) wanted, got {matrix.shape}")
    if not np.isfinite(matrix).all():
        raise ValueError(f"{owner}.{name}: not finite")
    # A float32 inverse leaves this row a rounding error away from what it means.
    if not np.allclose(matrix[3], (0.0, 0.0, 0.0, 1.0), atol=1e-5):
        raise ValueError(f"{owner}.{name}: last row must be (0, 0, 0, 1), got {matrix[3]}")
    matrix[3] = (0.0, 0.0, 0.0, 1.0)
    matrix.flags.writeable = False
    return matrix
