"""FreeMotion: no constraint; declares that a body may move freely, and measures its motion in world axes."""

from mbdsl.elements import free_motion
from mbdsl.elements.in_space.kinds import in_space
from mbdsl.elements.in_space.revolute import SIGNALS_OF_ANGLE
from mbdsl.elements.in_space.vectors import D, W
from mbdsl.elements.kind import Signal

KIND = in_space(
    free_motion.KIND,
    signals=(
        *(Signal(key, "m", d, "in world axes") for key, d in zip("xyz", D, strict=True)),
        *SIGNALS_OF_ANGLE,
        *(Signal(f"v{key}", "m/s", f"der({key})") for key in "xyz"),
        *(
            Signal(f"w{key}", "rad/s", w, "relative angular velocity, in world axes")
            for key, w in zip("xyz", W, strict=True)
        ),
    ),
)
