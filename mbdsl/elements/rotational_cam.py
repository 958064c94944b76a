"""RotationalCam: a cam turns a follower by a function f of its own angle; also Geneva drives, non-circular gears.

    g = beta - f(phi),  phi = phi_a - theta,  beta = phi_b - theta                       (1 row)

with theta the angle of the line of centres, see line_of_centres.py. Whole turns are removed from g. The multiplier is
the torque on the follower [N.m]. The bearing forces are those of a contact force perpendicular to the line of
centres, at the point where the common normal crosses this line; the component along the line does no work and is left
out. In space both axes have the direction n, and phi_a is called phi, phi_b beta.
"""

from mbdsl.elements.coordinates_in_space import PHI_A, PHI_B
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import JointKind, Signal, in_space, wrench
from mbdsl.elements.line_of_centres import FORMULA, SQUARE, TURN, add_direction, direction, direction_hessian, nearest
from mbdsl.elements.line_of_centres_in_space import (
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
from mbdsl.elements.motions import AXIS_Z
from mbdsl.elements.vectors import D, both, cross, reactions, total
from mbdsl.kernels.columns import PLANE, SPACE
from mbdsl.kernels.marks import kernel

KIND = JointKind(
    "RotationalCam",
    doc="A cam about the origin of frame_a turns frame_b about its origin, as a function of the cam angle. Both angles "
    "are measured from the line between the origins.",
    rows=1,
    parameters=(Parameter("beta", "rad", doc="angle of the follower at the cam angle phi", law=True),),
    signals=(
        Signal("theta", "rad", FORMULA, "angle of the line from frame_a to frame_b"),
        Signal("phi", "rad", "frame_a.phi - theta", "angle of the cam, from this line"),
        Signal("beta", "rad", "frame_b.phi - theta", "angle of the follower, from this line"),
        Signal("w", "rad/s", "der(phi)", "angular velocity of the cam"),
        Signal("w_b", "rad/s", "der(beta)", "angular velocity of the follower"),
    ),
    reactions=wrench(
        f"-(lam[1]*(1 - slope[1])*(frame_b.y - frame_a.y)/{SQUARE})",
        f"lam[1]*(1 - slope[1])*(frame_b.x - frame_a.x)/{SQUARE}",
        "-lam[1]",
    ),
    functions=(("beta", ("phi",)),),
    misfit=lambda values, distance: None,
    table=lambda v: (0.0, 0.0, 0.0),
    drawing="dashed",
)


@kernel
def gradient(frames, a, b, p, G):
    theta = direction(frames, a, b)
    G[0, PLANE.VALUE] = nearest(frames[b, 2] - theta - p[0], TURN)
    for j in range(6):
        G[0, j] = 0.0
    G[0, 2], G[0, 5] = -p[1], 1.0
    add_direction(frames, a, b, p[1] - 1.0, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    """-(1 - f') d^2 theta/dz^2 - f'' (d phi/dz) (d phi/dz)^T."""
    direction_hessian(frames, a, b, (p[1] - 1.0) * s[0], H)
    dx, dy = frames[b, 0] - frames[a, 0], frames[b, 1] - frames[a, 1]
    square = dx * dx + dy * dy
    if square > 0.0:
        x, y, second = dy / square, -dx / square, s[0] * p[2]
        for i, u in ((0, -x), (1, -y), (2, 1.0), (3, x), (4, y)):
            for j, v in ((0, -x), (1, -y), (2, 1.0), (3, x), (4, y)):
                H[i, j] -= second * u * v


IN_SPACE = in_space(
    KIND,
    parameters=(*KIND.parameters, AXIS_Z),
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
    axes=both("z"),
    first_angles={"phi": "frame_a.phi - theta", "beta": "frame_b.phi - theta"},
)


@kernel
def gradient_in_space(frames, a, b, p, G):
    G[0, SPACE.VALUE] = nearest(from_line(frames, a, b, b) - p[0], TURN)
    for j in range(12):
        G[0, j] = 0.0
    add_from_line(frames, a, b, b, PHI_B, 1.0, G, 0)
    add_from_line(frames, a, b, a, PHI_A, -p[1], G, 0)


@kernel
def hessian_in_space(frames, a, b, p, s, H):
    """Of the angles, and -f'' (d phi/dz) (d phi/dz)^T."""
    from_line_hessian(frames, a, b, b, PHI_B, s[0], H)
    from_line_hessian(frames, a, b, a, PHI_A, -p[1] * s[0], H)
    dx, dy, dz, mx, my, mz, _square = gradient_from_line(frames, a, b, a)
    cx, cy, cz = product(mx, my, mz, dx, dy, dz)
    second = -s[0] * p[2]
    for i, u in ((0, mx), (1, my), (2, mz), (3, -cx), (4, -cy), (5, -cz), (6, -mx), (7, -my), (8, -mz)):
        for j, v in ((0, mx), (1, my), (2, mz), (3, -cx), (4, -cy), (5, -cz), (6, -mx), (7, -my), (8, -mz)):
            H[i, j] += second * u * v
