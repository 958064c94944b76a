"""The normal force of contacts and stops: stiffness, and damping that follows from a coefficient of restitution.

    F = k d^n max(0, 1 + alpha d')                                                       at the depth d > 0

(K. H. Hunt, F. R. E. Crossley, J. Appl. Mech. 42 (1975) 440-445). n is 1 for springs and lines, 3/2 for points (Hertz).
It is zero at first touch and never pulls. A mass that arrives at the speed v_0 leaves at e v_0 if

    D (1 + e) = ln((1 + D)/(1 - e D)),  D = alpha v_0

for every n, which follows from v dv/dd = -F/m by separation of the variables. It is solved for D. v_0 is given; or it
is the speed of each touch, at which alpha is set (``LATCH``): then every impact has this restitution.
"""

from collections.abc import Mapping
from math import log

from mbdsl.elements.declaration import CONTACTS, REQUIRED, Latch, Parameter

RANGE = "e is the speed behind an impact over the speed before: 1 elastic, 0 plastic"
IMPACTS = Parameter(
    "impacts",
    "",
    "sequential",
    "whether impacts that touching rigid bodies pass on are solved one after another, or at once; at once in all "
    "contacts if one of them says so",
    choices=("sequential", "simultaneous"),
)
LEAST = 0.05  #: smallest coefficient of restitution; the damping grows like 1/e


def parameters(stiffness: str, speed: str, unit: str) -> tuple[Parameter, ...]:
    """The parameters of a contact with this unit of stiffness, whose speed is called ``speed``."""
    return (
        Parameter("k", stiffness, None, "stiffness; without it the contact is rigid", positive=True),
        Parameter("e", "1", None, "coefficient of restitution; default 1, but rigid contacts need it", minimum=0.0),
        Parameter(
            speed,
            unit,
            None,
            "speed of approach at which an impact has it; default: every impact has it",
            positive=True,
        ),
        Parameter(
            least(speed),
            unit,
            1e-3 if unit == "m/s" else 1e-2,
            f"least speed of touch, without {speed}: slower impacts have the damping of this one",
            positive=True,
        ),
        Parameter(
            "exponent",
            "1",
            1.0,
            "exponent n of the depth in the force k d^n, with d in m or rad; 1.5: Hertz",
            minimum=1.0,
        ),
        IMPACTS,
    )


def least(speed: str) -> str:
    """The name of the least speed of touch."""
    return speed.replace("_0", "_min")


def damping(e: float) -> float:
    """D, for a coefficient of restitution e: the root of D (1 + e) - ln((1 + D)/(1 - e D)) between 0 and 1/e."""
    if e == 1.0:
        return 0.0
    low, high = 0.0, 1.0 / e
    for _ in range(200):  # the difference is positive below the root and negative above it
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if e * middle < 1.0 and middle * (1.0 + e) > log((1.0 + middle) / (1.0 - e * middle)):
            low = middle
        else:
            high = middle
    return low


def check(values: Mapping, speed: str) -> str | None:
    """The error text, if the coefficient of restitution cannot be used, or the kind cannot be ``rigid``."""
    e, rigid = values["e"], values["k"] is None
    if rigid and e is None:
        return "without `k` it is rigid, and needs `e`, its coefficient of restitution"
    if rigid and (values[speed] is not None or values["exponent"] != 1.0):
        return f"without `k` it is rigid: `{speed}` and `exponent` have no meaning"
    if e is not None and not (0.0 if rigid else LEAST) <= e <= 1.0:
        least, which = ("0", "") if rigid else (f"{LEAST:g}", " of a contact with stiffness")
        stiff = "" if rigid else f"; below {LEAST:g} leave `k` out: the contact is rigid then"
        return f"e is {e:g}, the coefficient of restitution{which} must be between {least} and 1\n{RANGE}{stiff}"
    return None


def derive(values: Mapping, speed: str, touches: int = 1) -> dict:
    """``e``; ``D``, and ``alpha`` [s/m, s/rad] of each touch, None where an event sets it."""
    if values["k"] is None:
        return {"alpha": (0.0,) * touches}
    e = 1.0 if values["e"] is None else values["e"]
    D = damping(e)
    given = values[speed]
    alpha = 0.0 if D == 0.0 else None if given is None else D / given
    return {"e": e, "D": (D,), "alpha": (alpha,) * touches}


def latch(touch: int, condition: str, speed: str, parameter: str) -> Latch:
    """The event that sets alpha of a touch, where a ``condition`` becomes true; ``speed`` is the formula of the speed
    of approach then, ``parameter`` the name of the speed that may be given."""
    return Latch(f"alpha[{touch}]", condition, f"D[1]/max({speed}, {least(parameter)})")


def spring(depth: str) -> str:
    """The elastic force of a depth."""
    return f"k*max(0, {depth})^exponent"


def energy(depth: str) -> str:
    """The energy of ``spring``."""
    return f"k/(exponent + 1)*max(0, {depth})^(exponent + 1)"


def _elastic(values: Mapping) -> dict:
    """The values without damping."""
    return {} if set(values["alpha"]) == {0.0} else {"alpha": (0.0,) * len(values["alpha"])}


def _absent(values: Mapping) -> dict:
    """The values without contact."""
    if values["k"] is None:
        return {} if values["impacts"] == "never" else {"impacts": "never"}
    return {"k": 0.0, "alpha": (0.0,) * len(values["alpha"])} if values["k"] else {}


def _stiff(values: Mapping) -> dict:
    """The values of the rigid contact."""
    return {**_elastic(values), "k": None} if values["k"] else {}


EFFECTS = {"damping": _elastic, "contact": _absent}
#: of kinds that can be rigid
EFFECTS_OR_RIGID = {**EFFECTS, CONTACTS["rigid"]: _stiff}
