"""ProfileContact: a point or circle about the origin of frame_b on a closed profile of frame_a, with friction; in the
plane.

The features of the profile and the distances s_i of a point from them are those of profile.py. The circle touches at
its nearest feature, the one with the least |s_i| of those that are valid, and at the nearest of the others that it is
outside of, as in a corner or between the walls of a slot: at two points at most. With concave corners, a rigid contact
has a point for each of the chains between them, which remains the same while the circle moves. The number of features
is a part of the kind (``of_count``), and so are the lengths of the chains; their constants are data. The constants of a
feature that touches are sums over all features, of which one counts: its gap, its normal and their derivatives cost the
same for all profiles.
"""

from functools import cache
from itertools import pairwise

from mbdsl.elements import profile
from mbdsl.elements.contact_points import Point, contact
from mbdsl.elements.declaration import RIGID, Parameter

FIELDS = profile.Feature._fields
MOST = 200  #: features
FAR = "1e9"  #: [m], from features that do not count
PART = "0.001"  #: of the size, by which pieces extend beyond concave corners
X = "(frame_b.x - frame_a.x)", "(frame_b.y - frame_a.y)"
C, S = "cos(frame_a.phi)", "sin(frame_a.phi)"
PARAMETERS = (
    Parameter("points", "m", doc="points of the closed profile, in frame_a, in their order", shape=(None, 2)),
    Parameter(
        "arcs",
        "m",
        (),
        "of each piece, from a point to the next, the radius, positive if it bulges out of the enclosed area; 0: "
        "straight. Default: all are straight",
        shape=(None,),
    ),
    Parameter("smooth", "", False, "whether the profile is a smooth curve through the points"),
    Parameter("hole", "", False, "whether the solid is outside of the profile"),
    Parameter("radius", "m", 0.0, "radius about frame_b", minimum=0.0),
    Parameter("flat", "", False, "whether the x axis of frame_b is a flat face, with the body on the side of y"),
)


def check(values):
    points, smooth = values["points"], values["smooth"]
    if 2 * len(points) > MOST:
        return f"`points` has {len(points)} points, at most {MOST // 2} are possible"
    if values["flat"] and (values["radius"] or values["hole"]):
        return f"a `flat` face has no `{'radius' if values['radius'] else 'hole'}`"
    return profile.problem(points, values["arcs"], smooth)


def derive(values):
    """``features``: the constants of all features, one after another; ``size``: of the profile [m]; ``chains``: the
    numbers of features of its chains, which come first."""
    points = values["points"]
    given = points, values["arcs"], values["smooth"], values["hole"]
    found, chains = profile.features(*given, values["radius"])
    size = max(max(p[i] for p in points) - min(p[i] for p in points) for i in range(2))
    return {"features": tuple(x for feature in found for x in feature), "size": (size,), "chains": chains}


def specialised(values):
    count = len(values["features"]) // len(FIELDS)
    rigid, flat = RIGID * (values["k"] is None), "flat_" * bool(values["flat"])
    if flat or not rigid:
        return f"{rigid}{flat}profile_contact_of_{count}"
    return f"{RIGID}profile_contact_of_{'_'.join(map(str, (count, *map(int, values['chains']))))}"


def of(i, field):
    """A constant of feature i, from 1."""
    return f"features[{len(FIELDS) * (i - 1) + FIELDS.index(field) + 1}]"


def least_of(names):
    """The least of several signals, of pairs of pairs."""
    if len(names) == 1:
        return names[0]
    half = len(names) // 2
    return f"min({least_of(names[:half])}, {least_of(names[half:])})"


def nearest(m, which, key):
    """The constants of the feature that is nearest by ``key`` of some, as formulas: the sums over those of all."""
    least = f"least{m}"
    found = {least: least_of([f"{key}{i}" for i in which])}
    for i in which:
        own = f"le({key}{i}, {least})*lt({key}{i}, {FAR})"
        taken = f"taken{m}_{i - 1}" if i > which[0] else "0"
        found[f"taken{m}_{i}"] = f"max({taken}, {own})"
        found[f"is{m}_{i}"] = f"lt({taken}, {own})"
    for field in FIELDS[6:]:
        found[f"{field}{m}"] = " + ".join(f"is{m}_{i}*{of(i, field)}" for i in which)
    found[f"none{m}"] = f"1 - ({' + '.join(f'is{m}_{i}' for i in which)})"
    found[f"away{m}"] = f"hypot(px - cx{m}, py - cy{m})"
    for i in "xy":
        found[f"m{i}{m}"] = f"n{i}{m} + sigma{m}*ratio(p{i} - c{i}{m}, away{m})"
    return found


def distances(which, before=(), behind=()):
    """The distances of the centre from features. Those with a concave corner at their start (``before``) or end
    (``behind``) extend beyond it by a part of the size."""
    found = {"px": f"{C}*{X[0]} + {S}*{X[1]}", "py": f"{C}*{X[1]} - {S}*{X[0]}"}
    for i in which:
        ax, ay, alpha, bx, by, beta, nx, ny, d, sigma, cx, cy, R = (of(i, field) for field in FIELDS)
        alpha, beta = alpha + f" - {PART}*size[1]" * (i in before), beta + f" + {PART}*size[1]" * (i in behind)
        found |= {
            f"s{i}": f"{nx}*px + {ny}*py - {d} + {sigma}*(hypot(px - {cx}, py - {cy}) - {R})",
            f"valid{i}": f"le({alpha}, {ax}*px + {ay}*py)*lt({bx}*px + {by}*py, {beta})",
            f"first{i}": f"select(valid{i}, abs(s{i}), {FAR})",
        }
    return found


def of_chains(chains):
    """The terms of contacts with each of several chains: a chain counts if the centre is outside of its nearest
    feature, or if no other feature is as near."""
    ends = [sum(chains[:k]) for k in range(len(chains) + 1)]
    which = range(1, ends[-1] + 1)
    found = distances(which, [x + 1 for x in ends[:-1]], ends[1:])
    found["least"] = least_of([f"first{i}" for i in which])
    for i in which:
        found[f"near{i}"] = f"select(max(le(first{i}, least), lt(-{PART}*size[1], s{i})), first{i}, {FAR})"
    for m, (low, high) in enumerate(pairwise(ends), 1):
        found |= nearest(m, range(low + 1, high + 1), "near")
    return found


def terms(count):
    """The terms of contacts with the two nearest features."""
    which = range(1, count + 1)
    found = distances(which) | nearest(1, which, "first")
    for i in which:
        found[f"second{i}"] = f"select(lt(is1_{i}, valid{i}*lt(0, s{i})), s{i}, {FAR})"
    found |= nearest(2, which, "second")
    nearest_s = " + ".join(f"is1_{i}*s{i}" for i in which)
    return found | {"overlap": f"max(0, radius - ({nearest_s})) + max(0, radius - least2)"}


def touch(m):
    """The m-th point that touches."""
    n = f"({C}*mx{m} - {S}*my{m})", f"({S}*mx{m} + {C}*my{m})"
    gap = f"nx{m}*px + ny{m}*py - d{m} + sigma{m}*(away{m} - R{m}) + none{m}*size[1] - radius"
    return Point(gap, n, [f"(-radius*{x})" for x in n])


@cache
def of_count(count, *chains):
    """The kind of contacts with profiles of a number of features; rigid ones also by the lengths of their chains."""
    return contact(
        "ProfileContact",
        "A point, circle or flat face of frame_b on a closed profile of frame_a, which pushes it out of its solid "
        "side; with friction.",
        PARAMETERS,
        [touch(m) for m in range(1, len(chains) + 1)] if chains else [touch(1), touch(2)],
        terms=of_chains(chains) if chains else terms(count) if count else {},
        one=True,
        check=check,
        derive=derive,
        specialised=specialised,
        variant=f"profile_contact_of_{'_'.join(map(str, (count, *chains)))}" if count else "",
        drawing="profile",
    )


KIND = of_count(0)
