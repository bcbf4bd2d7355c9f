"""`regraft render` as a user runs it, in every Blender there is."""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
import OpenEXR
import pytest
from PIL import Image

from blenders import ROOT, Blender, available
from regraft.formats.images import verify

STATISTICS = (
    "frame evaluate_ms extract_ms update_ms trace_ms shade_ms write_ms total_ms "
    "policy structure layout "
    "triangles instances moved_instances deformed_meshes deformed_triangles "
    "nodes nodes_refitted nodes_rebuilt pairs_considered pairs_restructured "
    "late_updates late_update_ms "
    "rays_primary rays_shadow rays_secondary nodes_visited triangle_tests "
    "culling_efficiency observed_cost cost_ratio kdtree_nodes kdtree_built_fraction "
    "kdtree_unbuilt_nodes kdtree_large_leaves memory_bytes left_out warnings"
)


@dataclass(frozen=True)
class Command:
    """The command with one of the Blenders behind it, and the scenes made by that Blender."""

    words: list[str]
    environment: dict[str, str]
    scenes: Path
    version: str

    def start(self, *words: object, **options: object) -> subprocess.Popen[str]:
        command = [*self.words, *map(str, words)]
        return subprocess.Popen(  # type: ignore[call-overload, no-any-return]
            command,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            **options,
        )

    def render(self, *words: object, code: int = 0, **options: object) -> str:
        """Everything that `regraft render` said; its exit code must be `code`."""
        return self.run("render", *words, code=code, **options)

    def run(self, *words: object, code: int = 0, **options: object) -> str:
        """Everything the command said; its exit code must be `code`."""
        process = self.start(*words, **options)
        said, _ = process.communicate(timeout=120)
        assert process.returncode == code, said
        return said


@pytest.fixture(scope="session")
def command(blender: Blender, tmp_path_factory: pytest.TempPathFactory) -> Command:
    scenes = tmp_path_factory.mktemp("scenes")
    blender.run(ROOT / "tests" / "data" / "make_command_scenes.py", scenes)
    return command_in(blender.version, str(blender.executable), scenes)


def command_in(version: str, executable: str, scenes: Path) -> Command:
    environment = dict(os.environ)
    python = executable
    if version == "3.4":  # a program: any Python that has regraft can drive it
        python, environment["REGRAFT_BLENDER"] = sys.executable, executable
    return Command([python, "-m", "regraft"], environment, scenes, version)


def pixels(path: Path) -> npt.NDArray[np.int16]:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB")).astype(np.int16)


def test_frames_statistics_and_movie_are_there(command: Command, tmp_path: Path) -> None:
    said = command.render(
        command.scenes / "moving.blend",
        *("--output", tmp_path / "f", "--frames", "1,3-4"),
        *("--statistics", tmp_path / "s.jsonl", "--movie", tmp_path / "m.mp4"),
    )
    frames = [tmp_path / "f" / f"moving_{i:04d}.png" for i in (1, 3, 4)]
    for frame in frames:
        verify(frame, 160, 90)
    changed = np.abs(pixels(frames[0]) - pixels(frames[2])).max(axis=2)
    assert changed.max() > 20, "the cube does not move"
    rows = [json.loads(line) for line in (tmp_path / "s.jsonl").read_text().splitlines()]
    assert [row["frame"] for row in rows] == [1, 3, 4]
    assert all(" ".join(row) == STATISTICS for row in rows)
    assert all(0 < row["evaluate_ms"] < row["total_ms"] for row in rows)
    assert all(0 < row["write_ms"] < row["total_ms"] for row in rows)
    assert [row["triangles"] for row in rows] == [24, 24, 24]
    assert [row["moved_instances"] for row in rows[1:]] == [1, 1]
    assert (tmp_path / "m.mp4").stat().st_size > 0
    assert "median ms a frame" in said


def test_the_policy_that_plans_is_given_key_frames(command: Command, tmp_path: Path) -> None:
    said = command.render(
        command.scenes / "moving.blend",
        *("--output", tmp_path / "f", "--policy", "shot", "--statistics", tmp_path / "s.jsonl"),
    )
    assert [f"key frame {i} evaluated" in said for i in range(1, 8)] == [True] * 6 + [False]
    frames = [tmp_path / "f" / f"moving_{i:04d}.png" for i in (1, 6)]
    for frame in frames:
        verify(frame, 160, 90)
    assert np.abs(pixels(frames[0]) - pixels(frames[1])).max() > 20, "the cube does not move"
    rows = [json.loads(line) for line in (tmp_path / "s.jsonl").read_text().splitlines()]
    assert [row["policy"] for row in rows] == ["shot"] * 6
    assert [row["nodes_rebuilt"] > 0 for row in rows] == [True] + [False] * 5


def test_exr_files_hold_the_passes(command: Command, tmp_path: Path) -> None:
    passes = ("combined", "depth", "normal", "object_index", "cost")
    command.render(
        command.scenes / "moving.blend",
        *("--output", tmp_path, "--frames", "3", "--format", "exr", "--passes", ",".join(passes)),
    )
    with OpenEXR.File(str(tmp_path / "moving_0003.exr")) as file:
        channels = {n: c.pixels for part in file.parts for n, c in part.channels.items()}
    named = " ".join(sorted(channels))
    for word in ("Combined", "Depth.Z", "Normal.X", "Index", "Cost.X"):
        assert word in named
    (depth,) = (pixels for name, pixels in channels.items() if "Depth" in name)
    assert depth[45, 80] == pytest.approx(15.0, abs=0.1), "the still cube is 16 m away, less 1"


def test_a_file_without_camera_is_framed_whole(command: Command, tmp_path: Path) -> None:
    said = command.render(command.scenes / "no_camera.blend", "--output", tmp_path, "--frames", "1")
    assert "no camera in the file: framing everything" in said
    picture = pixels(tmp_path / "no_camera_0001.png")
    seen = np.abs(picture - picture[0, 0]).max(axis=2) > 8
    assert seen.mean() > 0.1, "the head is small or not there"
    border = np.concatenate([seen[0], seen[-1], seen[:, 0], seen[:, -1]])
    assert not border.any(), "the head is cut"


def test_a_camera_that_is_not_active_is_taken(command: Command, tmp_path: Path) -> None:
    scene = command.scenes / "idle_camera.blend"
    said = command.render(scene, "--output", tmp_path, "--frames", "1")
    assert "no camera is active in the file: taking 'camera'" in said
    picture = pixels(tmp_path / "idle_camera_0001.png")
    assert np.abs(picture[45, 80] - picture[0, 0]).max() > 8, "the cube is not in the middle"


def test_bad_files_are_named(command: Command, tmp_path: Path) -> None:
    whole = (command.scenes / "moving.blend").read_bytes()
    (tmp_path / "cut.blend").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "text.glb").write_text("no scene at all")
    nothing = command.scenes / "no_geometry.blend"
    assert "holds no geometry" in command.render(nothing, "--output", tmp_path / "a", code=3)
    for name in ("cut.blend", "text.glb"):
        assert name in command.render(tmp_path / name, "--output", tmp_path / "b", code=3)
    assert list((tmp_path / "a").iterdir()) == []


def test_a_killed_run_leaves_whole_frames_and_is_resumed(command: Command, tmp_path: Path) -> None:
    words = (command.scenes / "moving.blend", "--output", tmp_path)
    big = ("--resolution", "960x540", "--frames", "1-6")
    process = command.start("render", *words, *big)
    deadline = time.monotonic() + 60
    while not (tmp_path / "moving_0002.png").exists() and time.monotonic() < deadline:
        time.sleep(0.005)
    process.kill()
    process.communicate()
    finished = sorted(tmp_path.glob("moving_*.png"))
    assert len(finished) >= 2
    for frame in finished:
        verify(frame, 960, 540)
    before = {path: path.stat().st_mtime_ns for path in finished[:1]}
    said = command.render(*words, *big, "--resume")
    assert "finished frames stay" in said
    assert {path: path.stat().st_mtime_ns for path in finished[:1]} == before
    assert len(list(tmp_path.glob("moving_*.png"))) == 6


def test_a_full_disk_leaves_no_truncated_frame(command: Command, tmp_path: Path) -> None:
    def allow_a_kilobyte_a_file() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))

    said = command.render(
        command.scenes / "moving.blend",
        *("--output", tmp_path, "--frames", "1", "--resolution", "960x540"),
        code=4,
        preexec_fn=allow_a_kilobyte_a_file,
    )
    assert f"cannot write {tmp_path / 'moving_0001.png'}" in said
    assert [p.name for p in tmp_path.iterdir() if "moving" in p.name] == []


def test_a_simulation_looks_alike_whole_and_in_part(command: Command, tmp_path: Path) -> None:
    scene = command.scenes / "simulated.blend"
    command.render(scene, "--output", tmp_path / "whole")
    said = command.render(scene, "--output", tmp_path / "part", "--frames", "12")
    assert "simulations are not baked" in said
    first, last = (pixels(tmp_path / "whole" / f"simulated_00{i}.png") for i in ("01", "12"))
    assert np.abs(first - last).max() > 20, "the cloth does not fall"
    assert np.array_equal(last, pixels(tmp_path / "part" / "simulated_0012.png"))


def test_the_doctor_finds_this_blender_and_renders_with_it(command: Command) -> None:
    said = command.run("doctor")
    assert f"blender      {command.version}" in said
    assert "a picture through the add-on" in said
    assert said.endswith("all checks passed\n")


def test_the_benchmark_measures_every_engine(command: Command, tmp_path: Path) -> None:
    result = tmp_path / "b.json"
    words = ("--frames", "1", "--resolution", "64x48", "--output", result)
    said = command.run("bench", "sync", command.scenes / "moving.blend", *words)
    engines = json.loads(result.read_text())["engines"]
    assert set(engines) == {"REGRAFT", "CYCLES", "BLENDER_WORKBENCH"}
    assert engines["REGRAFT"]["with_file_s"] > engines["REGRAFT"]["without_file_s"] > 0
    assert engines["CYCLES"]["with_file_s"] > 0
    assert "bytes a triangle" in said


def test_every_policy_is_measured_over_a_shot(command: Command, tmp_path: Path) -> None:
    result = tmp_path / "b.json"
    words = ("--frames", "1-3", "--size", "32", "--policies", "refit,rebuild", "--output", result)
    said = command.run("bench", "update", command.scenes / "moving.blend", *words)
    shot = json.loads(result.read_text())["shots"]["moving"]
    assert [row["frame"] for row in shot["rows"]] == [1] * 4 + [2] * 4 + [3] * 4
    assert {(r["policy"], r["layout"]) for r in shot["totals"]} == {
        (policy, layout) for policy in ("refit", "rebuild") for layout in ("two-level", "flat")
    }
    assert all(row["rays_primary"] == 32 * 32 for row in shot["rows"])
    assert "moving, 32² primary and shadow rays, 3 frames" in said


@pytest.mark.parametrize(("name", "frame"), [("robots", 20), ("n_body", 60)])
def test_every_version_draws_the_same_picture(
    name: str, frame: int, blend_files: Path, tmp_path: Path
) -> None:
    pictures = {}
    for version, executable in available().items():
        folder = tmp_path / version
        words = ("--frames", frame, "--resolution", "160x90", "--output", folder)
        command_in(version, str(executable), blend_files).render(
            blend_files / f"{name}.blend", *words
        )
        pictures[version] = pixels(folder / f"{name}_{frame:04}.png")
    first, *others = pictures.values()
    assert first.std() > 10, "the picture shows something"
    for version, other in zip(list(pictures)[1:], others, strict=True):
        assert np.abs(first - other).max() <= 1, version
