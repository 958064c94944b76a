"""Backends on models in space: their motion agrees with published solutions and with dop853 to the tolerance."""

import json
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import integrators
from mbdsl.errors import UsageError
from mbdsl.integrators import available, method_files

ROOT = Path(__file__).parents[2]
SPACE = ROOT / "models" / "space"
REFERENCE = ROOT / "tests" / "data" / "reference"
BACKENDS = ("scipy-dop853", "scipy-radau", "scipy-lsoda", "ida")
TOL = 1e-4


def test_all_serve_space():
    assert set(BACKENDS) <= set(available(spatial=True))


@pytest.mark.parametrize("method", BACKENDS)
def test_heavy_top(method):
    """15 rad of spin. ``chance``: error estimates of backends are rough, because their orders vary from run to run."""
    values = json.loads((REFERENCE / "heavy_top.json").read_text(encoding="utf-8"))["values"]
    x, p, w = (np.array(values[key], float) for key in ("x_com", "quat_wxyz", "Omega_body"))
    t = mbdsl.simulate(SPACE / "heavy_top.mbd", method=method, tol=TOL, stop=0.1, interval=0.02)
    found, chance = np.array([t[f"top.p{k}"][-1] for k in range(4)]), 3.0
    assert 2 * min(np.abs(found - p).max(), np.abs(found + p).max()) < chance * TOL
    assert max(abs(t[f"top.{key}"][-1] - value) for key, value in zip("xyz", x, strict=True)) < chance * TOL
    assert np.abs(t.v[-1, 3:] - w).max() < chance * TOL * 150.0
    # constraints hold to rounding of the size 1 m and of velocities of 150 m/s
    assert max(np.abs(t[f"ball.Phi[{k}]"]).max() for k in (1, 2, 3)) < 1e-14
    assert max(np.abs(t[f"ball.dPhi[{k}]"]).max() for k in (1, 2, 3)) < 1e-11


@pytest.mark.parametrize("method", BACKENDS)
def test_bricard(method):
    """30 rows of rank 29."""
    expected = json.loads((REFERENCE / "bricard.json").read_text(encoding="utf-8"))["P3"]["1"]
    t = mbdsl.simulate(SPACE / "bricard.mbd", method=method, tol=TOL, stop=1.0, interval=0.5)
    assert [t[f"rod3.b.{key}"][-1] for key in "xyz"] == pytest.approx([float(x) for x in expected], abs=TOL)


@pytest.mark.parametrize("method", BACKENDS)
def test_spatial_slider_crank(method):
    """Haug's, driven, without its reduction to kinematics. The slider's path in closed form."""
    given = {"stop": 0.25, "interval": 0.05, "general": True}
    t = mbdsl.simulate(SPACE / "haug_slider_crank.mbd", method=method, tol=TOL, **given)
    psi = np.pi / 2 - 2 * np.pi * t.t
    path = np.sqrt(0.09 - (0.1 + 0.08 * np.cos(psi)) ** 2 - (0.12 + 0.08 * np.sin(psi)) ** 2)
    np.testing.assert_allclose(t["slider.x"], path, atol=1e-12)
    other = mbdsl.simulate(SPACE / "haug_slider_crank.mbd", method="dop853", tol=1e-9, **given)
    for key in "xyz":
        np.testing.assert_allclose(t[f"rod.{key}"], other[f"rod.{key}"], atol=TOL)
        np.testing.assert_allclose(t[f"rod.w{key}"], other[f"rod.w{key}"], atol=TOL * 2 * np.pi)


@pytest.mark.parametrize("method", BACKENDS)
def test_turns(method):
    """phi = w0/w sin(w t), 1.6 turns of a torsional spring about a tilted axis."""
    text = """spatial model Wound
      Ground ground(g = 0);
      Body wheel(m = 1 kg, I = {1, 1, 1} kg.m2);
      Revolute hinge(ground, wheel.c, n = {1, 2, 2});
      RotationalSpringDamper spring(ground, wheel.c, n = {1, 2, 2}, k = 0.01 N.m/rad);
    initial equation
      hinge.w = 10 rad/s;
    end Wound;"""
    t = mbdsl.simulate(mbdsl.parse(text), method=method, tol=TOL, stop=1.0, interval=0.25, general=True)
    np.testing.assert_allclose(t["hinge.phi"], 100 * np.sin(0.1 * t.t), atol=3 * TOL)


class OfThePlane:
    """A backend that does not say that it serves space."""

    METHOD = mbdsl.integrators.Method(
        "of-the-plane", doc="none", order=1, index=1, enforces=(), source="none", own_reactions=False
    )

    @staticmethod
    def solve(problem):
        yield problem.stop, problem.q, problem.v


def test_backends_that_do_not_declare_space(monkeypatch):
    monkeypatch.setitem(integrators._given, "of-the-plane", OfThePlane)
    assert "of-the-plane" in available() and "of-the-plane" not in available(spatial=True)
    with pytest.raises(UsageError, match="not available for models in space"):
        mbdsl.simulate(SPACE / "heavy_top.mbd", method="of-the-plane", step=1e-3, stop=0.1)


def test_backend_of_a_file(tmp_path, monkeypatch):
    """The example of docs/backends.md: order 4 on the top, with quaternions."""
    page = (ROOT / "docs" / "backends.md").read_text(encoding="utf-8")
    text = next(block for block in page.split("```")[1::2] if '"""rk4.py"""' in block)
    (tmp_path / "rk4.py").write_text(text.removeprefix("python\n"), encoding="utf-8")
    monkeypatch.setattr(method_files, "_modules", {})
    monkeypatch.setattr(integrators, "_given", dict(integrators._given))
    name = method_files.load(str(tmp_path / "rk4.py"))
    x = json.loads((REFERENCE / "heavy_top.json").read_text(encoding="utf-8"))["values"]["x_com"]
    errors = []
    for h in (2e-3, 1e-3):
        t = mbdsl.simulate(SPACE / "heavy_top.mbd", method=name, step=h, stop=0.1, interval=0.1)
        errors.append(max(abs(t[f"top.{key}"][-1] - float(value)) for key, value in zip("xyz", x, strict=True)))
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.5)  # the next term, at 0.3 rad a step


def test_compiled_method_of_a_file(tmp_path, monkeypatch):
    """The text of a shipped method under another name: the same bits."""
    source = (ROOT / "mbdsl" / "integrators" / "methods" / "newmark.py").read_text(encoding="utf-8")
    (tmp_path / "own.py").write_text(source.replace('"newmark"', '"own"'), encoding="utf-8")
    monkeypatch.setattr(method_files, "_modules", {})
    name = method_files.load(str(tmp_path / "own.py"))
    try:
        mine, shipped = (
            mbdsl.simulate(SPACE / "heavy_top.mbd", method=m, step=1e-3, stop=0.01) for m in (name, "newmark")
        )
    finally:
        integrators.modules().pop(name)
    assert np.array_equal(mine.q, shipped.q) and np.array_equal(mine.v, shipped.v)
