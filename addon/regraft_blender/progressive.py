"""A picture that gets better in another thread while Blender's interface goes on. No Blender here.

The thread never touches Blender's data: it is given values, and leaves pictures to be fetched.
"""

from __future__ import annotations

import threading
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

Region = tuple[int, int, int, int]

# One side of the first, coarse picture, as a share of the full one.
DRAFT_SCALE = 4
# Samples traced in one go; few, so that a picture appears often.
BATCH = 4


@dataclass(frozen=True)
class Request:
    """What to draw: equal requests give equal pictures of the same scene."""

    camera: Any
    width: int
    height: int
    region: Region
    shading: str
    samples: int
    transparent: bool
    policy: str
    structure: str
    layout: str

    def draft(self) -> Request:
        """The same picture with fewer pixels."""
        x0, y0, x1, y1 = (side // DRAFT_SCALE for side in self.region)
        return replace(
            self,
            width=max(1, self.width // DRAFT_SCALE),
            height=max(1, self.height // DRAFT_SCALE),
            region=(x0, y0, max(x0 + 1, x1), max(y0 + 1, y1)),
        )


@dataclass(frozen=True, eq=False)
class Picture:
    """Pixels (H,W,4) float32, linear, premultiplied, first row at the bottom; `samples` 0 for a
    draft."""

    pixels: npt.NDArray[np.float32]
    samples: int


class ProgressiveJob:
    """Brings the trees up to date, then draws one request: coarse, at one sample, at many."""

    def __init__(self, scene: Any, request: Request) -> None:
        self.request = request
        self.picture: Picture | None = None
        self.error: Exception | None = None
        self._scene = scene
        self._is_cancelled = False
        self._has_picture = threading.Event()
        self._thread = threading.Thread(target=self._run, name="regraft viewport")
        self._thread.start()

    def is_running(self) -> bool:
        """True until the picture is finished, given up, or has failed."""
        return self._thread.is_alive()

    def serves(self, request: Request) -> bool:
        """True if this job draws `request` and has not been stopped on the way."""
        return self.request == request and not self._is_cancelled

    def stop(self) -> None:
        """Give up and wait until the scene is no longer traced (at most some 50 ms, unless the
        trees are just being built)."""
        self._is_cancelled = True
        self._thread.join()

    def wait_for_picture(self, seconds: float) -> None:
        """Wait for the first picture, but no longer than this."""
        self._has_picture.wait(seconds)

    def is_cancelled(self) -> bool:
        """True if nobody wants the rest; also when Python is about to end."""
        return self._is_cancelled or not threading.main_thread().is_alive()

    def _run(self) -> None:
        try:
            request = self.request
            self._scene.update(request.policy, request.structure, request.layout)
            self._show(self._trace(request.draft(), 1, 0), 0)
            self._show(self._trace(request, 1, 0), 1)
            if request.samples > 1:
                self._refine(request)
        except Exception as error:  # noqa: BLE001 - handed to the thread that draws
            self.error = error
        finally:
            self._has_picture.set()

    def _refine(self, request: Request) -> None:
        """Average batches of jittered samples; the first, centred sample does not join in."""
        total, count = None, 0
        while count < request.samples and not self.is_cancelled():
            batch = min(BATCH, request.samples - count)
            pixels = self._trace(request, max(2, batch), 1 + count)
            if pixels is None:
                return
            weighted = pixels * np.float32(batch)
            total = weighted if total is None else total + weighted
            count += batch
            self._show(total / np.float32(count), count)

    def _trace(self, request: Request, samples: int, seed: int) -> npt.NDArray[np.float32] | None:
        if self.is_cancelled():
            return None
        frame = self._scene.render(
            request.camera,
            request.width,
            request.height,
            shading=request.shading,
            samples=samples,
            region=request.region,
            transparent=request.transparent,
            seed=seed,
            cancel=self.is_cancelled,
        )
        return None if frame.cancelled else frame.passes["combined"][::-1]

    def _show(self, pixels: npt.NDArray[np.float32] | None, samples: int) -> None:
        if pixels is not None:
            self.picture = Picture(np.ascontiguousarray(pixels), samples)
            self._has_picture.set()
