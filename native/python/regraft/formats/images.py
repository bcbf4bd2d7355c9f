"""Proof that an image file is whole: it decodes to the end and has the size asked for."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import numpy.typing as npt

from regraft.formats.quiet import hold_back_output

# What a complete file of the kind ends with.
_ENDINGS = {".png": b"IEND\xaeB\x60\x82", ".jpg": b"\xff\xd9"}


class DamagedImageError(ValueError):
    """The file is not a whole image of the size expected."""


def load_decoder(suffix: str) -> None:
    """Imports what `verify` will need, so that the first frame does not pay for it.

    Raises ImportError if it is not installed.
    """
    importlib.import_module("OpenEXR" if suffix == ".exr" else "PIL.Image")


def verify(path: Path, width: int, height: int) -> None:
    """Decodes the whole file; raises DamagedImageError naming it when anything is amiss."""
    try:
        with hold_back_output():
            found = _exr_size(path) if path.suffix == ".exr" else _pillow_size(path)
    except (OSError, SyntaxError, ValueError, RuntimeError) as error:
        raise DamagedImageError(f"{path.name} does not decode: {error}") from error
    if found != (width, height):
        raise DamagedImageError(f"{path.name} is {found}, wanted {(width, height)}")


def read_rgb8(path: Path) -> npt.NDArray[np.uint8]:
    """(H, W, 3) uint8 for a movie; OpenEXR's linear values pass through the sRGB curve."""
    if path.suffix == ".exr":
        return _srgb8(_exr_rgb(path))
    from PIL import Image

    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"))


def _pillow_size(path: Path) -> tuple[int, int]:
    from PIL import Image

    _check_ending(path)
    with Image.open(path) as image:
        image.load()
        return image.size


def _check_ending(path: Path) -> None:
    """A decoder may be content before the last bytes: a cut file must not pass."""
    ending = _ENDINGS[path.suffix]
    with path.open("rb") as file:
        file.seek(0, 2)
        file.seek(-min(len(ending), file.tell()), 2)
        if file.read() != ending:
            raise ValueError("the end is missing")


def _exr_size(path: Path) -> tuple[int, int]:
    import OpenEXR

    with OpenEXR.File(str(path)) as file:
        sizes = {c.pixels.shape[:2] for part in file.parts for c in part.channels.values()}
    if len(sizes) != 1:
        raise ValueError("pixels are missing")
    height, width = sizes.pop()
    return int(width), int(height)


def _exr_rgb(path: Path) -> npt.NDArray[np.float32]:
    """(H, W, 3) float32 linear: the first channel group that is a picture."""
    import OpenEXR

    with OpenEXR.File(str(path)) as file:
        channels = {n: c.pixels for part in file.parts for n, c in part.channels.items()}
    for name, pixels in channels.items():
        if name.rpartition(".")[2] in ("Combined", "RGBA", "RGB") and pixels.ndim == 3:
            return np.asarray(pixels[..., :3], np.float32)
    raise ValueError(f"{path.name} holds no picture, only {sorted(channels)}")


def _srgb8(linear: npt.NDArray[np.float32]) -> npt.NDArray[np.uint8]:
    """IEC 61966-2-1 transfer curve, values clamped to [0, 1]."""
    value = np.clip(np.nan_to_num(linear), 0.0, 1.0)
    curved = np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)
    return (curved * 255.0 + 0.5).astype(np.uint8)
