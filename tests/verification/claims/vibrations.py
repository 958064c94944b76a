"""Laws whose motion grows late, is chaotic, resonates or comes into a stiff limit cycle."""

from __future__ import annotations

from math import cos, sin, tanh

import numpy as np
from laws import law

# -- growth that shows late ----------------------------------------------------------------------------------------
law(
    "Delayed",
    "growth",
    "-(20*v + 10*(20 - time)*s + 1e3*s^3)",
    lambda t, s, v, on: -(20 * v + 10 * (20 - t) * s + 1e3 * s**3),
    s=0.1,
    stop=42,
    atol=1e-60,
)
law("Inverted", "growth", "9.81*sin(s)", lambda t, s, v, on: 9.81 * sin(s), s=1e-6, stop=8)
law("InvertedAtRest", "growth", "9.81*sin(s)", exact=lambda t: (0 * t, 0 * t), stop=10)
law("DoubleWell", "growth", "s - s^3 - 0.1*v", lambda t, s, v, on: s - s**3 - 0.1 * v, s=1e-5, stop=30)
law(
    "FromNothing",
    "growth",
    "1e-16*exp(40*time)",
    exact=lambda t: (1e-16 / 1600 * (np.exp(40 * t) - 1 - 40 * t), 1e-16 / 40 * (np.exp(40 * t) - 1)),
    stop=1,
)
law("Pole", "growth", "6*s^2", exact=lambda t: ((1 - t) ** -2.0, 2 * (1 - t) ** -3.0), s=1, v=2, stop=0.97)
law("PoleNear", "growth", "6*s^2", exact=lambda t: ((1 - t) ** -2.0, 2 * (1 - t) ** -3.0), s=1, v=2, stop=0.99)
law(
    "StiffThenFree",
    "growth",
    "-1e4*(1 - tanh(5*(time - 2)))*s - 0.1*v",
    lambda t, s, v, on: -1e4 * (1 - tanh(5 * (t - 2))) * s - 0.1 * v,
    s=1e-2,
    stop=5,
)
law(
    "NegativeDamping", "growth", "-s + 0.5*(time - 20)*v/10", lambda t, s, v, on: -s + 0.05 * (t - 20) * v, s=1, stop=40
)
law("Saddle", "growth", "25*s", exact=lambda t: (1e-9 * np.cosh(5 * t), 5e-9 * np.sinh(5 * t)), s=1e-9, stop=4)

# -- chaos ---------------------------------------------------------------------------------------------------------
UEDA = "-(0.1*v + s^3 - 7.5*cos(time))"
law("Ueda", "chaos", UEDA, lambda t, s, v, on: -(0.1 * v + s**3 - 7.5 * cos(t)), s=1, stop=40)
law("UedaLong", "chaos", UEDA, lambda t, s, v, on: -(0.1 * v + s**3 - 7.5 * cos(t)), s=1, stop=120)
law(
    "WellsDriven",
    "chaos",
    "s - s^3 - 0.25*v + 0.4*cos(time)",
    lambda t, s, v, on: s - s**3 - 0.25 * v + 0.4 * cos(t),
    s=1,
    stop=80,
)
law(
    "PendulumDriven",
    "chaos",
    "-1*sin(s) - 0.5*v + 1.5*cos(2/3*time)",
    lambda t, s, v, on: -sin(s) - 0.5 * v + 1.5 * cos(2 / 3 * t),
    s=0.2,
    stop=60,
)
law(
    "ImpactChaos",
    "chaos",
    "-s + 1*cos(2.8*time) - 0.05*v - (if s > 0 then 1e4*s else 0)",
    lambda t, s, v, on: -s + cos(2.8 * t) - 0.05 * v - (1e4 * s if on[0] else 0),
    s=-0.5,
    stop=15,
    switches=lambda t, s, v: (s,),
)

# -- resonance -----------------------------------------------------------------------------------------------------
law(
    "Resonance",
    "resonance",
    "-100*s + 1*cos(10*time)",
    exact=lambda t: (t / 20 * np.sin(10 * t), np.sin(10 * t) / 20 + t / 2 * np.cos(10 * t)),
    stop=30,
)
law(
    "Beat",
    "resonance",
    "-100*s + 1*cos(10.1*time)",
    exact=lambda t: (
        (np.cos(10.1 * t) - np.cos(10 * t)) / (100 - 10.1**2),
        (-10.1 * np.sin(10.1 * t) + 10 * np.sin(10 * t)) / (100 - 10.1**2),
    ),
    stop=60,
)
law(
    "HighQ",
    "resonance",
    "-100*s - 0.002*v + 0.01*sin(10*time)",
    lambda t, s, v, on: -100 * s - 0.002 * v + 0.01 * sin(10 * t),
    stop=100,
)
law(
    "Mathieu",
    "resonance",
    "-(1 + 0.4*cos(2*time))*s - 0.02*v",
    lambda t, s, v, on: -(1 + 0.4 * cos(2 * t)) * s - 0.02 * v,
    s=1e-3,
    stop=60,
)
law(
    "Superharmonic",
    "resonance",
    "-s - s^3 - 0.1*v + 5*cos(0.31*time)",
    lambda t, s, v, on: -s - s**3 - 0.1 * v + 5 * cos(0.31 * t),
    stop=60,
)
law(
    "Sweep",
    "resonance",
    "-400*s - 0.1*v + 1*sin(0.5*time^2)",
    lambda t, s, v, on: -400 * s - 0.1 * v + sin(0.5 * t * t),
    stop=40,
)

# -- stiff limit cycles --------------------------------------------------------------------------------------------
for mu, stop in ((5, 40), (100, 300), (300, 600)):
    law(
        f"VanDerPol{mu}",
        "cycles",
        f"{mu}*(1 - s^2)*v - s",
        lambda t, s, v, on, mu=mu: mu * (1 - s * s) * v - s,
        s=2,
        stop=stop,
    )
law("Rayleigh", "cycles", "30*(v - v^3/3) - s", lambda t, s, v, on: 30 * (v - v**3 / 3) - s, s=2, stop=100)
law(
    "BeltSmooth",
    "cycles",
    "-25*s - 3*tanh((v - 0.5)/0.01)*(1 + 1/(1 + 10*abs(v - 0.5)))",
    lambda t, s, v, on: -25 * s - 3 * tanh((v - 0.5) / 0.01) * (1 + 1 / (1 + 10 * abs(v - 0.5))),
    stop=5,
    switches=lambda t, s, v: (v - 0.5,),
)
