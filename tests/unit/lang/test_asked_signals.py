"""Sizes of vectors and expressions of signals: against closed forms of a pendulum, in every place that takes a name."""

from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import cli, results
from mbdsl.errors import UsageError
from mbdsl.lang.asked_signals import AskedSignals

MODELS = Path(__file__).parents[3] / "models"
G, L, M = 9.81, 0.7, 2.0
PLANE = f"""model Pendulum "released at rest from the horizontal"
  parameter Mass m = {M} kg; parameter Length L = {L} m;
  Ground ground; PointMass mass(m = m); Distance rod(ground, mass, length = L); Real c = 1.5;
initial equation mass.x = L; mass.y = 0 m;
annotation(experiment(StopTime = 0.6 s, Interval = 1 ms, Tolerance = 1e-9)); end Pendulum;"""
SPACE = PLANE.replace("model Pendulum", "spatial model Pendulum", 1)
SPACE = SPACE.replace("mass.y = 0 m;", "mass.y = 0 m; mass.z = 0 m;")


@pytest.fixture(scope="module", params=["plane", "space"])
def run(request):
    return mbdsl.simulate(mbdsl.parse(PLANE if request.param == "plane" else SPACE), method="radau5")


@pytest.fixture(scope="module")
def height(run):
    """The height below the pivot, from which energy and Newton's law give all sizes."""
    return -run["mass.y"]


def test_sizes_of_vectors(run, height):
    """v^2 = 2 g h; tension m g h/L + m v^2/L; accelerations v^2/L to the pivot and g x/L along the path."""
    np.testing.assert_allclose(run["mass.v"] ** 2, 2.0 * G * height, atol=1e-7)
    np.testing.assert_allclose(run["mass.c.v"], run["mass.v"], atol=1e-12)
    np.testing.assert_allclose(run["rod.f"], 3.0 * M * G * np.abs(height) / L, atol=1e-6)
    expected = np.hypot(2.0 * G * height / L, G * run["mass.x"] / L)
    np.testing.assert_allclose(run["mass.a"], expected, atol=1e-6)
    assert [run.unit(name) for name in ("mass.v", "rod.f", "mass.a")] == ["m/s", "N", "m/s2"]
    assert {"mass.v", "rod.f", "mass.a", "mass.c.v"} <= set(run.names)
    assert [run.signals[name].doc for name in ("rod.f", "mass.a")] == [
        "size of the force",
        "size of the acceleration",
    ]


def test_no_size_hides_a_signal_and_one_component_has_none():
    """A sliding joint has its own v; the torque of a hinge in the plane is one number, in space a vector."""
    crank = AskedSignals(mbdsl.load(MODELS / "slider_crank.mbd"))
    assert crank.scene.components["B"].kind.unit_of("v") == "m/s" and "B.f" in crank
    assert crank.entry("B.v")[0] is crank.scene.signal("B.v")
    assert "O.t" not in crank
    bicycle = AskedSignals(mbdsl.load(MODELS / "space" / "bicycle.mbd"))
    assert bicycle.unit("steer.t") == "N.m" and bicycle.unit("rear.v") == "m/s"


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [
        ("hypot(mass.vx, mass.vy)", lambda r: np.hypot(r["mass.vx"], r["mass.vy"]), "m/s"),
        ("0.5*m*mass.v^2 - energy.kinetic", lambda r: 0.0 * r.t, "J"),
        ("rod.f*mass.v", lambda r: r["rod.f"] * r["mass.v"], "W"),
        ("mass.a/(9.81 m/s2)", lambda r: r["mass.a"] / G, ""),
        ("der(mass.x) - mass.vx", lambda r: 0.0 * r.t, "m/s"),
        ("mass.m*mass.ax + rod.fx", lambda r: M * r["mass.ax"] + r["rod.fx"], "N"),
        ("mass.x/rod.length", lambda r: r["mass.x"] / L, ""),
        ("atan2(mass.y, mass.x)", lambda r: np.arctan2(r["mass.y"], r["mass.x"]), ""),
        ("if mass.x > 0.3 m then mass.x else 0.3 m", lambda r: np.maximum(r["mass.x"], 0.3), "m"),
        ("mass.vx*time", lambda r: r["mass.vx"] * r.t, "m"),
        ("2*pi*mass.x", lambda r: 2.0 * np.pi * r["mass.x"], "m"),
        ("-mass.x", lambda r: -r["mass.x"], "m"),
        ("c*mass.x", lambda r: 1.5 * r["mass.x"], None),
    ],
)
def test_expressions(run, text, value, unit):
    np.testing.assert_allclose(run[text], value(run), atol=1e-9)
    assert unit is None or run.unit(text) == unit
    assert text in run and text not in run.names


def test_angles_keep_their_unit():
    names = AskedSignals(mbdsl.load(MODELS / "slider_crank.mbd"))
    units = {x: names.unit(x) for x in ("O.phi - 2*A.phi", "-O.phi/3", "sin(O.phi)", "O.phi*A.phi", "O.w/2")}
    assert [*units.values()] == ["rad", "rad", "", "", "rad/s"]


def test_selections_and_parts(run):
    text = "hypot(mass.vx, mass.vy)"
    chosen = run[[text, "rod.f?"]]
    assert list(chosen)[:2] == [text, "rod.fx"]
    np.testing.assert_array_equal(run[0.2:0.4][text], run[text][200:401])
    assert chosen.signals[text].unit == "m/s"
    short = mbdsl.simulate(run.scene, stop=0.1, step=1e-3, signals=[text])
    assert short.names == ["time", text]
    assert not short.is_at_hand("mass.m*mass.a") and short.is_at_hand("2*mass.v")


@pytest.mark.parametrize("suffix", ["csv", "npz", "mat", "nc"])
def test_files(run, suffix, tmp_path, capsys):
    """Written, read back, and computed from the columns of a file; "/" is no letter of names in netCDF."""
    texts = ["hypot(mass.vx, mass.vy)", "mass.x/rod.length", "-mass.x"]
    path = tmp_path / f"run.{suffix}"
    words = [str(path), "--signals", "rod.f - 2*abs(rod.fx), mass.x*(1 N/m) + rod.fx"]
    run.save(path, [*texts, "rod.f", "rod.fx", "mass.x"])
    columns, _ = results.read(path)
    for text in texts:
        name = f"'{text}" if suffix == "csv" and text[0] == "-" else text
        np.testing.assert_array_equal(columns[name], run[text])
    (panel,) = mbdsl.plot(path, "rod.f - 2*abs(rod.fx)").panels
    np.testing.assert_allclose(panel.series[0].y, run["rod.f"] - 2.0 * np.abs(run["rod.fx"]), atol=1e-12)
    assert cli.main(["plot", *words]) == 0
    assert "mass.x*(1 N/m) + rod.fx" in capsys.readouterr().out
    assert cli.main(["info", str(path), "--signals", "abs(rod.fx)"]) == 0
    assert f"{np.abs(run['rod.fx']).max():.4g}" in capsys.readouterr().out
    some = str(tmp_path / "some.npz")
    assert cli.main(["convert", str(path), "--out", some, "--signals", "hypot(rod.fx, rod.f), mass.x"]) == 0
    columns, _ = results.read(some)
    np.testing.assert_allclose(columns["hypot(rod.fx, rod.f)"], np.hypot(run["rod.fx"], run["rod.f"]), rtol=1e-14)


def test_stepping_and_linear_models():
    """About a state at rest, hypot(fx, fy) of the load changes by g times the mass that an input adds."""
    text = """model Cart input Force u; Ground ground(g = 0); Body cart(m = 2 kg, I = 1 kg.m2);
        Prismatic rail(ground, cart.c); TranslationalSpringDamper s(rail, k = 50 N/m, c = 4 N.s/m);
        Force push(cart.c, fx = u); initial equation rail.s = 3 m; rail.v = 4 m/s;
        annotation(experiment(StopTime = 1 s)); end Cart;"""
    found = mbdsl.linearise(mbdsl.parse(text), "start", signals=["rail.s^2", "cart.v", "50*rail.s - cart.x"])
    np.testing.assert_allclose(found.C, [[6.0, 0.0], [0.0, 1.0], [49.0, 0.0]], atol=1e-9)
    np.testing.assert_allclose(found.y0, [9.0, 4.0, 147.0])
    assert found.output_units == ["m2", "m/s", "m"]
    sim = mbdsl.Simulation(mbdsl.parse(text), step=1e-3)
    sim.step(5)
    assert sim["2*cart.v"] == pytest.approx(2.0 * abs(sim["cart.vx"]), rel=1e-12)
    assert sim["cart.m*cart.ax"] == pytest.approx(2.0 * sim["cart.ax"], rel=1e-12)
    with pytest.raises(UsageError, match="cannot be an output"):
        mbdsl.linearise(mbdsl.parse(text), "start", signals=["2*cart.ax"])


@pytest.mark.parametrize(
    ("text", "says", "hint"),
    [
        ("hypot(rod.fx, rod.fq)", "no signal `rod.fq` in Pendulum", "rod.f"),
        ("rod.fx + mass.vx", "a force [N] and a velocity [m/s]", ""),
        ("hypot(rod.fx, rod.fy", "`)` is missing", ""),
        ("{rod.fx, rod.fy}", "an array of 2", "one by one"),
        ("(2*3)", "contains no signal", ""),
        ("hypott(rod.fx, rod.fy)", "no function is called `hypott`", "hypot"),
        ("der(rod.fx)", "der", ""),
        ("rod.fz", "no signal `rod.fz`", ""),
        ("nothing.*", "no signal `nothing.*`", ""),
        ("sum({i*mass.x for i in 1:3})", "no loops", ""),
    ],
)
def test_what_is_wrong(text, says, hint):
    scene = mbdsl.parse(PLANE)
    with pytest.raises(UsageError) as caught:
        mbdsl.simulate(scene, signals=text)
    assert says in caught.value.message and hint in (caught.value.hint or "")
    assert text not in AskedSignals(scene)


@pytest.mark.parametrize(
    ("law", "remedy"),
    [
        ("rod.f", "write `hypot(rod.fx, rod.fy)`"),
        ("mass.v", "write `hypot(mass.vx, mass.vy)`"),
        ("mass.c.v", "write `hypot(mass.c.vx, mass.c.vy)`"),
    ],
)
def test_sizes_in_laws_have_a_remedy(law, remedy):
    with pytest.raises(mbdsl.ModelError, match=f"`{law}` is a result of the simulation") as caught:
        mbdsl.parse(PLANE.replace("Real c = 1.5;", f"Real c = {law};"))
    assert remedy in caught.value.hint
    mbdsl.parse(PLANE.replace("Real c = 1.5;", f"Real c = {remedy.split('`')[1]};"))  # and it is one
    with pytest.raises(mbdsl.ModelError) as caught:
        mbdsl.parse(SPACE.replace("Real c = 1.5;", "Real c = rod.f;"))
    assert caught.value.hint == "write `sqrt(rod.fx^2 + rod.fy^2 + rod.fz^2)`"


def test_a_result_says_how_reactions_get_into_it(tmp_path, capsys):
    run = mbdsl.simulate(mbdsl.parse(PLANE), stop=0.1, step=1e-3)
    run.save(path := tmp_path / "run.csv")
    for text in ("rod.fx", "rod.f*"):
        with pytest.raises(UsageError) as caught:
            mbdsl.plot(path, text)
        assert f"`mbdsl simulate MODEL --signals {text if text == 'rod.fx' else repr(text)} --output FILE`" in (
            caught.value.hint
        )
    with pytest.raises(UsageError, match=r"`hypot\(rod.fx, rod.fy\)`: there is no signal `rod.fx` in .*run.csv"):
        mbdsl.plot(path, "hypot(rod.fx, rod.fy)")
    with pytest.raises(UsageError) as caught:  # nothing is missing in a run
        run.plot("rod.fq")
    assert "--output" not in caught.value.hint
