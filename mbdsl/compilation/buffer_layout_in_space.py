"""The buffers of models in space: columns and sizes that differ from those in the plane.

All other names are those of :mod:`mbdsl.compilation.buffer_layout`. Code that is the same in the plane and in space
reads the names from there; :mod:`mbdsl.system.in_space` makes its variants with the names from here.

A pose has 12 entries: the origin r and the axes x, y, z of the frame in world coordinates. Rates, wrenches and
gradients have 6: velocity and angular velocity, force and torque, virtual displacement and rotation, in world axes.
"""

from mbdsl.compilation.buffer_layout import *  # noqa: F403

# -- columns of frames: the origin in 0 .. 2 and the axes in 3 .. 11, then: -----------------------------------------
AXES = 3  #: x axis, y axis, z axis
POSE = 6  #: entries of a rate, of a wrench, and of a virtual displacement
RATE = 12  #: velocity and angular velocity, 12 .. 17
WRENCH = 18  #: accumulated force and torque, 18 .. 23
LEVER = 24  #: from the centre of mass to the origin of a frame on a rigid body
MU_WRENCH = 27  #: wrench of mu, 27 .. 32
PAST_WRENCH, PAST_LEVER = 33, 39  #: wrench of psi and lever, both for the pose at the start of the step
COLUMNS = 42
CARRIED = 18
LEVERS = 3

# -- columns of gradients -------------------------------------------------------------------------------------------
PAIR_POSE = 2 * POSE
VALUE, MAGNITUDE = 12, 13
GRADIENT_RATE = 14  #: 14 .. 25
PAST_GRADIENT = 26  #: 26 .. 37
GRADIENT_COLUMNS = 38

# -- blocks in numbers ----------------------------------------------------------------------------------------------
SQUARE = PAIR_POSE * PAIR_POSE
HALF = POSE * PAIR_POSE
BLOCK_SIZE = POSE * POSE
TANGENT_SCRATCH = 2 * SQUARE

# -- records in layout ----------------------------------------------------------------------------------------------
LEAF = 1 + PAIR_POSE
MOVED = 1 + CARRIED + POSE  #: row of the frame table; registers of pose, rates and accelerations
