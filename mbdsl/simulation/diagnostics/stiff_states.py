"""A warning about stiff states that begin away from the value at which they stay.

With h |f_x| far above one, a method of the Newmark family does not resolve how a state decays to its slow motion: it
multiplies the distance per step by about -(1/2 + alpha)/(1/2 - alpha), so that the state alternates for some steps.
"""

from __future__ import annotations

from mbdsl.integrators import declared
from mbdsl.simulation.examined_run import ExaminedRun

BEFORE = True
STIFF = 100.0  #: h |f_x| from which a state is stiff
NEAR = 1e-3  #: distance from the slow motion, relative to the state, that does not matter


def warnings(run: ExaminedRun) -> list[str]:
    """A warning about each stiff state that begins elsewhere; none of methods that remove the distance at once."""
    plan, found = run.motion.plan, list[str]()
    if plan.tol is not None or declared(plan.method).family != "Newmark":
        return found
    for p in run.motion.parts:
        if not p.system.tables.states:
            continue
        first = p.initial
        damping = p.system.damping(first.t, first.q, first.v, first.lam).diagonal()
        for c in (c for c in p.system.scene.states()):
            k = p.system.tables.coordinates[c.name]
            rate, f, x = float(damping[k]), float(first.a[k]), float(first.v[k])
            if plan.h * rate > STIFF and abs(f / rate) > NEAR * max(abs(x), abs(x + f / rate)):
                found.append(
                    f"state `{c.name}` is stiff, h |f_x| = {plan.h * rate:.2g}, and begins at {x:.4g}, from where it "
                    f"goes to {x + f / rate:.4g} within a step: write `der({c.name}) = 0` in `initial equation`"
                )
    return found
