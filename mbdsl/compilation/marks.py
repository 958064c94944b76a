"""The former place of :mod:`mbdsl.kernels.marks`, for branches that are not merged yet."""

from mbdsl.kernels.marks import *  # noqa: F403
