"""A backend without Blender: grey pictures, invented costs, and faults on demand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from PIL import Image

from regraft.cli.job import RenderJob, SceneInfo

SIZE = (40, 30)
Fault = Callable[[Path], None]


@dataclass
class StandInBackend:
    """Renders with Pillow; `faults[frame]` is called with the file just written."""

    frames: tuple[int, ...] = (1, 2, 3)
    faults: dict[int, Fault] = field(default_factory=dict)
    triangles: int = 12
    place: str = "a test"
    rendered: list[int] = field(default_factory=list)
    closed: bool = False

    def probe(self) -> dict[str, Any]:
        return {"blender": "0.0", "python": "3.11", "formats": [".blend"]}

    def open(self, job: RenderJob) -> SceneInfo:
        return SceneInfo("0.0", self.frames, job.width or SIZE[0], job.height or SIZE[1], 24.0)

    def render(self, frame: int, path: Path) -> dict[str, Any]:
        self.rendered.append(frame)
        Image.new("RGB", SIZE, (frame % 256, 0, 0)).save(path)
        if frame in self.faults:
            self.faults[frame](path)
        return {
            "frame": frame,
            "write_ms": 1.0,
            "total_ms": 5.0,
            "triangles": self.triangles,
            "left_out": ["no deformation: no refit"],
        }

    def begin_recording(self, folder: Path) -> None:
        raise NotImplementedError

    def record_frame(self, frame: int) -> None:
        raise NotImplementedError

    def end_recording(self, is_complete: bool) -> None:
        raise NotImplementedError

    def plan(self, folder: Path) -> None:
        raise NotImplementedError

    def close(self) -> None:
        self.closed = True
