"""Positions of numbers on an axis, and the labels of its ticks."""

import math

import pytest

from mbdsl.plotting.axes import axis, limits, number


def labels(a):
    return [label for _, label in a.ticks]


def values(a):
    """The values of the ticks, recovered from their positions."""
    ends = a.low, a.high
    read = [ends[0] + p * (ends[1] - ends[0]) for p, _ in a.ticks]
    return [10.0**v for v in read] if a.log else read


def test_decades_have_labels_and_what_is_between_them_minor_ticks():
    a = axis(*limits([1e-4, 1.0], True), True)
    assert labels(a) == ["10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "10⁰"]
    assert values(a) == pytest.approx([1e-4, 1e-3, 1e-2, 1e-1, 1.0], rel=1e-12)
    at_2e_3 = (math.log10(2e-3) - a.low) / (a.high - a.low)
    assert any(p == pytest.approx(at_2e_3, abs=1e-12) for p in a.minor)


def test_many_decades_have_fewer_labels():
    a = axis(*limits([1e-30, 1e3], True), True, 7)
    assert 3 <= len(a.ticks) <= 7
    assert len(a.ticks) + len(a.minor) == 36  # 10^-31 to 10^4: the padding is more than a decade


@pytest.mark.parametrize("ends", [(1.2e-3, 1.3e-3), (0.4, 0.7), (2.0, 9.0), (1.0, 1.0 + 1e-6), (3e-7, 3e-7)])
def test_less_than_a_decade_still_has_labels_that_tell(ends):
    a = axis(*limits(ends, True), True)
    assert len(set(labels(a))) >= 2
    for value, label in zip(values(a), labels(a), strict=True):
        if not a.scale:
            assert read(label) == pytest.approx(value, rel=1e-6)


@pytest.mark.parametrize(
    "ends", [(0.0, 10.0), (-3e-4, 3e-4), (0.0, 1.7e9), (1.0, 1.0 + 1e-9), (-5.0, -5.0), (0.0, 0.0), (1e-280, 2e-280)]
)
def test_linear_labels_with_their_scale_are_the_numbers(ends):
    a = axis(*limits(ends, False), False)
    assert 2 <= len(a.ticks) <= 9
    assert len(set(labels(a))) == len(a.ticks)
    factor, _, offset = a.scale.partition("+" if "+" in a.scale else " − ")
    factor = read(factor.removeprefix("× ").strip()) if factor.strip() else 1.0
    offset = read(offset.strip()) * (-1.0 if "−" in a.scale else 1.0) if offset else 0.0
    for value, label in zip(values(a), labels(a), strict=True):
        assert read(label) * factor + offset == pytest.approx(value, abs=1e-9 * (a.high - a.low), rel=1e-12)
        assert len(label) <= 8


def read(text):
    """The number that a label shows."""
    usual = text.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹−", "-0123456789-"))
    if "·10" in usual:
        return float(usual.replace("·10", "e"))
    return 10.0 ** int(usual[2:]) if any(c in text for c in "⁰¹²³⁴⁵⁶⁷⁸⁹") else float(usual)


@pytest.mark.parametrize("value", [0.0125, 1.25e-7, -3.0, 1e-9, 12345.0, -2.5e20])
def test_numbers_read_back(value):
    assert read(number(value)) == pytest.approx(value, rel=1e-9)


def test_what_has_no_place():
    a = axis(*limits([1.0, 100.0], True), True)
    assert a.place(10.0) == pytest.approx(0.5)
    assert all(math.isnan(a.place(v)) for v in (0.0, -1.0, math.nan, math.inf, 1e301))


@pytest.mark.parametrize("log", [False, True])
@pytest.mark.parametrize("given", [[], [math.nan], [math.inf, -math.inf], [0.0], [5e-324], [-1e-320, 1e299, 1e-320]])
def test_limits_are_never_empty(given, log):
    low, high = limits(given, log)
    assert low < high
    assert len(axis(low, high, log).ticks) >= 2
