"""Coulomb friction in joints: what they have in common, and joints that slide along one coordinate.

The resistance along a coordinate with rate v is

    N (mu + (mu_s - mu) exp(-(v/v_st)^2)) tanh(v/v_s)

with N the magnitude of the joint's own reaction (times the radius of a pin). mu_s is the peak near standstill and v_st
the Stribeck speed over which it falls to mu. tanh regularises the sign of v, for which the equations have no solution:
a joint that should stick creeps at a speed of the order of v_s. Smaller v_s reduce the creep and make the equations
stiffer. The creep with the defaults is negligible in machines (1 mm/s, 0.01 rad/s: 0.1 mm/s at the surface of a pin of
1 cm), and implicit methods handle their stiffness.

With `sticks = true` there is no such speed: friction is mu N against the sliding, and where the joint stops it is held,
until more than mu_s N is needed (:mod:`mbdsl.mechanism.sticking`).
"""

from collections.abc import Mapping

from mbdsl.elements.declaration import Parameter, Signal, power
from mbdsl.elements.kind import zero

EFFECTS = {"friction": zero("mu", "mu_s")}
#: of joints that stick: those that slide along one coordinate, and along several
SLIDING = Signal("sliding", "1", "number[1]", "sense of sliding, 1 or -1; 0 while friction holds the joint")
SLIDING_ON_SURFACE = Signal("sliding", "1", SLIDING.formula, "1 while the joint slides, 0 while friction holds it")
#: whether friction sticks
STICKS = Parameter("sticks", "", False, "whether friction holds the joint at rest, without creep, up to mu_s")
STRIBECK = 40.0  #: v_st/v_s unless v_st is given: tanh has reached its limit well before the exponential falls


def parameters(speed: str, unit: str, default: float) -> tuple[Parameter, ...]:
    """The parameters of friction against a rate called ``speed``."""
    return (
        Parameter("mu", "1", 0.0, "coefficient of friction; 0: none", minimum=0.0),
        Parameter("mu_s", "1", None, "coefficient around standstill; default mu", minimum=0.0),
        Parameter(
            f"{speed}_s",
            unit,
            default,
            f"speed over which friction changes its sign: tanh({speed}/{speed}_s)",
            positive=True,
        ),
        Parameter(f"{speed}_st", unit, None, f"Stribeck speed; default {STRIBECK:g} {speed}_s", positive=True),
    )


def formula(normal: str, speed: str, parameter: str = "") -> str:
    """The law for a normal force (or its torque) given by a formula; terms of mu_s = mu cancel.

    ``speed`` is the signal of this name; or another formula, whose parameters are those of ``parameter``.
    """
    name = parameter or speed
    return f"{normal}*(mu + (mu_s - mu)*exp(-({speed}/{name}_st)^2))*tanh({speed}/{name}_s)"


def check_order(values: Mapping) -> str | None:
    mu, mu_s = values["mu"], values["mu_s"]
    if mu_s is None or mu_s >= mu:
        return None
    return (
        f"mu_s is {mu_s:g}, less than mu = {mu:g}: static friction cannot be less than sliding friction\n"
        "mu_s is the coefficient at rest: exchange them, or leave mu_s out, which is mu then"
    )


def check(values: Mapping) -> str | None:
    if (problem := check_order(values)) is not None:
        return problem
    mu, mu_s = values["mu"], values["mu_s"]
    if (mu or mu_s) and "radius" in values and values["radius"] is None:
        return "friction in a pin needs its `radius`: the torque is mu * radius * force"
    if values.get("sticks") and values.get("v_st", values.get("w_st")) is not None:
        return "with `sticks`, friction falls from mu_s to mu as soon as the joint slides: leave the Stribeck speed out"
    return None


def derive(values: Mapping) -> dict:
    """The default values."""
    speed = "w" if "w_s" in values else "v"
    found = {} if values["mu_s"] is not None else {"mu_s": values["mu"]}
    return found if values[f"{speed}_st"] is not None else {**found, f"{speed}_st": STRIBECK * values[f"{speed}_s"]}


def against(normal: str, rate: str, signal: str, along: str) -> dict:
    """The fields of a joint with friction against the rate of a signal, for the normal force or its torque; ``along``
    is the kind along whose coordinate it acts."""
    return {
        "friction": formula(normal, rate),
        "friction_along": along,
        "normal": normal,
        "slides": (rate,),
        "places": (signal,),
        "results": (power(f"-(friction*{rate})"), SLIDING),
        "resists": (("friction", signal),),
        "check": check,
        "derive": derive,
        "effects": EFFECTS,
    }
