"""A ray-tracing scene that stays alive between frames: modify, update, trace.

The NumPy door to the native library; docs/api.md is the contract. Nothing here imports bpy.
"""

from __future__ import annotations

from regraft._regraft import (
    Frame,
    FrameStatistics,
    HitBatch,
    PointBatch,
    Scene,
    UpdateStatistics,
    __version__,
)
from regraft.camera import Camera
from regraft.light import Light

__all__ = [
    "Camera",
    "Frame",
    "FrameStatistics",
    "HitBatch",
    "Light",
    "PointBatch",
    "Scene",
    "UpdateStatistics",
    "__version__",
]
