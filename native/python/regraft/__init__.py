"""A ray-tracing scene that stays alive between frames: modify, update, trace.

The NumPy door to the native library; docs/api.md is the contract. Nothing here imports bpy.
"""

from __future__ import annotations

from regraft import machine_costs
from regraft._regraft import (
    Frame,
    FrameStatistics,
    HitBatch,
    KdTree,
    NodeBatch,
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
    "KdTree",
    "Light",
    "NodeBatch",
    "PointBatch",
    "Scene",
    "UpdateStatistics",
    "__version__",
]

machine_costs.load()
