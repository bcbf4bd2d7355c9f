"""Frame lists: what is written is what is rendered."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from regraft.cli.frame_range import format_frames, parse_frames


@pytest.mark.parametrize(
    ("text", "frames"),
    [
        ("7", [7]),
        ("1-4", [1, 2, 3, 4]),
        ("1,5,9-11", [1, 5, 9, 10, 11]),
        (" 3 - 5 , 1", [1, 3, 4, 5]),
        ("1-3,2-4", [1, 2, 3, 4]),
        ("-2-1", [-2, -1, 0, 1]),
        ("-5--4", [-5, -4]),
    ],
)
def test_ranges_and_lists_are_read(text: str, frames: list[int]) -> None:
    assert parse_frames(text) == frames


@pytest.mark.parametrize("text", ["", "a", "1-", "1,,2", "1.5", "1-2-3", "9-1", "0-9999999999"])
def test_nonsense_is_refused(text: str) -> None:
    with pytest.raises(ValueError, match=r"frame|backwards"):
        parse_frames(text)


@given(st.sets(st.integers(-50, 50), min_size=1))
def test_what_is_written_is_read_back(frames: set[int]) -> None:
    assert parse_frames(format_frames(frames)) == sorted(frames)
