"""Gear: two shafts in mesh whose axes are not parallel, as of bevel and worm gears.

    g = phi_a + ratio phi_b - phi0                                                       (1 row)

Each angle is that of a frame about its axis z from the direction of the other axis, across its own:

    phi_a = atan2(-y_a . z_b, x_a . z_b),   phi_b = atan2(-y_b . z_a, x_b . z_a)

They are angles relative to the carrier of both shafts, which may move in any way, as that of a differential does. They
count turns, and are zero where both frames have the same attitude: x_a and x_b are in the plane of both axes then. With
u = z_a . z_b,

    dg = L . (dphi_a - dphi_b),   L = ((1 + ratio u) z_a - (ratio + u) z_b)/(1 - u^2)

The multiplier is a torque [N.m], on frame_a about z_a for axes at right angles. The forces between the teeth, which the
bearings carry, are left out: they depend on radii and on the inclination of the teeth.
"""

from math import atan2, floor, pi

from mbdsl.elements.coordinates_in_space import PHI_A, PHI_B, X, Y, Z, add_cross
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import JointKind, Placing, Signal
from mbdsl.elements.rows import X_A, X_B, Y_A, Y_B, Z_A, Z_B
from mbdsl.elements.universal import product, unit
from mbdsl.elements.vectors import W, dot, reactions, total, turned_to
from mbdsl.kernels.columns import SPACE as C
from mbdsl.kernels.marks import kernel

PARALLEL = 0.999  #: cosine of the axes in their own frames, from which on they do not define x
TINY = 1e-12  #: least sin^2 of the angle between the axes; where they are parallel, the assembly is an error
U = dot(Z_A, Z_B)


def axes(v):
    """z along the axis, and x towards the other one, in frames of the same attitude."""
    a, b = unit(v["n_a"]), unit(v["n_b"])
    along = sum(x * y for x, y in zip(a, b, strict=True))
    if abs(along) > PARALLEL:
        return {"frame_a": turned_to("z", a), "frame_b": turned_to("z", b)}
    x_a = unit([y - along * x for x, y in zip(a, b, strict=True)])
    x_b = unit([x - along * y for x, y in zip(a, b, strict=True)])
    return {"frame_a": (*x_a, *product(a, x_a), *a), "frame_b": (*x_b, *product(b, x_b), *b)}


def check(v):
    if not (any(v["n_a"]) and any(v["n_b"])):
        return "an axis is zero"
    return "its ratio is zero" if v["ratio"] == 0.0 else None


IN_SPACE = JointKind(
    "Gear",
    doc="Two shafts in mesh with axes that are not parallel, as of bevel and worm gears: the angles about n_a and n_b, "
    "relative to the plane of both axes, obey phi_a + ratio phi_b = phi0. Other joints hold the shafts, on the ground "
    "or on a moving carrier. Parallel axes: GearPair.",
    rows=1,
    parameters=(
        Parameter("ratio", "1", doc="turns of frame_a for one of frame_b in the opposite sense; negative: the same"),
        Parameter("n_a", "1", (0.0, 0.0, 1.0), "axis of the shaft, in frame_a", shape=(3,)),
        Parameter("n_b", "1", (1.0, 0.0, 0.0), "axis of the shaft, in frame_b", shape=(3,)),
        Parameter("phi0", "rad", 0.0, "phi_a where phi_b is zero"),
    ),
    signals=(
        Signal("phi_a", "rad", f"angle(-{dot(Y_A, Z_B)}, {dot(X_A, Z_B)}, w_a)", "angle of frame_a about n_a"),
        Signal("phi_b", "rad", f"angle(-{dot(Y_B, Z_A)}, {dot(X_B, Z_A)}, w_b)", "angle of frame_b about n_b"),
        Signal("w_a", "rad/s", f"({U}*{dot(W, Z_B)} - {dot(W, Z_A)})/(1 - {U}*{U})", "rate of phi_a"),
        Signal("w_b", "rad/s", f"({dot(W, Z_B)} - {U}*{dot(W, Z_A)})/(1 - {U}*{U})", "rate of phi_b"),
    ),
    reactions=reactions(
        None,
        total((f"(lam[1]*(1 + ratio*{U})/(1 - {U}*{U}))", Z_A), (f"(-lam[1]*(ratio + {U})/(1 - {U}*{U}))", Z_B)),
    ),
    check=check,
    table=lambda v: (0.0, 0.0, 0.0, 0.0, v["ratio"], v["phi0"]),
    axes=axes,
    counts_turns=True,
    counted=("phi_a", "phi_b"),
    placing=Placing(crossing=True),
    spatial=True,
    drawing="dashed",
)


@kernel
def counted(frames, f, other, p):
    """The angle of frame f from the axis z of the other frame; p[0] is the last accepted one, p[1] becomes this one."""
    x, y = 0.0, 0.0
    for i in range(3):
        x += frames[f, X + i] * frames[other, Z + i]
        y += frames[f, Y + i] * frames[other, Z + i]
    phi = atan2(-y, x)
    p[1] = phi + 2.0 * pi * floor((p[0] - phi) / (2.0 * pi) + 0.5)
    return p[1]


@kernel
def cosine(frames, a, b):
    """u = z_a . z_b."""
    return frames[a, Z] * frames[b, Z] + frames[a, Z + 1] * frames[b, Z + 1] + frames[a, Z + 2] * frames[b, Z + 2]


@kernel
def gradient(frames, a, b, p, G):
    u, i = cosine(frames, a, b), p[4]
    sine = max(1.0 - u * u, TINY)
    A, B = (1.0 + i * u) / sine, (i + u) / sine
    G[0, C.VALUE] = counted(frames, a, b, p) + i * counted(frames, b, a, p[2:]) - p[5]
    for k in range(3):
        L = A * frames[a, Z + k] - B * frames[b, Z + k]
        G[0, PHI_A + k], G[0, PHI_B + k] = L, -L


@kernel
def hessian(frames, a, b, p, s, H):
    """dL = A dz_a - B dz_b + (A' z_a - B' z_b) du,  dz = dphi x z,  du = (z_a x z_b) . (dphi_a - dphi_b)."""
    u, i = cosine(frames, a, b), p[4]
    sine = max(1.0 - u * u, TINY)
    A, B = s[0] * (1.0 + i * u) / sine, s[0] * (i + u) / sine
    A1, B1 = s[0] * (i + 2.0 * u + i * u * u) / (sine * sine), s[0] * (1.0 + u * u + 2.0 * i * u) / (sine * sine)
    ax, ay, az = frames[a, Z], frames[a, Z + 1], frames[a, Z + 2]
    bx, by, bz = frames[b, Z], frames[b, Z + 1], frames[b, Z + 2]
    add_cross(-A * ax, -A * ay, -A * az, H, PHI_A, PHI_A)
    add_cross(A * ax, A * ay, A * az, H, PHI_B, PHI_A)
    add_cross(B * bx, B * by, B * bz, H, PHI_A, PHI_B)
    add_cross(-B * bx, -B * by, -B * bz, H, PHI_B, PHI_B)
    for k in range(3):
        j, l = (k + 1) % 3, (k + 2) % 3
        n = frames[a, Z + j] * frames[b, Z + l] - frames[a, Z + l] * frames[b, Z + j]
        for r in range(3):
            w = (A1 * frames[a, Z + r] - B1 * frames[b, Z + r]) * n
            H[PHI_A + r, PHI_A + k] += w
            H[PHI_A + r, PHI_B + k] -= w
            H[PHI_B + r, PHI_A + k] -= w
            H[PHI_B + r, PHI_B + k] += w
