"""Images are read to their last byte before they count as finished."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from PIL import Image

from regraft.formats.images import DamagedImageError, read_rgb8, verify

SIZE = (33, 20)
KINDS = (".png", ".jpg", ".exr")


def write(path: Path) -> Path:
    random = np.random.default_rng(1)
    if path.suffix == ".exr":
        pixels = random.random((SIZE[1], SIZE[0], 4), np.float32)
        channels = {"Layer.Combined": pixels, "Layer.Depth.Z": pixels[..., 0].copy()}
        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        with OpenEXR.File(header, channels) as file:
            file.write(str(path))
        return path
    noise = random.integers(0, 255, (SIZE[1], SIZE[0], 3), np.uint8)
    Image.fromarray(noise).save(path)
    return path


@pytest.mark.parametrize("kind", KINDS)
def test_a_whole_image_passes(kind: str, tmp_path: Path) -> None:
    verify(write(tmp_path / f"a{kind}"), *SIZE)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("share", [0.0, 0.3, 0.9, 0.999])
def test_a_truncated_image_is_found_out(kind: str, share: float, tmp_path: Path) -> None:
    path = write(tmp_path / f"a{kind}")
    content = path.read_bytes()
    path.write_bytes(content[: min(int(len(content) * share), len(content) - 1)])
    with pytest.raises(DamagedImageError, match="a" + kind):
        verify(path, *SIZE)


@pytest.mark.parametrize("kind", KINDS)
def test_an_image_of_another_size_is_found_out(kind: str, tmp_path: Path) -> None:
    with pytest.raises(DamagedImageError, match="wanted"):
        verify(write(tmp_path / f"a{kind}"), SIZE[0] + 1, SIZE[1])


def test_png_pixels_reach_a_movie_unchanged(tmp_path: Path) -> None:
    path = write(tmp_path / "a.png")
    assert np.array_equal(read_rgb8(path), np.asarray(Image.open(path)))


def test_exr_pixels_pass_through_the_srgb_curve(tmp_path: Path) -> None:
    linear = np.zeros((1, 4, 4), np.float32)
    linear[0, :, :3] = np.array([0.0, 0.21404114, 1.0, 7.0])[:, None]
    with OpenEXR.File({"type": OpenEXR.scanlineimage}, {"RGBA": linear}) as file:
        file.write(str(tmp_path / "a.exr"))
    assert read_rgb8(tmp_path / "a.exr")[0, :, 1].tolist() == [0, 128, 255, 255]
