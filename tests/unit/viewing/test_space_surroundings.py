"""Pages of models in space and what is around them: policy, widths, themes, browsers without WebGL, notebooks."""

import numpy as np
import pytest

from mbdsl import parse


def test_nothing_is_loaded_and_the_console_is_silent(browser, arm_page):
    browser.open_small(arm_page, still=False)
    for key in "fmlnd134":
        browser.key(key, ord(key.upper()), key)
    browser.scrub(0.5)
    assert [url for url in browser.loaded if not url.startswith("data:")] == [arm_page.as_uri()]
    assert browser.messages() == []
    # the policy forbids scripts from text
    browser.value("document.body.appendChild(Object.assign(document.createElement('script'), { text: 'run = 1' })); 0")
    browser.settle()
    assert browser.value("window.run === undefined") is True
    assert len(browser.messages()) == 1


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [400, 800, 1400])
def test_widths_and_themes(browser, arm_page, width, scheme):
    """Nothing is wider than the window, buttons do not overlap, and the paper has the colour of the theme."""
    browser.open_small(arm_page, width=width, height=800, scheme=scheme)
    found = browser.value(
        "[document.documentElement.scrollWidth, canvas.clientWidth, canvas.clientHeight,"
        " $('views').getBoundingClientRect().right, $('view').getBoundingClientRect().left]"
    )
    assert found[0] <= width and found[1] >= min(400, width) and found[2] >= 300
    assert found[3] <= found[4]
    browser.value("option('ground', false), 0")
    corner = browser.value(
        "(() => { paint(); const g = document.createElement('canvas').getContext('2d'); g.drawImage(canvas, 0, 0);"
        " return [...g.getImageData(2, 2, 1, 1).data].slice(0, 3); })()"
    )
    assert corner == pytest.approx([255, 255, 255] if scheme == "light" else [0x15, 0x18, 0x1D], abs=1)
    assert browser.messages() == []


def test_without_webgl_there_is_a_picture(browser, arm_page):
    """The projected picture of the start, a message, and plots that follow the time."""
    source = "const own = HTMLCanvasElement.prototype.getContext;"
    source += " HTMLCanvasElement.prototype.getContext = function (kind)"
    source += " { return kind.startsWith('webgl') ? null : own.apply(this, arguments); };"
    script = browser.send("Page.addScriptToEvaluateOnNewDocument", source=source)
    try:
        browser.open_small(arm_page)
        browser.scrub(0.5)
        assert browser.state()["time"] == pytest.approx(2.0)
        text, paths, width = browser.value(
            "[$('still').textContent, document.querySelectorAll('#still svg path').length,"
            " document.querySelector('#still svg').getBoundingClientRect().width]"
        )
        assert "WebGL" in text and paths > 0 and width > 300
        assert float(browser.value("plots.charts.length")) > 0
        browser.key("+", 187, "+")
        browser.key("4", 52, "4")
        assert browser.messages() == []
    finally:
        browser.send("Page.removeScriptToEvaluateOnNewDocument", identifier=script["identifier"])


def test_a_long_chain_needs_few_calls(browser, trajectory_of, tmp_path):
    """150 links are drawn by as many calls as 50: each geometry is one instanced mesh, for the picture and shadows."""

    def calls(count):
        text = f"""spatial model A Ground ground; for i in 1:{count} loop Rod link[i](m = 1 kg, length = 1 m); end for;
          Spherical first(ground, link[1].a);
          for i in 2:{count} loop Spherical pin[i](link[i - 1].b, link[i].a); end for; end A;"""
        t = np.array([0.0, 1.0])
        states = {f"link[{k + 1}]": np.column_stack([[k + 0.5] * 2, t, *[0 * t] * 4]) for k in range(count)}
        trajectory_of(parse(text), t, states).animate(tmp_path / "page.html", signals="link[1].x")
        browser.open_small(tmp_path / "page.html")
        browser.scrub(1.0)
        assert browser.value(f"painter.solids.tracks[{count - 1}].elements")[12:15] == pytest.approx(
            [count - 0.5, 1.0, 0.0], rel=1e-4
        )
        browser.value("option('frames', false), paint(), 0")
        return browser.value("painter.renderer.info.render.calls")

    few, many = calls(50), calls(150)
    assert many <= few < 20  # few solids have edges, by one call each


def test_a_notebook_shows_the_page(browser, arm_in_space, tmp_path):
    """The page works in a sandboxed frame of a notebook with the policy of its front end."""
    policy = "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; img-src data:"
    (tmp_path / "notebook.html").write_text(
        f'<!DOCTYPE html><meta charset="utf-8"><meta http-equiv="Content-Security-Policy" content="{policy}">'
        f"<body>{arm_in_space.animate()._repr_html_()}</body>",
        encoding="utf-8",
    )
    browser.open(tmp_path / "notebook.html")
    (target,) = [x["targetId"] for x in browser.send("Target.getTargets")["targetInfos"] if x["type"] == "iframe"]
    notebook = browser.session
    browser.session = browser.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
    try:
        browser.send("Runtime.enable")
        assert browser.value("drawable && painter.renderer.info.render.frame > 0") is True
    finally:
        browser.session = notebook
    assert browser.messages() == []
