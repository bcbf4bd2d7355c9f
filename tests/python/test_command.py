"""The command line: what it accepts, what it refuses, and the exit codes."""

from __future__ import annotations

from pathlib import Path

import pytest

from regraft.cli import main
from regraft.cli.command import build_parser


def exit_code(*words: str) -> int:
    """Exit code as a shell would see it."""
    try:
        return main(words)
    except SystemExit as end:
        return int(str(end.code))


@pytest.fixture
def source(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "shot.blend").write_text("not really a scene")
    return "shot.blend"


@pytest.mark.parametrize(
    "words",
    [
        (),
        ("render",),
        ("bench",),
        ("bench", "sync"),
        ("bench", "update"),
        ("study",),
        ("study", "update"),
        ("study", "image"),
        ("study", "lazy"),
        ("study", "prediction"),
        ("study", "stability"),
        ("study", "compare"),
        ("doctor",),
    ],
)
def test_help_is_everywhere(words: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code(*words, "-h") == 0
    assert "usage: regraft" in capsys.readouterr().out


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("--version") == 0
    assert capsys.readouterr().out.startswith("regraft ")


@pytest.mark.parametrize(
    ("words", "told"),
    [
        ((), "required"),
        (("paint",), "invalid choice"),
        (("render",), "FILE"),
        (("render", "a.blend", "--frames", "9-1"), "backwards"),
        (("render", "a.blend", "--resolution", "0x0"), "between 4 and"),
        (("render", "a.blend", "--resolution", "big"), "write 1280x720"),
        (("render", "a.blend", "--samples", "0"), "not between 1"),
        (("render", "a.blend", "--samples", "two"), "no whole number"),
        (("render", "a.blend", "--threads", "-1"), "not between 0"),
        (("render", "a.blend", "--shading", "toon"), "invalid choice: 'toon'"),
        (("render", "a.blend", "--policy", "hope"), "invalid choice: 'hope'"),
        (("render", "a.blend", "--passes", "combined,mist"), "'mist' is not known"),
        (("render", "a.blend", "--movie", "m.avi"), "must end in .mp4"),
        (("render", "a.blend", "--passes", "depth"), "needs --format exr"),
        (("study", "update"), "FILE"),
        (("study", "update", "a.blend", "--repeats", "0"), "not between 1"),
        (("bench", "update", "--policies", "refit,hope"), "'hope' is not known"),
    ],
)
def test_wrong_usage_is_explained(
    words: tuple[str, ...], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_code(*words) == 2
    assert told in capsys.readouterr().err


def test_options_have_their_defaults() -> None:
    args = build_parser().parse_args(["render", "a.blend"])
    assert (args.shading, args.samples, args.policy) == ("direct", 1, "auto")
    assert (args.structure, args.layout, args.threads) == ("auto", "two-level", 0)
    assert (args.format, args.passes, args.frames) == ("png", ("combined",), None)


def test_combined_is_always_among_the_passes() -> None:
    args = build_parser().parse_args(["render", "a.blend", "--passes", "cost,depth"])
    assert args.passes == ("combined", "depth", "cost")


@pytest.mark.parametrize(
    ("name", "told"),
    [("none.blend", "cannot read none.blend"), ("shot.docx", "the ending is none of")],
)
def test_a_file_that_cannot_be_read_is_bad_input(
    name: str, told: str, source: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert exit_code("render", name) == 3
    assert told in capfd.readouterr().err


def test_an_empty_file_is_bad_input(source: str, capfd: pytest.CaptureFixture[str]) -> None:
    Path("empty.glb").write_text("")
    assert exit_code("render", "empty.glb") == 3
    assert "empty.glb is empty" in capfd.readouterr().err


def test_an_output_folder_in_the_way_of_a_file_is_refused(
    source: str, capfd: pytest.CaptureFixture[str]
) -> None:
    Path("frames").write_text("")
    assert exit_code("render", source, "--output", "frames") == 4
    assert "cannot write frames" in capfd.readouterr().err


def test_without_any_blender_the_command_says_what_to_install(
    source: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("regraft.cli.backend.can_import_bpy", lambda: False)
    monkeypatch.setenv("PATH", "")
    assert exit_code("render", source) == 3
    assert "pip install 'regraft[blender]'" in capfd.readouterr().err


def test_a_named_blender_that_is_none_is_refused(
    source: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("REGRAFT_BLENDER", "/no/such/blender")
    assert exit_code("render", source) == 3
    assert "REGRAFT_BLENDER names /no/such/blender" in capfd.readouterr().err


def test_a_benchmark_without_its_file_is_bad_input(
    source: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert exit_code("bench", "sync", "none.blend") == 3
    assert exit_code("bench", "update", "none.blend") == 3
    assert "none.blend" in capfd.readouterr().err
