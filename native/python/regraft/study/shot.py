"""A shot as the library was told it: every edit of every frame, to be replayed on other scenes.

A shot is a folder with `shot.json` (the calls, in order) and `arrays.bin` (their arrays, one after
the other), which is mapped and not read: shots may be larger than memory.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from regraft import Camera, Light

INDEX, ARRAYS = "shot.json", "arrays.bin"
# Methods of regraft.Scene that change what it holds.
EDITS = frozenset(
    {
        "add_group",
        "add_instance",
        "add_instances",
        "add_mesh",
        "remove_instance",
        "remove_instances",
        "remove_mesh",
        "set_instance_materials",
        "set_lights",
        "set_materials",
        "set_mesh",
        "set_transform",
        "set_transforms",
        "set_vertices",
        "set_visible",
        "set_world",
    }
)
_ALIGNMENT = 64
Call = tuple[str, tuple[Any, ...], dict[str, Any]]


class ShotWriter:
    """Writes a shot into the folder `folder`, which exists. Close it, or use it in `with`."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._arrays = (folder / ARRAYS).open("wb")
        self._calls: list[Any] = []
        self._frames: list[dict[str, Any]] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        _error: BaseException | None,
        _trace: TracebackType | None,
    ) -> None:
        self.close(is_complete=kind is None)

    def add_call(self, name: str, args: tuple[Any, ...], kwargs: dict[str, Any]) -> None:
        """One edit of the frame that is not yet ended; arrays are copied."""
        self._calls.append([name, self._encode(args), self._encode(kwargs)])

    def end_frame(self, frame: int, camera: Camera) -> None:
        """What was added since the last frame's end belongs to `frame`, seen through `camera`."""
        seen = self._encode(camera)
        self._frames.append({"frame": frame, "camera": seen, "calls": self._calls})
        self._calls = []

    def close(self, *, is_complete: bool = True) -> None:
        """Without its index an interrupted recording is no shot."""
        self._arrays.close()
        if is_complete:
            text = json.dumps({"frames": self._frames}, separators=(",", ":"))
            (self._folder / INDEX).write_text(text, encoding="utf-8")

    def _encode(self, value: Any) -> Any:
        if isinstance(value, np.ndarray):
            return {"array": self._store(value)}
        if isinstance(value, Camera | Light):
            kind = type(value).__name__
            return {kind: {k: self._encode(v) for k, v in asdict(value).items()}}
        if isinstance(value, dict):
            return {"dict": {key: self._encode(v) for key, v in value.items()}}
        if isinstance(value, list):
            return {"list": [self._encode(v) for v in value]}
        if isinstance(value, tuple):
            return [self._encode(v) for v in value]
        return value.item() if isinstance(value, np.generic) else value

    def _store(self, array: np.ndarray[Any, Any]) -> list[Any]:
        array = np.ascontiguousarray(array)
        self._arrays.write(b"\0" * (-self._arrays.tell() % _ALIGNMENT))
        place = self._arrays.tell()
        self._arrays.write(array.tobytes())
        return [array.dtype.str, list(array.shape), place]


class Recorder:
    """Stands in for a `regraft.Scene` and writes down what is done to it.

    Every picture rendered ends a frame; frames are numbered by `next_frame`.
    """

    def __init__(self, scene: Any, writer: ShotWriter) -> None:
        self._scene, self._writer = scene, writer
        self.next_frame = 0

    def __getattr__(self, name: str) -> Any:
        method = getattr(self._scene, name)
        if name in EDITS:
            return self._recorded(name, method)
        return self._filmed(method) if name == "render" else method

    def _recorded(self, name: str, method: Callable[..., Any]) -> Callable[..., Any]:
        def call(*args: Any, **kwargs: Any) -> Any:
            result = method(*args, **kwargs)
            self._writer.add_call(name, args, kwargs)
            return result

        return call

    def _filmed(self, render: Callable[..., Any]) -> Callable[..., Any]:
        def call(camera: Camera, *args: Any, **kwargs: Any) -> Any:
            result = render(camera, *args, **kwargs)
            self._writer.end_frame(self.next_frame, camera)
            return result

        return call


class Shot:
    """A recorded shot. Replayed on a new scene from its first frame on, each edit returns the ids
    it returned when recorded: the library hands them out in order."""

    def __init__(self, folder: Path) -> None:
        path = folder / ARRAYS
        empty = path.stat().st_size == 0
        self._bytes = np.empty(0, np.uint8) if empty else np.memmap(path, np.uint8, "r")
        index = json.loads((folder / INDEX).read_text(encoding="utf-8"))
        self._frames: list[dict[str, Any]] = index["frames"]

    def __len__(self) -> int:
        return len(self._frames)

    @property
    def frames(self) -> tuple[int, ...]:
        """Numbers of the frames, in the order they were recorded."""
        return tuple(entry["frame"] for entry in self._frames)

    def camera(self, position: int) -> Camera:
        """The camera of the frame at `position`, 0 the first."""
        camera: Camera = self._decode(self._frames[position]["camera"])
        return camera

    def edits(self, position: int) -> list[Call]:
        """The calls that lead from the frame before to the one at `position`."""
        calls = self._frames[position]["calls"]
        return [(name, self._decode(args), self._decode(kwargs)) for name, args, kwargs in calls]

    def apply(self, position: int, scene: Any, *, leave_out: frozenset[str] = frozenset()) -> None:
        """Does to `scene` what was done in that frame, but for the methods in `leave_out`."""
        for name, args, kwargs in self.edits(position):
            if name not in leave_out:
                getattr(scene, name)(*args, **kwargs)

    def _decode(self, value: Any) -> Any:
        if isinstance(value, list):
            return tuple(self._decode(v) for v in value)
        if not isinstance(value, dict):
            return value
        ((kind, content),) = value.items()
        if kind == "array":
            return self._load(*content)
        if kind == "list":
            return [self._decode(v) for v in content]
        fields = {key: self._decode(v) for key, v in content.items()}
        return {"Camera": Camera, "Light": Light, "dict": dict}[kind](**fields)

    def _load(self, dtype: str, shape: list[int], place: int) -> np.ndarray[Any, Any]:
        count = int(np.prod(shape, dtype=np.int64))
        if count == 0:
            return np.empty(shape, dtype)
        return np.frombuffer(self._bytes, dtype, count, place).reshape(shape)
