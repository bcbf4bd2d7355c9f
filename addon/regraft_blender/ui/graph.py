"""Small line graphs for panels, as pictures: Blender's layouts have none of their own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import bpy
import bpy.utils.previews
import numpy as np
import numpy.typing as npt

Colour = tuple[float, float, float, float]
Pixels = npt.NDArray[np.float32]

SIZE = (256, 256)
GROUND: Colour = (0.10, 0.10, 0.10, 1.0)
GUIDE: Colour = (0.22, 0.22, 0.22, 1.0)
MARK: Colour = (0.95, 0.55, 0.15, 1.0)
# Rows kept free above and below the lines, and the height of a mark.
MARGIN, TICK = 14, 8
THICKNESS = 3


@dataclass(frozen=True)
class Line:
    """One value a frame; those that are not finite are gaps."""

    values: Sequence[float]
    colour: Colour


def draw(lines: Sequence[Line], marks: Sequence[bool], highest: float) -> Pixels:
    """Pixels (height, width, 4), first row at the bottom: lines from 0 to `highest` over the
    frames, and a tick under each marked frame."""
    width, height = SIZE
    pixels = np.empty((height, width, 4), np.float32)
    pixels[:] = GROUND
    for share in (0.0, 0.5, 1.0):
        pixels[int(_row(share))] = GUIDE
    for frame, marked in enumerate(marks):
        if marked:
            pixels[:TICK, _column(frame, len(marks))] = MARK
    for line in lines:
        _draw_line(pixels, line, highest)
    return pixels


def _row(share: float) -> float:
    return MARGIN + share * (SIZE[1] - 1 - 2 * MARGIN)


def _column(frame: int, count: int) -> int:
    return round(frame / max(count - 1, 1) * (SIZE[0] - 1))


def _draw_line(pixels: Pixels, line: Line, highest: float) -> None:
    """Fills, column by column, what lies between a line's height there and one column on."""
    count = len(line.values)
    if count < 2 or highest <= 0.0:
        return
    at = np.linspace(0, count - 1, SIZE[0])
    rows = np.interp(at, np.arange(count), np.asarray(line.values, float) / highest)
    for column in range(SIZE[0] - 1):
        here, there = rows[column], rows[column + 1]
        if not np.isfinite(here + there):
            continue
        low, high = sorted((_row(min(here, 1.0)), _row(min(there, 1.0))))
        pixels[int(low) : int(high) + THICKNESS, column] = line.colour


class GraphIcon:
    """A picture that panels can show; made when it is first shown."""

    def __init__(self) -> None:
        self._previews: Any = None
        self._shown: object = None
        self._number = 0

    def icon(self, key: object, pixels: Pixels) -> int:
        """The icon's number. `key`: what the picture shows; a new picture is made when it changes,
        because Blender may keep showing what an icon held first."""
        if self._previews is None:
            self._previews = bpy.utils.previews.new()
        if key != self._shown or not len(self._previews):
            self._previews.clear()
            self._number += 1
            preview = self._previews.new(f"graph{self._number}")
            preview.image_size = (pixels.shape[1], pixels.shape[0])
            preview.image_pixels_float = pixels.ravel()
            self._shown = key
        (preview,) = self._previews.values()
        return int(preview.icon_id)

    def close(self) -> None:
        """Give the picture back to Blender."""
        if self._previews is not None:
            bpy.utils.previews.remove(self._previews)
        self._previews = self._shown = None
