"""Contact: rigid contact of any gap that is a function of positions, with Coulomb friction.

    0 <= gap,  g = gap = 0 while it is closed                                            (1 row, by expression)
    slip = 0 while friction holds it                                                     (1 or 2 rows, of velocities)

While the gap is open, its row is left out. Where it closes, Newton's law of restitution gives the velocities behind the
impact; where impacts end, the row holds the contact closed until its reaction would pull. Friction acts along the slip,
which is a velocity: mu N against it while the bodies slide, and up to mu_s N while they do not.
"""

from dataclasses import replace

from mbdsl.elements.contact_law import IMPACTS, RANGE
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.friction import EFFECTS, check_order
from mbdsl.elements.kind import JointKind, Signal, in_space


def check(v):
    if v["e"] > 1.0:
        return f"e = {v['e']:g} is larger than 1, an impact would gain energy\n{RANGE}"
    return check_order(v)


def absent(v):
    """The values without contact: it never closes."""
    return {} if v["impacts"] == "never" else {"impacts": "never"}


GAP = Parameter("gap", "m", doc="the distance, an expression of positions such as `ball.y - r`", law=True)
SLIP = Parameter("slip", "m/s", None, "the velocity of sliding, an expression linear in velocities", law=True)
KIND = JointKind(
    "Contact",
    doc="Rigid contact: a gap, any function of positions, that does not become negative; with `slip` and `mu`, it has "
    "friction. It has no frames.",
    ports=(),
    rows=1,
    coupled=("gap",),
    parameters=(
        GAP,
        SLIP,
        Parameter("mu", "1", 0.0, "coefficient of friction; 0: none", minimum=0.0),
        Parameter("mu_s", "1", None, "coefficient while it does not slide; default mu", minimum=0.0),
        Parameter("e", doc="coefficient of restitution of impacts: 1 elastic, 0 plastic", minimum=0.0),
        IMPACTS,
    ),
    relations=("gap",),
    velocity_rows=("slip",),
    reactions=(Signal("force", "N", "carried[1]", "contact force, which opens the gap"),),
    friction="number[5]*lam[1] - carried[2]",
    results=(
        Signal("active", "1", "min(1, number[1])", "1 while the contact lasts, else 0"),
        Signal("impacts", "1", "number[2]", "number of impacts so far"),
        Signal("impulse", "N.s", "number[3]", "impulse of the last impact along the gap"),
        Signal("sliding", "1", "number[6]", "1 or -1 while it slides, by the sign of slip; else 0"),
    ),
    check=check,
    derive=lambda v: {} if v["mu_s"] is not None else {"mu_s": v["mu"]},
    effects={**EFFECTS, "contact": absent},
    unilateral=True,
    drawing="nothing",
)
IN_SPACE = in_space(
    KIND,
    parameters=(
        GAP,
        SLIP,
        replace(SLIP, name="slip_2", doc="the same in a second direction, normal to the first"),
        *KIND.parameters[2:],
    ),
    velocity_rows=("slip", "slip_2"),
    friction="number[5]*lam[1] + hypot(carried[2], carried[3])",
)
