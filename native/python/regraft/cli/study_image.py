"""`regraft study image`: image error against time."""

from __future__ import annotations

import argparse

from regraft.cli import options, study_frame
from regraft.cli.console import Console
from regraft.cli.errors import OutputError
from regraft.cli.interrupt import Interrupt
from regraft.study import image, image_error, image_report


def add_parser(kinds: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `study image`."""
    parser = kinds.add_parser(
        "image",
        help="image error against seconds, for each mode of shading",
        description="Render the last of the frames in every mode with 1, 2, 4, … samples and "
        "hold the pictures against a reference of many samples, whose own error is shown: RMSE, "
        "relMSE and FLIP against seconds, update included.",
    )
    parser.set_defaults(run=run)
    study_frame.add_options(parser, "image")
    parser.add_argument(
        "--resolution",
        type=options.resolution,
        metavar="WxH",
        default=(256, 144),
        help="in pixels (default: 256x144)",
    )
    parser.add_argument(
        "--samples",
        type=options.whole_number(2, 4096),
        default=64,
        metavar="N",
        help="most samples of a preview (default: %(default)s)",
    )
    parser.add_argument(
        "--reference",
        type=options.whole_number(1, 65536),
        default=512,
        metavar="N",
        help="samples of each half of the reference (default: %(default)s)",
    )


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft study image`; raises CommandError. Returns the exit code."""
    study_frame.prepare(args, args.files)
    try:
        image_error.require()
    except ImportError as error:
        raise OutputError(str(error)) from error
    width, height = args.resolution
    settings = image.Settings(width, height, args.samples, args.reference, threads=args.threads)
    report = study_frame.start("Image error against time", threads=args.threads or "all cores")
    with Interrupt(console).watching() as interrupt:
        for name, shot in study_frame.shots(args, console, interrupt, image.TRUE_MODE):
            count = 1 + len(image.MODES) * len(settings.samples())
            with study_frame.steps(name, count, console, interrupt) as tick:
                rows = list(image.measure(shot, settings, tick))
            report.sections.append(image_report.section(name, rows))
            report.add("image", rows, name)
    return study_frame.finish(report, args.output, console)
