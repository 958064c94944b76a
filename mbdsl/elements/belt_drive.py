"""BeltDrive: a belt or chain around two pulleys or sprockets, without slip or stretch (a constraint of positions).

    g = r_a (phi_a - theta) + r_b (phi_b - theta - phi0)                                 (1 row)

with theta the angle of the line of centres, see line_of_centres.py; r_b is negative for an open belt, whose pulleys
turn in the same sense, and positive for a crossed belt. If the centres move apart or together, both strands
change their length by the same amount, which changes no angle. The multiplier is the difference of the tensions of the
strands [N]; the sum of the tensions depends on the pretension and is left out.
"""

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.gear_pair import REACTIONS, REACTIONS_IN_SPACE, SIGNALS, about_parallel_axes, close
from mbdsl.elements.kind import JointKind, in_space
from mbdsl.elements.line_of_centres import rolling as gradient
from mbdsl.elements.line_of_centres import rolling_hessian as hessian
from mbdsl.elements.line_of_centres_in_space import rolling as gradient_in_space
from mbdsl.elements.line_of_centres_in_space import rolling_hessian as hessian_in_space


def check(values):
    r_a, r_b = values["r_a"], values["r_b"]
    if not values["crossed"] and r_a != r_b and close(r_a, r_b):
        return f"the radii r_a = {r_a:g} m and r_b = {r_b:g} m differ by less than 0.1 %: make them equal"
    return None


def misfit(values, distance):
    least = abs(sum(values["r"]))
    if distance < least:
        crossed = "crossed belt" if values["crossed"] else "belt"
        return f"its centres are {distance:.4g} m apart; a {crossed} around these pulleys needs more than {least:.4g} m"
    return None


KIND = JointKind(
    "BeltDrive",
    doc="A belt or chain around two pulleys or sprockets about the frame origins, without slip or stretch.",
    rows=1,
    parameters=(
        Parameter("r_a", "m", doc="radius about frame_a", positive=True),
        Parameter("r_b", "m", doc="radius about frame_b", positive=True),
        Parameter("crossed", "", False, "whether the strands cross, so that the pulleys turn in opposite senses"),
        Parameter("phi0", "rad", 0.0, "angle of frame_b when frame_a and the line of centres are at angle 0"),
    ),
    signals=SIGNALS,
    reactions=REACTIONS,
    check=check,
    misfit=misfit,
    derive=lambda v: {"r": (v["r_a"], v["r_b"] if v["crossed"] else -v["r_b"])},
    table=lambda v: (*v["r"], v["r"][1] * v["phi0"]),
    drawing="belt",
)
IN_SPACE = in_space(KIND, about_parallel_axes, reactions=REACTIONS_IN_SPACE)
