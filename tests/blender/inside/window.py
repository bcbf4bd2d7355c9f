"""A Blender with a window: runs checks that wait, one step after another, from a timer."""

from __future__ import annotations

import os
import sys
import time
import traceback
from collections.abc import Callable, Generator
from types import ModuleType
from typing import Any

import bpy
import numpy as np
from harness import part

PATIENCE = 60.0
Waiting = Generator[Callable[[], bool], None, None]


def run(names: dict[str, Any]) -> None:
    """Run every generator function `check_…`; each yields conditions to wait for. Ends Blender
    with exit code 0 or 1."""
    checks = [f for n, f in names.items() if n.startswith("check_") and callable(f)]
    bpy.app.timers.register(_Runner(checks), first_interval=1.0, persistent=True)


class _Runner:
    """One call a tick: goes on with the running check as soon as what it waits for is there."""

    __name__ = "window checks"

    def __init__(self, checks: list[Callable[[], Waiting]]) -> None:
        self.pending = list(checks)
        self.count = len(checks)
        self.name = "start"
        self.running: Waiting | None = None
        self.condition: Callable[[], bool] = lambda: True
        self.since = time.monotonic()

    def __call__(self) -> float:
        try:
            self.step()
        except Exception:  # noqa: BLE001 - whatever it is, it has to end Blender
            print(f"FAILED {self.name}\n{traceback.format_exc()}", flush=True)
            os._exit(1)
        return 0.05

    def step(self) -> None:
        if not self.condition():
            assert time.monotonic() - self.since < PATIENCE, "waited too long"
            return
        self.since = time.monotonic()
        if self.running is None:
            if not self.pending:
                print(f"{self.count} checks passed", flush=True)
                sys.stdout.flush()
                os._exit(0)
            check = self.pending.pop(0)
            self.name, self.running = check.__name__, check()
        try:
            self.condition = next(self.running)
        except StopIteration:
            self.running, self.condition = None, lambda: True


def area() -> bpy.types.Area:
    """The 3D viewport."""
    screen = bpy.context.window_manager.windows[0].screen
    return next(a for a in screen.areas if a.type == "VIEW_3D")


def region() -> bpy.types.Region:
    """The viewport's main region."""
    return next(r for r in area().regions if r.type == "WINDOW")


def space() -> bpy.types.SpaceView3D:
    """The viewport's settings."""
    return area().spaces.active


def here() -> Any:
    """Operators inside this run as if the mouse were over the viewport."""
    window = bpy.context.window_manager.windows[0]
    return bpy.context.temp_override(
        window=window, screen=window.screen, area=area(), region=region()
    )


def viewport() -> Any:
    """Our side of the viewport's engine that was made last; None before the first."""
    return _made[-1] if _made else None


def is_finished() -> bool:
    """True when the viewport has drawn all samples of what it shows now."""
    shown = viewport()
    if shown is None or shown._job is None or shown._job.is_running() or shown._is_stale:
        return False
    job = shown._job
    return not job._is_cancelled and job.picture is not None and shown._drawn is job.picture


def redrawn() -> Callable[[], bool]:
    """A condition: everything was drawn anew after now, and to its end."""
    area().tag_redraw()
    count = len(_draws)
    return lambda: len(_draws) > count and is_finished()


def picture() -> np.ndarray[Any, np.dtype[np.float32]]:
    """The finished picture, first row at the bottom."""
    pixels: np.ndarray[Any, np.dtype[np.float32]] = viewport()._drawn.pixels
    return pixels


def centre() -> np.ndarray[Any, np.dtype[np.float64]]:
    """Centre of what is seen on a transparent background, in pixels of the region."""
    rows, columns = np.nonzero(picture()[..., 3] > 0.5)
    assert len(rows), "nothing is seen"
    return np.array([columns.mean() + 0.5, rows.mean() + 0.5])


_made: list[Any] = []
_draws: list[float] = []


def watch(module: ModuleType) -> None:
    """Remember every viewport that is made and drawn from now on."""
    made, drawn = module.Viewport.__init__, module.Viewport.draw

    def make(self: Any, *arguments: Any) -> None:
        _made.append(self)
        made(self, *arguments)

    def draw(self: Any, *arguments: Any) -> None:
        drawn(self, *arguments)
        _draws.append(time.monotonic())

    module.Viewport.__init__, module.Viewport.draw = make, draw


watch(part("viewport"))
