"""Flexible beams as parts of models: their initial shapes, the messages about wrong ones, and how they are counted."""

import numpy as np
import pytest

import mbdsl
from mbdsl.errors import IntegrationError, ModelError
from mbdsl.lang.load import parse_text

STEEL = "length = 1 m, mass = 1 kg, S = 1e-4 m2, I = 1e-9 m4, E = 200 GPa"
SOFT = "length = 1 m, mass = 1 kg, S = 1e-4 m2, I = 1e-9 m4, E = 2 GPa"


def model(beam, rest="", initial="", ground="Ground world;"):
    return parse_text(
        f"model Test {ground} FlexibleBeam beam({beam}); {rest} initial equation {initial} end Test;", file="test.mbd"
    )


def run(scene, stop=0.02, step=1e-3, **more):
    return mbdsl.simulate(scene, stop=stop, step=step, interval=step, **more)


# -- starts ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("formulation", ['reference = "clamped-free"', 'formulation = "ancf"'])
def test_a_static_start_stays(formulation):
    """m g L^3/8EI; bending shortens the lever by the square of that, 4e-5."""
    t = run(model(f'{STEEL}, {formulation}, shape = "static"', "Fixed clamp(world, beam.a);"))
    sag = 9.81 / (8 * 200.0)
    assert t["beam.b.y"][0] == pytest.approx(-sag, rel=2 * sag**2)
    assert np.abs(t["beam.b.y"] - t["beam.b.y"][0]).max() < 1e-9 * sag
    assert np.abs(t["beam.dq[1]"]).max() < 1e-9


@pytest.mark.parametrize("formulation", ["elements = 8", 'formulation = "ancf"'])
def test_a_static_start_holds_what_is_said_of_positions(formulation):
    """Held by its middle, either half hangs down as a cantilever does; and it turns as a whole."""
    t = run(
        model(
            f'{STEEL}, {formulation}, shape = "static"',
            "Revolute pin(world, beam.c);",
            "beam.phi = 0; beam.w = 2;",
        ),
        stop=1e-3,
    )
    sag = (9.81 / 2) * 0.5**3 / (8 * 200.0)  # half the mass, half the length
    assert t["beam.phi"][0] == pytest.approx(0.0, abs=1e-15)
    for end, side in (("a", -1), ("b", 1)):
        assert t[f"beam.{end}.y"][0] == pytest.approx(-sag, rel=1e-4)
        assert t[f"beam.{end}.vy"][0] == pytest.approx(side * 2 * 0.5, rel=1e-6)


@pytest.mark.parametrize("formulation", ["elements = 4", 'formulation = "ancf"'])
def test_a_static_start_moves_nothing_as_a_whole(formulation):
    """A beam on a pin keeps its mean angle although nothing holds it; a free one stays straight under its weight; one
    that has no static shape stays where it is; and one that is declared undeformed is straight."""
    rest = f"""Revolute pin(world, beam.a); Rod rod(m = 1 kg, length = 1 m); Revolute R(world, rod.a);
        Body lump(m = 1 kg, I = 1 kg.m2); FreeMotion F(world, lump.c);
        FlexibleBeam free({STEEL}, {formulation}, shape = "static"); FreeMotion G(world, free.c);
        FlexibleBeam straight({STEEL}, {formulation}); Fixed clamp(world, straight.a);"""
    t = run(model(f'{STEEL}, {formulation}, shape = "static"', rest), stop=1e-3)
    assert (t["rod.phi"][0], t["lump.y"][0]) == (0.0, 0.0)
    for end in "ab":
        assert t[f"straight.{end}.y"][0] == pytest.approx(0.0, abs=1e-12)
        assert t[f"free.{end}.y"][0] == pytest.approx(0.0, abs=1e-12)
    assert abs(t["beam.b.y"][0]) < 1e-3  # w L^4/EI is 0.05
    assert t["beam.a.phi"][0] * t["beam.b.phi"][0] < 0.0  # it sags between the pin and its support


@pytest.mark.parametrize("formulation", ["modes = 3", 'formulation = "ancf"'])
def test_assembly_does_not_deform(formulation):
    """A four bar linkage with guesses that are far off: every bar keeps its length, and turns as a whole."""
    scene = parse_text(
        f"""model Loop Ground world; Frame wall(world, r = {{1 m, 0}});
        FlexibleBeam crank({STEEL.replace("1 m,", "0.4 m,", 1)}, {formulation});
        FlexibleBeam rod({STEEL}, {formulation});
        FlexibleBeam rocker({STEEL.replace("1 m,", "0.7 m,", 1)}, {formulation});
        Revolute O(world, crank.a); Revolute A(crank.b, rod.a); Revolute B(rod.b, rocker.b); Revolute C(wall, rocker.a);
        initial equation crank.phi = 1.1; crank.w = 3; guess rod.phi = 0.5; guess rocker.phi = 1.5; end Loop;"""
    )
    t = run(scene, stop=1e-4, step=1e-4)
    for name, length in (("crank", 0.4), ("rod", 1.0), ("rocker", 0.7)):
        dx, dy = (t[f"{name}.b.{k}"][0] - t[f"{name}.a.{k}"][0] for k in "xy")
        vx, vy = (t[f"{name}.b.v{k}"][0] - t[f"{name}.a.v{k}"][0] for k in "xy")
        assert np.hypot(dx, dy) == pytest.approx(length, rel=1e-12)
        assert t[f"{name}.b.phi"][0] == pytest.approx(t[f"{name}.a.phi"][0], abs=1e-12)
        w = t[f"{name}.w"][0]
        assert (vx, vy) == pytest.approx((-w * dy, w * dx), abs=1e-11)


def test_a_structure_under_stress_is_assembled_deformed():
    """Pins 1 mm further apart than the beam is long: the force is EA times the strain."""
    pins = "Revolute O(world, beam.a); Frame f(world, r = {1.001 m, 0}); Revolute B(f, beam.b);"
    t = run(model(f'{STEEL}, elements = 2, shape = "static"', pins, ground="Ground world(g = 0);"), stop=1e-3)
    assert t["beam.b.x"][0] - t["beam.a.x"][0] == pytest.approx(1.001, rel=1e-12)
    assert np.abs(t["B.fx"]) == pytest.approx(2e7 * 1e-3, rel=1e-6)


# -- errors ----------------------------------------------------------------------------------------------------


def test_a_frame_off_the_axis_has_a_place():
    with pytest.raises(ModelError, match=r"frame `f` does not lie on its axis.* between -0.5 and 0.5 m") as caught:
        run(
            model(
                f"{STEEL}, modes = 2, frames(f = {{0.1, 0.2}})",
                "Fixed clamp(world, beam.a); Force push(beam.f, fy = 1);",
            )
        )
    assert caught.value.span is not None


def test_what_bends_too_far_is_no_result():
    """A soft cantilever that falls by its weight: by m g L^2/6EI = 0.8 rad at rest."""
    with pytest.raises(IntegrationError, match=r"beam bends by 0\.5\d* rad at t = .* s: .* small") as caught:
        run(model(f'{SOFT}, modes = 4, reference = "clamped-free"', "Fixed clamp(world, beam.a);"), stop=0.5)
    assert "ancf" in caught.value.hint
    found = caught.value.trajectory
    assert 0.05 < found.t[-1] <= 0.5 and len(found) == round(found.t[-1] / 1e-3) + 1  # the results up to then are there
    assert caught.value.trajectory.status == "failed"
    t = run(model(f'{SOFT}, formulation = "ancf"', "Fixed clamp(world, beam.a);"), stop=0.5)
    assert np.abs(t["beam.b.phi"]).max() > 0.8


# -- beside other bodies ---------------------------------------------------------------------------------------


def test_parts_are_put_together_again():
    """A pendulum, a beam and a cable without connection: three parts, each computed as if it were alone."""
    beam, cable = f"FlexibleBeam beam({STEEL}, modes = 3);", f'FlexibleBeam cable({SOFT}, formulation = "ancf");'
    rest = {
        "rod": "Rod rod(m = 1 kg, length = 1 m); Revolute R(world, rod.a);",
        "beam": f"{beam} Revolute B(world, beam.a);",
        "cable": f"{cable} Revolute C(world, cable.a);",
    }

    def scene(*names):
        text = " ".join(rest[name] for name in names)
        start = " ".join(f"{name}.phi = 4*pi;" for name in names)
        return parse_text(f"model Test Ground world; {text} initial equation {start} end Test;")

    whole = run(scene(*rest))
    assert whole.stats["solved"]["parts"] == 3
    for name in rest:
        own = run(scene(name))
        for key in ("b.x", "b.vy", "phi", "b.phi"):
            assert np.array_equal(whole[f"{name}.{key}"], own[f"{name}.{key}"]), (name, key)
        assert own[f"{name}.phi"][0] == pytest.approx(4 * np.pi, rel=1e-15)


def test_a_driven_hub_carries_a_beam():
    """Steady rotation: the end moves by tan(kL)/k - L, k^2 = rho A w^2/EA, and the clamp pulls with EA u'(0)."""
    w, EA = 100.0, 2e7
    t = run(
        model(
            f'{STEEL}, reference = "clamped-free", elements = 4, beta = 1e-4 s',
            f"Body hub(m = 1 kg, I = 1 kg.m2); Revolute axis(world, hub.c); Fixed clamp(hub.c, beam.a);"
            f"RotationalDriver drive(axis, phi = {w}*time);",
            "guess beam.phi = 0;",
            ground="Ground world(g = 0);",
        ),
        stop=0.05,
        step=1e-5,
    )
    k = np.sqrt(w**2 / EA)
    reach = np.hypot(t["beam.b.x"], t["beam.b.y"])[-1] - 1.0
    assert reach == pytest.approx(np.tan(k) / k - 1.0, rel=1e-3)


def test_the_receipt_tells_of_flexibility():
    crank = "Rod crank(m = 1 kg, length = 0.3 m); Revolute O(world, crank.a); Revolute A(crank.b, beam.a);"

    def entries(beam):
        r = mbdsl.explain(model(beam, crank), measured=False)
        return {e.effect: e for e in r.entries}, "\n".join(r.hoisted)

    found, hoisted = entries(f"{STEEL}, modes = 3")
    assert found["flexibility"].present and found["flexibility"].unknowns == 3
    assert found["mass matrix"].present and "depends on coordinates" in found["mass matrix"].why
    assert "integrals" in hoisted
    found, hoisted = entries(f'{STEEL}, formulation = "ancf", elements = 2')
    assert found["flexibility"].unknowns == 9
    assert "constant, but not diagonal" in found["mass matrix"].why
    assert "factorised once" in hoisted
    found, _ = entries(f"{STEEL}, modes = 0")
    assert not found["flexibility"].present and not found["mass matrix"].present


def test_what_bends_too_far_is_seen_between_outputs_by_steps_and_at_rest():
    soft = model(f'{SOFT}, modes = 4, reference = "clamped-free"', "Fixed clamp(world, beam.a);")
    with pytest.raises(IntegrationError, match="beam bends by"):
        mbdsl.simulate(soft, stop=1.6, step=1e-3, interval=1.6)
    steps = mbdsl.Simulation(soft, step=1e-3)
    with pytest.raises(IntegrationError, match="beam bends by"):
        steps.step(500)
    assert 0.05 < steps.time < 0.5
    with pytest.raises(mbdsl.errors.EquilibriumError, match="beam bends by") as caught:
        mbdsl.static(soft)
    assert caught.value.span is not None


def test_a_beam_that_cannot_shorten_is_told_so():
    """Pinned at both ends, it becomes shorter when it bends, and needs a mode that stretches."""
    pins = "Revolute pin(world, beam.a); Frame wall(world, r = {1 m, 0}); Revolute other(wall, beam.b);"
    with pytest.raises(IntegrationError) as caught:
        run(model(f"{STEEL}, modes = 4", pins))
    assert caught.value.hint.startswith("beam may have no axial mode")
    t = run(model(f"{STEEL}, modes = 4, axial = 1", pins))
    assert -2e-3 < t["beam.y"].min() < 0.0  # 5/384 m g L^3/EI is 0.6 mm, and twice that when let go
