"""RotationalCam: a cam turns a follower about a parallel axis n by a function f of its own angle.

    g = phi_b - f(phi_a)     with the angles from the line of centres, see line_of_centres.py                 (1 row)

Whole turns are removed from g. In models, phi_a is called phi, and phi_b beta. The multiplier is the torque on the
follower [N.m].
"""

from mbdsl.compilation.buffer_layout_in_space import VALUE
from mbdsl.compilation.marks import kernel
from mbdsl.elements import rotational_cam
from mbdsl.elements.coordinates_in_space import PHI_A, PHI_B
from mbdsl.elements.in_space.line_of_centres import (
    M_A,
    M_B,
    THETA,
    add_from_line,
    angle_of,
    from_line,
    from_line_hessian,
    gradient_from_line,
    product,
    rate_of,
)
from mbdsl.elements.kind import Signal, axis_given, in_space
from mbdsl.elements.line_of_centres import TURN, nearest
from mbdsl.elements.motions import AXIS_Z
from mbdsl.elements.vectors import D, both, cross, reactions, total

DRAWING = "dashed"

KIND = in_space(
    rotational_cam.KIND,
    parameters=(*rotational_cam.KIND.parameters, AXIS_Z),
    signals=(
        THETA,
        Signal("phi", "rad", angle_of("frame_a"), "angle of the cam, from the line of centres"),
        Signal("beta", "rad", angle_of("frame_b"), "angle of the follower, from this line"),
        Signal("w", "rad/s", rate_of("frame_a"), "angular velocity of the cam"),
        Signal("w_b", "rad/s", rate_of("frame_b"), "angular velocity of the follower"),
    ),
    reactions=reactions(
        total(("lam[1]", M_B), ("(-lam[1]*slope[1])", M_A)),
        total(("lam[1]", cross(M_B, D))),
    ),
    check=axis_given,
    axes=both("z"),
    first_angles={"phi": "frame_a.phi - theta", "beta": "frame_b.phi - theta"},
)


@kernel
def gradient(frames, a, b, p, G):
    G[0, VALUE] = nearest(from_line(frames, a, b, b) - p[0], TURN)
    for j in range(12):
        G[0, j] = 0.0
    add_from_line(frames, a, b, b, PHI_B, 1.0, G, 0)
    add_from_line(frames, a, b, a, PHI_A, -p[1], G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    """Of the angles, and -f'' (d phi/dz) (d phi/dz)^T."""
    from_line_hessian(frames, a, b, b, PHI_B, s[0], H)
    from_line_hessian(frames, a, b, a, PHI_A, -p[1] * s[0], H)
    dx, dy, dz, mx, my, mz, _square = gradient_from_line(frames, a, b, a)
    cx, cy, cz = product(mx, my, mz, dx, dy, dz)
    second = -s[0] * p[2]
    for i, u in ((0, mx), (1, my), (2, mz), (3, -cx), (4, -cy), (5, -cz), (6, -mx), (7, -my), (8, -mz)):
        for j, v in ((0, mx), (1, my), (2, mz), (3, -cx), (4, -cy), (5, -cz), (6, -mx), (7, -my), (8, -mz)):
            H[i, j] += second * u * v
