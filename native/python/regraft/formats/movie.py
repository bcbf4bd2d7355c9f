"""A movie out of frame files, through the ffmpeg that imageio-ffmpeg brings."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from regraft.formats import atomic
from regraft.formats.images import read_rgb8


def available() -> str:
    """Version of the ffmpeg at hand; ImportError or RuntimeError when there is none."""
    import imageio_ffmpeg

    return str(imageio_ffmpeg.get_ffmpeg_version())


def write_movie(target: Path, frames: Sequence[Path], fps: float) -> None:
    """H.264 in `target` (.mp4) at `fps`, one picture a file, put in place when complete.

    All frames have the size of the first; an odd width or height is scaled to an even one.
    Raises OSError when the movie cannot be written.
    """
    with atomic.replacing(target) as temporary:
        _encode(temporary, frames, fps)


def _encode(temporary: Path, frames: Sequence[Path], fps: float) -> None:
    import imageio_ffmpeg

    height, width = read_rgb8(frames[0]).shape[:2]
    writer = imageio_ffmpeg.write_frames(
        str(temporary), (width, height), fps=fps, macro_block_size=2, ffmpeg_log_level="error"
    )
    writer.send(None)
    try:
        for path in frames:
            writer.send(np.ascontiguousarray(read_rgb8(path)))
    finally:
        writer.close()
    if not temporary.is_file() or temporary.stat().st_size == 0:
        raise OSError(f"ffmpeg wrote nothing to {temporary}")
