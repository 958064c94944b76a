"""The picture of the velocity constraints is drawn, and of what the other tests find."""

import importlib.util
from pathlib import Path

import pytest

from mbdsl.integrators import methods


def test_limit_cycles(tmp_path):
    pytest.importorskip("matplotlib", reason="matplotlib is not installed: pip install 'mbdsl[plot]'")
    spec = importlib.util.spec_from_file_location("plots", Path(__file__).with_name("plots.py"))
    plots = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(plots)
    largest = plots.limit_cycles(tmp_path / "picture.png", steps=(2.0**-6, 2.0**-7), stop=2.0)
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
    assert set(largest) == set(methods())
    for name, sizes in largest.items():
        if name in plots.INDEX3:
            assert 1.0 > sizes[0] > 1.4 * sizes[1] > 1e-6
        else:
            assert sizes[0] < 1e-10
