"""RotationalStop: limits of the angle of a joint, stiff torsional springs with damping beyond them; rigid without `k`.

torque = k d^n max(0, 1 + alpha d'),  d = phi - phi_max or phi_min - phi,  where d > 0    see contact_law.py
"""

from mbdsl.elements import contact_law
from mbdsl.elements.declaration import power
from mbdsl.elements.kind import ForceKind, Signal, in_space
from mbdsl.elements.motions import TURNING, about_n
from mbdsl.elements.rigid_contact import specialised
from mbdsl.elements.rows import ANGLE
from mbdsl.elements.translational_stop import bounds, check_limits, energy, force, limits, rigid, touch

KIND = ForceKind(
    "RotationalStop",
    doc="Limits of an angle: beyond them a stiff torsional spring pushes back; it never pulls.",
    g=(ANGLE,),
    parameters=(*limits("phi_min", "phi_max", "rad"), *contact_law.parameters("N.m/rad", "w_0", "rad/s")),
    signals=(*TURNING, Signal("torque", "N.m", force("phi", "w"), "resisting torque")),
    results=(power("-(torque*w)"),),
    resists=(("torque", "phi"),),
    energy=energy("phi"),
    check=lambda v: check_limits(v, "phi_min", "phi_max") or contact_law.check(v, "w_0"),
    derive=lambda v: {**bounds(v, "phi_min", "phi_max"), **contact_law.derive(v, "w_0")},
    laws=("torque",),
    effects=contact_law.EFFECTS_OR_RIGID,
    touching=rigid("phi", "phi_min", "phi_max"),
    specialised=specialised("rotational_stop"),
    latches=touch("phi", "w", "w_0"),
    drawing="turning stop",
)
IN_SPACE = in_space(KIND, about_n)
