"""The front of the `regraft` command: its parser, and how errors become exit codes."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import regraft
from regraft.cli import bench, doctor, render, study
from regraft.cli.console import Console, start_logging
from regraft.cli.errors import EXIT_INTERRUPTED, CommandError

EXIT_CODES = """exit codes: 0 all asked for is there; 1 a self-check failed; 2 usage;
3 bad or unreadable input; 4 output could not be written; 130 interrupted"""


def build_parser() -> argparse.ArgumentParser:
    """The whole command line."""
    parser = argparse.ArgumentParser(
        prog="regraft",
        description="Ray-traced previews of animations, from trees that live through the shot.",
        epilog=EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"regraft {regraft.__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (render, study, bench, doctor):
        command.add_parser(commands)
    return parser


def run(arguments: Sequence[str] | None) -> int:
    """Exit code of the command; argparse itself exits with 2 on a wrong command line."""
    args = build_parser().parse_args(arguments)
    start_logging(getattr(args, "verbose", False))
    with Console() as console:
        return _run(args, console)


def _run(args: argparse.Namespace, console: Console) -> int:
    try:
        code: int = args.run(args, console)
    except CommandError as error:
        console.error(str(error))
        return error.exit_code
    except KeyboardInterrupt:
        console.error("interrupted")
        return EXIT_INTERRUPTED
    return code
