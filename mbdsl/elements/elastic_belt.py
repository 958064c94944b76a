"""ElasticBelt: a belt around two pulleys that stretches: a spring and damper along the coordinate of a BeltDrive.

    g = r_a (phi_a - theta) + r_b (phi_b - theta),  force  k (g - g_0) + c dg/dt         see belt_drive.py

with g_0 at the start. g - g_0 is by how much the rim of one pulley is ahead of the other: one strand is longer by it,
the other shorter. With the stiffness k_1 of each strand, the tensions differ by 2 k_1 (g - g_0). The belt is
pretensioned: no strand becomes slack.
"""

from mbdsl.elements import belt_drive
from mbdsl.elements.declaration import Parameter, power
from mbdsl.elements.gear_pair import SIGNALS_IN_SPACE, about_parallel_axes
from mbdsl.elements.kind import ForceKind, Signal, in_space, zero
from mbdsl.elements.line_of_centres import rolling as gradient
from mbdsl.elements.line_of_centres import rolling_hessian as hessian
from mbdsl.elements.line_of_centres_in_space import rolling as gradient_in_space
from mbdsl.elements.line_of_centres_in_space import rolling_hessian as hessian_in_space

#: vector between the centres
DX, DY = "(frame_b.x - frame_a.x)", "(frame_b.y - frame_a.y)"
#: sine and cosine of the angle by which it has turned since the start, times both distances
SIDES = f"start({DX})*{DY} - start({DY})*{DX}, start({DX})*{DX} + start({DY})*{DY}"
#: this angle, with its turns
TURNED = f"angle({SIDES}, der(atan2({SIDES})))"
_UNIT, _DOC = "m", "how far the rim of one pulley has run ahead of the other since the start"

FORCE = Signal("force", "N", "k*stretch + c*der(stretch)", "difference of the tensions of the strands")


def along(stretch: str) -> tuple[Signal, ...]:
    """The signals of the belt for a formula of its stretch."""
    return (Signal("stretch", _UNIT, stretch, _DOC), FORCE)


KIND = ForceKind(
    "ElasticBelt",
    doc="A belt or chain around two pulleys about the frame origins, which stretches and does not slip; without force "
    "at the start. The ratio of the radii is that of the speeds.",
    rows=1,
    parameters=(
        *(p for p in belt_drive.KIND.parameters if p.name != "phi0"),
        Parameter("k", "N/m", doc="stiffness: twice that of one strand", positive=True),
        Parameter("c", "N.s/m", 0.0, "damping", minimum=0.0),
    ),
    signals=(
        *along(
            f"r[1]*(frame_a.phi - start(frame_a.phi) - {TURNED}) + r[2]*(frame_b.phi - start(frame_b.phi) - {TURNED})"
        ),
        *belt_drive.KIND.signals,
    ),
    energy="0.5*k*stretch^2",
    results=(power("-(force*der(stretch))"),),
    resists=(("force", "stretch"),),
    derive=lambda v: {**belt_drive.KIND.derive(v), "searched": None},
    table=lambda v: (*v["r"], 0.0),
    laws=("force",),
    effects={"damping": zero("c")},
    misfit=belt_drive.KIND.misfit,
    drawing="belt",
)
IN_SPACE = in_space(
    KIND,
    about_parallel_axes,
    signals=(*SIGNALS_IN_SPACE, *along("r[1]*(phi_a - start(phi_a)) + r[2]*(phi_b - start(phi_b))")),
)
