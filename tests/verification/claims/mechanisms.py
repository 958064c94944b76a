"""Claims that are mechanisms; their poses by hand in minimal coordinates."""

from __future__ import annotations

from math import exp

from claim import Claim, G

CLAIMS: dict[str, Claim] = {}


def mechanism(name, family, body, pose, *, z, v, stop, start, masses=None, g=G, begin=0.0, **more):
    text = f"model {name}\n  Ground ground(g = {g!r});\n{body}\ninitial equation\n{start}\n"
    start = f"StartTime = {float(begin)!r}, " if begin else ""
    text += f"  annotation(experiment({start}StopTime = {float(begin + stop)!r}));\nend {name};\n"
    z, v = (list(map(float, x)) for x in (z, v))
    CLAIMS[name] = Claim(name, family, text, float(stop), pose, z, v, masses=masses, g=g, begin=float(begin), **more)


def bell(t, at, width, height=1.0):
    return height * exp(-(((t - at) / width) ** 2))


def around(at, width):
    """Times at which the reference of a pulse restarts."""
    return [at + k * width for k in (-8, -3, 0, 3, 8)]


def rod(m, length):
    return m, m * length**2 / 12
