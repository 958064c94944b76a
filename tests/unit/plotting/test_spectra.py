"""Amplitude spectra against closed forms."""

import tracemalloc

import numpy as np
import pytest

from mbdsl.errors import UsageError
from mbdsl.plotting.spectra import LONGEST, amplitudes, spectrum
from mbdsl.results.stored import of_columns

#: relative loss of a peak halfway between two frequencies of a transform that is padded to 8 and 4 times the length:
#: 1 - W(1/16) and 1 - W(1/8), W(x) = sinc(x)/(1 - x^2) the transform of the Hann window
LOSS_8, LOSS_4 = (1.0 - np.sinc(x) / (1.0 - x**2) for x in (1 / 16, 1 / 8))


def within(found, amplitude, *losses):
    """Whether a peak lies below the amplitude by no more than these losses, but for leakage of 1e-5."""
    return (1.0 - sum(losses) - 1e-5) * amplitude <= found <= (1.0 + 1e-5) * amplitude


def chords(w, h):
    """Relative loss of a sine that is interpolated linearly over intervals h, w h small: (w h)^2/12."""
    return (w * h) ** 2 / 12.0


def result(**columns):
    columns = {name.replace("_", "."): np.asarray(x) for name, x in columns.items()}
    return of_columns("r.csv", list(columns), lambda name: "", columns.__getitem__)


@pytest.mark.parametrize("frequency", [3.0, 3.07, 12.5])
def test_a_sine_shows_its_amplitude_at_its_frequency(frequency):
    t = np.arange(2000) * 0.01
    s = spectrum(result(time=t, a_x=5.0 + 0.3 * np.sin(2.0 * np.pi * frequency * t + 0.4)), "a.x")
    k = s.amplitude.argmax()
    assert abs(s.frequency[k] - frequency) <= 0.5 / (8.0 * 20.0)  # half the spacing of the frequencies
    assert within(s.amplitude[k], 0.3, LOSS_8)
    assert s.frequency[-1] == pytest.approx(50.0)  # half the sampling frequency
    assert s.amplitude[0] < 0.3 / (np.pi * 20.0 * frequency) + 1e-12  # without the mean of 5: at most that of the sine
    assert (s.segments, s.resampled) == (1, "")


def test_two_sines_and_the_shape_of_the_window():
    """A Hann window has the amplitude 1/2 at one line beside the peak, and zero at two."""
    n = 4000
    t = np.arange(n) / 400.0
    y = np.sin(2.0 * np.pi * 20.0 * t) + 0.01 * np.cos(2.0 * np.pi * 80.0 * t)
    found, _ = amplitudes([y[:1500], y[1500:]])
    line = 8 * 10  # a frequency of 1 Hz: ten lines, each eight points of the padded transform
    assert found[20 * line] == pytest.approx(1.0, abs=1e-6)
    assert found[20 * line + 8] == pytest.approx(0.5, abs=1e-4)
    assert found[20 * line + 16] == pytest.approx(0.0, abs=1e-4)
    assert found[80 * line] == pytest.approx(0.01, abs=1e-5)


def test_non_uniform_times_are_resampled():
    k = np.arange(3000) / 3000.0
    t = 30.0 * (k + 0.02 * np.sin(2.0 * np.pi * k))
    w = 2.0 * np.pi * 2.0
    columns = dict(time=t, a_x=0.7 * np.sin(w * t), a_vx=0.7 * w * np.cos(w * t), a_f=0.7 * np.sin(w * t))
    for name, how, loss in (("a.x", "cubically", 0.0), ("a.f", "linearly", chords(w, np.diff(t).max()))):
        s = spectrum(result(**columns), name)
        assert s.resampled == how
        assert within(s.amplitude.max(), 0.7, LOSS_8, loss)
        assert abs(s.frequency[s.amplitude.argmax()] - 2.0) <= 0.5 / (8.0 * 30.0)


def test_long_signals_are_divided_into_segments():
    """The mean of the squares: a sine keeps its amplitude."""
    n = 4 * LONGEST
    y = 2.0 * np.sin(2.0 * np.pi * 0.01234567 * np.arange(n))
    found, segments = amplitudes(np.array_split(y, 50))
    assert segments == 7
    assert within(found.max(), 2.0, LOSS_4)
    assert found.argmax() / (2.0 * (len(found) - 1)) == pytest.approx(0.01234567, rel=1e-4)


def test_no_spectrum():
    t = np.arange(20) * 0.1
    gap = np.where(t == t[3], np.nan, t)
    with pytest.raises(UsageError, match="not finite"):
        spectrum(result(time=t, a_x=gap), "a.x")
    with pytest.raises(UsageError, match="5 rows: a spectrum needs at least 8"):
        spectrum(result(time=t[:5], a_x=t[:5]), "a.x")
    with pytest.raises(UsageError, match="do not ascend"):
        spectrum(result(time=np.where(t > 1.0, t - 0.5, t), a_x=t), "a.x")


def test_long_results_need_little_memory():
    """Read and resampled in parts: the same as that of the whole signal, with a fraction of its memory."""
    n = 3 * LONGEST
    k = np.arange(n) / n
    t = 1000.0 + 700.0 * (k + 0.05 * k**2)
    y = 0.7 * np.sin(2.0 * np.pi * 30.0 * t)
    tracemalloc.start()
    s = spectrum(result(time=t, a_f=y), "a.f")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert (s.segments, s.resampled) == (5, "linearly")
    assert within(s.amplitude.max(), 0.7, LOSS_4, chords(2.0 * np.pi * 30.0, np.diff(t).max()))
    assert abs(s.frequency[s.amplitude.argmax()] - 30.0) <= 0.5 * s.frequency[1]
    assert peak < 10 * 8 * 4 * LONGEST


@pytest.mark.parametrize("start", [0.0, 1e3, 1e6])
def test_rounded_times_are_uniform(start):
    t = start + np.arange(300_000) * 1e-3
    assert spectrum(result(time=t, a_x=np.sin(t)), "a.x").resampled == ""
    t[200_000:] += 1e-4
    assert spectrum(result(time=t, a_x=np.sin(t)), "a.x").resampled == "linearly"
