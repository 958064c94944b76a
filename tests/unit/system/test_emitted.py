"""The emitted code has the functions that a scene needs and no others; it depends on its structure, never on a number.

The expected contents are listed here, model by model and effect by effect; they are not read from the emitting code.
"""

import re
from pathlib import Path

import pytest

import mbdsl
from mbdsl.integrators import modules as methods
from mbdsl.mechanism import graph
from mbdsl.mechanism.reduction import reduce
from mbdsl.system import build, emit

MODELS = Path(__file__).parents[3] / "models"
#: effect -> functions in the code of every scene that has it, and of no other
TRACES = {
    "joints": {"loops.constraints", "tangent_loops.constraint_tangents"},
    "drivers": {"loops.drive"},
    "couplings": {"loops.couple"},
    "moving": {"loops.carry"},
    "relations": {"relation_loops.values", "relation_loops.tangents"},
    "velocity rows": {"loops.gammas", "tangent_loops.gamma_tangents"},
    "springs": {"loops.springs", "tangent_loops.spring_tangents"},
    "laws": {"loops.laws", "tangent_loops.law_tangents"},
    "expressions": {"expression_tape.run", "TAPE_LENGTH", "GRADIENT_LENGTH"},
    "mass matrix": {"tangent_loops.coupling_matrix", "INERTIA_ROW", "TIMES"},
}
ALWAYS = {"loops.start", "tangent_loops.begin_matrix", "loops.inertia"}
#: model -> its effects, the modules that its code takes kernels from
EXPECTED = {
    "chain": ("joints", "rigid_body_kernels revolute"),
    "chaplygin_sleigh": ("velocity rows, expressions", "rigid_body_kernels"),
    "crank_ivp": (
        "joints, moving, expressions, mass matrix",
        "point_mass_kernels floating_beam_kernels revolute point_on_line",
    ),
    "double_pendulum": ("joints, springs", "rigid_body_kernels revolute rotational_spring_damper"),
    "driven_crank": ("joints, moving, expressions", "rigid_body_kernels point_mass_kernels revolute point_on_line"),
    "flexible_pendulum": ("joints, mass matrix", "ancf_cable_kernels revolute"),
    "flexible_slider_crank": ("joints, mass matrix", "rigid_body_kernels floating_beam_kernels revolute point_on_line"),
    "four_bar": ("joints", "rigid_body_kernels revolute"),
    "hoist": ("joints, laws, expressions", "rigid_body_kernels revolute rope torque"),
    "pendulum": ("joints", "point_mass_kernels distance"),
    "rolling_disc": ("joints, velocity rows, springs, expressions", "rigid_body_kernels rolling_disc spring_damper"),
    "seven_body": ("joints, springs, laws, expressions", "rigid_body_kernels revolute spring_damper torque"),
    "slider_crank": ("joints, springs", "rigid_body_kernels revolute point_on_line spring_damper"),
    "spin_up_beam": ("joints, moving, expressions, mass matrix", "floating_beam_kernels fixed"),
    "spring_mass": ("joints, springs", "rigid_body_kernels prismatic translational_spring_damper"),
    # its block's friction acts along what a translational spring and damper measures
    "stick_slip_belt": (
        "joints, moving, springs, laws, expressions",
        "rigid_body_kernels prismatic spring_damper translational_spring_damper",
    ),
}
ROD = "Ground ground; Rod rod(m = 1 kg, length = 1 m); Rod tip(m = 1 kg, length = 1 m);"
JOINED = f"{ROD} Revolute pin(ground, rod.a); Revolute knee(rod.b, tip.a);"
#: small scenes, each with one element more than JOINED
SCENES = {
    "": ("joints", "rigid_body_kernels revolute"),
    # not of the joint's own coordinate from the ground: it remains a constraint
    "RotationalDriver d(ground, tip.c, phi = 1 rad/s*time);": (
        "joints, drivers, expressions",
        "rigid_body_kernels revolute rotational_driver",
    ),
    "RotationalDriver d(pin, phi = 1 rad/s*time);": ("joints, moving, expressions", "rigid_body_kernels revolute"),
    "RotationalVelocityDriver d(knee, w = 1 rad/s);": (
        "joints, velocity rows, expressions",
        "rigid_body_kernels revolute",
    ),
    "KnifeEdge k(ground, tip.b);": ("joints, velocity rows, expressions", "rigid_body_kernels revolute"),
    "RotationalSpringDamper s(rod.b, tip.a, k = 1 N.m/rad);": (
        "joints, springs",
        "rigid_body_kernels revolute rotational_spring_damper",
    ),
    "RotationalSpringDamper s(rod.b, tip.a, torque = 1 N.m*phi^3);": (
        "joints, laws, expressions",
        "rigid_body_kernels revolute rotational_spring_damper",
    ),
    "GearPair g(rod.c, tip.c, r_a = 0.4 m, r_b = 0.6 m);": ("joints", "rigid_body_kernels revolute gear_pair"),
    "RotationalCam r(rod.c, tip.c, beta = 0.1*sin(phi));": (
        "joints, couplings, expressions",
        "rigid_body_kernels revolute rotational_cam",
    ),
    "Coupling c(pin.phi, knee.phi, ratio = 2);": (
        "joints, drivers, relations, expressions",
        "rigid_body_kernels revolute",
    ),
    "PlanetaryGear c(pin.phi, rod.phi, knee.phi, ratio = 2);": (
        "joints, relations, expressions",
        "rigid_body_kernels revolute",
    ),
    "CircleContact c(ground, tip.c, r_a = 0.4 m, r_b = 0.6 m, k = 1 N/m);": (
        "joints, laws, expressions",
        "rigid_body_kernels revolute circle_contact",
    ),
    "Force f(tip.b, fx = 1 N);": ("joints, laws, expressions", "rigid_body_kernels revolute force"),
    "Bushing b(ground, tip.b, k = {1 N/m, 1 N/m});": ("joints, springs", "rigid_body_kernels revolute bushing"),
    "PointMass p(m = 1 kg); Distance link(tip.b, p, length = 1 m);": (
        "joints",
        "rigid_body_kernels point_mass_kernels revolute distance",
    ),
    "Body lump(m = 1 kg, I = 1 kg.m2); Fixed f(tip.b, lump.c);": ("joints", "rigid_body_kernels revolute"),  # merged
}


def small(more):
    return mbdsl.parse(f"model Small {JOINED} {more} annotation(experiment(StopTime = 1 s)); end Small;")


def codes(scene, sets=1):
    """The code of every part that is solved."""
    parts = reduce(graph.build(scene)).parts
    systems = [build(part.scene, part.graph) for part in parts]
    return [emit.emit(s.tables.blocks, s.tables.has_tape, sets) for s in systems]


def names(code):
    """Functions of loops and tape, and modules of kernels, that occur in the code below its title."""
    text = code.split('"""', 2)[2]
    found = (
        set(
            re.findall(
                r"\b(?:loops|tangent_loops|relation_loops|expression_tape)\.\w+|\b(?:[A-Z]+_LENGTH|INERTIA_ROW|TIMES)\b",
                text,
            )
        )
        - ALWAYS
    )
    modules = set(re.findall(r"import mbdsl_kind_(\w+)|from mbdsl\.bodies import (\w+)", text))
    called = set(re.findall(r"^    (\w+)\.\w+\(", text, re.MULTILINE)) - {
        "loops",
        "tangent_loops",
        "relation_loops",
        "expression_tape",
    }
    imported = {a or b for a, b in modules}
    assert called == imported  # every import is used
    return found, imported


def check(code, effects, modules):
    found, imported = names(code)
    wanted = set().union(*(TRACES[effect] for effect in effects.split(", ")))
    assert found == wanted
    assert imported == set(modules.split())


def test_every_model_is_here():
    assert set(EXPECTED) == {path.stem for path in MODELS.glob("*.mbd")}
    every = {effect for effects, _ in (*EXPECTED.values(), *SCENES.values()) for effect in effects.split(", ")}
    assert every == set(TRACES)  # each occurs in some model, and is missing in another
    assert all(any(effect not in effects for effects, _ in EXPECTED.values()) for effect in TRACES)


@pytest.mark.parametrize("name", EXPECTED)
def test_models_hold_what_they_call_for(name):
    (code,) = codes(mbdsl.load(MODELS / f"{name}.mbd"))
    check(code, *EXPECTED[name])


@pytest.mark.parametrize("more", SCENES)
def test_one_thing_more_is_one_trace_more(more):
    (code,) = codes(small(more))
    check(code, *SCENES[more])


def test_general_code_holds_everything():
    """The same search finds every function in the code that has all of them."""
    s = build(small(""), general=True)
    found, imported = names(emit.emit(s.tables.blocks, s.tables.has_tape, 1))
    assert found == set().union(*TRACES.values())
    kernels = set(" ".join(modules for _, modules in (*EXPECTED.values(), *SCENES.values())).split())
    assert kernels < imported


@pytest.mark.parametrize("name", EXPECTED)
def test_sets_of_multipliers(name):
    """Methods of index 3 have lam alone: nothing computes Phi_q^T mu, or keeps the Phi_q of a step before."""
    scene = mbdsl.load(MODELS / f"{name}.mbd")
    joints = "joints" in EXPECTED[name][0]
    one, two, three = ("".join(codes(scene, sets)) for sets in (1, 2, 3))
    past = ("loops.keep", "loops.remember", "PAST_FORCE")
    assert not any(word in one for word in ("_with_mu", *past))
    assert ("loops.constraints_with_mu" in two) == ("collect_with_mu" in two or "L.FORCE2" in two) == joints
    assert not any(word in two for word in past)
    assert all((word in three) == (joints or word == "loops.keep") for word in past)


def test_methods_have_as_many_sets_as_they_enforce_levels():
    """The definitions with which a method's code is compiled: methods of index 3 and 1 have no mu."""
    sets = {name: module.METHOD.sets for name, module in methods().items()}
    without = {name for name, module in methods().items() if module.METHOD.index in (1, 3)}
    assert {name for name, number in sets.items() if number == 1} == without > {"newmark", "hht-i3", "nstiff"}
    assert {name for name, number in sets.items() if number == 3} == {"hht-add"}


def test_friction_leaves_no_trace():
    with_, without = (
        "".join(codes(mbdsl.load(MODELS / "stick_slip_belt.mbd", without=effects))) for effects in ((), ("friction",))
    )
    gone = names(with_)[0] - names(without)[0]
    # tape and carry stay: they turn the belt
    assert gone == TRACES["laws"]
    assert names(with_)[1] - names(without)[1] == {"translational_spring_damper"}
    wrist = "Rod last(m = 1 kg, length = 1 m); Revolute wrist(tip.b, last.a, mu = {}, radius = 1 cm);"
    assert codes(small(wrist.format(0))) == codes(small(""))
    assert TRACES["laws"] < names(codes(small(wrist.format(0.1)))[0])[0]
    # in a kinematic part, friction changes no motion
    pin = "Revolute wrist(ground, tip.b, mu = 0.1, radius = 1 cm);"
    assert codes(small(pin)) == codes(small(""))


def test_what_does_not_bend_leaves_no_trace():
    """A beam without modes is a rod: the code is that of the slider crank without its spring."""
    path = MODELS / "flexible_slider_crank.mbd"
    rigid = codes(mbdsl.load(path, {"modes": 0}))
    assert rigid == codes(mbdsl.load(path, without=("flexibility",)))
    assert names(rigid[0]) == (TRACES["joints"], {"rigid_body_kernels", "revolute", "point_on_line"})


# -- structure, not numbers ----------------------------------------------------------------------------------------


def module_names(name, **parameters):
    scene = mbdsl.load(MODELS / f"{name}.mbd", parameters)
    return [emit.module_name(code) for code in codes(scene)]


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        ("slider_crank", {"k": "7 N/m", "m1": 2.0, "L2": "0.7 m", "g": 0.0, "c": 0.0}),
        ("chain", {"N": 3}),
        ("driven_crank", {"w0": "3 rpm"}),
        ("stick_slip_belt", {"mu": 0.1, "belt_speed": 0.2}),
        ("double_pendulum", {"L1": 0.7}),
        ("flexible_slider_crank", {"modes": 7, "m2": 1.0}),
        ("spin_up_beam", {"modes": 4, "stiffening": False}),
    ],
)
def test_numbers_do_not_matter(name, parameters):
    assert module_names(name, **parameters) == module_names(name)


def test_expressions_do_not_matter():
    laws = ("1 N", "if time > 1 s then 3 N else 1 N*sin(4 rad/s*time)", "-5 N.s/m*tip.b.vx")
    assert len({"".join(codes(small(f"Force f(tip.b, fx = {law});"))) for law in laws}) == 1


def test_structure_does_matter():
    every = {name: tuple(module_names(name)) for name in EXPECTED}
    assert every["chain"] == every["four_bar"]  # rods on pins, both
    assert len(set(every.values())) == len(every) - 1
