"""Texts about guesses that the assembly has changed."""

import pytest

from mbdsl.initial.consistent import Moved
from mbdsl.initial.start_check import check_start
from mbdsl.lang.load import parse_text
from mbdsl.mechanism.graph import build
from mbdsl.messages import DisplayUnit

TEXT = """model M
  Ground ground;
  Body chassis(m = 1 kg, I = 1 kg.m2);
  Prismatic rail(ground, chassis.c);
  Distance d(ground, chassis.c, length = {} m);
initial equation
  guess chassis.x = 0.5 m;
end M;
"""


@pytest.mark.parametrize("length", ["0.50000002", "0.500001", "0.5001"])
def test_a_small_change_is_visible(length):
    line, _size = check_start(build(parse_text(TEXT.format(length))))
    assert line.endswith(f"1 guess moved: chassis.x from 0.5 m to {length} m")


@pytest.mark.parametrize("digits", [4, 9])
@pytest.mark.parametrize("change", [1e-16, 1e-12, 1e-6, 0.5])
def test_both_texts_differ(digits, change):
    guess, value = Moved("x", 1.0, 1.0 + 2.0 * change, DisplayUnit("deg", 0.1)).texts(digits)
    assert guess != value
