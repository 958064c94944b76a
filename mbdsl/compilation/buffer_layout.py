"""The former place of :mod:`mbdsl.kernels.buffer_layout` and ``PLANE``, for branches that are not merged yet."""

from mbdsl.kernels.buffer_layout import *  # noqa: F403
from mbdsl.kernels.columns import PLANE


def __getattr__(name: str) -> int:
    return int(getattr(PLANE, name))
