"""ProfileContact with ``flat``: a flat face, the x axis of frame_b, on a closed profile of frame_a, with friction; in
the plane.

With n, the y axis of frame_b, the face is at the distance n . (r_b - r_a) - h from the profile, whose extent along n is

    h = max (n . c_i + R_i)        over its convex corners and arcs with the centres c_i, whose normals contain n

The body of frame_b is on the side of n, and its face has no ends. It touches at one point: where it is parallel to a
straight piece, at one of its ends.
"""

from functools import cache

from mbdsl.elements.contact_points import Point, contact
from mbdsl.elements.profile_contact import FAR, PARAMETERS, C, S, X, check, derive, least_of, of, specialised

N = "(-sin(frame_b.phi))", "cos(frame_b.phi)"
PX, PY = "(cx + R*mx)", "(cy + R*my)"  #: the point of the profile, in frame_a
POINT = Point(
    f"{N[0]}*{X[0]} + {N[1]}*{X[1]} - (mx*cx + my*cy + R)",
    N,
    (f"({C}*{PX} - {S}*{PY} - {X[0]})", f"({S}*{PX} + {C}*{PY} - {X[1]})"),
)


def terms(count):
    """n in frame_a, and the constants of the feature that is farthest along n: that with the least depth."""
    found = {"mx": f"{C}*{N[0]} + {S}*{N[1]}", "my": f"{C}*{N[1]} - {S}*{N[0]}"}
    which = range(1, count + 1)
    for i in which:
        ax, ay, bx, by, sigma, cx, cy, R = (of(i, x) for x in ("ax", "ay", "bx", "by", "sigma", "cx", "cy", "R"))
        # smooth joins are smooth to 1e-9: ranges that overlap leave no direction without a feature
        valid = f"le(-2e-9, {ax}*mx + {ay}*my)*lt({bx}*mx + {by}*my, 2e-9)*lt(0, {sigma})"
        found[f"depth{i}"] = f"select({valid}, -(mx*{cx} + my*{cy} + {R}), {FAR})"
    found["least"] = least_of([f"depth{i}" for i in which])
    for i in which:
        taken = f"taken{i - 1}" if i > 1 else "0"
        found[f"taken{i}"] = f"max({taken}, le(depth{i}, least))"
        found[f"is{i}"] = f"lt({taken}, le(depth{i}, least))"
    for field in ("cx", "cy", "R"):
        found[field] = " + ".join(f"is{i}*{of(i, field)}" for i in which)
    return found


@cache
def of_count(count):
    """The kind of contacts with profiles of a number of features."""
    return contact(
        "ProfileContact",
        "A flat face on the x axis of frame_b on a closed profile of frame_a.",
        PARAMETERS,
        [POINT],
        terms=terms(count),
        check=check,
        derive=derive,
        specialised=specialised,
        variant=f"flat_profile_contact_of_{count}",
        drawing="profile",
    )


KIND = of_count(1)
