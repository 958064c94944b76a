"""PointOnSurface: the origin of frame_b stays on a surface f(x, y, z) = 0 of frame_a.

    g = f(x, y, z),  (x, y, z) = (x_a . d, y_a . d, z_a . d),  d = r_b - r_a                              (1 row)

With n = f_x x_a + f_y y_a + f_z z_a and the virtual change B z of d in frame_a, B = [-I, d~, I]:

    G = (-n, n x d, n, 0),   H = that of n . d with the axes of frame_a in n, and B^T F B, F = sum f_ij e_i e_j^T

The reaction is normal to the surface. f has to have a gradient on it. Friction: a force mu times the reaction against
the sliding, see friction.py and sliding_friction.py.
"""

from mbdsl.compilation.buffer_layout_in_space import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements import friction, sliding_friction
from mbdsl.elements.coordinates_in_space import PHI_A, R_A, R_B, X, dot2_hessian
from mbdsl.elements.kind import JointKind, Parameter, Signal
from mbdsl.elements.rows import X_A, Y_A, Z_A
from mbdsl.elements.vectors import D, Vector, dot, origin, reactions, total, wrench

AXES = (X_A, Y_A, Z_A)
SIGNALS = (
    *(Signal(key, "m", dot(a, D), "position in frame_a") for key, a in zip("xyz", AXES, strict=True)),
    *(Signal(f"v{key}", "m/s", f"der({key})", "its rate") for key in "xyz"),
)
COUNT = 10  #: numbers of a function: f; f_x, f_y, f_z; f_xx, f_xy, f_xz, f_yy, f_yz, f_zz


def surface(name: str, doc: str) -> Parameter:
    """The parameter of a function."""
    return Parameter(name, "", doc=doc, law=True)


def force(row: int) -> Vector:
    """-lam n of a row, counted from 1."""
    return total(*((f"(-lam[{row}]*slope[{3 * row - 2 + i}])", a) for i, a in enumerate(AXES)))


FRICTION = friction.parameters("v", "m/s", 1e-3)
RATES = "vx", "vy", "vz"
KIND = JointKind(
    "PointOnSurface",
    doc="The origin of frame_b stays on the surface f = 0 of frame_a, free to turn.",
    rows=1,
    parameters=(
        surface("f", "function of the coordinates in frame_a that is zero on the surface, of any unit"),
        *FRICTION,
    ),
    signals=SIGNALS,
    reactions=reactions(force(1), None),
    **sliding_friction.against("hypot(hypot(fx, fy), fz)", "v", "sliding_in_space", RATES, AXES),
    touches=origin("frame_b"),
    functions=(("f", ("x", "y", "z")),),
    table=lambda v: (0.0,) * COUNT,
    spatial=True,
)


@kernel
def gradient(frames, a, b, p, G):
    level(frames, a, b, p, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    level_hessian(frames, a, b, p, s[0], H)


@kernel
def level(frames, a, b, p, G, k):
    """g = f in row k."""
    G[k, VALUE] = p[0]
    nx, ny, nz = in_world(frames, a, p[1], p[2], p[3])
    dx, dy, dz = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1], frames[b, 2] - frames[a, 2]
    G[k, R_A], G[k, R_A + 1], G[k, R_A + 2] = -nx, -ny, -nz
    G[k, PHI_A], G[k, PHI_A + 1], G[k, PHI_A + 2] = ny * dz - nz * dy, nz * dx - nx * dz, nx * dy - ny * dx
    G[k, R_B], G[k, R_B + 1], G[k, R_B + 2] = nx, ny, nz


@kernel
def level_hessian(frames, a, b, p, factor, H):
    """H += factor * d(G^T)/dz."""
    for i in range(3):
        dot2_hessian(frames, a, X + 3 * i, b, factor * p[1 + i], H)
    for j in range(R_B + 3):
        x, y, z = change(frames, a, b, j)
        u, v, w = in_frame(frames, a, x, y, z)
        x, y, z = in_world(
            frames,
            a,
            factor * (p[4] * u + p[5] * v + p[6] * w),
            factor * (p[5] * u + p[7] * v + p[8] * w),
            factor * (p[6] * u + p[8] * v + p[9] * w),
        )
        for i in range(R_B + 3):
            bx, by, bz = change(frames, a, b, i)
            H[i, j] += bx * x + by * y + bz * z


@kernel
def in_world(frames, a, u, v, w):
    """A vector with components in frame a, in world axes."""
    x = frames[a, X] * u + frames[a, X + 3] * v + frames[a, X + 6] * w
    y = frames[a, X + 1] * u + frames[a, X + 4] * v + frames[a, X + 7] * w
    z = frames[a, X + 2] * u + frames[a, X + 5] * v + frames[a, X + 8] * w
    return x, y, z


@kernel
def in_frame(frames, a, x, y, z):
    """The components of a vector in frame a."""
    u = frames[a, X] * x + frames[a, X + 1] * y + frames[a, X + 2] * z
    v = frames[a, X + 3] * x + frames[a, X + 4] * y + frames[a, X + 5] * z
    w = frames[a, X + 6] * x + frames[a, X + 7] * y + frames[a, X + 8] * z
    return u, v, w


@kernel
def change(frames, a, b, j):
    """Column j of B, in world axes."""
    dx, dy, dz = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1], frames[b, 2] - frames[a, 2]
    if j == PHI_A:
        return 0.0, dz, -dy
    if j == PHI_A + 1:
        return -dz, 0.0, dx
    if j == PHI_A + 2:
        return dy, -dx, 0.0
    sign = -1.0 if j < PHI_A else 1.0
    i = j % 3
    x = sign if i == 0 else 0.0
    y = sign if i == 1 else 0.0
    z = sign if i == 2 else 0.0
    return x, y, z
