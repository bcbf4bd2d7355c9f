"""Figures for reports, drawn by matplotlib, which is needed for studies only."""

from __future__ import annotations

import io
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, cast

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HOW_TO_GET = "studies draw with matplotlib, which is missing: pip install 'regraft[study]'"
# One colour for one name in every figure (Okabe and Ito's, which colour-blind people tell apart).
PALETTE = {
    "refit": "#E69F00",
    "rebuild": "#000000",
    "lm": "#CC79A7",
    "rtdeform": "#B8A800",
    "selective": "#0072B2",
    "selective+rotate": "#56B4E9",
    "shot": "#8C6BB1",
    "auto": "#009E73",
    "k-d tree": "#D55E00",
}
_OTHERS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
_STYLE: dict[str, Any] = {
    "figure.figsize": (6.4, 4.0),
    "figure.constrained_layout.use": True,
    "font.size": 9,
    "axes.grid": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.alpha": 0.3,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "svg.hashsalt": "regraft",
}


# Without, `drawing` draws nothing.
are_wanted = True


@dataclass(frozen=True)
class Plot:
    """A finished figure under the name of its files, with a sentence that says what to see."""

    name: str
    caption: str
    png: bytes
    svg: bytes


def require() -> None:
    """Raises ImportError, with what to do, where matplotlib is wanted and missing."""
    if not are_wanted:
        return
    try:
        import matplotlib.pyplot  # noqa: F401
    except ImportError as error:
        raise ImportError(HOW_TO_GET) from error


@contextmanager
def drawing(name: str, caption: str, into: list[Plot], **style: Any) -> Iterator[Axes]:
    """Yields axes to draw on; the figure joins `into` when the block ends."""
    if not are_wanted:
        yield cast("Axes", _NoAxes())
        return
    import matplotlib as mpl
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with mpl.rc_context({**_STYLE, **style}):
        figure = Figure()
        FigureCanvasAgg(figure)
        yield figure.add_subplot()
        png, svg = io.BytesIO(), io.BytesIO()
        figure.savefig(png, format="png", dpi=120, metadata={"Software": None})
        figure.savefig(svg, format="svg", metadata={"Date": None, "Creator": "regraft"})
    into.append(Plot(name, caption, png.getvalue(), svg.getvalue()))


class _NoAxes:
    """Takes whatever is drawn, and shows nothing."""

    def __getattr__(self, _name: str) -> Any:
        return lambda *_args, **_kwargs: None


def colour(name: str, position: int = 0) -> str:
    """Of a policy by its name, of anything else by its position."""
    base = name.removesuffix(" flat")
    return PALETTE.get(base, _OTHERS[position % len(_OTHERS)])


def lines(axes: Axes, series: Mapping[str, tuple[Sequence[float], Sequence[float]]]) -> None:
    """One line for each name: (x, y)."""
    for i, (name, (x, y)) in enumerate(series.items()):
        dash = "--" if name.endswith(" flat") else "-"
        axes.plot(x, y, dash, label=name, color=colour(name, i), linewidth=1.3)
    if series:
        axes.legend()


def log_scale(axes: Axes, which: str = "y") -> None:
    """Makes that axis logarithmic, with plain numbers at the ticks."""
    if isinstance(axes, _NoAxes):
        return
    from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter

    axis = axes.xaxis if which == "x" else axes.yaxis
    axes.set(**{f"{which}scale": "log"})
    axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_formatter(NullFormatter())


def scatter(axes: Axes, points: Mapping[str, tuple[float, float]]) -> None:
    """One named point each, and the staircase of those that nothing beats in both."""
    for i, (name, (x, y)) in enumerate(points.items()):
        axes.plot([x], [y], "o", color=colour(name, i))
        axes.annotate(name, (x, y), xytext=(5, 4), textcoords="offset points", fontsize=8)
    front = pareto(list(points.values()))
    if len(front) > 1:
        axes.step(*zip(*front, strict=True), where="post", color="0.5", linewidth=1, zorder=0)


def pareto(points: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """The points that no other is at most as large as in both, by ascending x."""
    front: list[tuple[float, float]] = []
    for point in sorted(set(points)):
        if not front or point[1] < front[-1][1]:
            front.append(point)
    return front
