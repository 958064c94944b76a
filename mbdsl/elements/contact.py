"""Contact: rigid contact of any gap that is a function of positions.

    0 <= gap,  g = gap = 0 while it is closed                                            (1 row, by expression)

While the gap is open, its row is left out. Where it closes, Newton's law of restitution gives the velocities behind the
impact; where impacts end, the row holds the contact closed until its reaction would pull.
"""

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import JointKind, Signal, in_space

KIND = JointKind(
    "Contact",
    doc="Rigid contact without friction: a gap, any function of positions, that does not become negative. It has no "
    "frames.",
    ports=(),
    rows=1,
    coupled=("gap",),
    parameters=(
        Parameter("gap", "m", doc="the distance, an expression of positions such as `ball.y - r`", law=True),
        Parameter("e", doc="coefficient of restitution of impacts: 1 elastic, 0 plastic", minimum=0.0),
        Parameter(
            "impacts",
            "",
            "sequential",
            "whether impacts that are touching bodies pass on are solved one after another or at once; that of the "
            "first contact counts",
            choices=("sequential", "simultaneous"),
        ),
    ),
    relations=("gap",),
    reactions=(Signal("force", "N", "-lam[1]", "contact force, which opens the gap"),),
    results=(
        Signal("active", "1", "number[1]", "1 while the contact lasts, else 0"),
        Signal("impacts", "1", "number[2]", "number of impacts so far"),
        Signal("impulse", "N.s", "number[3]", "impulse of the last impact"),
    ),
    check=lambda v: f"e = {v['e']:g} is larger than 1, an impact would gain energy" if v["e"] > 1.0 else None,
    unilateral=True,
    drawing="nothing",
)
IN_SPACE = in_space(KIND)
