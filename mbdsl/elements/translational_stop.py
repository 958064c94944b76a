"""TranslationalStop: end stops of a sliding joint, stiff springs with damping beyond its limits; rigid without `k`.

force = k d^n max(0, 1 + alpha d'),  d = s - s_max or s_min - s,  where d > 0          see contact_law.py
"""

from mbdsl.elements import contact_law
from mbdsl.elements.declaration import Parameter, power
from mbdsl.elements.kind import AT_B, ForceKind, Signal, Touch, in_space
from mbdsl.elements.motions import SLIDING, along_n
from mbdsl.elements.rigid_contact import specialised
from mbdsl.elements.rows import along


def limits(low: str, high: str, unit: str) -> tuple[Parameter, ...]:
    """The parameters of a range."""
    return (
        Parameter(low, unit, None, "lower limit; no limit if omitted"),
        Parameter(high, unit, None, "upper limit; no limit if omitted"),
    )


def check_limits(values, low, high):
    if values[low] is None and values[high] is None:
        return f"give `{low}`, `{high}` or both"
    if None not in (values[low], values[high]) and not values[low] < values[high]:
        hint = "\nexchange them" if values[low] > values[high] else ""
        return f"{low} = {values[low]:g} is not less than {high} = {values[high]:g}{hint}"
    return None


def bounds(values, low, high):
    """Values for the formulas: ``on`` is 1 for limits that exist, ``at`` their values."""
    found = (values[low], values[high])
    return {"on": tuple(float(x is not None) for x in found), "at": tuple(0.0 if x is None else x for x in found)}


def force(s, v):
    """The formula of the resistance to growth of the coordinate ``s`` with the rate ``v``."""
    high = f"on[2]*max(0, {s} - at[2])^exponent*max(0, 1 + alpha[1]*{v})"
    low = f"on[1]*max(0, at[1] - {s})^exponent*max(0, 1 - alpha[1]*{v})"
    return f"k*({high} - {low})"


def energy(s):
    high, low = (f"on[{i}]*max(0, {x})^(exponent + 1)" for i, x in ((2, f"{s} - at[2]"), (1, f"at[1] - {s}")))
    return f"k/(exponent + 1)*({high} + {low})"


def touch(s, v, parameter):
    """The latch of a limit: both have one number, since one of them at a time touches."""
    beyond = f"(on[2]*lt(at[2], {s}) + on[1]*lt({s}, at[1]))"
    return (contact_law.latch(1, f"ne({beyond}, 0)", f"abs({v})", parameter),)


def rigid(s, low, high):
    """The rigid contacts of the limits of a coordinate."""
    return Touch("min", f"{s} - {low}", limit=low, sense=-1.0), Touch("max", f"{high} - {s}", limit=high)


KIND = ForceKind(
    "TranslationalStop",
    doc="End stops of a sliding joint, or one-sided contact of a point with a line: beyond its limits a stiff spring "
    "pushes back; it never pulls.",
    g=(along("x"),),
    parameters=(
        *limits("s_min", "s_max", "m"),
        *contact_law.parameters("N/m", "v_0", "m/s"),
    ),
    signals=(*SLIDING, Signal("force", "N", force("s", "v"), "resisting force")),
    results=(power("-(force*v)"),),
    resists=(("force", "s"),),
    touches=AT_B,
    energy=energy("s"),
    check=lambda v: check_limits(v, "s_min", "s_max") or contact_law.check(v, "v_0"),
    derive=lambda v: {**bounds(v, "s_min", "s_max"), **contact_law.derive(v, "v_0")},
    laws=("force",),
    effects=contact_law.EFFECTS_OR_RIGID,
    touching=rigid("s", "s_min", "s_max"),
    specialised=specialised("translational_stop"),
    latches=touch("s", "v", "v_0"),
    drawing="stop",
)
IN_SPACE = in_space(KIND, along_n)
