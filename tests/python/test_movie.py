"""A movie holds every frame, at the right size, or is not there."""

from __future__ import annotations

import subprocess
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from regraft.formats.movie import write_movie


def make_frames(folder: Path, count: int, size: tuple[int, int]) -> list[Path]:
    paths = [folder / f"f_{i}.png" for i in range(count)]
    for i, path in enumerate(paths):
        Image.new("RGB", size, (0, 25 * i, 0)).save(path)
    return paths


def read_greens(path: Path, size: tuple[int, int]) -> list[int]:
    """The mean green of each frame, which must have this size."""
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-i", str(path), "-f", "rawvideo"]
    command += ["-pix_fmt", "rgb24", "-"]
    done = subprocess.run(command, capture_output=True, check=True)
    assert f", {size[0]}x{size[1]}" in done.stderr.decode()
    frames = np.frombuffer(done.stdout, np.uint8).reshape(-1, size[0] * size[1], 3)
    return [int(frame[:, 1].mean()) for frame in frames]


def test_a_movie_holds_every_frame_in_order(tmp_path: Path) -> None:
    movie = tmp_path / "m.mp4"
    write_movie(movie, make_frames(tmp_path, 5, (64, 48)), 25.0)
    assert read_greens(movie, (64, 48)) == pytest.approx([0, 25, 50, 75, 100], abs=4)


def test_odd_sizes_become_even(tmp_path: Path) -> None:
    movie = tmp_path / "m.mp4"
    write_movie(movie, make_frames(tmp_path, 2, (65, 49)), 24.0)
    assert len(read_greens(movie, (66, 50))) == 2


def test_a_movie_that_fails_leaves_nothing(tmp_path: Path) -> None:
    frames = make_frames(tmp_path, 2, (64, 48))
    frames[1].write_bytes(b"no picture")
    with pytest.raises(OSError, match=r"f_1\.png"):
        write_movie(tmp_path / "m.mp4", frames, 24.0)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["f_0.png", "f_1.png"]
