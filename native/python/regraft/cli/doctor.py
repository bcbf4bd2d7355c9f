"""`regraft doctor`: what is installed, what works, and what to do about the rest."""

from __future__ import annotations

import argparse
import importlib.metadata
import importlib.util
import os
import platform
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import regraft
from regraft import _regraft, machine_costs
from regraft.cli.backend import HOW_TO_GET_BLENDER, Backend, choose_backend
from regraft.cli.console import Console
from regraft.cli.errors import (
    EXIT_OK,
    CommandError,
    InputError,
    SelfCheckError,
    describe_write_failure,
)
from regraft.cli.job import RenderJob
from regraft.cli.self_check import run_self_check
from regraft.formats import images, movie

ISAS = ("scalar", "sse", "avx2", "avx512")
_TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\n"
_PICTURE = (64, 48)


def add_parser(commands: argparse._SubParsersAction[argparse.ArgumentParser]) -> None:
    """Adds `doctor`."""
    parser = commands.add_parser(
        "doctor",
        help="say what is installed and what works",
        description="Say what is installed, trace a small scene against NumPy, render a small "
        "picture through Blender, and give hints. Exit code 1 if a check fails; things that are "
        "merely not installed are hints.",
    )
    parser.set_defaults(run=run)
    parser.add_argument(
        "--calibrate",
        action="store_true",
        help="measure first what operations cost on this machine, and keep it in the user's cache "
        "folder; takes a few seconds in which the machine should do nothing else",
    )
    parser.add_argument("--verbose", action="store_true", help="let Blender's own output through")


@dataclass
class Report:
    """Lines of the report; counts what failed and keeps the hints for the end."""

    console: Console
    failures: int = 0

    def fact(self, name: str, text: str) -> None:
        """Something found."""
        self.console.say(f"  {name:<12} {text}")

    def hint(self, name: str, text: str) -> None:
        """Something missing that not everybody needs."""
        self.console.say(f"- {name:<12} {text}")

    def check(self, name: str, work: Callable[[], str]) -> None:
        """Runs a check; whatever it raises is a failure, and the next check still runs."""
        try:
            self.console.say(f"✓ {name:<12} {work()}")
        except CommandError as error:
            self._fail(name, str(error))
        except Exception as error:  # noqa: BLE001 - a report of what is broken must go on
            self._fail(name, f"{type(error).__name__}: {error}")

    def _fail(self, name: str, text: str) -> None:
        self.failures += 1
        self.console.say(f"✗ {name:<12} {text}")


def run(args: argparse.Namespace, console: Console) -> int:
    """Runs `regraft doctor`. Raises SelfCheckError if any check failed."""
    report = Report(console)
    if args.calibrate:
        _calibrate(console)
    _machine(report)
    report.check("tracing", run_self_check)
    _formats(report)
    _blender(report, args.verbose)
    if report.failures:
        raise SelfCheckError(f"{report.failures} checks failed")
    console.say("all checks passed")
    return EXIT_OK


def _machine(report: Report) -> None:
    report.fact("regraft", f"{regraft.__version__}, in {Path(regraft.__file__).parent}")
    report.fact("python", f"{platform.python_version()}, NumPy {np.__version__}")
    report.fact("system", platform.platform())
    report.fact("cores", str(usable_cores()))
    available = available_isas()
    report.fact("SIMD", f"{available[-1]} (available: {', '.join(available)})")
    source = machine_costs.load()
    report.fact("costs", f"{_in_words(_regraft.machine_costs())} ({source})")


def _calibrate(console: Console) -> None:
    costs = _regraft.calibrate()
    try:
        path = machine_costs.save(costs)
    except OSError as error:
        raise describe_write_failure(machine_costs.cache_file(), error) from error
    console.say(f"  {'measured':<12} {_in_words(costs)}, kept in {path}")


def _in_words(costs: dict[str, float]) -> str:
    return ", ".join(f"{name} {cost:.3g}" for name, cost in costs.items())


def usable_cores() -> int:
    """Cores this process may run on."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def available_isas() -> list[str]:
    """Instruction sets this machine and build offer, weakest first; `auto` takes the last."""
    return [isa for isa in ISAS if _offers(isa)]


def _offers(isa: str) -> bool:
    try:
        regraft.Scene(threads=1, isa=isa)
    except ValueError:
        return False
    return True


def _formats(report: Report) -> None:
    try:
        report.fact("movies", f"ffmpeg {movie.available()}")
    except (ImportError, RuntimeError):
        report.hint("movies", "--movie needs the package imageio-ffmpeg")
    for name, package in (("png, jpeg", "pillow"), ("exr", "OpenEXR"), ("progress", "tqdm")):
        try:
            report.fact(name, f"{package} {importlib.metadata.version(package)}")
        except importlib.metadata.PackageNotFoundError:
            report.hint(name, f"not installed: pip install {package}")


def _blender(report: Report, verbose: bool) -> None:
    if importlib.util.find_spec("regraft_blender") is None:
        report.hint("add-on", "regraft_blender cannot be imported: only the NumPy API works")
        return
    if program := shutil.which("blender"):
        report.fact("program", program)
    try:
        backend = choose_backend(verbose)
    except InputError:
        report.hint("blender", HOW_TO_GET_BLENDER)
        return
    try:
        report.check("blender", lambda: _probe(backend))
        report.check("rendering", lambda: _render(backend))
    finally:
        backend.close()


def _probe(backend: Backend) -> str:
    found = backend.probe()
    return (
        f"{found['blender']} with Python {found['python']} ({backend.place}), "
        f"reads {' '.join(found['formats'])}"
    )


def _render(backend: Backend) -> str:
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder, "triangle.obj"), Path(folder, "triangle.png")
        source.write_text(_TRIANGLE, encoding="ascii")
        info = backend.open(RenderJob(str(source), *_PICTURE, threads=0))
        row = backend.render(info.frames[0], target)
        try:
            images.verify(target, *_PICTURE)
        except images.DamagedImageError as error:
            raise SelfCheckError(str(error)) from error
    return f"a picture through the add-on, {row['total_ms']:.0f} ms"
