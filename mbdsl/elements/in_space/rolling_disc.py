"""RollingDisc: a thin disc about the origin of frame_b that rolls without slip on a plane of frame_a.

With the normal k of the plane, the axis n of the disc, u = k . n and c = sqrt(1 - u^2), the lowest point of the disc is
r = -radius (k - u n)/c from its centre:

    g     = k . d - radius c,   d = r_b - r_a                                            (1 row)
    Gamma = (n x k) . V,   (n - u k) . V     with V = v_b - v_a - w_a x d + (w_b - w_a) x r
                                                                                         (2 rows, of velocities)

V is the velocity of the disc's lowest point relative to the plane; its part along k is the rate of g. A disc that lies
flat has no lowest point.
"""

from math import sqrt

from mbdsl.compilation.buffer_layout_in_space import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements import rolling_disc, universal
from mbdsl.elements.coordinates_in_space import X, Z, dot1, dot1_hessian, dot2, dot2_hessian
from mbdsl.elements.kind import Parameter, Signal, in_space
from mbdsl.elements.rows import X_B, Y_A, Y_B, Z_A, Z_B
from mbdsl.elements.vectors import D, W, cross, dot, origin, reactions, slip, total

U = dot(Z_A, X_B)
LOWEST = total((f"(-radius/sqrt(1 - {U}*{U}))", Z_A), (f"(radius*{U}/sqrt(1 - {U}*{U}))", X_B))
FORWARD, SIDEWARD = cross(X_B, Z_A), total(("1", X_B), (f"(-{U})", Z_A))
#: rate of the angle of the disc from the normal, about its axis
ROLL = f"({dot(SIDEWARD, W)}/(1 - {U}*{U}))"
V = total(("1", slip()), ("1", cross(W, LOWEST)))
FORCE = total(("-lam[1]", Z_A), ("-lam[2]", FORWARD), ("-lam[3]", SIDEWARD))


def check(v):
    return "the axis n or the normal is zero" if not (any(v["n"]) and any(v["normal"])) else None


KIND = in_space(
    rolling_disc.KIND,
    doc="A thin disc with its centre at the origin of frame_b rolls without slip on a plane through that of frame_a.",
    parameters=(
        *rolling_disc.KIND.parameters,
        Parameter("n", "1", (0.0, 0.0, 1.0), "axis of the disc, in frame_b", shape=(3,)),
        Parameter("normal", "1", (0.0, 1.0, 0.0), "normal of the plane, in frame_a, towards the disc", shape=(3,)),
    ),
    signals=(
        Signal("s", "m", dot(Y_A, D), "position of the centre along the direction normal x n at the start"),
        Signal("v", "m/s", "der(s)", "its rate"),
        Signal("phi", "rad", f"angle({dot(Z_A, Y_B)}, {dot(Z_A, Z_B)}, {ROLL})", "angle about the disc's axis"),
        Signal("w", "rad/s", dot(W, X_B), "angular velocity about the disc's axis"),
    ),
    velocity_rows=(dot(FORWARD, V), dot(SIDEWARD, V)),
    reactions=reactions(FORCE, cross(LOWEST, FORCE)),
    touches=total(("1", origin("frame_b")), ("1", LOWEST)),
    check=check,
    # where both frames coincide, the disc is upright, with its axis n in the direction n of the plane's frame
    axes=lambda v: universal.axes({"n_a": v["normal"], "n_b": v["n"]}),
    angle=(),
    along=(),
)


@kernel
def gradient(frames, a, b, p, G):
    """dg = d(k . d) + radius u/c du."""
    dot1(frames, a, Z, b, X, G, 0)
    u = G[0, VALUE]
    c = sqrt(1.0 - u * u)
    slope = p[0] * u / c
    x, y, z = slope * G[0, 3], slope * G[0, 4], slope * G[0, 5]
    dot2(frames, a, Z, b, G, 0)
    G[0, VALUE] -= p[0] * c
    G[0, 3] += x
    G[0, 4] += y
    G[0, 5] += z
    G[0, 9], G[0, 10], G[0, 11] = -x, -y, -z


@kernel
def hessian(frames, a, b, p, s, H):
    """d(u/c)/du = 1/c^3; du = (k x n) . (dphi_a - dphi_b)."""
    ax, ay, az = frames[a, Z], frames[a, Z + 1], frames[a, Z + 2]
    bx, by, bz = frames[b, X], frames[b, X + 1], frames[b, X + 2]
    u = ax * bx + ay * by + az * bz
    c = sqrt(1.0 - u * u)
    dot2_hessian(frames, a, Z, b, s[0], H)
    dot1_hessian(frames, a, Z, b, X, s[0] * p[0] * u / c, H)
    curve = s[0] * p[0] / (c * c * c)
    across = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    for i in range(3):
        for j in range(3):
            square = curve * across[i] * across[j]
            H[3 + i, 3 + j] += square
            H[3 + i, 9 + j] -= square
            H[9 + i, 3 + j] -= square
            H[9 + i, 9 + j] += square
