"""ConstantVelocity in a closed loop: its rows g = R_a^T (r_b - r_a) are in the axes of frame_a, see rows_in_axes.py."""

from mbdsl.compilation.marks import kernel
from mbdsl.elements.in_space import constant_velocity
from mbdsl.elements.in_space.constant_velocity import gradient as gradient_in_world
from mbdsl.elements.in_space.constant_velocity import hessian as hessian_in_world
from mbdsl.elements.in_space.coordinates import point_in_axes, point_in_axes_hessian
from mbdsl.elements.in_space.rows_in_axes import in_axes

KIND = in_axes(constant_velocity.KIND)


@kernel
def gradient(frames, a, b, p, G):
    gradient_in_world(frames, a, b, p, G)
    point_in_axes(frames, a, b, G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    hessian_in_world(frames, a, b, p, s, H)
    point_in_axes_hessian(frames, a, b, s, H)
