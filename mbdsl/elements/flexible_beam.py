"""FlexibleBeam: a uniform straight beam that bends and stretches; joints attach to it as to any other body.

Euler-Bernoulli, in the plane. ``formulation = "floating"`` treats deformation as small relative to a frame that
moves with the beam (:mod:`mbdsl.bodies.floating_beam_kernels`), by finite elements or by their modes; ``"ancf"`` allows
large deformations, with absolute positions and slopes of nodes as coordinates
(:mod:`mbdsl.bodies.ancf_cable_kernels`). With ``modes = 0`` it is a rigid rod, in both formulations.
"""

from collections.abc import Mapping

from mbdsl.bodies import ancf_cable_kernels, floating_beam_kernels, rigid_body_kernels
from mbdsl.elements import body
from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import BodyKind, zero

MOTIONS = (rigid_body_kernels, floating_beam_kernels, ancf_cable_kernels)
FLOATING, ANCF = "floating", "ancf"
#: limits, because the matrices are full during assembly
MOST_ELEMENTS, MOST_MODES = {FLOATING: 256, ANCF: 2000}, 256


def motion(values: Mapping):
    """The module whose kernels move frames on a beam with these values."""
    if values["modes"] == 0:
        return rigid_body_kernels
    return ancf_cable_kernels if values["formulation"] == ANCF else floating_beam_kernels


def coordinates(values: Mapping) -> tuple[str, ...]:
    """Names of the coordinates: those of a body for a rigid rod, else numbers, as they depend on the formulation."""
    if values["modes"] == 0:
        return ("x", "y", "phi")
    elements = int(values["elements"])
    if values["formulation"] == ANCF:
        count = 4 * (elements + 1)
    else:
        count = 3 + (4 * elements if values["modes"] is None else int(values["modes"]))
    return tuple(f"q[{j}]" for j in range(1, count + 1))


def check(values: Mapping) -> str | None:
    """Checks of the values together, in the order in which a user would correct them."""
    v = values
    if v["density"] is None and v["mass"] is None:
        return "its mass is missing; give the density of the material, or the mass of the whole beam"
    if v["density"] is not None and v["mass"] is not None:
        return "the mass follows from the density: give one or the other"
    for name in ("elements", "modes", "axial"):
        if v[name] is not None and v[name] != int(v[name]):
            return f"`{name}` is a whole number, not {v[name]:g}"
    if v["elements"] is not None and v["elements"] < 1:
        return "a beam has at least one element"
    most = MOST_ELEMENTS[v["formulation"]]
    if v["elements"] is not None and v["elements"] > most:
        return f"{v['elements']:g} elements are too many: up to {most} are possible"
    if v["modes"] is not None and v["modes"] > MOST_MODES:
        return f"{v['modes']:g} modes are too many: up to {MOST_MODES} are possible"
    for name, (x, y, _) in v["frames"]:
        if y != 0.0 or not abs(x) <= v["length"] / 2 * (1 + 1e-9):
            return (
                f"frame `{name}` does not lie on its axis: {{x, 0, phi}} with x, from the middle, between "
                f"-{v['length'] / 2:g} and {v['length'] / 2:g} m"
            )
    modes, axial, ancf = v["modes"], v["axial"], v["formulation"] == ANCF
    if modes == 0:
        return None
    if ancf:
        for name in ("modes", "axial"):
            if v[name] is not None:
                return f'`{name}` belongs to formulation = "{FLOATING}": with ANCF the elements\' nodes are coordinates'
        if v["zeta"] or v["alpha"]:
            return "with ANCF damping is given by `beta`: `zeta` and `alpha` would damp rigid motion, too"
        return None
    if modes is None:
        if axial is not None:
            return "`axial` is the number of axial ones among the `modes`: give `modes`, too"
        if v["reference"] == "mean-axis":
            return "the mean axis is the frame of free-free modes: give `modes`"
        if v["zeta"]:
            return "`zeta` is a damping ratio of modes: give `modes`, or Rayleigh's `alpha` and `beta`"
    else:
        if axial is not None and axial > modes:
            return f"{axial:g} of {modes:g} modes cannot be axial ones"
        boundary = 6 if v["reference"] == "mean-axis" else 3
        if v["basis"] == "craig-bampton" and modes < 3:
            return f"Craig-Bampton modes include three static modes of the ends: at least 3 modes, not {modes:g}"
        most = 4 * int(v["elements"]) if v["elements"] is not None else modes + boundary
        if modes > most:
            return f"{v['elements']:g} elements have {most:g} modes, not {modes:g}: give more elements"
        if axial is not None:
            bending = modes - axial
            if v["basis"] == "craig-bampton" and (axial < 1 or bending < 2):
                return f"the ends alone need one axial mode and two of bending, not {axial:g} and {bending:g}"
            if v["elements"] is not None and max(axial, bending) > 2 * v["elements"]:
                of = f"{axial:g} axial ones" if axial > bending else f"{bending:g} of bending"
                return f"half of the {most:g} modes that {v['elements']:g} elements have are axial: too few for {of}"
    return None


def derive(values: Mapping) -> dict:
    v = values
    found = {}
    if v["mass"] is None:
        found["mass"] = v["density"] * v["S"] * v["length"]
    if v["elements"] is None:
        modes = v["modes"] or 0.0
        found["elements"] = 8.0 if v["formulation"] == ANCF else min(max(16.0, 4.0 * modes), 256.0) if modes else 4.0
    return found


def rigid(values: Mapping) -> tuple[float, float, float]:
    """The inertia of the rigid rod."""
    mass, length = values["mass"], values["length"]
    return mass, mass, mass * length**2 / 12 + values["rotary"] * length


KIND = BodyKind(
    "FlexibleBeam",
    doc="A uniform straight beam that bends and stretches in the plane, with frames a and b at its ends, c in its "
    "middle, and further frames on its axis; each frame rotates with its cross-section.",
    parameters=(
        Parameter("length", "m", doc="length, undeformed", positive=True),
        Parameter("density", "kg/m3", None, "of the material; or give the mass", positive=True),
        Parameter("mass", "kg", None, "of the whole beam; or give the density", positive=True),
        Parameter("S", "m2", doc="area of the section", positive=True),
        Parameter("I", "m4", doc="second moment of area of the section", positive=True),
        Parameter("E", "Pa", doc="Young's modulus", positive=True),
        Parameter("rotary", "kg.m", 0.0, "rotary inertia of the section per length", minimum=0.0),
        Parameter(
            "formulation",
            "",
            FLOATING,
            'small deformation in a floating frame, or large deformation by absolute nodal coordinates ("ancf")',
            choices=(FLOATING, ANCF),
        ),
        Parameter("elements", "1", None, "number of finite elements; default 4, with modes at least 16, with ANCF 8"),
        Parameter(
            "modes",
            "1",
            None,
            "number of elastic coordinates; 0: a rigid rod; default: all those of the elements",
            minimum=0.0,
        ),
        Parameter(
            "axial", "1", None, "number of axial modes; default: those among the lowest frequencies", minimum=0.0
        ),
        Parameter(
            "basis",
            "",
            "eigenmodes",
            "kind of the modes: eigenmodes under the reference conditions, or static shapes for displacements of the "
            "ends and eigenmodes between fixed ends (Craig-Bampton), orthogonalised",
            choices=("eigenmodes", "craig-bampton"),
        ),
        Parameter(
            "reference",
            "",
            "pinned-pinned",
            "position of the floating frame: through both ends, tangent at frame a, or the mean axis",
            choices=("pinned-pinned", "clamped-free", "mean-axis"),
        ),
        Parameter("stiffening", "", True, "geometric stiffening: bending shortens the beam (floating frame)"),
        Parameter("zeta", "1", 0.0, "damping ratio of every mode", minimum=0.0),
        Parameter(
            "alpha", "1/s", 0.0, "Rayleigh damping: factor on the mass matrix of the elastic coordinates", minimum=0.0
        ),
        Parameter(
            "beta", "s", 0.0, "Rayleigh damping: factor on the stiffness matrix, as of a viscous material", minimum=0.0
        ),
        Parameter(
            "shape",
            "",
            "undeformed",
            "initial shape: undeformed, or that of the static equilibrium under the initial loads",
            choices=("undeformed", "static"),
        ),
        Parameter("frames", "", (), "further frames: frames(tip = {x, 0, phi}, ...) from the middle, on the axis"),
    ),
    signals=body.SIGNALS,
    check=check,
    derive=derive,
    effects={
        "flexibility": lambda v: {} if v["modes"] == 0 else {"modes": 0.0},
        "damping": zero("zeta", "alpha", "beta"),
    },
    coordinates=("x", "y", "phi"),
    size="length",
    coordinates_of=coordinates,
    frames=body.ends,
    table=rigid,
)
