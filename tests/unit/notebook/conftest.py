"""IPython in this process, and a reader of the tables in HTML."""

import sys
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace

import pytest


class Reader(HTMLParser):
    """Tables as lists of rows of texts, the other texts, and the names of all tags."""

    def __init__(self, text):
        super().__init__()
        self.tables, self.texts, self.tags, self.cell = [], [], set(), None
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        if tag == "table":
            self.tables.append([])
        elif tag == "tr":
            self.tables[-1].append([])
        elif tag in ("th", "td"):
            self.cell = ""

    def handle_endtag(self, tag):
        if tag in ("th", "td"):
            self.tables[-1][-1].append(self.cell)
            self.cell = None

    def handle_data(self, text):
        if self.cell is None:
            self.texts.append(text)
        else:
            self.cell += text


@pytest.fixture(scope="session")
def model_folder():
    return Path(__file__).parents[3] / "models"


@pytest.fixture(scope="session")
def read():
    """``read(html)``: its ``tables``, ``texts`` and ``tags``."""
    return Reader


@pytest.fixture
def shell(monkeypatch, tmp_path):
    """``shell.run(cell)``: success, value and printed text; ``shell.names``: the variables."""
    pytest.importorskip("IPython", reason="IPython is not installed: pip install 'mbdsl[notebook]'")
    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    for name in ("displayhook", "excepthook"):
        monkeypatch.setattr(sys, name, getattr(sys, name))
    monkeypatch.setitem(sys.modules, "__main__", sys.modules["__main__"])
    monkeypatch.chdir(tmp_path)
    from IPython.core.interactiveshell import InteractiveShell
    from IPython.utils.capture import capture_output
    from traitlets.config import Config

    config = Config()
    config.HistoryManager.enabled = False
    ipython = InteractiveShell(config=config)

    def run(cell):
        with capture_output() as printed:
            done = ipython.run_cell(cell, store_history=True)
        return SimpleNamespace(
            success=done.success, value=done.result, error=done.error_in_exec, text=printed.stdout + printed.stderr
        )

    return SimpleNamespace(run=run, names=ipython.user_ns)
