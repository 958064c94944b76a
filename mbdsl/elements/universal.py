"""Universal: a Cardan joint, whose cross has one axis n_a in frame_a and one, n_b, in frame_b; in space.

    r_b - r_a = 0,   z_a . x_b = 0      with z_a along n_a and x_b along n_b             (4 rows)

Both axes of the frames coincide where phi_a = phi_b = 0: frame_b is turned by phi_a about z, then by phi_b about x.
"""

from collections.abc import Mapping, Sequence
from math import hypot

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import JointKind, Placing, Signal
from mbdsl.elements.rows import POINT, X_A, X_B, Y_A, Y_B, Z_A, Z_B, normal
from mbdsl.elements.vectors import W, dot, turned_to


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


IN_SPACE = JointKind(
    "Universal",
    doc="A Cardan joint: the origins coincide, and the axis n_a of frame_a stays at right angles to n_b of frame_b.",
    g=(*POINT, normal("z", "x")),
    parameters=(
        Parameter("n_a", "1", (1.0, 0.0, 0.0), "axis of the cross in frame_a", shape=(3,)),
        Parameter("n_b", "1", (0.0, 1.0, 0.0), "axis of the cross in frame_b", shape=(3,)),
    ),
    signals=(
        Signal("phi_a", "rad", f"angle({dot(Y_A, X_B)}, {dot(X_A, X_B)}, w_a)", "angle of the cross about n_a"),
        Signal("phi_b", "rad", f"angle({dot(Z_A, Y_B)}, {dot(Z_A, Z_B)}, w_b)", "angle of frame_b about n_b"),
        Signal("w_a", "rad/s", dot(W, Z_A), "rate of phi_a"),
        Signal("w_b", "rad/s", dot(W, X_B), "rate of phi_b"),
    ),
    check=lambda v: None if any(v["n_a"]) and any(v["n_b"]) else "an axis is zero",
    axes=axes,
    placing=Placing(moves=(("phi_a", "rz"), ("phi_b", "rx")), free_axes={"rotation": None}),
    spatial=True,
    drawing="cross",
)
