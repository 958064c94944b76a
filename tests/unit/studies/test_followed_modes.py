"""Modes followed along sweeps, against closed forms of frequencies that cross and that veer from each other."""

import numpy as np
import pytest

import mbdsl

PAIR = """model Pair
  parameter Real k(unit = "N/m") = 100 N/m;
  parameter Real link(unit = "N/m") = 0 N/m;
  parameter Real c(unit = "N.s/m") = 0 N.s/m;
  Ground ground(g = 0);
  Body a(m = 1 kg, I = 1 kg.m2);
  Body b(m = 1 kg, I = 1 kg.m2);
  Prismatic rail_a(ground, a.c);
  Prismatic rail_b(ground, b.c);
  TranslationalSpringDamper spring_a(rail_a, k = 100 N/m);
  TranslationalSpringDamper spring_b(rail_b, k = k, c = c);
  TranslationalSpringDamper between(a.c, b.c, k = link);
end Pair;"""


def swept(tmp_path, vary, measures, **given):
    return mbdsl.sweep(mbdsl.parse(PAIR), vary, measures, store=tmp_path, workers=1, **given)


def hertz(k):
    return np.sqrt(k) / (2.0 * np.pi)


@pytest.mark.parametrize("values", ["50:150:6", "50:150:11"])
def test_frequencies_that_cross(tmp_path, values):
    """Two oscillators without a connection: one frequency is constant, also where both are equal (k = 100 N/m)."""
    found = swept(tmp_path, {"k": f"{values} N/m"}, "frequency(1), frequency(2), damping(1)", parameters={"c": 1.0})
    assert found["frequency(1)"] == pytest.approx(hertz(found["k"]), rel=1e-9)
    assert found["frequency(2)"] == pytest.approx(hertz(100.0), rel=1e-9)
    assert found["damping(1)"] == pytest.approx(0.5 / np.sqrt(found["k"]), rel=1e-9)
    assert any("mode 1 is mode 2 by frequency" in note for note in found.notes)
    assert not any("not certain" in note for note in found.notes)
    assert "followed by their shapes" in found.text()


def test_degenerate_first_point(tmp_path):
    found = swept(tmp_path, {"k": "100:150:3 N/m"}, "frequency(1), frequency(2)")
    assert found["frequency(1)"] == pytest.approx(hertz(100.0), rel=1e-9)
    assert found["frequency(2)"] == pytest.approx(hertz(found["k"]), rel=1e-9)


@pytest.mark.parametrize("points", [4, 21])
def test_frequencies_that_veer(tmp_path, points):
    """A weak spring between the oscillators: the squares are the eigenvalues of [[100 + l, -l], [-l, k + l]], and do
    not cross, whatever the distance of the points is."""
    found = swept(tmp_path, {"k": f"50:150:{points} N/m"}, "frequency(1), frequency(2)", parameters={"link": 2.0})
    expected = np.array([np.linalg.eigvalsh([[102.0, -2.0], [-2.0, k + 2.0]]) for k in found["k"]])
    for j in range(2):
        assert found[f"frequency({j + 1})"] == pytest.approx(hertz(expected[:, j]), rel=1e-9)
    assert not found.notes


def test_two_parameters(tmp_path):
    """The order is that of the first point on the whole grid."""
    found = swept(tmp_path, {"k": "50:150:4 N/m", "c": "0, 0.5 N.s/m"}, "frequency(1)")
    assert found["frequency(1)"] == pytest.approx(hertz(found["k"]), rel=1e-9)


def test_curves_do_not_depend_on_the_other_values(tmp_path):
    """Without the spring between them frequencies cross, with it they veer: each curve is followed by itself."""
    found = swept(tmp_path, {"k": "50:150:4 N/m", "link": "0, 2 N/m"}, "frequency(1), frequency(2)")
    veer = found["link"] == 2.0
    expected = np.array([np.linalg.eigvalsh([[102.0, -2.0], [-2.0, k + 2.0]]) for k in found["k"][veer]])
    for j in range(2):
        assert found[f"frequency({j + 1})"][veer] == pytest.approx(hertz(expected[:, j]), rel=1e-9)
    assert found["frequency(2)"][~veer] == pytest.approx(hertz(100.0), rel=1e-9)


def test_paired_parameters(tmp_path):
    found = swept(tmp_path, {"k": "50:150:4 N/m", "c": "0:0.6:4 N.s/m"}, "frequency(1)", paired=True)
    assert found["frequency(1)"] == pytest.approx(hertz(found["k"]), rel=1e-9)


def test_uncertain_order(tmp_path):
    """Values that are texts have none between them: the shapes of strongly linked oscillators change too much."""
    text = PAIR.replace("k = k, c = c", "k = if stiff then 1e4 N/m else 1 N/m, c = c")
    text = text.replace("parameter Real c", "parameter Boolean stiff = false;\n  parameter Real c")
    found = mbdsl.sweep(
        mbdsl.parse(text),
        {"stiff": [False, True]},
        "frequency(1)",
        parameters={"link": 100.0},
        store=tmp_path,
        workers=1,
    )
    assert any("not certain at stiff = true" in note for note in found.notes)


def test_decays_with_one_shape(tmp_path):
    """Beyond critical damping one oscillator has two real eigenvalues, -d +- sqrt(d^2 - k), with the same shape."""
    found = swept(tmp_path, {"c": "30:60:4 N.s/m"}, "frequency(1), frequency(3)")
    d = found["c"] / 2.0
    assert found["frequency(1)"] == pytest.approx((d - np.sqrt(d * d - 100.0)) / (2.0 * np.pi), rel=1e-9)
    assert found["frequency(3)"] == pytest.approx((d + np.sqrt(d * d - 100.0)) / (2.0 * np.pi), rel=1e-9)
    assert not found.notes
