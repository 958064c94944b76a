"""Buffers of one computation."""

from __future__ import annotations

from dataclasses import dataclass

from mbdsl.kernels.arrays import Array, Integers


@dataclass
class Workspace:
    """The buffers of one computation; see :mod:`mbdsl.kernels.buffer_layout`."""

    vectors: Array
    frames: Array
    gradients: Array
    numbers: Array
    layout: Integers
