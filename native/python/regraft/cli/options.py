"""Values of options, parsed and checked, with messages that say what would be right."""

from __future__ import annotations

import argparse
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypeVar

from regraft.cli.frame_range import parse_frames
from regraft.cli.job import PASSES

LARGEST_SIDE = 65536
T = TypeVar("T")


def resolution(text: str) -> tuple[int, int]:
    """`1280x720` as (width, height) in pixels."""
    match = re.fullmatch(r"(\d+)[xX×](\d+)", text.strip())
    if not match:
        raise argparse.ArgumentTypeError(f"{text!r} is no size; write 1280x720")
    width, height = int(match[1]), int(match[2])
    if not (4 <= width <= LARGEST_SIDE and 4 <= height <= LARGEST_SIDE):
        raise argparse.ArgumentTypeError(
            f"{text}: width and height must be between 4 and {LARGEST_SIDE} pixels"
        )
    return width, height


def frames(text: str) -> list[int]:
    """`1-100` or `1,5,9-20` as frame numbers."""
    try:
        return parse_frames(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from error


def passes(text: str) -> tuple[str, ...]:
    """Comma-separated pass names, `combined` first and always there."""
    names = list_of(PASSES)(text)
    return tuple(name for name in PASSES if name in names or name == "combined")


def list_of(known: Sequence[str]) -> Callable[[str], tuple[str, ...]]:
    """A type for argparse: comma-separated names out of `known`."""

    def parse(text: str) -> tuple[str, ...]:
        names = tuple(name.strip() for name in text.split(","))
        for name in names:
            if name not in known:
                choice = ", ".join(known)
                raise argparse.ArgumentTypeError(f"{name!r} is not known; there are {choice}")
        return names

    return parse


def whole_number(low: int, high: int) -> Callable[[str], int]:
    """A type for argparse: an integer in [low, high]."""

    def parse(text: str) -> int:
        try:
            value = int(text)
        except ValueError:
            raise argparse.ArgumentTypeError(f"{text!r} is no whole number") from None
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(f"{value} is not between {low} and {high}")
        return value

    return parse


def list_of_numbers(low: int, high: int) -> Callable[[str], tuple[int, ...]]:
    """A type for argparse: comma-separated integers in [low, high]."""
    number = whole_number(low, high)
    return lambda text: tuple(number(part.strip()) for part in text.split(","))


def file_with_suffix(suffix: str) -> Callable[[str], Path]:
    """A type for argparse: a path that must end in `suffix`."""

    def parse(text: str) -> Path:
        path = Path(text)
        if path.suffix.lower() != suffix:
            raise argparse.ArgumentTypeError(f"{text!r} must end in {suffix}")
        return path

    return parse
