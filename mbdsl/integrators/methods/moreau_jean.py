"""Moreau-Jean: time stepping of rigid contacts, without location of events.

With theta = 1/2, velocities v and states x of first order, and q_theta = q_n + theta h v_theta:

    v_theta = v_n + theta (v_{n+1} - v_n),   q_{n+1} = q_n + h v_theta
    M (v_{n+1} - v_n) = h Q(t_n + theta h, q_theta, v_theta) - Phi_q^T Lam + W^T P
    Phi(q_{n+1}, t_{n+1}) = 0,   (Phi_q v + Phi_t)_{n+1} = 0
    0 <= u_N,n+1 + e u_N,n  perp  P_N >= 0;   |P_T| <= mu P_N, opposite to the slip u_T,n+1

u = W v are the velocities of the contacts whose gaps are not positive at q_n + theta h v_n; W and M are those of this
position. Forces are implicit: their linearisation is exact for linear springs and dampers, however stiff, and is
repeated for others. Impacts that touching bodies pass on are solved as the model says (:mod:`mbdsl.numerics.impact`),
and kinetic energy does not grow by them. A contact that lasts has P_N > 0 in every step; its reaction is P_N/h.

The order is 1 with impacts, because they occur at the end of the step that contains them: no impact, no lift-off and
no reversal of friction is located, and any number of them in a step takes one step. Without contacts the order is 2,
and with theta > 1/2 it is 1. Gaps of closed contacts are negative, by up to one step's way.

Conditions of when-equations are looked at at the ends of steps, where samples that are due act. Not available: joints
that stick, laws that read reactions of rigid contacts, inputs that change during a run, checkpoints.

Source: J. J. Moreau, Unilateral contact and dry friction in finite freedom dynamics, in: Nonsmooth Mechanics and
Applications (1988) 1-82; M. Jean, The non-smooth contact dynamics method, Comput. Methods Appl. Mech. Engrg. 177 (1999)
235-257.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from mbdsl.integrators.method import Method, Option

if TYPE_CHECKING:
    from mbdsl.integrators.backends import Problem

METHOD = Method(
    "moreau-jean",
    doc="time stepping of rigid contacts without location of events, for many impacts; order 2 without contacts",
    order=1,
    index=2,
    enforces=("Phi", "dPhi"),
    source="Moreau (1988); Jean (1999)",
    parameters={"theta": Option(0.5, 0.5, 1.0, "weight of the end of a step; above 1/2, stiff vibrations are damped")},
    knows=("when", "contacts"),
    spatial=True,
)


def solve(problem: Problem) -> Iterator[tuple]:
    """Yield t, q, v and lam at the ends of all steps."""
    from mbdsl.integrators.contact_steps import ContactSteps

    return ContactSteps(problem).states()
