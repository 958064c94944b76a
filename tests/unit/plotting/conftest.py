"""A page as a study makes one: all elements that can be on it, with realistic numbers."""

import math

import pytest

from mbdsl.plotting.figures import Figure, Outcome, Page, Series, TextTable

MODEL = "model Pendulum\n  parameter m = 1 kg\n" + "\n".join(f"  // line {k}: a < b && c > d" for k in range(60))
SPEEDS = {
    "newmark": (2, 3e-3, 0.3),
    "hht-i3": (2, 4e-3, 0.2),
    "nstiff": (2, 6e-3, 0.4),
    "hht-si2": (2, 5e-3, 0.1),
    "hht-add": (2, 5.5e-3, 0.15),
    "nstiff-si2": (2, 8e-3, 0.3),
    "radau5": (5, 2e-2, 2.0),
    "scipy-dop853": (8, 9e-2, 8.0),
    "ida": (4, 5e-2, 3.0),
    "Exudyn": (2, 6e-2, 0.2),
}


def work_precision():
    series = []
    for name, (order, first, size) in SPEEDS.items():
        times = [first * 2.0**k for k in range(9)]
        errors = [size * 1e-2 * 2.0 ** (-order * k) * (1.0 + 0.2 * math.sin(3 * k)) for k in range(9)]
        kept = [(t, e) for t, e in zip(times, errors, strict=True) if e > 2e-12]
        x, y = zip(*kept, strict=True)
        hover = [f"h = 2^-{7 + k} s, {2 ** (7 + k)} steps, {3 * 2 ** (7 + k)} iterations" for k in range(len(x))]
        series.append(Series(name, x, y, [0.8 * e for e in y], [1.4 * e for e in y], hover))
    points = sorted((t, e) for s in series for t, e in zip(s.x, s.y, strict=True))
    front = [p for k, p in enumerate(points) if all(p[1] < q[1] for q in points[:k])]
    t = [3e-3, 30.0]
    return Figure(
        "work-precision",
        "Seven body mechanism: error of the positions against run time",
        "run time, median of 7 [s]",
        "scaled error in q",
        [
            Series("Pareto front", *zip(*front, strict=True), style="front"),
            Series("order 2", t, [1e-2, 1e-2 * (t[0] / t[1]) ** 2], style="guide"),
            Series("order 5", t, [1.0, (t[0] / t[1]) ** 5], style="guide"),
            *series,
        ],
        outcomes=[
            Outcome("nstiff", 6e-3, "diverged at t = 0.0123 s, h = 2^-6 s"),
            Outcome("scipy-radau", None, "not installed: pip install 'mbdsl[backends]'"),
            Outcome("hht-add", 2.7e-3, "refused: too stiff for it"),
            Outcome("hht-add", 5.5e-3, "refused: too stiff for it"),
        ],
        floors=[(1e-12, "below 10⁻¹² the reference is not trusted")],
        note="Lower left is better. Bars are the quartiles of the seven repeats.",
    )


def drift(count=2000):
    angles = [2.0 * math.pi * 7.03 * k / count for k in range(count)]
    series = [
        Series(
            f"hht-i3, h = 2^-{8 + j} s",
            [4.0**-j * 3e-4 * math.cos(a) * (1.0 + 0.1 * math.sin(a / 7)) for a in angles],
            [4.0**-j * 2e-4 * math.sin(2 * a) * (1.0 + 0.1 * math.cos(a / 9)) for a in angles],
            style="line",
        )
        for j in range(3)
    ]
    dots = [1e-5 * math.sin(k * k) for k in range(400)], [1e-5 * math.cos(3.3 * k * k) for k in range(400)]
    series.append(Series("hht-si2, h = 2^-8 s", *dots, style="marks"))
    return Figure(
        "drift",
        "Velocity constraint of the fixed pin, over 10 s",
        "O.dPhi[1] [m/s]",
        "O.dPhi[2] [m/s]",
        series,
        x_log=False,
        y_log=False,
        equal=True,
    )


def energy(count=3000):
    times = [10.0 * k / (count - 1) for k in range(count)]
    fall = {"hht-i3": 0.02, "nstiff": 0.05, "newmark": 0.0}
    series = [
        Series(
            name,
            times,
            [
                math.nan if 4.0 < t < 4.4 else 12.0 - 12.0 * (1 - math.exp(-c * t)) + 0.1 * math.sin(9 * t)
                for t in times
            ],
            [11.8 - 12.0 * (1 - math.exp(-c * t)) for t in times] if c == 0.05 else None,
            [12.2 - 12.0 * (1 - math.exp(-c * t)) for t in times] if c == 0.05 else None,
            style="line",
        )
        for name, c in fall.items()
    ]
    return Figure("energy", "Total energy", "time [s]", "energy [J]", series, x_log=False, y_log=False)


def sample():
    times = TextTable(
        "Cheapest for each error",
        ["error", "method", "h or tol", "time [s]", "spread", "factor"],
        [
            ["1e-3", "hht-i3", "2^-7 s", "0.0040", "± 2 %", "15.2"],
            ["1e-6", "hht-si2", "2^-11 s", "0.0812", "± 3 %", "11.7"],
            ["1e-10", "radau5", "1e-9", "0.3201", "± 1 %", "–"],
            ["1e-12", "none", "", "failed", "", ""],
        ],
        "Factor: the time of Exudyn at the same error over this one.",
    )
    slopes = TextTable(
        "Fitted slopes",
        ["method", "q", "v", "range of h [s]"],
        [
            ["hht-i3", "2.01 ± 0.02", "1.98 ± 0.03", "2^-13 … 2^-8"],
            ["radau5", "5.03 ± 0.1", "4.9 ± 0.2", "2^-9 … 2^-6"],
        ],
    )
    return Page(
        "What accuracy costs in time: seven body mechanism",
        ["Each method was run at nine steps, one after the other, seven times.", "The reference has 12 digits."],
        [work_precision(), times, drift(), slopes, energy()],
        [
            ("mbdsl", "0.1.0"),
            ("machine", "2 cores of Example CPU at 2.5 GHz"),
            ("command", "mbdsl study work-precision models/seven_body.mbd --methods all --repeats 7"),
            ("model", MODEL),
        ],
    )


@pytest.fixture(name="work_precision")
def _work_precision():
    return work_precision()


@pytest.fixture(name="drift")
def _drift():
    return drift()


@pytest.fixture(name="energy")
def _energy():
    return energy()


@pytest.fixture(name="page", scope="session")
def _page():
    return sample()
