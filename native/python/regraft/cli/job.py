"""What a render was asked to do, as plain values that travel to another process."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

SHADINGS = ("clay", "occlusion", "direct", "reflection", "cost")
# Those that need no key frames of the shot, unlike "shot".
POLICIES = ("auto", "refit", "rebuild", "selective", "selective+rotate", "lm", "rtdeform")
STRUCTURES = ("auto", "bvh", "kdtree")
LAYOUTS = ("two-level", "flat")
PASSES = ("combined", "depth", "normal", "object_index", "cost")
SUFFIXES = {"png": ".png", "exr": ".exr", "jpeg": ".jpg"}


@dataclass(frozen=True)
class RenderJob:
    """Settings of one render. `width`, `height` in pixels; 0: as the file says."""

    source: str
    width: int = 0
    height: int = 0
    format: str = "png"
    shading: str = "direct"
    samples: int = 1
    policy: str = "auto"
    structure: str = "auto"
    layout: str = "two-level"
    threads: int = 0
    passes: tuple[str, ...] = ("combined",)
    engine: str = "REGRAFT"

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> RenderJob:
        """The job that `as_json` describes."""
        return cls(**{**values, "passes": tuple(values["passes"])})

    def as_json(self) -> dict[str, Any]:
        """Values that JSON can carry."""
        return asdict(self)


@dataclass(frozen=True)
class SceneInfo:
    """What the opened file says. `frames` ascending; `notes` are sentences for the user."""

    blender: str
    frames: tuple[int, ...]
    width: int
    height: int
    fps: float
    libraries: tuple[str, ...] = ()
    notes: tuple[str, ...] = field(default=())

    @classmethod
    def from_json(cls, values: Mapping[str, Any]) -> SceneInfo:
        """The info that `as_json` describes."""
        sequences = {k: tuple(values[k]) for k in ("frames", "libraries", "notes")}
        return cls(**{**values, **sequences})

    def as_json(self) -> dict[str, Any]:
        """Values that JSON can carry."""
        return asdict(self)


def fingerprint(job: RenderJob, info: SceneInfo, version: str) -> str:
    """Equal for two runs exactly when their frames may stand side by side.

    Covers every setting but the thread count, the versions of regraft and Blender, and the bytes
    of the file and of the libraries it links; not textures, caches or other files it refers to.
    """
    settings = {**job.as_json(), "width": info.width, "height": info.height}
    for unimportant in ("threads", "source"):
        del settings[unimportant]
    files = [_digest(Path(p)) for p in (job.source, *info.libraries) if Path(p).is_file()]
    text = json.dumps([settings, files, info.blender, version], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
