"""A render from its first check to its summary, without Blender."""

from __future__ import annotations

import errno
import json
import os
import signal
from dataclasses import dataclass
from pathlib import Path

import pytest

from regraft.cli.console import Console
from regraft.cli.errors import InputError, InterruptedRunError, OutputError
from regraft.cli.job import RenderJob
from regraft.cli.render_run import Outputs, RenderRun
from stand_in_backend import StandInBackend
from stand_in_recording import RecordingStandIn


@dataclass
class Shot:
    """A source file and a place for its frames."""

    folder: Path

    @property
    def frames(self) -> Path:
        return self.folder / "frames"

    @property
    def statistics(self) -> Path:
        return self.folder / "s.jsonl"

    def run(
        self,
        backend: StandInBackend,
        *,
        resume: bool = False,
        samples: int = 1,
        movie: bool = False,
        explain: bool = False,
        policy: str = "auto",
    ) -> int:
        target = self.folder / "m.mp4" if movie else None
        outputs = Outputs(self.frames, "shot", ".png", self.statistics, target, resume)
        job = RenderJob(str(self.folder / "shot.blend"), samples=samples, policy=policy)
        with Console() as console:
            run = RenderRun(job, outputs, None, console, explain=explain, choose=lambda _: backend)
            return run.run()

    def names(self) -> list[str]:
        return sorted(p.name for p in self.frames.iterdir() if p.name.startswith("shot"))

    def strays(self) -> list[str]:
        return [p.name for p in self.frames.iterdir() if ".regraft-" in p.name]

    def rows(self) -> list[int]:
        return [json.loads(line)["frame"] for line in self.statistics.read_text().splitlines()]


@pytest.fixture
def shot(tmp_path: Path) -> Shot:
    (tmp_path / "shot.blend").write_text("scene")
    return Shot(tmp_path)


ALL = ["shot_0001.png", "shot_0002.png", "shot_0003.png"]


def test_all_that_was_asked_for_is_there(shot: Shot, capfd: pytest.CaptureFixture[str]) -> None:
    backend = StandInBackend()
    assert shot.run(backend, movie=True) == 0
    assert shot.names() == ALL
    assert shot.rows() == [1, 2, 3]
    assert (shot.folder / "m.mp4").stat().st_size > 0
    assert backend.closed
    told = capfd.readouterr().out
    assert f"frames: {shot.frames} (3 files)" in told
    assert f"movie: {shot.folder / 'm.mp4'}" in told
    assert f"statistics: {shot.statistics}" in told
    assert "median ms a frame: evaluate 0.0" in told
    assert "left out: no deformation: no refit (3 of 3 frames)" in told


def test_a_planned_render_first_evaluates_key_frames_of_all_that_is_to_be_rendered(
    shot: Shot, capfd: pytest.CaptureFixture[str]
) -> None:
    backend = RecordingStandIn(15)
    shot.run(backend, policy="shot")
    assert backend.planned == (1, 3, 5, 7, 9, 11, 13, 15)
    assert backend.rendered == list(range(1, 16))
    told = capfd.readouterr()
    assert "key frame 13 evaluated" in told.out + told.err


def test_a_planned_render_names_a_mesh_whose_triangles_change(shot: Shot) -> None:
    backend = RecordingStandIn(3, remade=2)
    with pytest.raises(InputError, match="gets other triangles"):
        shot.run(backend, policy="shot")
    assert backend.rendered == []


def test_negative_frames_are_named_as_in_blender(shot: Shot) -> None:
    shot.run(StandInBackend(frames=(-2, 12345)))
    assert shot.names() == ["shot_-0002.png", "shot_12345.png"]


def test_a_damaged_picture_never_takes_its_final_name(shot: Shot) -> None:
    backend = StandInBackend(faults={2: lambda path: os.truncate(path, 60)})
    with pytest.raises(OutputError, match=r"shot_0002\.png"):
        shot.run(backend)
    assert shot.names() == ["shot_0001.png"]
    assert shot.strays() == []
    assert shot.rows() == [1]
    assert backend.closed


def test_a_full_disk_is_named(shot: Shot) -> None:
    def fill(_: Path) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(OutputError, match=r"shot_0003\.png: No space left .* MB free"):
        shot.run(StandInBackend(faults={3: fill}))
    assert shot.names() == ALL[:2]


def test_a_failing_engine_leaves_the_frames_before_it(shot: Shot) -> None:
    def fail(_: Path) -> None:
        raise InputError("frame 2: boom")

    with pytest.raises(InputError, match="boom"):
        shot.run(StandInBackend(faults={2: fail}))
    assert shot.names() == ALL[:1]
    assert shot.strays() == []


def test_resume_renders_only_what_is_missing(shot: Shot, capfd: pytest.CaptureFixture[str]) -> None:
    shot.run(StandInBackend())
    (shot.frames / ALL[1]).unlink()
    backend = StandInBackend()
    assert shot.run(backend, resume=True) == 0
    assert backend.rendered == [2]
    assert shot.rows() == [1, 3, 2]
    assert "2 finished frames stay, 1 to render" in capfd.readouterr().out


def test_resume_with_other_settings_renders_everything(shot: Shot) -> None:
    shot.run(StandInBackend())
    backend = StandInBackend()
    shot.run(backend, resume=True, samples=2)
    assert backend.rendered == [1, 2, 3]
    assert shot.rows() == [1, 2, 3]


def test_resume_of_a_finished_run_renders_nothing(shot: Shot) -> None:
    shot.run(StandInBackend())
    backend = StandInBackend()
    assert shot.run(backend, resume=True, movie=True) == 0
    assert backend.rendered == []
    assert (shot.folder / "m.mp4").exists()


def test_without_resume_everything_is_rendered_anew(shot: Shot) -> None:
    shot.run(StandInBackend())
    backend = StandInBackend()
    shot.run(backend)
    assert backend.rendered == [1, 2, 3]
    assert shot.rows() == [1, 2, 3]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_finishes_the_frame_and_says_how_to_go_on(
    shot: Shot, number: signal.Signals
) -> None:
    backend = StandInBackend(faults={2: lambda _: os.kill(os.getpid(), number)})
    before = signal.getsignal(number)
    with pytest.raises(InterruptedRunError, match=r"2 of 3 frames.*--resume") as caught:
        shot.run(backend, movie=True)
    assert caught.value.exit_code == 130
    assert shot.names() == ALL[:2]
    assert not (shot.folder / "m.mp4").exists()
    assert signal.getsignal(number) == before
    shot.run(StandInBackend(), resume=True)
    assert shot.names() == ALL


def test_a_shot_in_which_nothing_is_visible_is_bad_input(shot: Shot) -> None:
    with pytest.raises(InputError, match="nothing is visible"):
        shot.run(StandInBackend(triangles=0))


def test_a_folder_that_cannot_be_written_is_named_before_any_work(shot: Shot) -> None:
    shot.frames.write_text("a file in the way")
    backend = StandInBackend()
    with pytest.raises(OutputError, match=str(shot.frames)):
        shot.run(backend)
    assert backend.rendered == []


def test_statistics_in_a_missing_folder_are_refused_before_any_work(shot: Shot) -> None:
    outputs = Outputs(shot.frames, "shot", ".png", shot.folder / "no" / "s.jsonl", None, False)
    with Console() as console, pytest.raises(OutputError, match=r"s\.jsonl: No such file"):
        RenderRun(RenderJob("x"), outputs, None, console).run()


def test_a_plan_is_told_for_each_frame_if_asked(
    shot: Shot, capsys: pytest.CaptureFixture[str]
) -> None:
    assert shot.run(StandInBackend()) == 0
    assert "    left out: no deformation" not in capsys.readouterr().out
    assert shot.run(StandInBackend(), explain=True) == 0
    assert capsys.readouterr().out.count("    left out: no deformation: no refit\n") == 3
