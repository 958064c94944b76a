"""The page as a text: its policy, its data, and nothing that refers to other files; its frame in a notebook."""

import base64
import hashlib
import html
import json
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from mbdsl import parse
from mbdsl.errors import UsageError
from mbdsl.viewing import page

EVIL = "</script><script>alert(1)</script><!-- \\u2028 '\""


class Reader(HTMLParser):
    """Tags with attributes, and the content of scripts and styles."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.raw = [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_data(self, data):
        if self.tags and self.tags[-1][0] in ("script", "style") and data.strip():
            self.raw.append((*self.tags[-1], data))

    def data(self):
        return json.loads(next(text for tag, about, text in self.raw if about.get("id") == "data"))


def array(stored):
    return np.frombuffer(base64.b64decode(stored["data"]), f"<{stored['kind']}")


def test_the_page_loads_nothing(slider_crank):
    page = Reader(slider_crank.animate().html)
    assert not [about for _, about in page.tags if {"src", "href", "style", "onclick", "onload"} & set(about)]
    assert not re.search(r"https?://|@import|url\(|\beval\b|new Function", slider_crank.animate().html)
    ids = [about["id"] for _, about in page.tags if "id" in about]
    assert len(ids) == len(set(ids))


def test_the_policy_allows_this_script_and_this_style_only(slider_crank):
    page = Reader(slider_crank.animate().html)
    (policy,) = [about["content"] for _, about in page.tags if about.get("http-equiv") == "Content-Security-Policy"]
    digests = {
        tag: base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        for tag, about, text in page.raw
        if "type" not in about
    }
    assert policy == (
        f"default-src 'none'; style-src 'sha256-{digests['style']}'; script-src 'sha256-{digests['script']}'"
    )


def test_the_data_are_the_motion(slider_crank):
    data = Reader(slider_crank.animate().html).data()
    np.testing.assert_array_equal(array(data["t"]), slider_crank.t)
    poses = array(data["poses"]).reshape(301, 2, 3)
    np.testing.assert_array_equal(poses[:, 0, 2], slider_crank["crank.phi"].astype("f4"))
    np.testing.assert_array_equal(poses[:, 1, 0], slider_crank["rod.x"].astype("f4"))
    (line,) = [s for s in data["signals"] if s["name"] == "rod.x"]
    values = line["low"] + (array(line["y"]) / 32767 + 1) / 2 * (line["high"] - line["low"])
    assert np.abs(values - slider_crank["rod.x"]).max() <= 0.51 * (line["high"] - line["low"]) / 65534


def test_the_slider_crank_is_small(slider_crank):
    assert len(slider_crank.animate().html.encode()) < 150_000


def test_positions_far_from_the_origin_keep_their_digits(trajectory_of):
    """A mass that moves by 1 mm at x = 1e6 m; 32-bit numbers have steps of 6 cm there."""
    scene = parse("model A Ground ground(g = 0); PointMass m(m = 1 kg); FreeMotion free(ground, m); end A;")
    x = 1e6 + np.linspace(0, 1e-3, 11)
    data = Reader(trajectory_of(scene, np.arange(11.0), {"m": np.column_stack([x, 0 * x])}).animate().html).data()
    found = array(data["poses"]).reshape(11, 3)[:, 0] + data["origin"][0]
    np.testing.assert_allclose(found, x, atol=1e-8)


def test_texts_of_a_model_are_texts(trajectory_of):
    scene = parse(f"model A {json.dumps(EVIL)} Ground ground; PointMass m(m = 1 kg); FreeMotion f(ground, m); end A;")
    page = Reader(trajectory_of(scene, [0.0, 1.0], {"m": np.zeros((2, 2))}).animate().html)
    assert [tag for tag, _ in page.tags].count("script") == 2
    assert page.data()["doc"] == scene.doc and "</script>" in scene.doc


def test_values_that_are_not_numbers_are_gaps(trajectory_of, slider_crank):
    q = {"crank": np.full((3, 3), np.nan)}
    data = Reader(
        trajectory_of(slider_crank.scene, [0.0, 1.0, 2.0], q).animate(signals=["crank.x", "rod.x"]).html
    ).data()
    assert array(data["signals"][0]["y"]).tolist() == [-32768] * 3
    assert array(data["signals"][1]["y"]).tolist() == [0] * 3


def test_a_notebook_shows_the_page_in_a_frame(slider_crank):
    animation = slider_crank.animate()
    ((tag, about),) = Reader(animation._repr_html_()).tags
    assert tag == "iframe" and about["srcdoc"] == animation.html
    assert "allow-same-origin" not in about["sandbox"]
    assert html.unescape(animation._repr_html_()).count("<iframe") == 1
    assert repr(animation) == "<Animation of SliderCrank: 301 frames, 0 ... 3 s>"


def test_one_name_is_a_list_of_one(slider_crank):
    one = slider_crank.animate(signals="rod.x", traces="rod", arrows="reactions")
    assert one.html == slider_crank.animate(signals=["rod.x"], traces=["rod"], arrows=["reactions"]).html
    with pytest.raises(UsageError, match="there is no frame or joint `rid`"):
        slider_crank.animate(traces="rid")


def test_the_page_is_not_written_over_the_model(tmp_path, trajectory_of):
    from mbdsl import load

    model = tmp_path / "model.html"
    model.write_text("model A Ground ground; PointMass m(m = 1 kg); FreeMotion f(ground, m); end A;")
    trajectory = trajectory_of(load(model), [0.0], {"m": np.zeros((1, 2))})
    with pytest.raises(UsageError, match="it is an input of this command"):
        trajectory.animate(model)
    trajectory.animate(tmp_path / "a.html")
    assert (tmp_path / "a.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


@pytest.mark.parametrize("scripts", [page.SCRIPTS, page.SCRIPTS_IN_SPACE])
def test_scripts_declare_each_name_once(scripts):
    """The files of a page are one script: a second function of a name would replace the first."""
    text = "\n".join((page.HERE / name).read_text(encoding="utf-8") for name in (*scripts, page.MODES))
    names = re.findall(r"^(?:function|class|const|let) (\w+)", text, re.MULTILINE)
    assert len(names) > 50 and len(names) == len(set(names))
