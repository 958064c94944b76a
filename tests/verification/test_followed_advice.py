"""Models in Modelica's words: the advice about them is followed as text, and the motion is that of the model.

The truth is not from mbdsl: the parts of a model are rigidly connected to a single body, whose mass, centre of mass and
inertia are computed here, from Modelica's definitions; or it is a closed form.
"""

import re

import numpy as np
import pytest

import mbdsl
from mbdsl.elements import find, kinds
from mbdsl.errors import MbdslError, ModelError
from mbdsl.lang.mistakes import blocks, gears
from mbdsl.lang.mistakes import kinds as other_kinds
from mbdsl.lang.mistakes import names as other_names
from mbdsl.lang.parser import parse

PARTS = "Modelica.Mechanics.MultiBody.Parts."
ROUNDS = 25


def follow(text):
    """The scene of a text, after the advice about it was followed; a statement is a line."""
    for _ in range(ROUNDS):
        try:
            return mbdsl.parse(text)
        except MbdslError as problem:
            before, text = text, followed(text, problem)
            if text == before:
                raise
    raise AssertionError(text)


def followed(text, problem):
    lines, hint = text.split("\n"), problem.hint or problem.render()
    k = problem.span.line - 1
    if model := re.search(r"write `spatial model (\w+)`", hint):
        return text.replace(f"model {model[1]}", f"spatial model {model[1]}", 1)
    if weld := re.search(r"delete this connection and declare `(.*?;)`", hint):
        del lines[k]
        lines.insert(lines.index("equation"), f"  {weld[1]}")
        return "\n".join(lines)
    (written, *_) = re.findall(r"write `(.*?)`", hint)
    if left_out := re.search(r"leave it(?: and `(\w+)`)? out, and write `(.*?)` under `initial equation`", hint):
        lines[k] = without_argument(lines[k], problem.span.column - 1)
        if left_out[1]:
            lines[k] = without_argument(lines[k], lines[k].index(f"{left_out[1]} ="))
        lines.insert(-1, f"  {left_out[2]}")
        return "\n".join(lines)
    if starts := re.search(r"; and `(.*?)` under `initial equation`", hint):
        lines.insert(-1, f"  {starts[1]}")
    written += " ".join(["", *re.findall(r"` and `(.*?;)`", hint)])
    if written.endswith(";"):
        name = re.search(r"(\w+)\s*(\(.*\))?;$", lines[k])[1]
        lines[k] = f"  {written}"
        changed = "\n".join(lines)
        if "delete its connections" in hint:
            changed = re.sub(rf"  connect\(.*\b{name}\..*\n", "", changed)
        for new, old in re.findall(r"`([\w.]+)` instead of `([\w.]+)`", hint):
            changed = re.sub(rf"(?<![\w.]){re.escape(old)}(?!\w)", new, changed)
        return changed
    at = problem.span.column - 1
    before, rest = lines[k][:at], lines[k][at:]
    if re.match(r"\w+ = ", written):  # a parameter
        end = argument_end(rest)
        already = re.search(rf"\b{written.split(' ')[0]} = ", before)
        lines[k] = before + (written if not already else "frames()") + rest[end:]
        return "\n".join(lines).replace(", frames()", "")
    owner = re.search(r"[\w.]*$", before)[0]
    lines[k] = before[: len(before) - len(owner)] + written + re.sub(r"^\w+(\[\d\])?", "", rest)
    return "\n".join(lines)


def without_argument(line, at):
    rest = line[at + argument_end(line[at:]) :]
    return line[:at] + rest.removeprefix(", ") if line[:at].endswith("(") else line[:at].removesuffix(", ") + rest


def argument_end(text):
    depth = 0
    for k, c in enumerate(text):
        depth += (c in "({[") - (c in ")}]")
        if depth < 0 or (depth == 0 and c == ","):
            return k
    raise AssertionError(text)


# -- rigid chains ------------------------------------------------------------------------------------------------------


def rotation(n, degrees):
    n, a = np.array(n) / np.linalg.norm(n), np.radians(degrees)
    cross = np.cross(n, np.eye(3)).T
    return np.eye(3) + np.sin(a) * cross + (1.0 - np.cos(a)) * cross @ cross


X, Y, Z = np.eye(3)
UNTURNED = np.eye(3)


class Rigid:
    """Masses in one body: they are added with position of the centre, moments of inertia about it, and attitude."""

    def __init__(self, *parts):
        self.m = sum(m for m, *_ in parts)
        self.com = sum(m * np.array(r, float) for m, r, *_ in parts) / self.m
        self.J = np.zeros((3, 3))
        for m, r, moments, *attitude in parts:
            R, d = (attitude[0] if attitude else UNTURNED), np.array(r, float) - self.com
            J = np.diag(moments) if np.ndim(moments) == 1 else np.array(moments)
            self.J += R @ J @ R.T + m * (d @ d * np.eye(3) - np.outer(d, d))

    def text(self, spatial):
        rows = [", ".join(map(repr, row)) for row in self.J.tolist()]
        size, moments = (3, "{{" + "}, {".join(rows) + "}}") if spatial else (2, repr(float(self.J[2, 2])))
        com = ", ".join(map(repr, self.com[:size].tolist()))
        return f"Body rod(m = {self.m!r}, I = {moments}, com = {{{com}}}, frames(a = {{{', '.join('0' * size)}}}));"


#: rod of 1 kg and 1 m from the pivot along x; in space a body with these moments
ROD = (1.0, (0.5, 0.0, 0.0), (0.01, 0.08, 1.0 / 12.0))
ROD_IN_SPACE = "Body rod(m = 1, I = {0.01, 0.08, 1/12}, com = {0.5, 0, 0}, frames(a = {0, 0, 0}, b = {1, 0, 0}));"
BOB = "Body bob(m = 2, I = 0.4, com = {0.3, 0.1}, frames(a = {0, 0}));"
BOB_IN_SPACE = "Body bob(m = 2, I = {0.2, 0.3, 0.4}, com = {0.3, 0.1, 0.2}, frames(a = {0, 0, 0}));"


def bob(at, R=UNTURNED, z=0.2):
    return (2.0, np.array(at, float) + R @ [0.3, 0.1, z], (0.2, 0.3, 0.4), R)


def chain(declarations, connections, spatial, head=None):
    head = head or ("spatial model" if spatial else "model")
    joint = "Spherical pin(world, rod.a);" if spatial else "Revolute pin(world, rod.a);"
    lines = [f"{head} M", "  World world;", f"  {joint}", *(f"  {d}" for d in declarations), "equation"]
    start = "rod.wx = 0.3; rod.wy = 0.7; rod.wz = 1;" if spatial else "rod.w = 1;"
    angles = "rod.phi_x = 0.4; rod.phi_y = 0.3; rod.phi_z = -1;" if spatial else "rod.phi = -1;"
    lines += [f"  connect({a}, {b});" for a, b in connections]
    return "\n".join([*lines, f"initial equation\n  {angles} {start}", "end M;"])


def same_motion(scene, truth, signals):
    """At the start and during a motion; both models are rigid bodies with the same axes."""
    found, expected = (mbdsl.simulate(x, method="dop853", tol=1e-9, stop=0.3, interval=0.1) for x in (scene, truth))
    for name in signals:
        assert found[name] == pytest.approx(expected[name], abs=2e-7), name


#: title -> (declarations, connections, the rigid body, whether it is in space)
RIGID = {}


def case(title, declarations, connections, parts, spatial):
    assert title not in RIGID
    rod = ROD_IN_SPACE if spatial else "Rod rod(m = 1, length = 1);"
    RIGID[title] = ((rod, *declarations), connections, Rigid(ROD, *parts), spatial)


AFTER = (("rod.frame_b", "x.frame_a"), ("x.frame_b", "bob.frame_a"))
BEFORE = (("rod.frame_b", "j.frame_a"), ("j.frame_b", "x.frame_a"), ("x.frame_b", "bob.frame_a"))
for spatial in (False, True):
    where, body, z = ("space", BOB_IN_SPACE, 0.2) if spatial else ("plane", BOB, 0.0)
    here = Z if spatial else 0 * Z
    case(f"{where}: a rigid connection of bodies", (body,), (("rod.frame_b", "bob.frame_a"),), [bob(X, z=z)], spatial)
    case(
        f"{where}: a joint on two bodies",
        ("Fixed j;", body, "PointMass p(m = 3);"),
        (("rod.frame_b", "j.frame_a"), ("j.frame_b", "bob.frame_a"), ("j.frame_b", "p.frame_a")),
        [bob(X, z=z), (3.0, X, (0, 0, 0))],
        spatial,
    )
    case(
        f"{where}: a point mass",
        ("PointMass p(m = 3);",),
        (("p.frame_a", "rod.frame_b"),),
        [(3.0, X, (0, 0, 0))],
        spatial,
    )
    r = f"r = {{0.2, 0.4, {0.6 if spatial else 0}}}"
    at = X + [0.2, 0.4, 0.6 if spatial else 0.0]
    case(f"{where}: FixedTranslation", (f"{PARTS}FixedTranslation x({r});", body), AFTER, [bob(at, z=z)], spatial)
    case(
        f"{where}: FixedTranslation before a body",
        (f"{PARTS}FixedTranslation x({r});", "Fixed j;", body),
        BEFORE,
        [bob(at, z=z)],
        spatial,
    )
    case(
        f"{where}: two of them",
        (f"{PARTS}FixedTranslation x({r});", f"{PARTS}FixedTranslation y(r = {{0, 1, 0}}, animation = false);", body),
        (("x.frame_a", "rod.frame_b"), ("x.frame_b", "y.frame_a"), ("y.frame_b", "bob.frame_a")),
        [bob(at + Y, z=z)],
        spatial,
    )
    angle = "angle = 40, n = {0, 0, -1}"
    for title, given, R in (
        ("about -z", angle, rotation(-Z, 40)),
        ("about z", "angle = -40, n = {0, 0, 2}", rotation(-Z, 40)),
        ("by two axes", "n_x = {0, 3, 0}, n_y = {-1, 1, 0}", rotation(Z, 90)),
        ("by two axes, named", f"rotationType = {PARTS}RotationTypes.TwoAxesVectors, n_x = {{0, 3, 0}}", None),
        ("by a sequence", "angles = {10, 0, 20}, sequence = {3, 1, 3}", rotation(Z, 30)),
    ):
        if R is None:
            R = rotation(Z, 90)
            given += ", n_y = {-1, 0, 0}"
        declared = f"{PARTS}FixedRotation x({r}, {given});"
        case(f"{where}: FixedRotation {title}", (declared, body), AFTER, [bob(at, R, z)], spatial)
        case(
            f"{where}: FixedRotation {title} before a body",
            (declared, "Fixed j;", body),
            BEFORE,
            [bob(at, R, z)],
            spatial,
        )
R = rotation([1, 2, 3], 50)
for title, given, R in (
    ("about an axis", "n = {1, 2, 3}, angle = 50", rotation([1, 2, 3], 50)),
    ("about x", "angle = 50", rotation(X, 50)),
    (
        "by a sequence",
        "angles = {10, 20, 30}, sequence = {3, 1, 2}",
        rotation(Z, 10) @ rotation(X, 20) @ rotation(Y, 30),
    ),
    ("by two axes", "n_x = {0, 0, 2}, n_y = {1, 0, 1}", np.array([Z, X, Y]).T),
):
    declared = f"{PARTS}FixedRotation x({given}, r = {{0.2, 0.4, 0.6}});"
    at = X + [0.2, 0.4, 0.6]
    case(f"FixedRotation {title}", (declared, BOB_IN_SPACE), AFTER, [bob(at, R)], True)
    case(f"FixedRotation {title} before a body", (declared, "Fixed j;", BOB_IN_SPACE), BEFORE, [bob(at, R)], True)
case(
    "FixedRotation of PlanarMechanics",
    ("PlanarMechanics.Parts.FixedRotation x(alpha = 0.5);", BOB),
    AFTER,
    [bob(X, rotation(Z, np.degrees(0.5)), 0.0)],
    False,
)

SHAPE = "m = 3, r_CM = {0.1, 0.2, 0.3}, I_11 = 0.4, I_22 = 0.5, I_33 = 0.6, I_21 = 0.01, I_31 = 0.02, I_32 = 0.03"
MATRIX = [[0.4, 0.01, 0.02], [0.01, 0.5, 0.03], [0.02, 0.03, 0.6]]
ON_IT = (("rod.frame_b", "x.frame_a"), ("x.frame_b", "p.frame_a"))
for name, r in (("x", (0.5, 0.0, 0.0)), ("-x", (-0.5, 0.0, 0.0)), ("y", (0.0, 0.5, 0.0)), ("z", (0.0, 0.0, 0.5))):
    shown, end = "{" + ", ".join(map(repr, r)) + "}", X + r
    mass = (2.0, end, (0, 0, 0))
    case(
        f"BodyShape along {name}",
        (f"{PARTS}BodyShape x({SHAPE}, r = {shown}, width = 0.1);", "PointMass p(m = 2);"),
        ON_IT,
        [(3.0, X + [0.1, 0.2, 0.3], MATRIX), mass],
        True,
    )
    m = 1000 * 0.5 * 0.3 * 0.1
    across = {"x": (1, 2), "y": (0, 2), "z": (1, 0)}[name[-1]]  # of width and height
    for inside, gone in (("", ()), (", innerWidth = 0.2, innerHeight = 0.05", (0.2, 0.05))):
        moments = np.zeros(3)
        for part, w, h in ((m, 0.3, 0.1), (-1000 * 0.5 * gone[0] * gone[1], *gone) if gone else (0.0, 0.0, 0.0)):
            moments[int(np.argmax(np.abs(r)))] += part * (w * w + h * h) / 12
            moments[across[0]] += part * (0.25 + h * h) / 12
            moments[across[1]] += part * (0.25 + w * w) / 12
        total = 1000 * 0.5 * (0.03 - (0.01 if gone else 0.0))
        declared = (
            f"{PARTS}BodyBox x(r = {shown}, width = 0.3, height = 0.1, density = 1000{inside}, color = {{1, 2, 3}});"
        )
        case(
            f"{'hollow ' if gone else ''}BodyBox along {name}",
            (declared, "PointMass p(m = 2);"),
            ON_IT,
            [(total, X + np.array(r) / 2, moments), mass],
            True,
        )
        m = 1000 * 0.5 * 0.03
    for inside, hole in (("", 0.0), (", innerDiameter = 0.1", 0.1)):
        m = 1000 * np.pi / 4 * (0.04 - hole**2) * 0.5
        moments = np.full(3, m * (0.25 / 12 + (0.04 + hole**2) / 16))
        moments[int(np.argmax(np.abs(r)))] = m * (0.04 + hole**2) / 8
        case(
            f"BodyCylinder along {name}{', a tube' if hole else ''}",
            (f"{PARTS}BodyCylinder x(r = {shown}, diameter = 0.2, density = 1000{inside});", "PointMass p(m = 2);"),
            ON_IT,
            [(m, X + np.array(r) / 2, moments), mass],
            True,
        )
    if name != "z":
        m = 7700 * 0.5 * 0.3 * 0.1
        for given in (f"r = {shown}", "r = {L*" + ", L*".join(str(2 * x) for x in r[:2]) + ", 0}"):
            if "L" in given and name == "-x":
                continue
            L = ("parameter Length L = 0.5 m;",) if "L" in given else ()
            given = re.sub(r"L\*0\.0", "0", given).replace("L*1.0", "L")
            case(
                f"plane: BodyBox along {name}{' by a parameter' if L else ''}",
                (*L, f"{PARTS}BodyBox x({given}, width = 0.3, height = 0.1);", "PointMass p(m = 2);"),
                ON_IT,
                [(m, X + np.array(r) / 2, (0, 0, m * (0.25 + 0.09) / 12)), mass],
                False,
            )
        m = 7700 * np.pi / 4 * 0.04 * 0.5
        case(
            f"plane: BodyCylinder along {name}",
            (f"{PARTS}BodyCylinder x(r = {shown}, diameter = 0.2);", "PointMass p(m = 2);"),
            ON_IT,
            [(m, X + np.array(r) / 2, (0, 0, m * (0.25 / 12 + 0.04 / 16))), mass],
            False,
        )
        case(
            f"plane: BodyShape along {name}",
            (f"{PARTS}BodyShape x(m = 3, r_CM = {{0.1, 0.2, 0}}, I_33 = 0.6, r = {shown});", "PointMass p(m = 2);"),
            ON_IT,
            [(3.0, X + [0.1, 0.2, 0.0], (0, 0, 0.6)), mass],
            False,
        )
oblique = np.array([0.3, 0.4, 1.2])  # 1.3 m
e_x = oblique / 1.3
e_z = np.cross(e_x, Y) / np.linalg.norm(np.cross(e_x, Y))
m = 1000 * 1.3 * 0.03
case(
    "an oblique BodyBox",
    (f"{PARTS}BodyBox x(r = {{0.3, 0.4, 1.2}}, width = 0.3, height = 0.1, density = 1000);", "PointMass p(m = 2);"),
    ON_IT,
    [
        (
            m,
            X + oblique / 2,
            np.array([0.1, 1.69 + 0.01, 1.69 + 0.09]) * m / 12,
            np.array([e_x, np.cross(e_z, e_x), e_z]).T,
        ),
        (2.0, X + oblique, (0, 0, 0)),
    ],
    True,
)
m = 1000 * np.pi * 0.01 * 1.3
case(
    "an oblique BodyCylinder",
    (f"{PARTS}BodyCylinder x(r = {{0.3, 0.4, 1.2}}, diameter = 0.2, density = 1000);", "PointMass p(m = 2);"),
    ON_IT,
    [
        (
            m,
            X + oblique / 2,
            np.array([0.02 / 4, 1.69 / 12 + 0.0025, 1.69 / 12 + 0.0025]) * m,
            np.array([e_x, np.cross(e_z, e_x), e_z]).T,
        ),
        (2.0, X + oblique, (0, 0, 0)),
    ],
    True,
)
case(
    "Body with a centre of mass",
    (f"{PARTS}Body x(m = 3, r_CM = {{0.1, 0.2, 0.3}}, I_11 = 0.4, I_22 = 0.5, I_33 = 0.6, I_21 = 0.01);",),
    (("rod.frame_b", "x.frame_a"),),
    [(3.0, X + [0.1, 0.2, 0.3], [[0.4, 0.01, 0], [0.01, 0.5, 0], [0, 0, 0.6]])],
    True,
)
case(
    "plane: Body with a centre of mass",
    (f"{PARTS}Body x(m = 3, r_CM = {{0.1, 0.2, 0}}, I_33 = 0.6);",),
    (("rod.frame_b", "x.frame_a"),),
    [(3.0, X + [0.1, 0.2, 0.0], (0, 0, 0.6))],
    False,
)


@pytest.mark.parametrize("title", RIGID)
def test_rigidly_connected_parts(title):
    declarations, connections, whole, spatial = RIGID[title]
    scene = follow(chain(declarations, connections, spatial))
    truth = mbdsl.parse(chain((whole.text(spatial),), (), spatial))
    same_motion(scene, truth, ("rod.wx", "rod.wy", "rod.wz", "rod.phi_x") if spatial else ("rod.phi", "rod.w"))


# -- where the world is ------------------------------------------------------------------------------------------------


def test_space_is_said_first_and_no_z_is_lost():
    """A pendulum in the plane y = 0 with gravity along -z, 2 m above the origin: its first acceleration."""
    text = f"""model F05
  inner Modelica.Mechanics.MultiBody.World world(n = {{0, 0, -1}});
  {PARTS}Fixed hook(r = {{0, 0, 2}}, animation = false);
  Modelica.Mechanics.MultiBody.Joints.Revolute pin(n = {{0, 1, 0}}, useAxisFlange = true);
  {PARTS}BodyShape bar(m = 1, r = {{0.5, 0, 0.1}}, r_CM = {{0.25, 0, 0.1}}, I_11 = 0.02, I_22 = 0.02, I_33 = 0.02);
equation
  connect(hook.frame_b, pin.frame_a);
  connect(pin.frame_b, bar.frame_a);
end F05;"""
    scene = follow(text)
    run = mbdsl.simulate(scene, stop=1e-3, step=1e-3)
    start = {name: run[name][0] for name in ("bar.a.x", "bar.a.y", "bar.a.z", "bar.z", "pin.w")}
    assert start == pytest.approx(
        {"bar.a.x": 0.0, "bar.a.y": 0.0, "bar.a.z": 2.0, "bar.z": 2.1, "pin.w": 0.0}, abs=1e-12
    )
    # about y, gravity along -z at (0.25, 0, 0.1): M_y = z F_x - x F_z = 0.25 * 9.81
    expected = 0.25 * 9.81 / (0.02 + 0.25**2 + 0.1**2)
    assert run["bar.alphay"][0] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    "declared",
    [
        "Force f(rod.b, f = {1, 0, 4} N);",
        "Frame h(world, r = {0, 0, 2});",
        f"{PARTS}BodyShape b(r = {{0, 1, 1}}, m = 1, I_33 = 1);",
        "Prismatic j(world, rod.b, n = {0, 0, 1});",
        f"{PARTS}FixedRotation t(rod.b, angle = 30);",
        f"{PARTS}FixedRotation t(rod.b, angles = {{30, 0, 0}});",
        f"{PARTS}FixedRotation t(rod.b, n_x = {{1, 0, 1}}, n_y = {{0, 1, 0}});",
    ],
)
def test_whatever_is_out_of_the_plane_asks_for_space(declared):
    text = chain(("Rod rod(m = 1, length = 1);", "Rod other(m = 1 kg, length = 2, r = 3);", declared), (), False)
    with pytest.raises(mbdsl.ModelError, match="`M` is in space, but declared in the plane") as problem:
        mbdsl.parse(text)
    assert "write `spatial model M` first" in problem.value.hint


@pytest.mark.parametrize(
    "declared",
    [
        "Frame h(world, r = {1, 2, 0});",
        "Revolute j(rod.b, world, n = {0, 0, -1});",
        "Prismatic j(world, rod.b, n = {0, 1, 0});",
        "Torque t(pin, tau = {0, 0, 3});",
        f"{PARTS}FixedRotation t(rod.b, n = {{0, 0, 1}}, angle = 30);",
    ],
)
def test_what_is_in_the_plane_does_not(declared):
    with pytest.raises(mbdsl.ModelError) as problem:
        mbdsl.parse(chain(("Rod rod(m = 1, length = 1);", declared), (), False))
    assert "spatial" not in str(problem.value)


def test_a_link_between_two_joints_keeps_its_direction():
    for spatial, end in ((False, "{0, 0.7}"), (True, "{0, 0.7, 0}")):
        declarations = (
            ROD_IN_SPACE if spatial else "Rod rod(m = 1, length = 1);",
            "Body bob(m = 1, I = 1);",
            "Revolute k;",
            "Revolute l;",
            f"{PARTS}FixedTranslation x(r = {{0, 0.7, 0}});",
        )
        connections = (
            ("rod.frame_b", "k.frame_a"),
            ("k.frame_b", "x.frame_a"),
            ("x.frame_b", "l.frame_a"),
            ("l.frame_b", "bob.frame_a"),
        )
        with pytest.raises(mbdsl.ModelError, match=rf"frames\(a = .*, b.*{re.escape(end)}"):
            mbdsl.parse(chain(declarations, connections, spatial))


AXES = {
    "along y": ("Prismatic slide(n = {0, 1, 0}, s(start = 0.3, fixed = true))", 90.0, (0.3, -9.81)),
    "along -x": ("Prismatic slide(n = {-1, 0, 0}, s(start = 0.3, fixed = true))", 180.0, (0.3, 0.0)),
    "along y in PlanarMechanics": ("Prismatic slide(r = {0, 2}, s(start = 0.3, fixed = true))", 90.0, (0.3, -9.81)),
    "oblique": ("Prismatic slide(n = {3, 4, 0}, s(start = 0.3, fixed = true))", 53.13010235415598, (0.3, -9.81 * 0.8)),
}


@pytest.mark.parametrize("connected", [False, True])
@pytest.mark.parametrize("title", AXES)
def test_the_axis_of_a_slide(title, connected):
    """A body slides along n without turning, s'' is the part of gravity along n."""
    declared, angle, (s0, a) = AXES[title]
    frames = "" if connected else "world, b.c, "
    text = f"""model Slide
  World world;
  Body b(m = 2, I = 1);
  Modelica.Mechanics.MultiBody.Joints.{declared.replace("(", f"({frames}", 1)};
equation
{"  connect(world.frame_b, slide.frame_a);" if connected else ""}
{"  connect(slide.frame_b, b.frame_a);" if connected else ""}
end Slide;"""
    run = mbdsl.simulate(follow(text), method="dop853", tol=1e-9, stop=0.5, interval=0.5)
    s, n = s0 + a * run.t**2 / 2, (np.cos(np.radians(angle)), np.sin(np.radians(angle)))
    for name, expected in (("slide.s", s), ("b.x", n[0] * s), ("b.y", n[1] * s), ("b.phi", 0 * s)):
        assert run[name] == pytest.approx(expected, abs=1e-9), name


def test_a_hinge_about_minus_z():
    """Its angle is clockwise."""
    text = chain(("Rod rod(m = 1, length = 1);",), (), False).replace(
        "pin(world, rod.a)", "pin(world, rod.a, n = {0, 0, -1}, phi(start = 0.3), w(start = 2, fixed = true))"
    )
    text = text.replace("rod.phi = -1; rod.w = 1;", "")
    run = mbdsl.simulate(follow(text), stop=1e-3, step=1e-3)
    assert (run["rod.phi"][0], run["rod.w"][0], run["pin.phi"][0]) == pytest.approx((-0.3, -2.0, 0.3), abs=1e-12)


@pytest.mark.parametrize("spatial", [False, True])
@pytest.mark.parametrize("kind", ["Body", "BodyShape"])
def test_start_values_of_a_body(kind, spatial):
    """Position and velocity of frame_a, where the centre of mass is elsewhere."""
    given = "r_0(start = {1, 2, 0}, fixed = true), v_0(start = {3, 4, 0}, fixed = true)"
    given += ", angles_fixed = true, angles_start = {0, 0, 0.5}, w_0_start = {0, 0, 2}"
    com, I = ("{0.3, 0, 0}", "I_11 = 1, I_22 = 1, I_33 = 1") if spatial else ("{0.3, 0, 0}", "I_33 = 1")
    text = f"""{"spatial " if spatial else ""}model Flying
  World world;
  {PARTS}{kind} b(m = 2, {I}, {given}, r_CM = {com});
  FreeMotion free(world, b.frame_a);
initial equation
end Flying;"""
    run = mbdsl.simulate(follow(text), stop=1e-3, step=1e-3)
    expected = {"b.a.x": 1.0, "b.a.y": 2.0, "b.a.vx": 3.0, "b.a.vy": 4.0, "b.phi": 0.5, "b.w": 2.0}
    expected["b.x"] = 1.0 + 0.3 * np.cos(0.5)
    assert {name: run[name][0] for name in expected} == pytest.approx(expected, abs=1e-9)


def test_starts_without_values_are_zero():
    text = f"""model Rest
  World world;
  {PARTS}Body b(m = 2, I_33 = 1, r_0(start = {{1, 2, 0}}, fixed = true), v_0(fixed = true), angles_fixed = true);
  FreeMotion free(world, b.frame_a);
initial equation
end Rest;"""
    initial = {i.name: (i.value, i.fixed) for i in follow(text).initial}
    assert initial == {"b.x": (1, True), "b.y": (2, True), "b.vx": (0, True), "b.vy": (0, True), "b.phi": (0, True)}


def test_a_body_of_planar_mechanics():
    text = """model Flight
  PlanarMechanics.PlanarWorld planarWorld(constantGravity = {3, -4}, defaultZPosition = 0);
  PlanarMechanics.Parts.Body body(m = 1, I = 1, enableGravity = true, r(start = {1, 2}), v(start = {3, 4}));
  FreeMotion free(planarWorld, body.frame_a);
initial equation
end Flight;"""
    run = mbdsl.simulate(follow(text), method="dop853", tol=1e-9, stop=1.0, interval=1.0)
    assert (run["body.x"][-1], run["body.y"][-1]) == pytest.approx((1 + 3 + 1.5, 2 + 4 - 2), abs=1e-9)


# -- rods --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("spatial", [False, True])
@pytest.mark.parametrize("kind", ["SphericalSpherical", "UniversalSpherical"])
@pytest.mark.parametrize("m", ["", ", m = 3"])
def test_a_rod_keeps_its_mass(spatial, kind, m):
    """A pendulum with a point mass of 3 kg in its middle and one of 2 kg at its end: (m/4 + M) L w' = (m/2 + M) g."""
    given = "rodLength = 0.5" if kind == "SphericalSpherical" else "rRod_ia = {0.3, 0.4, 0}"
    if not spatial and kind == "UniversalSpherical":
        given = "rRod_ia = {0.5, 0, 0}"
    text = f"""{"spatial " if spatial else ""}model Rods
  World world;
  PointMass mass(m = 2);
  Modelica.Mechanics.MultiBody.Joints.{kind} x({given}{m});
equation
  connect(world.frame_b, x.frame_a);
  connect(x.frame_b, mass.frame_a);
initial equation
  mass.x = 0.3; mass.y = -0.4;{" mass.z = 0; mass.vz = 0;" if spatial else ""} mass.vx = 0.8; mass.vy = 0.6;
end Rods;"""
    run = mbdsl.simulate(follow(text), method="dop853", tol=1e-8, stop=0.1, interval=0.1)
    rod = 3.0 if m else 0.0
    inertia, moment = (rod / 4 + 2) * 0.25, (rod / 2 + 2) * 9.81 * 0.5
    state, h = np.array([np.arctan2(0.3, 0.4), 2.0]), 1e-3  # angle from the downward vertical; RK4

    def slopes(state):
        return np.array([state[1], -moment * np.sin(state[0]) / inertia])

    for _ in range(100):
        k1 = slopes(state)
        k2 = slopes(state + h / 2 * k1)
        k3 = slopes(state + h / 2 * k2)
        state = state + h * (k1 + 2 * k2 + 2 * k3 + slopes(state + h * k3)) / 6
    assert run["mass.x"][-1] == pytest.approx(0.5 * np.sin(state[0]), abs=1e-6)
    assert run["mass.y"][-1] == pytest.approx(-0.5 * np.cos(state[0]), abs=1e-6)


# -- variables ---------------------------------------------------------------------------------------------------------

SLIDER = """model Slider
  World world;
  Frame rail(world, r = {1, 2}, phi = 0.4);
  Body rod(m = 2, I = 0.3, com = {0.2, 0.5}, frames(a = {0, 0}, b = {1, 0}));
  Prismatic pin(rail, rod.a);
  Real y = VARIABLE;
initial equation
  pin.s = 0.1; pin.v = 0.3;
end Slider;"""


def variable(text, name):
    """The values of a variable in Modelica's words during a short motion, and the run."""
    run = mbdsl.simulate(follow(text.replace("VARIABLE", name)), method="dop853", tol=1e-9, stop=0.2, interval=0.1)
    return run["y"], run


@pytest.mark.parametrize("joint", ["Prismatic", "Revolute"])
@pytest.mark.parametrize("port", ["frame_a", "frame_b"])
@pytest.mark.parametrize("k", [1, 2])
def test_cut_forces_in_the_plane(joint, port, k):
    """The force on the joint, in the axes of its frame: from the acceleration of the body's centre of mass."""
    text = SLIDER.replace("Prismatic", joint)
    text = text if joint == "Prismatic" else text.replace("pin.s = 0.1; pin.v = 0.3;", "pin.phi = 0.3; pin.w = 2;")
    y, run = variable(text, f"pin.{port}.f[{k}]")
    on_body = np.array([2 * run["rod.ax"], 2 * (run["rod.ay"] + 9.81)])
    angle = run["rod.phi"] if port == "frame_b" else 0.4
    local = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
    sign = -1 if port == "frame_b" else 1
    assert y == pytest.approx(sign * (on_body[0] * local[k - 1][0] + on_body[1] * local[k - 1][1]), abs=1e-6)


def test_cut_torque_in_the_plane():
    """The torque at the origin of frame_b keeps the slider from turning: tau = -(r_b - r_c) x F."""
    y, run = variable(SLIDER, "pin.frame_b.t[3]")
    F = np.array([2 * run["rod.ax"], 2 * (run["rod.ay"] + 9.81)])
    d = np.array([run["rod.a.x"] - run["rod.x"], run["rod.a.y"] - run["rod.y"]])
    assert y == pytest.approx(d[0] * F[1] - d[1] * F[0], abs=1e-6)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("rod.r_0[1]", 1 + 0.1 * np.cos(0.4)),
        ("rod.r_0[2]", 2 + 0.1 * np.sin(0.4)),
        ("rod.frame_b.r_0[2]", 2 + 1.1 * np.sin(0.4)),
        ("rod.v_0[2]", 0.3 * np.sin(0.4)),
        ("rod.w_a[3]", 0.0),
        ("rail.r_0[2]", 2.0),
    ],
)
def test_positions_and_velocities_in_the_plane(name, expected):
    assert variable(SLIDER, name)[0][0] == pytest.approx(expected, abs=1e-12)


def test_a_body_without_frame_a_is_given_it():
    text = SLIDER.replace("frames(a = {0, 0}, b = {1, 0})", "frames(b = {0, 0})").replace("rod.a)", "rod.b)")
    with pytest.raises(mbdsl.ModelError) as problem:
        mbdsl.parse(text.replace("VARIABLE", "rod.r_0[2]"))
    assert "give `rod` the frame `frames(a = {0, 0})`, and write `rod.a.y`" in problem.value.hint


@pytest.mark.parametrize("k", [1, 2, 3])
def test_variables_in_space(k):
    """Positions and velocities are those of the frame; the angular velocity and cut forces are in its axes."""
    text = chain((ROD_IN_SPACE, "Real y = VARIABLE;"), (), True)
    R = rotation(X, np.degrees(0.4)) @ rotation(Y, np.degrees(0.3)) @ rotation(Z, np.degrees(-1.0))
    w, i = np.array([0.3, 0.7, 1.0]), k - 1
    expected = {
        "rod.frame_b.r_0": R @ X,
        "rod.r_0": 0 * X,
        "rod.v_0": 0 * X,
        "rod.frame_b.v_0": np.cross(w, R @ X),
        "rod.w_a": R.T @ w,
    }
    for name, vector in expected.items():
        assert variable(text, f"{name}[{k}]")[0][0] == pytest.approx(vector[i], abs=1e-12), name
    y, run = variable(text, f"pin.frame_b.f[{k}]")
    on_body = np.array([run["rod.ax"][0], run["rod.ay"][0] + 9.81, run["rod.az"][0]])
    assert y[0] == pytest.approx((R.T @ -on_body)[i], rel=1e-9)
    assert variable(text, f"pin.frame_a.f[{k}]")[0][0] == pytest.approx(on_body[i], rel=1e-9)


# -- other names -------------------------------------------------------------------------------------------------------

#: parameters that a kind needs, besides those of the table
NEEDED = {
    "Force": "fx = 1",
    "Torque": "tau = 1",
    "RotationalDriver": "phi = 1",
    "RotationalVelocityDriver": "w = 1",
    "TranslationalDriver": "s = 1",
    "TranslationalVelocityDriver": "v = 1",
    "Screw": "pitch = 0.1",
    "FlexibleBeam": "length = 1, E = 1e9, A = 1e-4, I = 1e-9, rho = 1000",
    "Rod": "m = 1, length = 2",
}


@pytest.mark.parametrize("key", other_kinds._RENAMED)
def test_a_kind_with_another_name_keeps_its_values(key):
    """Every value of the table arrives in the parameter of the same meaning; what is drawn does not."""
    kind, names = other_kinds._RENAMED[key]
    given = {old: 1.5 + i for i, old in enumerate(dict.fromkeys(names))}
    chosen = {}
    for old, x in given.items():  # two names of one parameter are not given together
        takes = [p.name for p in find(kind, True).parameters]
        if names[old] in takes and names[old] not in [names[o] for o in chosen]:
            chosen[old] = x
    arguments = ", ".join([*(f"{old} = {x}" for old, x in chosen.items()), *filter(None, [NEEDED.get(kind)])])
    text = f"""spatial model M
  World world;
  Body rod(m = 1, I = 1);
  Modelica.Mechanics.{key} x({arguments}{", " if arguments else ""}animation = false);
end M;"""
    with pytest.raises(mbdsl.ModelError) as problem:
        mbdsl.parse(text)
    (written,) = re.findall(r"write `(.*?)`", problem.value.hint)
    assert written.startswith(f"{kind} x(") and "animation" not in written
    for old, x in chosen.items():
        assert re.search(rf"\b{names[old]} = {x}\b", written), written


def test_springs_vibrate_as_in_modelica():
    """m s'' = -c (s - s_unstretched) - d s', over-damped and along x; J phi'' = -c phi - d phi'."""
    for spatial in ("", "spatial "):
        text = f"""{spatial}model Springs
  World world(g = 0);
  Body a(m = 2, I = 1);
  Prismatic slide(world, a.c);
  Modelica.Mechanics.MultiBody.Forces.SpringDamperParallel x(c = 8, d = 10, s_unstretched = 0.5, width = 0.1);
  Body b(m = 1, I = 2);
  Revolute pin(world, b.c);
  Modelica.Mechanics.Rotational.Components.SpringDamper y(pin, c = 8, d = 10, phi_rel0 = 0.5);
equation
  connect(world.frame_b, x.frame_a);
  connect(x.frame_b, a.frame_a);
initial equation
  slide.s = 1; pin.phi = 1;
end Springs;"""
        run = mbdsl.simulate(follow(text), method="dop853", tol=1e-9, stop=1.0, interval=0.5)
        expected = 0.5 + (4 * np.exp(-run.t) - np.exp(-4 * run.t)) / 6  # roots -1 and -4
        assert run["slide.s"] == pytest.approx(expected, abs=1e-7)
        assert run["pin.phi"] == pytest.approx(expected, abs=1e-7)


@pytest.mark.parametrize("from_world", [True, False])
def test_the_spring_of_planar_mechanics(from_world):
    """Spring and damper along x and y of the world, and about the angle from phi_rel0: three vibrations."""
    first, second = ("world.frame_b", "b.frame_a") if from_world else ("b.frame_a", "world.frame_b")
    sign = 1 if from_world else -1
    relaxed = f"s_relx0 = {sign * 0.3}, s_rely0 = {sign * -0.2}, phi_rel0 = {sign * 0.5}"
    text = f"""model Mount
  World world(g = 0);
  Body b(m = 2, I = 2);
  PlanarMechanics.Parts.SpringDamper x(c_x = 8, d_x = 10, c_y = 18, d_y = 0, c_phi = 8, d_phi = 10, {relaxed});
equation
  connect({first}, x.frame_a);
  connect(x.frame_b, {second});
initial equation
  b.x = 1.3; b.y = 0.8; b.phi = 1.5;
end Mount;"""
    run = mbdsl.simulate(follow(text), method="dop853", tol=1e-9, stop=1.0, interval=0.5)
    decay = (4 * np.exp(-run.t) - np.exp(-4 * run.t)) / 3
    assert run["b.x"] == pytest.approx(0.3 + decay, abs=1e-7)
    assert run["b.y"] == pytest.approx(-0.2 + np.cos(3 * run.t), abs=1e-7)
    assert run["b.phi"] == pytest.approx(0.5 + decay, abs=1e-7)


def test_the_spring_of_planar_mechanics_between_two_bodies_that_turn():
    """Its axes are those of the world: the relative motion along x and y is that of the reduced mass."""
    text = """model Mount
  World world(g = 0);
  Body a(m = 2, I = 1);
  Body b(m = 3, I = 2);
  FreeMotion fa(world, a.c);
  FreeMotion fb(world, b.c);
  PlanarMechanics.Parts.SpringDamper x(c_x = 10.8, c_y = 4.8);
equation
  connect(a.frame_a, x.frame_a);
  connect(x.frame_b, b.frame_a);
initial equation
  a.x = 0; a.y = 0; b.x = 1; b.y = 2; a.w = 2; b.w = -1; a.vx = 0; a.vy = 0; b.vx = 0; b.vy = 0;
end Mount;"""
    run = mbdsl.simulate(follow(text), method="dop853", tol=1e-9, stop=1.0, interval=0.5)
    assert run["b.x"] - run["a.x"] == pytest.approx(np.cos(3 * run.t), abs=1e-7)
    assert run["b.y"] - run["a.y"] == pytest.approx(2 * np.cos(2 * run.t), abs=1e-7)


#: type and parameters -> flanges at p, q and r, and their speeds after 1 s: p and q turn, or q slides, r turns. The
#: torque 1 N.m acts on p, whose inertia is 0.5 kg.m2; that of q 0.2 kg.m2, or 2 kg; that of r 1 kg.m2
GEARS = {
    # phi_p = 2 phi_q: (0.5 + 0.2/4) w' = 1
    "IdealGear x(ratio = 2)": (("flange_a", "flange_b"), (1 / 0.55, 0.5 / 0.55)),
    "LossyGear x(ratio = 2)": (("flange_a", "flange_b"), (1 / 0.55, 0.5 / 0.55)),
    "Gearbox x(ratio = 2)": (("flange_a", "flange_b"), (1 / 0.55, 0.5 / 0.55)),
    "IdealGearR2R x(ratio = 2)": (("flange_a", "flange_b"), (1 / 0.55, 0.5 / 0.55)),
    # phi_p = 4 s_q: (0.5 + 2/16) w' = 1
    "IdealGearR2T x(ratio = 4)": (("flangeR", "flangeT"), (1 / 0.625, 0.25 / 0.625)),
    # s_q = 0.25 phi_p
    "IdealRollingWheel x(radius = 0.25)": (("flangeR", "flangeT"), (1 / 0.625, 0.25 / 0.625)),
    # p + 3 r = 4 q, and torques T, 3 T, -4 T: 0.5 p' = 1 + T, 0.2 q' = -4 T, r' = 3 T, so that T = -2/91
    "IdealPlanetary x(ratio = 3)": (("sun", "carrier", "ring"), (178 / 91, 40 / 91, -6 / 91)),
}


@pytest.mark.parametrize("spatial", ["", "spatial "])
@pytest.mark.parametrize("gear", GEARS)
def test_gears_of_one_dimensional_libraries(gear, spatial):
    (flanges, speeds), slides = GEARS[gear], gear.startswith(("IdealGearR2T", "IdealRolling"))
    second = "Prismatic q(world, b.c);" if slides else "Revolute q(world, b.c);"
    lines = [f"{spatial}model Gears", "  World world;", "  Body a(m = 1, I = 0.5);", "  Body b(m = 2, I = 0.2);"]
    lines += ["  Body c(m = 1, I = 1);", "  Revolute p(world, a.c);", f"  {second}", "  Revolute r(world, c.c);"]
    lines += [f"  Modelica.Mechanics.Rotational.Components.{gear};", "  Torque t(p, tau = 1);", "equation"]
    lines += [f"  connect(x.{flange}, {joint}.axis);" for flange, joint in zip(flanges, "pqr", strict=False)]
    run = mbdsl.simulate(follow("\n".join([*lines, "end Gears;"])), step=0.01, stop=1.0)
    found = [run[f"{joint}.{'v' if slides and joint == 'q' else 'w'}"][-1] for joint in "pqr"[: len(flanges)]]
    assert found == pytest.approx(speeds, abs=1e-9)


def test_every_rule_that_makes_a_declaration_is_followed_here():
    types = " ".join(d for declarations, *_ in RIGID.values() for d in declarations)
    elsewhere = {
        "Parts.SpringDamper",
        "Parts.Spring",
        "SphericalSpherical",
        "UniversalSpherical",
        "Parts.Fixed",
        "Marker",
        *(gear.split(" ")[0] for gear in GEARS),
        *(name for name, made in gears.GEARS.items() if made is gears._coupling),  # without values
        *blocks.MADE,
    }
    assert {key for key in other_kinds._MADE if f"{key} x(" not in types} == elsewhere


#: blocks with the values that their advice reads
BLOCKS = {
    "Integrator": "(k = 2, y_start = 0.5)",
    "LimIntegrator": "(k = 2)",
    "FirstOrder": "(k = 2, T = 0.1)",
    "Derivative": "(T = 0.1)",
    "LimPID": "(k = 100, Ti = 0.1, Td = 0.1, yMax = 12, Ni = 0.1)",
    "Continuous.PID": "(k = 3, Ti = 0.5, Td = 0.1)",
    "Continuous.PI": "(k = 3, T = 0.5, initType = Modelica.Blocks.Types.Init.SteadyState)",
    "KinematicPTP": "(startTime = 0.5, deltaq = {2}, qd_max = {1}, qdd_max = {1})",
    "KinematicPTP2": "(deltaq = {2}, qd_max = {1}, qdd_max = {1})",
    "Rotational.Components.Inertia": "(J = 0.5)",
    "Inertia": "(J = 0.5)",
    "ConstantTorque": "(tau_constant = 10)",
    "Rotational.Sources.Torque": "(tau_constant = 10)",
    "Hysteresis": "(uLow = 0, uHigh = 1)",
    "OnOffController": "(bandwidth = 0.2, pre_y_start = true)",
    "ZeroOrderHold": "(samplePeriod = 0.1, startTime = 0.5)",
    "Discrete.Sampler": "(samplePeriod = 0.1)",
    "UnitDelay": "(samplePeriod = 0.1, y_start = 2)",
}


def blocks_followed(codes, names=""):
    """A model with pieces of advice, each in its section, and what they refer to."""
    initial = [x for x in codes if re.match(r"der\(\w+\) = 0;", x)]
    equations = [x for x in codes if re.match(r"der\(|when ", x) and x not in initial]
    declared = [x.replace("... - ...", "1 - u") for x in codes if x not in (*initial, *equations)]
    model = f"model M Ground ground; Body b(m = 1 kg, I = 1 kg.m2); Revolute shaft(ground, b.c); {names}"
    model += f" Real u = sin(2*time/(1 s)); {' '.join(declared)}"
    model += f" initial equation {' '.join(initial)}" * bool(initial)
    return f"{model} equation {' '.join(equations)} end M;"


@pytest.mark.parametrize("block", BLOCKS)
def test_blocks_become_variables_states_and_bodies(block):
    name = "Rotational.Inertia" if block == "Inertia" else block  # which alone is a quantity
    with pytest.raises(ModelError) as problem:
        mbdsl.parse(f"model M Ground ground; {name} x{BLOCKS[block]}; end M;")
    codes = [code for code in re.findall(r"`([^`]*)`", str(problem.value)) if code.endswith(";")]
    codes += re.findall(r"`(parameter Time [^`]*|Real \w+ = [^`]*)`", str(problem.value))
    model = mbdsl.parse(blocks_followed(dict.fromkeys(codes), "Real reference = 0;"))
    assert any(re.search(r"\bx", name) for name in (*model.variables, *model.components, *model.events.variables))


def test_every_block_is_followed():
    assert set(blocks.MADE) == {*BLOCKS, "Limiter"}  # which is an expression


CODES = sorted(
    {code for x in other_kinds._TEXTS.values() for code in re.findall(r"`([^`]*;)`", x) if "..." not in code}
)


@pytest.mark.parametrize("code", CODES)
def test_declarations_in_other_advice_are_accepted(code):
    if re.match(r"der\(|when ", code):
        names = (
            "Boolean on(start = false), set = u > 0, reset = u < 0; discrete Real y; parameter Real high = 1, low = 0; "
            "Real x[2];"
        )
        rest = "" if "der(" in code else "der(x) = {0, 0}/(1 s);"
        assert mbdsl.parse(blocks_followed([code, *filter(None, [rest])], names)).events or "der(" in code
        return
    if code == "Real x[2];":
        assert mbdsl.parse(blocks_followed([code, "der(x) = {x[2], u - x[1]}/(1 s);"])).components
        return
    around = {
        "ground": "Ground ground;",
        "rod": "Rod rod(m = 1 kg, length = 1 m);",
        "pin": "Revolute pin(ground, rod.a);",
        "rotor": "Revolute axle(ground, rotor.c);",
        "load": "PointMass load(m = 1 kg);",
    } | {name: f"Body {name}(m = 1 kg, I = 1 kg.m2);" for name in ("block", "wheel", "drum")}
    if re.match(r"\w+ rotor\(", code):
        del around["rod"], around["pin"]
    else:
        del around["rotor"]
    around.pop(re.match(r"[\w ]+? (\w+)\b", code)[1], None)
    assert mbdsl.parse(f"model M {' '.join(around.values())} {code} end M;").components


@pytest.mark.parametrize("name", other_names._SAME)
@pytest.mark.parametrize("spatial", [False, True])
def test_a_parameter_with_another_name_keeps_its_value(name, spatial):
    own = other_names._SAME[name]
    fitting = [k for k in kinds(spatial) if (kind := find(k, spatial)).parameter(own) and not kind.parameter(name)]
    if not fitting or name in ("R", "axis", "I_33", "I_zz", "Izz", "r_CM"):  # those of bodies are above
        return
    text = chain(("Rod rod(m = 1, length = 1);", f"{fitting[0]} x({name} = 3);"), (), spatial)
    with pytest.raises(mbdsl.ModelError) as problem:
        mbdsl.parse(text)
    assert problem.value.hint.startswith(f"write `{own} = 3")


# -- passed over -------------------------------------------------------------------------------------------------------

DRAWN = """model Drawn
  inner Modelica.Mechanics.MultiBody.World world(animateWorld = false, label1 = "x", axisColor_x = {0, 0, 0},
    gravityType = Modelica.Mechanics.MultiBody.Types.GravityTypes.UniformGravity, defaultJointLength = 0.1);
  Rod rod(m = 1 kg, length = 1 m, animation = false, sphereColor = {0, 128, 255}, width = 0.1);
  Modelica.Mechanics.MultiBody.Joints.Revolute fixed(useAxisFlange = true, cylinderLength = 0.1,
    phi(fixed = true, stateSelect = StateSelect.always), w(start = 1, fixed = true, min = -100),
    stateSelect = StateSelect.prefer) annotation(Placement(transformation(extent = {{1, 2}, {3, 4}})));
  Frame guess if true;
equation
  connect(world.frame_b, fixed.frame_a);
  connect(fixed.frame_b, rod.frame_a);
end Drawn;"""


def test_what_has_no_effect_on_the_motion_is_passed_over_in_one_note():
    """What is drawn, states and flanges; a fixed start without a value is zero, as in Modelica."""
    scene = mbdsl.parse(DRAWN)
    (note,) = scene.warnings
    assert note.severity == "note" and "`animateWorld`, `label1`, `axisColor_x`, `gravityType`" in note.message
    plain = """model Drawn
  World world;
  Rod rod(m = 1 kg, length = 1 m);
  Revolute fixed(phi(start = 0, fixed = true), w(start = 1, fixed = true));
  Frame guess;
equation
  connect(world, fixed.frame_a);
  connect(fixed.frame_b, rod.a);
end Drawn;"""
    assert scene == mbdsl.parse(plain)


@pytest.mark.parametrize(
    "wrong", ["animations = false", "gravityType = Types.NoGravity", "density = 3", "phi(begin = 3)"]
)
def test_what_has_an_effect_or_is_misspelt_is_not(wrong):
    kind = "World other" if "gravity" in wrong else "Revolute x" if "phi" in wrong else "Rod x"
    with pytest.raises(mbdsl.ModelError):
        mbdsl.parse(chain(("Rod rod(m = 1, length = 1);", f"{kind}({wrong});"), (), False))


@pytest.mark.parametrize("name", ["fixed", "guess"])
@pytest.mark.parametrize("more", [" annotation(Icon())", " if 1 < 2", "", ' "a frame"', "[2]"])
def test_words_of_the_initial_section_are_names(name, more):
    text = chain(("Rod rod(m = 1, length = 1);", f"Frame {name}{more};"), (), False)
    assert name in (line.name.partition("[")[0] for line in parse(text).models[0].items)
    text = text.replace("rod.phi = -1;", f"{name} rod.phi = -1;").replace(f"Frame {name}", "Frame other")
    assert mbdsl.parse(text).initial[0].fixed == (name == "fixed")


def test_a_spring_with_a_mass_says_that_it_is_lost_and_a_body_keeps_its_own():
    around = (("Rod rod(m = 1, length = 1);", "{}"), (), False)
    for declared, written, said in (
        ("Modelica.Mechanics.MultiBody.Forces.Spring x(c = 3, m = 0.5)", "SpringDamper x(k = 3 N/m);", "has no mass"),
        ("RigidBody x(mass = 3, Izz = 2)", "Body x(m = 3 kg, I = 2 kg.m2);", ""),
    ):
        with pytest.raises(mbdsl.ModelError) as problem:
            mbdsl.parse(chain(*around).replace("{}", f"{declared};"))
        assert f"write `{written}`" in problem.value.hint and said in problem.value.hint


def test_a_weld_in_a_sub_model_has_its_names():
    text = """model Pair
  Frame foot;
  Rod rod(m = 1, length = 1);
  Body disc(m = 2, I = 0.4);
  Revolute pin(foot, rod.a);
equation
  connect(rod.frame_b, disc.frame_a);
end Pair;
model Both
  World world;
  Pair first(foot = world);
  Pair second(foot = world);
end Both;"""
    scene = follow(text)
    assert {"first.rod_disc", "second.rod_disc"} <= scene.components.keys()
