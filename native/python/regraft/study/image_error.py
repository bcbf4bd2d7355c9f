"""How far a picture is from another: RMSE and relMSE of linear radiance, mean FLIP of what is seen.

FLIP: Andersson and others, FLIP: A Difference Evaluator for Alternating Images, HPG 2020; computed
by NVIDIA's own flip-evaluator.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Picture = npt.NDArray[np.float32]  # (H, W, 3) linear radiance
HOW_TO_GET = "image errors need flip-evaluator, which is missing: pip install 'regraft[study]'"
# Keeps relMSE finite where the reference is black.
_DARK = 1e-2


def require() -> None:
    """Raises ImportError, with what to do, where flip-evaluator is missing."""
    try:
        import flip_evaluator  # noqa: F401
    except ImportError as error:
        raise ImportError(HOW_TO_GET) from error


def rmse(picture: Picture, reference: Picture) -> float:
    """Root of the mean square difference."""
    difference = picture.astype(np.float64) - reference
    return float(np.sqrt(np.mean(difference**2)))


def relative_mse(picture: Picture, reference: Picture) -> float:
    """Mean of the square difference over the reference's square."""
    true = reference.astype(np.float64)
    return float(np.mean((picture - true) ** 2 / (true**2 + _DARK)))


def flip(picture: Picture, reference: Picture) -> float:
    """Mean difference that a person sees, 0 to 1, on a screen that shows sRGB."""
    from flip_evaluator import evaluate

    _, mean, _ = evaluate(shown(reference), shown(picture), "LDR", applyMagma=False)
    return float(mean)


def shown(linear: Picture) -> Picture:
    """The picture as a screen shows it: clipped to [0, 1], IEC 61966-2-1 transfer curve."""
    value = np.clip(linear, 0.0, 1.0)
    curved = np.where(value <= 0.0031308, 12.92 * value, 1.055 * value ** (1 / 2.4) - 0.055)
    return np.ascontiguousarray(curved, np.float32)
