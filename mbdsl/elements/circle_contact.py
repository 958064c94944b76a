"""CircleContact: two circles, in space balls, that push each other apart where they overlap; or one in a round hole.

    force = k d^n max(0, 1 + alpha d'),  d = r_a + r_b - |r_b - r_a| > 0                   see contact_law.py

(in a hole d = |r_b - r_a| - (r_a - r_b)), along the line of centres. With `mu` the component is of the kind in
circle_friction.py; without, it needs the distance of the centres only.
"""

from mbdsl.elements import contact_law, friction
from mbdsl.elements.declaration import RIGID, Parameter, Signal, power
from mbdsl.elements.kind import ForceKind, in_space
from mbdsl.elements.motions import APART, APART_IN_SPACE
from mbdsl.elements.rows import LENGTH


def check(values):
    if values["internal"] and not values["r_a"] > values["r_b"]:
        r_a, r_b = values["r_a"], values["r_b"]
        return f"frame_a has the hole, but its radius r_a = {r_a:g} m is not larger than r_b = {r_b:g} m"
    return contact_law.check(values, "v_0") or friction.check(values)


def derive(values):
    """``side``: the sign of the contact force along the distance; ``reach``: the distance at first touch."""
    inside = values["internal"]
    reach = values["r_a"] - values["r_b"] if inside else values["r_a"] + values["r_b"]
    found = {"side": (-1.0 if inside else 1.0,), "reach": (reach,), **contact_law.derive(values, "v_0")}
    return found | friction.derive(values)


def specialised(values):
    """With friction it is another kind, and without stiffness."""
    return f"{RIGID}circle_friction" if values["k"] is None else "circle_friction" if values["mu_s"] else ""


SHAPE = (
    Parameter("r_a", "m", doc="radius about frame_a", positive=True),
    Parameter("r_b", "m", doc="radius about frame_b", positive=True),
    Parameter("internal", "", False, "whether circle a is a round hole that contains circle b"),
)
DEPTH = Signal("depth", "m", "side[1]*(reach[1] - s)", "overlap; negative: the gap")
KIND = ForceKind(
    "CircleContact",
    doc="Contact of two circles about the frame origins, which push each other apart where they overlap; with "
    "friction if it has `mu`.",
    g=(LENGTH,),
    parameters=(
        *SHAPE,
        *contact_law.parameters("N/m", "v_0", "m/s"),
        *friction.parameters("v", "m/s", 1e-3),
    ),
    signals=(
        *APART,
        DEPTH,
        Signal(
            "force",
            "N",
            f"side[1]*{contact_law.spring('depth')}*max(0, 1 - alpha[1]*side[1]*v)",
            "contact force along the line of centres, positive if it pushes the centres apart",
        ),
    ),
    results=(power("force*v"),),
    resists=(("(-force)", "s"),),
    energy=contact_law.energy("depth"),
    check=check,
    derive=derive,
    laws=("force",),
    sign=1.0,
    effects={**contact_law.EFFECTS_OR_RIGID, **friction.EFFECTS},
    specialised=specialised,
    latches=(contact_law.latch(1, "lt(0, depth)", "abs(v)", "v_0"),),
    drawing="circles",
)
IN_SPACE = in_space(
    KIND,
    doc="Contact of two balls about the frame origins, which push each other apart where they overlap; with "
    "friction if it has `mu`.",
    signals=(*APART_IN_SPACE, *KIND.signals[2:]),
)
