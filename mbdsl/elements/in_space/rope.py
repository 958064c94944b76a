"""Rope: pulls two points in space together along a path over discs about the z axes of frames, and winds on drums.

The path, and the tensions of its spans, are those of :mod:`~mbdsl.elements.rope_path`; g is that of
:mod:`.disc_tangents`.
"""

from dataclasses import replace

from mbdsl.compilation.marks import kernel
from mbdsl.elements import rope
from mbdsl.elements.in_space.disc_tangents import span_gradient, span_hessian
from mbdsl.elements.kind import in_space
from mbdsl.elements.motions import APART_IN_SPACE

DRAWING = "rope"
KIND = in_space(
    rope.KIND,
    signals=(replace(APART_IN_SPACE[0], doc=rope.KIND.signals[0].doc), *APART_IN_SPACE[1:], *rope.KIND.signals[2:]),
)


@kernel
def gradient(frames, a, b, p, G):
    span_gradient(frames, a, b, p[0], p[1], G, 0)


@kernel
def hessian(frames, a, b, p, s, H):
    span_hessian(frames, a, b, p[0], p[1], s[0], H)
