"""Universal: a Cardan joint, whose cross has one axis n_a in frame_a and one, n_b, in frame_b.

g = r_b - r_a,   z_a . x_b     with z_a along n_a and x_b along n_b                      (4 rows)

Both axes of the frames coincide where phi_a = phi_b = 0: frame_b is turned by phi_a about z, then by phi_b about x.
"""

from collections.abc import Mapping, Sequence
from math import hypot

from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space.coordinates import X, Z, dot1, dot1_hessian, point
from mbdsl.elements.in_space.revolute import X_A, X_B, Y_A, Z_A, Z_B
from mbdsl.elements.in_space.vectors import W, axis, cross, dot, reactions, total, turned_to
from mbdsl.elements.kind import JointKind, Parameter, Signal


def axes(v: Mapping) -> dict[str, tuple[float, ...]]:
    """Both frames coincide where n_a and n_b are at right angles, so that this is the attitude of the placement."""
    a, b = unit(v["n_a"]), unit(v["n_b"])
    along = sum(p * q for p, q in zip(a, b, strict=True))
    if abs(along) > 0.999:  # each vector belongs to its own frame: they may be parallel
        return {"frame_a": turned_to("z", a), "frame_b": turned_to("x", b)}
    across_a = unit([q - along * p for p, q in zip(a, b, strict=True)])
    across_b = unit([p - along * q for p, q in zip(a, b, strict=True)])
    return {
        "frame_a": (*across_a, *product(a, across_a), *a),
        "frame_b": (*b, *product(across_b, b), *across_b),
    }


def unit(a: Sequence[float]) -> list[float]:
    size = hypot(*a)
    return [x / size for x in a]


def product(a: Sequence[float], b: Sequence[float]) -> list[float]:
    """a x b."""
    return [a[j] * b[k] - a[k] * b[j] for j, k in ((1, 2), (2, 0), (0, 1))]


Y_B = axis("frame_b", "y")
SIGNALS = (
    Signal("phi_a", "rad", f"angle({dot(Y_A, X_B)}, {dot(X_A, X_B)}, w_a)", "angle of the cross about n_a"),
    Signal("phi_b", "rad", f"angle({dot(Z_A, Y_B)}, {dot(Z_A, Z_B)}, w_b)", "angle of frame_b about n_b"),
    Signal("w_a", "rad/s", dot(W, Z_A), "rate of phi_a"),
    Signal("w_b", "rad/s", dot(W, X_B), "rate of phi_b"),
)

KIND = JointKind(
    "Universal",
    doc="A Cardan joint: the origins coincide, and the axis n_a of frame_a stays at right angles to n_b of frame_b.",
    rows=4,
    parameters=(
        Parameter("n_a", "1", (1.0, 0.0, 0.0), "axis of the cross in frame_a", shape=(3,)),
        Parameter("n_b", "1", (0.0, 1.0, 0.0), "axis of the cross in frame_b", shape=(3,)),
    ),
    signals=SIGNALS,
    reactions=reactions(("-lam[1]", "-lam[2]", "-lam[3]"), total(("lam[4]", cross(Z_A, X_B)))),
    check=lambda v: None if any(v["n_a"]) and any(v["n_b"]) else "an axis is zero",
    axes=axes,
    moves=(("phi_a", "rz"), ("phi_b", "rx")),
    free_axes={"rotation": None},
    curved_by_rotations=True,
    in_loops="universal_in_axes",
    spatial=True,
)


@kernel
def gradient(frames, a, b, p, G):
    point(frames, a, b, G, 0)
    dot1(frames, a, Z, b, X, G, 3)


@kernel
def hessian(frames, a, b, p, s, H):
    dot1_hessian(frames, a, Z, b, X, s[3], H)
