"""Bushing: a linear spring and damper in the three directions of the plane, in the axes of frame_a or of the world.

g = (t_a . d, n_a . d, phi_b - phi_a),  d = r_b - r_a;  s_k = k_k g_k + c_k dg_k/dt

In axes of the world, (t_a, n_a) are the unit vectors along x and y, and the forces on both frames are opposite, but not
along one line: their moments do not cancel, as the world's axes resist turning.

In space, in six directions:

    g = (x_a . d, y_a . d, z_a . d, sigma_1, sigma_2, psi),  d = r_b - r_a;  s_k = k_k g_k + c_k dg_k/dt
    torque on frame_b, besides these: -(c_w1 x_a x_a^T + c_w2 y_a y_a^T + c_w3 z_a z_a^T) (w_b - w_a)

The attitude of frame_b is a twist psi about z_a, which counts turns, followed by a tilt with the rotation vector sigma
along x_a and y_a (:mod:`~mbdsl.elements.swing_twist`). Rotations about one axis of frame_a alone have torques
that are linear at any angle. The forces have a potential, and small rotations are those about x_a, y_a and z_a. A tilt
of half a turn has no direction.

With the forces in axes of the world, (x_a, y_a, z_a) in the first three rows are the unit vectors along x, y and z.
"""

from collections.abc import Mapping

from mbdsl.elements.coordinates_in_space import X as X_AXIS
from mbdsl.elements.coordinates_in_space import Y as Y_AXIS
from mbdsl.elements.coordinates_in_space import Z as Z_AXIS
from mbdsl.elements.coordinates_in_space import point, point_in_axes, point_in_axes_hessian, turn, turn_hessian
from mbdsl.elements.declaration import Parameter, power
from mbdsl.elements.kind import ForceKind, Signal, in_space, zero
from mbdsl.elements.row import Row
from mbdsl.elements.rows import TURN
from mbdsl.elements.swing_twist import (
    RATE,
    TILT,
    TWIST,
    X_A,
    Y_A,
    Z_A,
    tilt,
    tilt_hessian,
    twist,
    twist_hessian,
)
from mbdsl.elements.vectors import D, W, dot, total, wrench
from mbdsl.kernels.marks import kernel

#: the forces along, and the torque about, coordinates
RESISTS = (
    ("(k[1]*x + c[1]*der(x))", "x"),
    ("(k[2]*y + c[2]*der(y))", "y"),
    ("(k_phi*(phi - phi0) + c_phi*der(phi))", "phi"),
)

PHI = "turns[1]*frame_a.phi"  #: angle of the axes of the forces
X = f"cos({PHI})*(frame_b.x - frame_a.x) + sin({PHI})*(frame_b.y - frame_a.y)"
Y = f"cos({PHI})*(frame_b.y - frame_a.y) - sin({PHI})*(frame_b.x - frame_a.x)"
AXES = Parameter(
    "axes", "", "frame_a", "axes of k and c, those of frame_a or of the world", choices=("frame_a", "world")
)


def turning(v):
    """(1,) if the axes of the forces turn with frame_a, (0,) if they are those of the world."""
    return {"turns": (1.0 if v["axes"] == "frame_a" else 0.0,)}


KIND = ForceKind(
    "Bushing",
    doc="A compliant joint: spring and damper along x and y of frame_a, or of the world, and about the angle.",
    g=(Row("", X), Row("", Y), Row("", TURN)),
    parameters=(
        Parameter("k", "N/m", (0.0, 0.0), "stiffness along x and y of `axes`", shape=(2,)),
        Parameter("c", "N.s/m", (0.0, 0.0), "damping along x and y of `axes`", shape=(2,)),
        Parameter("k_phi", "N.m/rad", 0.0, "torsional stiffness"),
        Parameter("c_phi", "N.m.s/rad", 0.0, "torsional damping"),
        Parameter("phi0", "rad", 0.0, "angle without torque"),
        AXES,
    ),
    signals=(
        Signal("x", "m", X),
        Signal("y", "m", Y),
        Signal("phi", "rad", TURN),
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
    drawing="bushing",
)

# -- in space ----------------------------------------------------------------------------------------------------------

NONE = (0.0, 0.0, 0.0)


def derive_in_space(v: Mapping) -> dict:
    """Stiffness and damping of the plane: two along x and y, and one about z; one c_w about all axes."""
    found: dict = {name: (*v[name], 0.0) for name in ("k", "c") if len(v[name]) == 2}
    found |= turning(v)
    found |= {name: (0.0, 0.0, v[name]) for name in ("k_phi", "c_phi") if not isinstance(v[name], tuple)}
    return found if isinstance(v["c_w"], tuple) else found | {"c_w": (v["c_w"],) * 3}


#: the forces along, and the torques about, coordinates; c_w acts about the axes of frame_a
RESISTS_IN_SPACE = (
    *((f"(k[{i}]*{x} + c[{i}]*der({x}))", x) for i, x in enumerate("xyz", 1)),
    ("(k_phi[1]*phi_x + c_phi[1]*der(phi_x))", "phi_x"),
    ("(k_phi[2]*phi_y + c_phi[2]*der(phi_y))", "phi_y"),
    ("(k_phi[3]*(phi - phi0) + c_phi[3]*w)", "phi"),
)
SPINS = tuple(dot(W, a) for a in (X_A, Y_A, Z_A))
POWER = [f"{size}*{'w' if x == 'phi' else f'der({x})'}" for size, x in RESISTS_IN_SPACE]
POWER += [f"c_w[{i}]*{w}*{w}" for i, w in enumerate(SPINS, 1)]

IN_SPACE = in_space(
    KIND,
    g=(),
    doc="A compliant joint: spring and damper along and about x, y and z of frame_a; along those of the world with "
    '`axes = "world"`.',
    rows=9,
    parameters=(
        Parameter("k", "N/m", NONE, "stiffness along x, y and z of `axes`", shape=(3,), or_shapes=((2,),)),
        Parameter("c", "N.s/m", NONE, "damping along x, y and z of `axes`", shape=(3,), or_shapes=((2,),)),
        Parameter(
            "k_phi", "N.m/rad", NONE, "stiffness about x, y and z; a number: about z", shape=(3,), or_shapes=((),)
        ),
        Parameter(
            "c_phi",
            "N.m.s/rad",
            NONE,
            "damping of the rates of phi_x, phi_y and phi; a number: of phi",
            shape=(3,),
            or_shapes=((),),
        ),
        Parameter(
            "c_w",
            "N.m.s/rad",
            NONE,
            "damping of the relative angular velocity about x, y and z of frame_a; a number: about all axes",
            shape=(3,),
            or_shapes=((),),
        ),
        Parameter("phi0", "rad", 0.0, "twist without torque"),
        AXES,
    ),
    signals=(
        *(
            Signal(
                key, "m", f"turns[1]*{dot(a, D)} + (1 - turns[1])*{d}", f"position along {key} of the axes of k and c"
            )
            for key, a, d in zip("xyz", (X_A, Y_A, Z_A), D, strict=True)
        ),
        Signal("phi_x", "rad", TILT[0], "tilt about x of frame_a"),
        Signal("phi_y", "rad", TILT[1], "tilt about y of frame_a"),
        Signal("phi", "rad", TWIST, "twist about z of frame_a"),
        Signal("w", "rad/s", RATE, "rate of the twist"),
    ),
    energy="0.5*k[1]*x^2 + 0.5*k[2]*y^2 + 0.5*k[3]*z^2"
    " + 0.5*k_phi[1]*phi_x^2 + 0.5*k_phi[2]*phi_y^2 + 0.5*k_phi[3]*(phi - phi0)^2",
    results=(power(f"-({' + '.join(POWER)})"),),
    resists=RESISTS_IN_SPACE,
    exerts=wrench(None, total(*((f"(-c_w[{i + 1}]*{SPINS[i]})", a) for i, a in enumerate((X_A, Y_A, Z_A))))),
    derive=derive_in_space,
    effects={"damping": zero("c", "c_phi", "c_w")},
    springs=lambda v: (
        *((v["k"][i], v["c"][i], 0.0) for i in range(3)),
        *((v["k_phi"][i], v["c_phi"][i], v["phi0"] if i == 2 else 0.0) for i in range(3)),
        *((0.0, c, 0.0) for c in v["c_w"]),
    ),
    table=lambda v: (0.0, 0.0, *v["turns"]),
    counts_turns=True,
)


@kernel
def gradient_in_space(frames, a, b, p, G):
    if p[2] == 0.0:
        point(frames, a, b, G, 0)
    else:
        point_in_axes(frames, a, b, G, 0)
    tilt(frames, a, b, G, 3)
    twist(frames, a, b, p, G, 5)
    turn(frames, a, X_AXIS, G, 6)
    turn(frames, a, Y_AXIS, G, 7)
    turn(frames, a, Z_AXIS, G, 8)


@kernel
def hessian_in_space(frames, a, b, p, s, H):
    if p[2] != 0.0:
        point_in_axes_hessian(frames, a, b, s, H)
    if s[3] != 0.0 or s[4] != 0.0:  # after half a turn, these do not exist
        tilt_hessian(frames, a, b, s[3], s[4], H)
    if s[5] != 0.0:
        twist_hessian(frames, a, b, s[5], H)
    turn_hessian(frames, a, X_AXIS, s[6], H)
    turn_hessian(frames, a, Y_AXIS, s[7], H)
    turn_hessian(frames, a, Z_AXIS, s[8], H)
