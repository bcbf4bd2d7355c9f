"""Blender's own arrays seen as NumPy arrays: the only place that trusts a memory layout.

Element access through RNA costs 20–40 ms for the corners of 250,000 triangles, a copy of the array
behind it 0.1–0.5 ms. Every view is checked against RNA at its two ends and in the middle before it
is used; a layout that is not as expected raises LayoutError and the caller reads element-wise.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np

# Blender up to 3.5.
LOOP = np.dtype([("vertex", "<i4"), ("edge", "<i4")])
POLYGON = np.dtype(
    [("start", "<i4"), ("size", "<i4"), ("slot", "<i2"), ("flag", "u1"), ("unused", "u1")]
)
EDGE = np.dtype([("first", "<i4"), ("second", "<i4"), ("unused", "<i2"), ("flag", "<i2")])
LOOP_TRIANGLE = np.dtype([("corners", "<i4", (3,)), ("polygon", "<i4")])
SMOOTH_POLYGON = 1
SHARP_EDGE = 1 << 9

# Blender from 3.6 on.
CORNER_TRIANGLE = np.dtype([("corners", "<i4", (3,))])
FACE_START = np.dtype([("start", "<i4")])


class LayoutError(RuntimeError):
    """Blender's memory is not laid out as this version's code expects."""


def view(
    items: Any, layout: np.dtype[Any], agrees: Callable[[Any, Any], bool]
) -> np.ndarray[Any, Any]:
    """The array behind the RNA collection `items`, read-only, valid until Blender touches it.

    `agrees(item, row)` compares one RNA element with its row. Raises LayoutError.
    """
    count = len(items)
    if count == 0:
        return np.empty(0, layout)
    address = int(items[0].as_pointer())
    if count > 1 and int(items[1].as_pointer()) - address != layout.itemsize:
        raise LayoutError(f"{items.rna_type.identifier}: unexpected element size")
    memory = (ctypes.c_ubyte * (count * layout.itemsize)).from_address(address)
    rows = np.frombuffer(memoryview(memory), layout)
    rows.flags.writeable = False
    if not all(agrees(items[i], rows[i]) for i in (0, count // 2, count - 1)):
        raise LayoutError(f"{items.rna_type.identifier}: unexpected contents")
    return rows
