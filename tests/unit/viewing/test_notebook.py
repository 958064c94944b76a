"""Animation and plot in a notebook: their frames run under the content policy of a strict front end."""

import pytest

#: that of the notebooks of VS Code; a frame with `srcdoc` has to satisfy the policy of the page around it, too
POLICY = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; style-src 'unsafe-inline'; img-src https: data:; "
    "font-src https:; connect-src https:; child-src https: data:"
)

#: resolved when the page in the frame has run its script
LOADED = "new Promise((done) => document.readyState === 'complete' ? done(0) : addEventListener('load', () => done(0)))"


@pytest.fixture
def inside(browser, tmp_path):
    """``inside(html, expression)``: values of expressions in the frame of a notebook's cell, and in the notebook."""

    def values(html, *expressions):
        page = tmp_path / "notebook.html"
        policy = f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        page.write_text(f'<!DOCTYPE html><meta charset="utf-8">{policy}<body>{html}</body>', encoding="utf-8")
        browser.open(page, width=1000, height=1000)
        frame = "document.querySelector('iframe')"
        fits = browser.value(f"[{frame}.getBoundingClientRect().right <= innerWidth, scrollX, {frame}.offsetWidth]")
        about = browser.send("Target.getTargets")["targetInfos"]
        (target,) = [found["targetId"] for found in about if found["type"] == "iframe"]
        notebook = browser.session
        browser.session = browser.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        try:
            for domain in ("Runtime", "Log", "Network"):
                browser.send(f"{domain}.enable")
            browser.value(LOADED)
            found = []
            for expression in expressions:
                found.append(browser.value(expression))
                browser.settle()
        finally:
            browser.session = notebook
        assert browser.said == [] and browser.loaded == [page.as_uri()]
        assert fits[:2] == [True, 0]
        return found

    return values


def test_an_animation_runs_in_its_cell(inside, slider_crank):
    """Half of the time bar is t = 1.5 s, where the crank of the slider crank is at 3 rad."""
    scrub = (
        "(() => { const bar = document.getElementById('time'); bar.value = 500000;"
        " bar.dispatchEvent(new Event('input', { bubbles: true })); })()"
    )
    time = "Number(document.getElementById('status').dataset.time)"
    shown = "[...document.querySelectorAll('*')].map((e) => e.childElementCount ? '' : e.textContent).join(' ')"
    _, found, text = inside(slider_crank.animate()._repr_html_(), scrub, time, shown)
    assert found == pytest.approx(1.5, abs=1e-9)
    assert "SliderCrank" in text


def test_a_plot_runs_in_its_cell(inside, slider_crank):
    plot = slider_crank.plot(["crank.phi", "rod.phi", "crank.x"])
    buttons = "[...document.querySelectorAll('.legend button')].map((b) => b.textContent)"
    hidden = "document.querySelector('.legend button').click(), document.querySelectorAll('svg .off').length"
    fits = "document.documentElement.scrollHeight - innerHeight"
    names, off, rest = inside(plot._repr_html_(), buttons, hidden, fits)
    assert names == ["crank.phi", "rod.phi", "crank.x"]
    assert off > 0
    assert rest <= 0  # nothing to scroll
