"""`regraft study`: what trees, pictures and predictions are worth, on any file."""

from __future__ import annotations

import argparse

from regraft.cli import (
    study_compare,
    study_image,
    study_lazy,
    study_origins,
    study_prediction,
    study_scan,
    study_stability,
    study_update,
)

KINDS = (
    study_scan,
    study_update,
    study_image,
    study_prediction,
    study_lazy,
    study_origins,
    study_stability,
    study_compare,
)
_EPILOG = """exit codes: 0 done; 1 an identity failed: two ways to trace the same rays disagree;
2 usage; 3 bad or unreadable input; 4 output could not be written; 130 interrupted"""


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `study` and its kinds."""
    study = commands.add_parser(
        "study",
        help="tables, plots and a page with a verdict, on any file",
        description="Measure on any .blend or mesh and write tidy CSV, JSON Lines, PNG and SVG "
        "plots and one HTML page that opens with a verdict.",
        epilog=_EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    kinds = study.add_subparsers(title="studies", required=True, metavar="WHAT")
    for kind in KINDS:
        kind.add_parser(kinds)
