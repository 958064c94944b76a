"""The page: read back by the parser of the standard library, as a browser would."""

import json
import math
import re
import subprocess
import sys
from html.parser import HTMLParser
from itertools import pairwise

import pytest

from mbdsl.errors import UsageError
from mbdsl.plotting import pages
from mbdsl.plotting.figure_layout import lay_out
from mbdsl.plotting.figures import Bar, Bars, Figure, Outcome, Page, Series, TextTable

VOID = {"meta", "br", "link", "img"}
EVIL = "</script><script>alert(1)</script><b>\"'&"


class Element:
    def __init__(self, tag, attributes):
        self.tag, self.attributes, self.children = tag, attributes, []

    def all(self, tag=None, **wanted):
        """Descendants in order; ``class_`` is one of the classes."""
        for child in self.children:
            if isinstance(child, Element):
                classes = (child.attributes.get("class") or "").split()
                fits = all(v in classes if k == "class_" else child.attributes.get(k) == v for k, v in wanted.items())
                if tag in (None, child.tag) and fits:
                    yield child
                yield from child.all(tag, **wanted)

    @property
    def text(self):
        return "".join(c if isinstance(c, str) else c.text for c in self.children)


class Reader(HTMLParser):
    """Builds the tree, and requires that every opened element is closed."""

    def __init__(self):
        super().__init__(convert_charrefs=True)
        self.open = [Element("", {})]

    def handle_starttag(self, tag, attrs):
        element = Element(tag, dict(attrs))
        self.open[-1].children.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_startendtag(self, tag, attrs):
        self.open[-1].children.append(Element(tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop().tag == tag

    def handle_data(self, data):
        self.open[-1].children.append(data)


def read(page):
    reader = Reader()
    reader.feed(pages.html(page))
    reader.close()
    assert len(reader.open) == 1
    return reader.open[0]


def data(figure):
    (script,) = figure.all("script", type="application/json")
    return json.loads(script.text)


def only(figure, narrow=False):
    """The figure on a page, with one of its two pictures: for wide or for narrow windows."""
    (found,) = read(Page("p", items=[figure])).all("figure")
    for place in found.all("div", class_="both"):
        of = [child for child in place.children if isinstance(child, Element)]
        assert [child.attributes.get("class") for child in of] == [None, "narrow"]
        place.children = [of[narrow]]
    return found


@pytest.fixture(scope="module")
def root(page):
    return read(page)


def test_order_and_headings(root, page):
    (title,), (h1,) = root.all("title", id=None), root.all("h1")
    assert title.text == h1.text == page.title
    (main,) = root.all("main")
    kinds = [c.tag for c in main.children if isinstance(c, Element)]
    assert kinds == ["h1", "p", "p", "figure", "div", "figure", "div", "figure", "section"]
    assert [f.text for f in root.all("h2")][:3] == [page.items[k].title for k in (0, 2, 4)]


def test_the_page_stands_by_itself(page):
    text = pages.html(page)
    assert not re.search(r"https?:|//[a-z]|@import|<link|<img|\bsrc=|\bhref=", re.sub(r"(?m)^\s*// .*$", "", text))
    assert "default-src &#x27;none&#x27;" in text
    assert re.findall(r"url\((?!#)", text) == []


def test_identifiers_are_unique_and_found(root):
    names = [e.attributes["id"] for e in root.all() if "id" in e.attributes]
    assert len(names) == len(set(names))
    for picture in root.all("svg", role="img"):
        assert set(picture.attributes["aria-labelledby"].split()) <= set(names)
        assert all("Series:" in d.text for d in picture.all("desc"))
    clips = {e.attributes["clip-path"][5:-1] for e in root.all() if "clip-path" in e.attributes}
    assert clips <= set(names)


def test_hover_tells_every_point(work_precision):
    payload = data(only(work_precision))
    assert (payload["x"], payload["y"]) == (work_precision.x_label, work_precision.y_label)
    for series, name, points in zip(work_precision.series, payload["names"], payload["points"], strict=True):
        assert name == series.name
        if series.style == "guide":
            assert points == []
        else:
            assert len(points) == len(series.x)
        if series.hover is not None:
            assert [p[5] for p in points] == list(series.hover)
            assert all("…" in p[4] for p in points)
    # Further right is slower, further down is more accurate.
    exudyn = payload["points"][payload["names"].index("Exudyn")]
    assert sorted(exudyn) == exudyn == sorted(exudyn, key=lambda p: p[1])
    assert [p[6] for p in payload["failed"]].count("hht-add") == 2


@pytest.mark.parametrize("narrow", [False, True])
def test_marks_stand_where_the_data_says(work_precision, narrow):
    figure = only(work_precision, narrow)
    payload = data(figure)
    payload |= payload["narrow"] if narrow else {}
    k = payload["names"].index("hht-si2")
    (group,) = [g for g in figure.all("g", class_="series") if g.attributes["data-series"] == str(k)]
    marks = [(float(c.attributes["cx"]), float(c.attributes["cy"])) for c in group.all("circle", class_="mark")]
    assert marks == [tuple(p[:2]) for p in payload["points"][k]]


def test_outcomes_and_floors_are_shown(work_precision):
    figure = only(work_precision)
    groups = [g.text for g in figure.all("g", class_="outcome")]
    assert len(groups) == 3  # those of hht-add share one text
    assert any("diverged at t = 0.0123 s" in text for text in groups)
    (listed,) = figure.all("ul", class_="outcomes")
    assert "scipy-radau: not installed" in listed.text
    assert "0.0027, 0.0055" in listed.text
    assert len(list(figure.all("path", class_="floor-line"))) == 1
    assert "the reference is not trusted" in next(figure.all("svg", role="img")).text
    (rect,) = figure.all("rect", class_="floor")
    assert float(rect.attributes["height"]) > 14.0  # room for its text


@pytest.mark.parametrize("narrow", [False, True])
def test_no_text_is_cut_off(work_precision, narrow):
    """With the width of letters of a common sans-serif font at the sizes of the style sheet."""
    from dataclasses import replace

    figure = replace(work_precision, x_label="error in positions and velocities, largest over time, scaled [-]")
    (picture,) = only(figure, narrow).all("svg", role="img")
    _, _, width, height = map(float, picture.attributes["viewbox"].split())
    assert width == (400.0 if narrow else 860.0)
    for text in picture.all("text"):
        letter = 6.9 if text.attributes["class"] == "label" else 6.4
        wide = float(text.attributes.get("textlength", letter * len(text.text)))
        anchor = {"start": 0.0, "middle": 0.5, "end": 1.0}[text.attributes["text-anchor"]]
        left = float(text.attributes["x"]) - anchor * wide
        assert left >= -1.0 and left + wide <= width + 1.0, text.text
        assert 8.0 < float(text.attributes["y"]) < height


def test_bars_have_the_ratio_of_their_values():
    bars = Bars("k", "Costs", "time [s]", [Bar("hht-i3", 1.0, "1 s"), Bar("radau5 --tol", 4.0, "4 s <b>")], "a note")
    figure = only(bars)
    drawn = list(figure.all("span", class_="bar"))
    assert not any("style" in bar.attributes for bar in drawn)  # the policy of the page would not apply it
    own = [bar.attributes["class"].split()[1] for bar in drawn]
    widths = dict(re.findall(r"\.([\w-]+) \{ width: (.*?); \}", pages.html(Page("p", (), [bars]))))
    assert [widths[name] for name in own] == ["25.0%", "100.0%"]
    assert ["hollow-bar" in bar.attributes["class"] for bar in drawn] == [False, True]  # a tolerance
    assert [row.text for row in figure.all("th")] == ["hht-i3", "radau5 --tol"] and "4 s <b>" in figure.text
    assert "time [s]" in figure.text and "a note" in figure.text


def test_a_floor_far_below_is_told_and_leaves_the_axis_to_the_data(work_precision):
    from dataclasses import replace

    bare, far = (lay_out(replace(work_precision, floors=floors)) for floors in ((), [(1e-40, "the references differ")]))
    assert (far.y.low, far.y.high, far.floors) == (bare.y.low, bare.y.high, [])
    assert far.left_out == f"{bare.left_out} Further below: the references differ (10⁻⁴⁰).".strip()
    figure = only(replace(work_precision, floors=[(1e-40, "the references differ")]))
    assert not list(figure.all("path", class_="floor-line"))
    assert "Further below" in " ".join(p.text for p in figure.all("p", class_="note"))


@pytest.mark.parametrize("narrow", [False, True])
def test_no_two_texts_of_outcomes_overlap(work_precision, narrow):
    from dataclasses import replace

    many = [Outcome(f"method{k % 7}", 10.0 ** (-3 + k % 4), f"diverged in step {k}") for k in range(14)]
    figure = only(replace(work_precision, outcomes=many), narrow)
    boxes = {}
    for group in figure.all("g", class_="outcome"):
        (text,) = group.all("text")
        width = 6.7 * len(text.text)
        start = float(text.attributes["x"]) - (width if text.attributes["text-anchor"] == "end" else 0.0)
        boxes.setdefault(text.attributes["y"], []).append((start, start + width))
    assert 1 < len(boxes) <= 6
    for row in boxes.values():
        row.sort()
        assert all(one[1] <= other[0] for one, other in pairwise(row))
        assert row[0][0] >= 0.0
        assert row[-1][1] <= 860.0
    (listed,) = figure.all("ul", class_="outcomes")
    assert len(list(listed.all("li"))) == 14  # also the ones without a row


def test_a_gap_divides_a_line():
    x = [1.0, 2.0, 3.0, 4.0, 5.0]
    figure = only(Figure("k", "t", "x", "y", [Series("a", x, [1.0, 2.0, math.nan, 2.0, 1.0])], False, False))
    (group,) = figure.all("g", class_="series")
    (line,) = group.all("path", class_="line")
    assert line.attributes["d"].count("M") == 2
    assert len(list(group.all("circle", class_="mark"))) == 4
    assert len(data(figure)["points"][0]) == 4


def test_zero_on_a_logarithmic_axis_is_told():
    figure = only(Figure("k", "t", "x", "y", [Series("a", [1.0, 2.0], [0.0, 1.0])]))
    assert "without a place on a logarithmic axis: a (1)." in figure.text
    assert len(data(figure)["points"][0]) == 1


def test_many_points_are_thinned_by_less_than_is_seen(energy):
    figure = only(energy)
    (group,) = [g for g in figure.all("g", class_="series") if g.attributes["data-series"] == "2"]
    (line,) = group.all("path", class_="line")
    drawn = [tuple(map(float, p.split())) for p in re.split("[ML]", line.attributes["d"]) if p]
    assert 50 < len(drawn) < 700
    payload = [p[:2] for p in data(figure)["points"][2]]
    for x, y in payload:  # each is rounded to a tenth of a pixel
        after = next(k for k, p in enumerate(drawn) if p[0] >= x - 0.05)
        (x0, y0), (x1, y1) = drawn[max(after - 1, 0)], drawn[after]
        at = y0 + (y1 - y0) * (x - x0) / (x1 - x0) if x1 > x0 else y1
        assert abs(at - y) < 1.0


@pytest.mark.parametrize("ratio", [0.05, 0.5, 4.0])
def test_equal_axes_have_one_scale(ratio):
    circle = [2.0 * math.pi * k / 100 for k in range(100)]
    series = Series("a", [math.cos(a) for a in circle], [ratio * math.sin(a) for a in circle], style="marks")
    points = data(only(Figure("k", "t", "x", "y", [series], False, False, equal=True)))["points"][0]
    wide = max(p[0] for p in points) - min(p[0] for p in points)
    high = max(p[1] for p in points) - min(p[1] for p in points)
    assert high == pytest.approx(ratio * wide, abs=0.1 * (1.0 + ratio))  # positions are rounded to 0.1 px


def test_tables(root, page):
    tables = list(root.all("table"))
    assert [next(t.all("caption")).text for t in tables] == [page.items[k].title for k in (1, 3)]
    heads = [(h.text, "number" in h.attributes.get("class", "")) for h in tables[0].all("th", scope="col")]
    assert heads == list(zip(page.items[1].columns, [True, False, False, True, True, True], strict=True))
    rows = [[c.text for c in r.children if isinstance(c, Element)] for r in tables[0].all("tr")][1:]
    assert rows == [list(r) for r in page.items[1].rows]
    assert [h.text for h in tables[0].all("th", scope="row")] == [r[0] for r in page.items[1].rows]


def test_fine_print_unfolds_what_is_long(root, page):
    (section,) = root.all("section", class_="fine")
    assert [d.text for d in section.all("dt")] == [name for name, _ in page.fine_print]
    (details,) = section.all("details")
    assert next(details.all("pre")).text == page.fine_print[-1][1].strip("\n")


def test_every_text_is_only_text():
    series = Series(EVIL, [1.0, 2.0], [1.0, 2.0], hover=[EVIL, EVIL])
    figure = Figure(
        EVIL, EVIL, EVIL, EVIL, [series], outcomes=[Outcome(EVIL, 1.0, EVIL)], floors=[(0.5, EVIL)], note=EVIL
    )
    table = TextTable(EVIL, [EVIL, EVIL], [[EVIL, EVIL]], EVIL)
    page = Page(EVIL, [EVIL], [figure, table], [(EVIL, EVIL), ("long", EVIL * 20)])
    root = read(page)
    assert len(list(root.all("script"))) == 2  # the data script and our own script
    assert list(root.all("b")) == []
    payload = data(next(root.all("figure")))
    assert payload["points"][0][0][5] == payload["x"] == payload["names"][0] == EVIL
    assert next(root.all("h1")).text == EVIL
    assert [c.text for c in root.all("td")] == [EVIL]


@pytest.mark.parametrize("log", [False, True])
def test_empty_figures(log):
    bad = [Series("a", [], []), Series("b", [math.nan], [math.inf], [math.nan], [math.nan]), Series("c", [1.0], [1.0])]
    for series in ([], bad[:1], bad[:2], bad):
        figure = only(Figure("k", "t", "x", "y", series, log, log))
        assert len(data(figure)["points"]) == len(series)
        assert (
            "nan"
            not in pages.html(Page("p", items=[Figure("k", "t", "x", "y", series, log, log)])).split("<script>")[0]
        )


def test_written(tmp_path, page):
    pages.write(page, tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == pages.html(page)
    with pytest.raises(UsageError, match="cannot write"):
        pages.write(page, tmp_path / "none" / "page.html")


def test_no_matplotlib_needed():
    code = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "from mbdsl.plotting import pages, figures as f\n"
        "print(len(pages.html(f.Page('p', items=[f.Figure('k', 't', 'x', 'y', [f.Series('a', [1], [1])])]))))"
    )
    assert int(subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout) > 1000
