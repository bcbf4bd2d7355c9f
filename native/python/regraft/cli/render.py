"""`regraft render`: frames, statistics and a movie out of a file, and an exit code to trust."""

from __future__ import annotations

import argparse
from pathlib import Path

from regraft.cli import job as jobs
from regraft.cli import options
from regraft.cli.backend import PROGRAM_VARIABLE
from regraft.cli.blender_file import SUFFIXES
from regraft.cli.console import Console
from regraft.cli.errors import InputError, UsageError
from regraft.cli.job import RenderJob
from regraft.cli.ledger import LEDGER
from regraft.cli.render_run import Outputs, RenderRun

_DESCRIPTION = f"""Render the frames of FILE with the Regraft engine.

FILE may be {", ".join(SUFFIXES)},
as far as the Blender at hand can read it. Blender is used as the Python module bpy if it is
installed, else as the program `blender` on the PATH, or as the program that the environment
variable {PROGRAM_VARIABLE} names. Scripts inside the file are not run.

A frame file appears under its final name only when it is complete and has been read back.
A file without a camera is framed whole, as at its first frame, from a three-quarter view.
A folder of frames also holds {LEDGER}, by which --resume tells which frames
are finished."""

_EPILOG = """exit codes: 0 all asked for is there; 1 a self-check failed; 2 usage;
3 bad or unreadable input; 4 output could not be written;
130 interrupted (Ctrl-C or SIGTERM: the frame is finished first)"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `render` and its options."""
    parser = commands.add_parser(
        "render",
        help="render the frames of a .blend, glTF, USD, … file",
        description=_DESCRIPTION,
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.set_defaults(run=run)
    parser.add_argument("file", metavar="FILE", type=Path)
    _add_picture_options(parser.add_argument_group("picture"))
    _add_work_options(parser.add_argument_group("work"))
    _add_output_options(parser.add_argument_group("output"))


def _add_picture_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--frames",
        type=options.frames,
        metavar="LIST",
        help="such as 1-100 or 1,5,9-20 (default: the file's range)",
    )
    group.add_argument(
        "--resolution",
        type=options.resolution,
        metavar="WxH",
        default=(0, 0),
        help="in pixels (default: the file's)",
    )
    group.add_argument(
        "--shading", choices=jobs.SHADINGS, default="direct", help="(default: %(default)s)"
    )
    group.add_argument(
        "--samples",
        type=options.whole_number(1, 4096),
        default=1,
        metavar="N",
        help="a pixel (default: %(default)s)",
    )
    group.add_argument(
        "--passes",
        type=options.passes,
        default=("combined",),
        metavar="LIST",
        help=f"of {','.join(jobs.PASSES)}; more than combined needs --format exr "
        "and makes multi-layer files (default: combined)",
    )


def _add_work_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--policy",
        choices=(*jobs.POLICIES, "shot"),
        default="auto",
        help="how trees follow motion; shot builds them once for up to eight key frames of the "
        "frames to render, which are evaluated first (default: %(default)s)",
    )
    group.add_argument(
        "--structure",
        choices=jobs.STRUCTURES,
        default="auto",
        help="what is traced (default: %(default)s)",
    )
    group.add_argument(
        "--layout",
        choices=jobs.LAYOUTS,
        default="two-level",
        help="a tree a mesh and one over instances, or one over all triangles "
        "(default: %(default)s)",
    )
    group.add_argument(
        "--threads",
        type=options.whole_number(0, 1024),
        default=0,
        metavar="N",
        help="0: all cores (default: %(default)s)",
    )


def _add_output_options(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        "--output",
        type=Path,
        metavar="DIR",
        help="folder for the frames (default: NAME_frames here)",
    )
    group.add_argument(
        "--format",
        choices=tuple(jobs.SUFFIXES),
        default="png",
        help="of the frame files (default: %(default)s)",
    )
    group.add_argument(
        "--statistics",
        type=Path,
        metavar="FILE.jsonl",
        help="one JSON object a frame (docs/statistics.md)",
    )
    group.add_argument(
        "--movie",
        type=options.file_with_suffix(".mp4"),
        metavar="FILE.mp4",
        help="also put the frames together (H.264)",
    )
    group.add_argument(
        "--resume",
        action="store_true",
        help="leave finished frames made with the same settings alone",
    )
    group.add_argument(
        "--explain",
        action="store_true",
        help="tell for each frame what changed, what was done about it, and what was left out",
    )
    group.add_argument("--verbose", action="store_true", help="let Blender's own output through")


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft render`; raises CommandError. Returns the exit code."""
    job = _job(args)
    outputs = Outputs(
        folder=args.output or Path(f"{args.file.stem}_frames"),
        stem=args.file.stem,
        suffix=jobs.SUFFIXES[job.format],
        statistics=args.statistics,
        movie=args.movie,
        resume=args.resume,
    )
    return RenderRun(job, outputs, args.frames, console, args.verbose, args.explain).run()


def _job(args: argparse.Namespace) -> RenderJob:
    if args.passes != ("combined",) and args.format != "exr":
        raise UsageError(f"--passes {','.join(args.passes)} needs --format exr")
    if args.file.suffix.lower() not in SUFFIXES:
        raise InputError(f"{args.file}: the ending is none of {', '.join(SUFFIXES)}")
    _check_readable(args.file)
    return RenderJob(
        source=str(args.file.resolve()),
        width=args.resolution[0],
        height=args.resolution[1],
        format=args.format,
        shading=args.shading,
        samples=args.samples,
        policy=args.policy,
        structure=args.structure,
        layout=args.layout,
        threads=args.threads,
        passes=args.passes,
    )


def _check_readable(path: Path) -> None:
    try:
        with path.open("rb") as file:
            if not file.read(1):
                raise InputError(f"{path} is empty")
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror}") from error
