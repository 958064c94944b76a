"""A model of this suite: its text, its motion in minimal coordinates, and the file of its answer."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from jets import Jet, jet

DATA = Path(__file__).parents[2] / "data" / "claims"
OUTPUTS = 100  #: spaced evenly, without the start
G = 9.81


@dataclass(frozen=True)
class Claim:
    """A model made to fool an error estimate.

    Its bodies follow from minimal coordinates z by ``pose(z, t)``, written by hand: {body: (x, y, phi)}. Their motion
    z(t) is that of ``exact(t)``, a closed form that gives (z, z'), or of ``rate(t, z, z', on)``, z'', where ``on`` are
    the signs of ``switches(t, z, z')``; or, of mechanisms, of ``masses`` {body: (m, I)} and ``loads(t, p, v, on)``
    {body: (fx, fy, tau)}, gravity left out.
    """

    name: str
    family: str
    text: str
    stop: float
    pose: Callable
    z: Sequence[float]
    v: Sequence[float]
    exact: Callable | None = None
    rate: Callable | None = None
    masses: dict | None = None
    loads: Callable | None = None
    g: float = G
    switches: Callable | None = None
    breaks: Sequence[float] = ()  #: times at which the reference restarts: corners, both ends of pulses
    atol: float = 1e-15  #: of the reference [m or rad, and per s]
    rounding: float = 1e-14  #: of a closed form, for example from the rounding of its times
    begin: float = 0.0  #: the time at which the run starts [s]; all other times count from there

    @property
    def times(self):
        return np.linspace(0.0, self.stop, OUTPUTS + 1)[1:]

    @cached_property
    def stored(self) -> dict:
        """The stored answer, empty if there is none yet."""
        path = DATA / f"{self.family}.json"
        return json.loads(path.read_text(encoding="utf-8")).get(self.name, {}) if path.exists() else {}

    def truth(self) -> dict[str, np.ndarray]:
        """Signal -> (N,) of the stored answer [m, rad; m/s, rad/s], without the start."""
        return self._signals(self.times, *(np.array(self.stored[key]) for key in ("z", "v")))

    def between(self) -> dict[str, np.ndarray]:
        """The same for the largest velocity of the run: of closed forms from many more times; of others at the outputs,
        and at the stored times of the largest velocities."""
        if self.exact is None:
            found = self.truth()
            for t, z, v in self.stored.get("fastest", ()):
                more = self._signals(np.array([t]), np.array([z]), np.array([v]))
                found = {key: np.append(x, more[key]) for key, x in found.items()}
            return found
        t = np.linspace(0.0, self.stop, 20001)[1:]
        z, v = (x if np.ndim(x) == 2 else np.broadcast_to(x, t.shape)[:, None] for x in self.exact(t))
        return self._signals(t, z, v)

    def _signals(self, t, z, v) -> dict[str, np.ndarray]:
        found = {}
        pose = self.pose([Jet(z[:, k], v[:, k], 0.0 * z[:, k]) for k in range(z.shape[1])], Jet(t, 1.0, 0.0))
        for body, of in pose.items():
            for keys, value in zip((("x", "vx"), ("y", "vy"), ("phi", "w")), of, strict=True):
                if value is not None:
                    one = jet(value)
                    found[f"{body}.{keys[0]}"] = one.f + np.zeros(len(z))
                    found[f"{body}.{keys[1]}"] = one.d + np.zeros(len(z))
        return found
