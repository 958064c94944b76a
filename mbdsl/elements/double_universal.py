"""DoubleUniversal: two universal joints with a massless shaft between them, from r_a to r_b; in space.

    |d| - L = 0,   cos(psi) d . (z_a x z_b)/L - sin(psi) (z_a . z_b - (d . z_a) (d . z_b)/L^2) = 0       (2 rows)

with d = r_b - r_a and z along n_a and n_b, the axes of both crosses in the frames. The other axis of each cross is
fixed in the shaft, at right angles to it and to n: along d x z_a and d x z_b. psi is the angle between them about the
shaft.
With psi = 0, and both joints bent by the same angle in one plane, the joint is homokinetic.
"""

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import AXIAL, JointKind, Placing
from mbdsl.elements.motions import APART_IN_SPACE
from mbdsl.elements.row import Row
from mbdsl.elements.rows import LENGTH, Z_A, Z_B, less
from mbdsl.elements.vectors import D, cross, dot, turned_to

SINE = f"{dot(D, cross(Z_A, Z_B))}/length"
COSINE = f"({dot(Z_A, Z_B)} - {dot(D, Z_A)}*{dot(D, Z_B)}/length/length)"

IN_SPACE = JointKind(
    "DoubleUniversal",
    doc="A shaft without mass with a Cardan joint at each end, whose crosses have the axes n_a of frame_a and n_b of "
    "frame_b; the other axes of the crosses enclose the angle psi about the shaft.",
    g=(less(LENGTH, "length"), Row(f"cos(psi)*{SINE} - sin(psi)*{COSINE}")),
    parameters=(
        Parameter("length", "m", doc="length of the shaft between the centres of the crosses", positive=True),
        Parameter("n_a", "1", (0.0, 0.0, 1.0), "axis of the cross in frame_a", shape=(3,)),
        Parameter("n_b", "1", (0.0, 0.0, 1.0), "axis of the cross in frame_b", shape=(3,)),
        Parameter("psi", "rad", 0.0, "angle between the axes of the crosses in the shaft"),
    ),
    signals=APART_IN_SPACE,
    results=(AXIAL,),
    check=lambda v: None if any(v["n_a"]) and any(v["n_b"]) else "an axis is zero",
    axes=lambda v: {"frame_a": turned_to("z", v["n_a"]), "frame_b": turned_to("z", v["n_b"])},
    placing=Placing(along=("s", "length"), aligned=f"(cos(psi)*{COSINE} + sin(psi)*{SINE})"),
    size="length",
    drawing="rod",
    spatial=True,
)
