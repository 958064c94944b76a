"""Buffers of one computation."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass
class Workspace:
    """The buffers of one computation; see :mod:`mbdsl.kernels.buffer_layout`."""

    vectors: Array
    frames: Array
    gradients: Array
    numbers: Array
    layout: NDArray[np.int64]
