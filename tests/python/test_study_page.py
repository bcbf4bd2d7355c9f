"""What studies leave behind: tables, pictures and a page that needs nothing else."""

from __future__ import annotations

import csv
import re
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree

import pytest

from regraft.study import page, plots, tidy
from regraft.study.page import Page, Section, Table
from regraft.study.report import Report, file_name

EVIL = '<script>alert("&")</script>'


class Reader(HTMLParser):
    """The tags of a page, with their attributes, and its text."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.text = ""
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.fixture(scope="module")
def plot() -> plots.Plot:
    drawn: list[plots.Plot] = []
    with plots.drawing("a/b", EVIL, drawn) as axes:
        plots.lines(axes, {EVIL: ([1, 2], [3, 4]), "refit": ([1, 2], [1, 1])})
        plots.log_scale(axes)
    return drawn[0]


def section(plot: plots.Plot) -> Section:
    table = Table({"name": EVIL, "n": "count"}, [{"name": EVIL, "n": 12345}, {"n": None}], 1)
    return Section(EVIL, f"{EVIL} wins", plots=[plot], tables=[table], notes=[EVIL])


def test_the_page_shows_names_and_runs_nothing(plot: plots.Plot) -> None:
    read = Reader(Page(EVIL, [section(plot)], {EVIL: EVIL}).html())
    names = [name for name, _ in read.tags]
    assert "script" not in names
    assert read.text.count(EVIL) == 10, "title 2, verdict, section, caption, table 2, note, facts 2"
    assert not any(key.startswith("on") for _, attributes in read.tags for key in attributes)


def test_the_page_needs_no_network(plot: plots.Plot) -> None:
    html = Page("t", [section(plot)], {}).html()
    for tag, attributes in Reader(html).tags:
        for key in ("src", "href"):
            if key in attributes:
                assert str(attributes[key]).startswith("data:"), tag
    assert not re.search(r"url\(|@import|<link", html)


def test_the_verdict_comes_first(plot: plots.Plot) -> None:
    wrong = Section("b", "it is broken", wrong=True)
    html = Page("t", [section(plot), wrong], {}).html()
    assert html.index("wins") < html.index("it is broken") < html.index("<h2>")
    assert html.index('class="verdict wrong"') < html.index("it is broken")


def test_plots_are_whole_pictures(plot: plots.Plot) -> None:
    assert plot.png.startswith(b"\x89PNG")
    assert plot.png.endswith(b"IEND\xaeB\x60\x82")
    root = ElementTree.fromstring(plot.svg)
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    assert "href" not in " ".join(
        k for e in root.iter() for k in e.attrib if e.tag.endswith("image")
    )


def test_numbers_are_written_for_people() -> None:
    values = [None, 3, 1234567, 0.123456, 12345.6, 1e-7, "x", True]
    said = ["–", "3", "1,234,567", "0.1235", "12,346", "1e-07", "x", "True"]
    assert [page.text(v) for v in values] == said


def test_a_report_writes_every_file(tmp_path: Path, plot: plots.Plot) -> None:
    report = Report("t", {})
    report.sections.append(section(plot))
    report.add("numbers", [{"a": 1, "b": 0.1}], "one")
    report.add("numbers", [{"a": 2, "c": ["x", "y"]}], 'two, "or" so')
    report.lines["numbers"] = [{"a": float("nan")}]
    assert report.write(tmp_path).read_text("utf-8").startswith("<!DOCTYPE html>")
    names = ["a_b.png", "a_b.svg", "index.html", "numbers.csv", "numbers.jsonl"]
    names.append("verdicts.jsonl")
    assert sorted(p.name for p in tmp_path.iterdir()) == names
    with (tmp_path / "numbers.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert rows[0] == {"scene": "one", "a": "1", "b": "0.1", "c": ""}
    assert rows[1] == {"scene": 'two, "or" so', "a": "2", "b": "", "c": "x; y"}
    assert (tmp_path / "numbers.jsonl").read_text() == '{"a": null}\n'


@pytest.mark.parametrize(
    ("name", "safe"), [("a/b c", "a_b_c"), ("../..", "scene"), ("Żółw", "Żółw"), ("", "scene")]
)
def test_file_names_stay_in_their_folder(name: str, safe: str) -> None:
    assert file_name(name) == safe


def test_the_front_holds_what_nothing_beats() -> None:
    points = [(3.0, 1.0), (1.0, 5.0), (2.0, 6.0), (2.0, 2.0), (4.0, 1.0)]
    assert plots.pareto(points) == [(1.0, 5.0), (2.0, 2.0), (3.0, 1.0)]


def test_quartiles() -> None:
    assert tidy.quartiles([7.0]) == (7.0, 7.0, 7.0)
    assert tidy.quartiles([1.0, 2.0, 3.0, 4.0, 5.0]) == (2.0, 3.0, 4.0)
