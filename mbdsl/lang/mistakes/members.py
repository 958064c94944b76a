"""Variables of Modelica's components that have another name, place, sign or axes here, as expressions of the language.

``r_0``, ``v_0`` and ``a_0`` of a body are those of frame_a, whose axes ``w_a`` has; x, y and z of a body are those of
its centre of mass. ``f`` and ``t`` of a frame of a joint act on the joint, in the axes of this frame; here ``fx``, ...
of the frame act on the body.
"""

from __future__ import annotations

from collections.abc import Mapping

from mbdsl.elements.kind import BodyKind, Kind, PairKind
from mbdsl.lang import syntax as s
from mbdsl.lang.mistakes import names as other_names
from mbdsl.lang.mistakes.values import items
from mbdsl.lang.unparse import write

_AXES = "xyz"
#: vectors of a frame -> the prefix of their components here
_VECTORS = {"r_0": "", "r": "", "v_0": "v", "a_0": "a"}


def hint(kind: Kind | None, owner: str, port: str, frame_a: str, step: s.NamePart, spatial: bool) -> str | None:
    """What to write instead of ``owner.step``; None if it is no variable of Modelica.

    ``kind`` is that of the component that ``owner`` is, or whose frame ``port`` it is, if there is one; ``frame_a`` is
    the frame of a body that has this name in Modelica, "" if there is none.
    """
    name, k = step.name, _index(step)
    size = 3 if spatial else 2
    if name in _VECTORS and (port or kind is None or isinstance(kind, BodyKind)):
        place, more = _frame_a(frame_a, owner, spatial) if kind is not None and not port else (owner, "")
        found = [f"{place}.{_VECTORS[name]}{i}" for i in _AXES[:size]]
        return more + _one_of(found, k) + (", in results" if name == "a_0" else "")
    if name in ("w_a", "z_a") and isinstance(kind, BodyKind):
        return _rotation(frame_a, owner, name, k, spatial)
    if name in ("f", "t") and port and isinstance(kind, PairKind):
        flat = name == "t" and not spatial
        found = [f"-{owner}.{name}{i}" for i in _AXES[:size]]
        written = f"write `-{owner}.tau`" if flat else _one_of(found, k)
        return f"{written}: it acts on the joint there, in the axes of this frame"
    if name in ("f", "t") and (kind is None or isinstance(kind, BodyKind)):
        return "forces at the frames of a body are those of the joints and forces there, as `pin.fx` or `spring.force`"
    return other_names.MEMBERS.get(name)


#: start values of a body in Modelica -> signals here, and the one that remains in the plane
STARTS = {
    **dict.fromkeys(("r_0", "r"), ("x", "y", "z")),
    **dict.fromkeys(("v_0", "v"), ("vx", "vy", "vz")),
    "w_0_start": ("wx", "wy", "wz"),
    "angles_start": ("phi_x", "phi_y", "phi_z"),
}
_IN_PLANE = {"w_0_start": "w", "angles_start": "phi"}


def start(
    kind: Kind,
    owner: str,
    name: str,
    value: s.Expression | None,
    fixed: s.Expression | None,
    given: Mapping[str, s.Expression],
) -> str | None:
    """What to write instead of a start value of a body; None for other parameters.

    Positions and velocities are those of frame_a, the reference point. ``given`` are all parameters of the body.
    """
    own, partner = name.replace("_fixed", "_start"), ""
    if own not in STARTS or not isinstance(kind, BodyKind) or (name in ("r", "v") and name in given):
        return None
    if own.endswith("_start"):  # angles_start and angles_fixed
        other = own.replace("_start", "_fixed")
        value, fixed = given.get(own), given.get(other)
        partner = "".join(f" and `{x}`" for x in (own, other) if x != name and x in given)
    elsewhere = own in ("r_0", "r", "v_0", "v") and {"r_CM", "com", "length", "frames"} & given.keys()
    written = initial(f"{owner}.a" if elsewhere else owner, own, value, fixed, kind.spatial)
    return written and f"leave it{partner} out, and write `{written}` under `initial equation`"


def initial(place: str, name: str, value: s.Expression | None, fixed: s.Expression | None, spatial: bool) -> str:
    """The initial equations for a start value; "" if its components are not written out."""
    values = items(value)
    if values is None:
        return ""
    found = list(zip(STARTS[name], values, strict=True))
    if not spatial:
        found = [(_IN_PLANE[name], values[2])] if name in _IN_PLANE else found[:2]
    guess = "" if isinstance(fixed, s.Boolean) and fixed.value else "guess "
    return " ".join(f"{guess}{place}.{key} = {write(x)};" for key, x in found)


def of_declaration(d: s.Declaration, spatial: bool) -> str:
    """The initial equations for all start values in the declaration of a body with a frame a."""
    given = {a.name: a.value for a in d.arguments}
    found = []
    for a in d.arguments:
        if a.name in STARTS and (a.modifiers or a.name.endswith("_start")):
            inner = {x.name: x.value for x in a.modifiers}
            fixed = inner.get("fixed") or given.get(a.name.replace("_start", "_fixed"))
            place = d.name if a.name.endswith("_start") else f"{d.name}.a"
            found.append(initial(place, a.name, inner.get("start") or a.value, fixed, spatial))
    return " ".join(filter(None, found))


def _index(step: s.NamePart) -> int | None:
    """The index 0, 1, 2 of the component that is named; None for all of them."""
    first = step.indices[0] if step.indices else None
    return int(first.value) - 1 if isinstance(first, s.Number) and first.value in (1, 2, 3) else None


def _one_of(found: list[str], k: int | None) -> str:
    if k is None:
        return f"write {{{', '.join(found)}}} by its components, `{'`, `'.join(found)}`"
    return f"write `{found[k]}`" if k < len(found) else "in the plane there is no z"


def _frame_a(frame_a: str, owner: str, spatial: bool) -> tuple[str, str]:
    """The name of the frame that is frame_a of a body, and what has to be done before."""
    if not frame_a:
        zeros = "{0, 0, 0}" if spatial else "{0, 0}"
        return f"{owner}.a", f"it is that of frame_a: give `{owner}` the frame `frames(a = {zeros})`, and "
    return (owner if frame_a == "c" else f"{owner}.{frame_a}"), ""


def _rotation(frame_a: str, owner: str, name: str, k: int | None, spatial: bool) -> str:
    if not spatial:
        return f"write `{owner}.w`" if name == "w_a" else f"write `{owner}.alpha`, in results"
    if name == "z_a":
        return "its angular acceleration is alphax, alphay, alphaz about the axes of the world, in results"
    place = owner if frame_a in ("", "c") else f"{owner}.{frame_a}"
    return _one_of([f"{place}.w{i}_local" for i in _AXES], k)
