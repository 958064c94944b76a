"""Models of Modelica's MultiBody library in space: joints by their full names, and remedies that can be used as they
are."""

import re

import pytest

import mbdsl

MODEL = """spatial model Arm
  inner Modelica.Mechanics.MultiBody.World world;
  {}
  Modelica.Mechanics.MultiBody.Joints.{} joint({});
equation
  connect(world.frame_b, joint.frame_a);
  connect(joint.frame_b, part.frame_a);
end Arm;"""


@pytest.mark.parametrize(
    ("joint", "rows", "axes"),
    [
        ("Revolute", 5, "n = {0, 1, 0}"),
        ("Prismatic", 5, "n = {0, 0, 1}"),
        ("Cylindrical", 4, ""),
        ("Planar", 3, ""),
        ("Spherical", 3, ""),
        ("Universal", 4, "n_a = {1, 0, 0}, n_b = {0, 1, 0}"),
    ],
)
def test_joints_by_their_full_names(joint, rows, axes):
    part = "Modelica.Mechanics.MultiBody.Parts.Body part(m = 1 kg, I = {1, 1, 1} kg.m2);"
    scene = mbdsl.parse(MODEL.format(part, joint, axes))
    assert (scene.components["joint"].kind.name, scene.components["joint"].kind.rows) == (joint, rows)


#: a declaration, and the mass [kg] and a moment of inertia [kg.m2] of the body that the remedy makes. Box: 7700 kg/m3,
#: 1 m x 0.1 m x 0.05 m; cylinder: radius 0.05 m; moments about x of both: m (b^2 + h^2)/12 and m r^2/2.
PARTS = [
    ("Parts.BodyBox part(r = {1, 0, 0}, width = 0.1, height = 0.05)", 38.5, (0, 38.5 * (0.01 + 0.0025) / 12)),
    ("Parts.BodyCylinder part(r = {1, 0, 0}, diameter = 0.1, density = 1000)", 7.853982, (0, 7.853982 * 0.00125)),
    ("Parts.BodyShape part(m = 3, r = {1, 0, 2}, r_CM = {0, 0, 1}, I_11 = 4, I_22 = 5, I_33 = 6)", 3, (1, 5)),
    ("Parts.Body part(m = 3, r_CM = {1, 2, 3}, I_11 = 4, I_22 = 5, I_33 = 6)", 3, (2, 6)),
    ("Parts.Body part(m = 3, I_11 = 4, I_22 = 5, I_33 = 6, I_21 = 0.5)", 3, (0, 4)),
]


@pytest.mark.parametrize(("declared", "m", "moment"), PARTS)
def test_remedies_can_be_used_as_they_are(declared, m, moment):
    """Each remedy replaces what it names, until the model is read."""
    text = f"Modelica.Mechanics.MultiBody.{declared};"
    for _ in range(4):
        try:
            scene = mbdsl.parse(MODEL.format(text, "Spherical", ""))
            break
        except mbdsl.ModelError as problem:
            remedy = re.search(r"(?:write|or) `(.*?)`", str(problem))[1]
            if remedy.endswith(";"):
                text = remedy
            elif remedy.startswith("com"):
                text = text.replace("r_CM = {1, 2, 3}", remedy)
            elif remedy.startswith("I = "):
                text = re.sub(r"I_11.*\)", f"{remedy})", text)
            else:
                text = text.replace(");", f", {remedy});")
    body = scene.components["part"]
    table = body.kind.table(body.values)
    assert table[0] == pytest.approx(m, rel=1e-6)
    assert table[1 + 4 * moment[0]] == pytest.approx(moment[1], rel=1e-6)
    assert "part.b" in scene.frames or "r = " not in declared


def test_a_joint_in_space_in_a_planar_model():
    text = MODEL.format("Rod part(m = 1 kg, length = 1 m);", "Spherical", "").replace("spatial ", "")
    with pytest.raises(mbdsl.ModelError, match="in the plane it is a Revolute; for a model in space write"):
        mbdsl.parse(text)


def test_a_turned_frame():
    text = MODEL.format(
        "Body part(m = 1 kg, I = {1, 1, 1} kg.m2);\n"
        "  Modelica.Mechanics.MultiBody.Parts.FixedRotation turned(r = {1, 0, 2}, n = {0, 1, 0}, angle = 90);",
        "Spherical",
        "",
    )
    with pytest.raises(mbdsl.ModelError) as problem:
        mbdsl.parse(text)
    remedy = re.search(r"write `(.*?)`", str(problem.value))[1].replace("body.c", "part.c")
    scene = mbdsl.parse(re.sub(r"Modelica\S*FixedRotation.*", remedy, text))
    # x, y and z axes of a frame that is turned by 90 degrees about y
    assert scene.frames["turned"].pose == pytest.approx((1, 0, 2, 0, 0, -1, 0, 1, 0, 1, 0, 0), abs=1e-15)
