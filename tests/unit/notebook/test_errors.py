"""Errors in IPython: one message, the line that caused it, and no traceback."""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import Interrupted, Span
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.system.system import build

SPAN = Span("a.mbd", 2, 3, 4, "  rodd x;")


def test_a_cell_shows_the_message_and_the_line(shell):
    done = shell.run("import mbdsl\nx = 1\nmbdsl.simulate('none.mbd')\n")
    assert done.text.splitlines() == [
        "UsageError: there is no file `none.mbd`",
        "line 3 of the cell: mbdsl.simulate('none.mbd')",
    ]
    assert shell.run("mbdsl.simulate('none.mbd')").text.splitlines() == ["UsageError: there is no file `none.mbd`"]


def test_a_function_of_a_file_is_named_with_its_line(shell, tmp_path, monkeypatch):
    file = tmp_path / "helper_of_test.py"
    file.write_text("import mbdsl\n\n\ndef go():\n    return mbdsl.load('none.mbd')\n")
    monkeypatch.syspath_prepend(tmp_path)
    text = shell.run("import helper_of_test\nhelper_of_test.go()").text
    assert text.splitlines()[1:] == [f"{file}:5: return mbdsl.load('none.mbd')"]


def test_other_errors_keep_their_traceback(shell):
    done = shell.run("import mbdsl\nmbdsl.simulate(nothing=1)")
    assert "Traceback" in done.text and "TypeError" in done.text


def test_an_interruption_names_its_results(shell):
    system = build(mbdsl.parse("model A Ground g; PointMass m(m = 1 kg); FreeMotion f(g, m); end A;"))
    zero = np.zeros((3, 2))
    run = Trajectory(system, np.arange(3.0), zero, zero, None, {"status": "interrupted"})
    shell.names["problem"] = Interrupted(run)
    text = shell.run("raise problem").text
    assert text.splitlines()[:2] == [
        "interrupted at t = 2 s",
        "  = `sys.last_value.trajectory` holds the results up to then",
    ]
    assert shell.run("import sys\nsys.last_value.trajectory").value is run


@pytest.mark.parametrize("kind", [mbdsl.UsageError, mbdsl.ModelError, mbdsl.IntegrationError])
def test_no_word_is_doubled(kind):
    """Python writes the name of the class before ``str``; the command line prints ``render``."""
    assert str(kind("no.", hint="yes")) == "no.\n  = yes"
    assert kind("no.", hint="yes").render() == "error: no.\n  = yes"
    assert str(kind("no.", SPAN)) == "a.mbd:2:3: no.\n      rodd x;\n      ^^^^"
    assert kind("no.", SPAN).render() == "a.mbd:2:3: error: no.\n      rodd x;\n      ^^^^"


def test_an_error_as_a_value_is_its_text(read):
    shown = read(mbdsl.ModelError("`<b>` & more", SPAN, "<i>")._repr_html_())
    assert shown.tags == {"pre"}
    assert "".join(shown.texts) == mbdsl.ModelError("`<b>` & more", SPAN, "<i>").render()
