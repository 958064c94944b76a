"""The tables of docs/paper.md, made of numbers.json.

In the page they stand between ``<!-- name -->`` and ``<!-- end -->``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Sequence

import numpy as np

MARKED = re.compile(r"(<!-- (?!end)(.+?) -->\n).*?(<!-- end -->)", re.DOTALL)
BLOCKS: dict[str, Callable[[dict], str]] = {}


def block(function: Callable[[dict], str]) -> Callable[[dict], str]:
    """What stands between the marks that have the function's name, with spaces."""
    BLOCKS[function.__name__.replace("_", " ")] = function
    return function


def filled(text: str, numbers: dict) -> str:
    """The page with all of its tables made anew."""
    return MARKED.sub(lambda m: f"{m[1]}\n{BLOCKS[m[2]](numbers)}\n\n{m[3]}", text)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def short(x: float) -> str:
    """Two digits: 8.4e-5."""
    mantissa, exponent = f"{x:.1e}".split("e")
    return f"{mantissa}e{int(exponent)}"


def step(label: str) -> float:
    """[s] of "2^-8" or "0.03*2^-8"."""
    unit, _, power = label.rpartition("*")
    return float(unit or 1.0) * 2.0 ** float(power.removeprefix("2^"))


def shown(label: str) -> str:
    """ "2^-8 s", or "30 ms/2^8"."""
    unit, _, power = label.rpartition("*")
    return f"{power} s" if not unit else f"{1e3 * float(unit):g} ms/{power.replace('-', '')}"


def slope(row: dict[str, float], first: str, last: str) -> float:
    """Of the straight line through the logarithms, over the steps from ``first`` to ``last``."""
    labels = list(row)
    within = labels[labels.index(first) : labels.index(last) + 1]
    return float(np.polyfit(np.log([step(k) for k in within]), np.log([row[k] for k in within]), 1)[0])


#: where slopes are fitted, by method, and for the others by ""
FITS: dict[str, dict[str, tuple[str, str]]] = {
    "figure 3": {"": ("2^-10", "2^-14")},
    "angle": {"": ("2^-8", "2^-11")},
    "resolved": {"": ("0.05*2^-13", "0.05*2^-17")},
    "figure 5": {"": ("0.03*2^-11", "0.03*2^-15"), "newmark": ("0.03*2^-15", "0.03*2^-18")},
    "figure 6": {"": ("0.03*2^-11", "0.03*2^-15"), "newmark": ("0.03*2^-14", "0.03*2^-18")},
    "figure 9": {"": ("2^-10", "2^-14")},
    "figure 10": {"": ("2^-8", "2^-11"), "nstiff": ("2^-9", "2^-12"), "nstiff-si2": ("2^-9", "2^-12")},
}
POWERS = ("2^-8", "2^-10", "2^-12", "2^-14")
PARTS = ("0.03*2^-9", "0.03*2^-12", "0.03*2^-15", "0.03*2^-18")


def slopes(errors: dict, fit: dict[str, tuple[str, str]]) -> dict[str, float]:
    return {method: slope(row, *fit.get(method, fit[""])) for method, row in errors.items()}


def span(values: Iterable[float]) -> str:
    """ "1.98 to 2.03"."""
    low, *_, high = [f"{x:.2f}" for x in sorted(values)]
    return low if low == high else f"{low} to {high}"


def orders(errors: dict, name: str) -> str:
    """Of the five methods of order 2, and of newmark."""
    found = slopes(errors, FITS[name])
    first = found.pop("newmark")
    return f"{span(found.values())}, `newmark` {first:.2f}"


@block
def summary(numbers: dict) -> str:
    """What the paper says of each figure, and what is found."""
    four, seven = numbers["figure 4"], numbers["figures 5 and 6"]
    ratios = [row["-0.3"]["2^-8"] / row["-0.05"]["2^-8"] for row in numbers["figures 7 and 8"]["lost"].values()]
    drift = numbers["figures 11 to 15"]
    kept = max(max(drift["largest"][name].values()) for name in ("hht-add", "hht-si2"))
    loops = [slope(drift["largest"][name], "2^-8", "2^-10") for name in drift["predicted"]]
    costs = [(row, case) for case, rows in numbers["figure 16"]["ratios"].items() for row in rows.values()]
    pairs = span(row[name][0] for row, _ in costs for name in ("nstiff-si2", "hht-si2"))
    add = span(row["hht-add"][0] for row, case in costs if case == "flexible slider crank")
    add_else = span(row["hht-add"][0] for row, case in costs if case != "flexible slider crank")
    return table(
        ["figure", "the paper", "here"],
        [
            ["3", "slope 2, NEWMARK 1", f"slope {orders(numbers['figure 3']['errors'], 'figure 3')}"],
            ["4", "slope 2, NEWMARK 1", "angular velocity at 2 s, which rings: none"],
            ["", "", f"angular velocity, resolved: slope {orders(four['resolved'], 'resolved')}"],
            ["", "", f"angle: slope {orders(four['angle'], 'angle')}"],
            ["5", "slope 2, NEWMARK 1", f"slope {orders(seven['errors'], 'figure 5')}"],
            ["6", "slope 2, NEWMARK 1", f"slope {orders(seven['rates'], 'figure 6')}"],
            ["7, 8", "alpha = -0.3 dissipates an order of magnitude more", f"{span(ratios)} times as much"],
            ["9", "O(h^2), NEWMARK O(h)", f"slope {orders(numbers['figure 9']['errors'], 'figure 9')}"],
            ["10", "O(h^2), NEWMARK O(h)", f"slope {orders(numbers['figure 10']['errors'], 'figure 10')}"],
            ["11, 12", "within machine precision", f"up to {short(kept)} m/s, where the iteration stops"],
            ["13 to 15", "O(h^q), NEWMARK thus O(h); cause open", f"slope {span(loops)}, `newmark` too; cause below"],
            ["16", "SI2 about 1.3, more with seven bodies", f"SI2 {pairs}"],
            ["", "HHT-ADD very costly with the flexible body", f"`hht-add` {add}; with the others {add_else}"],
        ],
    )


def errors_table(errors: dict, columns: Sequence[str], name: str) -> str:
    """Errors at some steps, and the slope."""
    found = slopes(errors, FITS[name])
    rows = [[f"`{k}`", *(short(row[c]) for c in columns), f"{found[k]:.2f}"] for k, row in errors.items()]
    return table(["error with h =", *map(shown, columns), "slope"], rows)


@block
def figure_3(numbers: dict) -> str:
    return errors_table(numbers["figure 3"]["errors"], POWERS, "figure 3")


@block
def figure_4(numbers: dict) -> str:
    """The velocity has no slope over the whole range: that of the angle where the ringing is small against it."""
    found, columns = numbers["figure 4"], ("2^-6", "2^-8", "2^-12", "2^-16", "2^-20")
    angle, resolved = (slopes(found[name], FITS[name]) for name in ("angle", "resolved"))
    rows = [
        [f"`{k}`", *(short(row[c]) for c in columns), f"{angle[k]:.2f}", f"{resolved[k]:.2f}"]
        for k, row in found["errors"].items()
    ]
    head = ["error at 2 s with h =", *map(shown, columns), "slope of the angle", "slope, resolved"]
    return f"{table(head, rows)}\n\nThe crank's angular velocity swings by up to {short(found['ringing'])} rad/s."


@block
def mass_matrix(numbers: dict) -> str:
    columns = ["2^-8", "2^-10", "2^-12"]
    rows = [
        [name, *(short(row[k]) for k in columns), f"{slope(row, '2^-9', '2^-12'):.2f}"]
        for name, row in numbers["figure 4"]["mass matrix"].items()
    ]
    return table(["error with h =", *map(shown, columns), "slope"], rows)


@block
def figure_5(numbers: dict) -> str:
    return errors_table(numbers["figures 5 and 6"]["errors"], PARTS, "figure 5")


@block
def figure_6(numbers: dict) -> str:
    return errors_table(numbers["figures 5 and 6"]["rates"], PARTS, "figure 6")


def theory(alpha: float) -> float:
    """What HHT takes from an oscillator, up to a factor, to leading order."""
    return abs(alpha) * (1 + alpha) ** 2


@block
def figures_7_and_8(numbers: dict) -> str:
    rows = []
    for method, found in numbers["figures 7 and 8"]["lost"].items():
        strong, weak = found["-0.3"], found["-0.05"]
        rows.append(
            [f"`{method}`", short(strong["2^-8"]), short(weak["2^-8"]), f"{strong['2^-8'] / weak['2^-8']:.2f}"]
            + [f"{slope(row, '2^-7', '2^-10'):.2f}" for row in (strong, weak)]
        )
    rows.append(["an oscillator, in theory", "", "", f"{theory(-0.3) / theory(-0.05):.2f}", "3", "3"])
    rows.append(["the paper", "", "", "an order of magnitude", "", ""])
    head = ["lost per second, h = 2^-8 s [W]", "alpha = -0.3", "alpha = -0.05", "ratio"]
    strong, weak = (short(x) for x in numbers["figures 7 and 8"]["wavers"].values())
    return (
        f"{table([*head, 'slope, -0.3', 'slope, -0.05'], rows)}\n\n"
        f"In the last two seconds the energy of `hht-i3` goes to and fro by {strong} and {weak} J."
    )


@block
def figure_9(numbers: dict) -> str:
    return errors_table(numbers["figure 9"]["errors"], POWERS, "figure 9")


@block
def figure_10(numbers: dict) -> str:
    return errors_table(numbers["figure 10"]["errors"], POWERS, "figure 10")


@block
def figures_11_and_12(numbers: dict) -> str:
    found = numbers["figures 11 to 15"]["largest"]
    rows = [[f"`{name}`", *map(short, found[name].values())] for name in ("nstiff-si2", "hht-add", "hht-si2")]
    return table(["largest violation [m/s] with h =", "2^-8 s", "2^-9 s", "2^-10 s"], rows)


@block
def figures_13_to_15(numbers: dict) -> str:
    found = numbers["figures 11 to 15"]
    rows = []
    for name, predicted in found["predicted"].items():
        row = found["largest"][name]
        off = abs(row["2^-10"] / predicted["2^-10"] - 1)
        rows.append(
            [f"`{name}`", *map(short, row.values()), short(predicted["2^-10"]), f"{100 * off:.1g} %"]
            + [f"{slope(row, '2^-8', '2^-10'):.2f}"]
        )
    head = ["largest violation [m/s] with h =", "2^-8 s", "2^-9 s", "2^-10 s", "c h^2 Phi_q q''', 2^-10 s"]
    return table([*head, "off by", "slope"], rows)


@block
def figure_16(numbers: dict) -> str:
    found = numbers["figure 16"]["ratios"]
    names = ("newmark", "nstiff", "nstiff-si2", "hht-add", "hht-si2")
    rows = [
        [f"{model}, {label}", *(f"{row[name][0]:.2f}" for name in names), f"{row['step [us]']:.2f} us"]
        for model, cases in found.items()
        for label, row in cases.items()
    ]
    return table(["model, step", *(f"`{name}`" for name in names), "a step of `hht-i3`"], rows)
