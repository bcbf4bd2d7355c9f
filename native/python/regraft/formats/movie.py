"""A movie out of frame files, through the ffmpeg that imageio-ffmpeg brings."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from regraft.formats import atomic
from regraft.formats.images import read_rgb8


def available() -> str:
    """Version of the ffmpeg at hand; ImportError or RuntimeError when there is none."""
    import imageio_ffmpeg

    return str(imageio_ffmpeg.get_ffmpeg_version())


def write_movie(target: Path, frames: Sequence[Path], fps: float) -> None:
    """H.264 in `target` (.mp4) at `fps`, one picture a file, put in place when complete.

    All frames have the size of the first; to an odd width or height its last column or row is
    added once more, because the codec knows only even ones.
    Raises OSError when the movie cannot be written.
    """
    with atomic.replacing(target) as temporary:
        _encode(temporary, frames, fps)


def _encode(temporary: Path, frames: Sequence[Path], fps: float) -> None:
    import imageio_ffmpeg

    height, width = _even(read_rgb8(frames[0])).shape[:2]
    writer = imageio_ffmpeg.write_frames(
        str(temporary), (width, height), fps=fps, macro_block_size=1, ffmpeg_log_level="error"
    )
    writer.send(None)
    try:
        for path in frames:
            writer.send(_even(read_rgb8(path)))
    finally:
        writer.close()
    if not temporary.is_file() or temporary.stat().st_size == 0:
        raise OSError(f"ffmpeg wrote nothing to {temporary}")


def _even(frame: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
    """(H, W, 3) with even H and W."""
    height, width = frame.shape[:2]
    return np.pad(frame, ((0, height % 2), (0, width % 2), (0, 0)), mode="edge")
