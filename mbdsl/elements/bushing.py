"""Bushing: a linear spring and damper in the three directions of the plane, in the axes of frame_a or of the world.

g = (t_a . d, n_a . d, phi_b - phi_a),  d = r_b - r_a;  s_k = k_k g_k + c_k dg_k/dt

In axes of the world, (t_a, n_a) are the unit vectors along x and y, and the forces on both frames are opposite, but not
along one line: their moments do not cancel, as the world's axes resist turning.
"""

from mbdsl.compilation.buffer_layout import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements.coordinates import angle, offset, offset_hessian, slide, slide_hessian
from mbdsl.elements.kind import ForceKind, Parameter, Signal, power, zero

#: the forces along, and the torque about, coordinates
RESISTS = (
    ("(k[1]*x + c[1]*der(x))", "x"),
    ("(k[2]*y + c[2]*der(y))", "y"),
    ("(k_phi*(phi - phi0) + c_phi*der(phi))", "phi"),
)

PHI = "turns[1]*frame_a.phi"  #: angle of the axes of the forces
AXES = Parameter(
    "axes", "", "frame_a", "axes of k and c, those of frame_a or of the world", choices=("frame_a", "world")
)


def turning(v):
    """(1,) if the axes of the forces turn with frame_a, (0,) if they are those of the world."""
    return {"turns": (1.0 if v["axes"] == "frame_a" else 0.0,)}


KIND = ForceKind(
    "Bushing",
    doc="A compliant joint: spring and damper along x and y of frame_a, or of the world, and about the angle.",
    rows=3,
    parameters=(
        Parameter("k", "N/m", (0.0, 0.0), "stiffness along x and y of `axes`", shape=(2,)),
        Parameter("c", "N.s/m", (0.0, 0.0), "damping along x and y of `axes`", shape=(2,)),
        Parameter("k_phi", "N.m/rad", 0.0, "torsional stiffness"),
        Parameter("c_phi", "N.m.s/rad", 0.0, "torsional damping"),
        Parameter("phi0", "rad", 0.0, "angle without torque"),
        AXES,
    ),
    signals=(
        Signal("x", "m", f"cos({PHI})*(frame_b.x - frame_a.x) + sin({PHI})*(frame_b.y - frame_a.y)"),
        Signal("y", "m", f"cos({PHI})*(frame_b.y - frame_a.y) - sin({PHI})*(frame_b.x - frame_a.x)"),
        Signal("phi", "rad", "frame_b.phi - frame_a.phi"),
    ),
    energy="0.5*k[1]*x^2 + 0.5*k[2]*y^2 + 0.5*k_phi*(phi - phi0)^2",
    results=(power("-(" + " + ".join(f"{size}*der({x})" for size, x in RESISTS) + ")"),),
    resists=RESISTS,
    derive=turning,
    effects={"damping": zero("c", "c_phi")},
    springs=lambda v: (
        (v["k"][0], v["c"][0], 0.0),
        (v["k"][1], v["c"][1], 0.0),
        (v["k_phi"], v["c_phi"], v["phi0"]),
    ),
    table=lambda v: v["turns"],
)


@kernel
def gradient(frames, a, b, p, G):
    angle(frames, a, b, G, 2)
    if p[0] == 0.0:
        for k in range(2):
            G[k, VALUE] = frames[b, k] - frames[a, k]
            G[k, k], G[k, 3 + k] = -1.0, 1.0
        return
    slide(frames, a, b, G, 0)
    offset(frames, a, b, G, 1)


@kernel
def hessian(frames, a, b, p, s, H):
    if p[0] != 0.0:
        slide_hessian(frames, a, b, s[0], H)
        offset_hessian(frames, a, b, s[1], H)
