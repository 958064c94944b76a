"""Displays of objects in a notebook: short texts, and tables whose numbers are those of the objects."""

import numpy as np
import pytest

import mbdsl
from mbdsl.mechanism.graph import build as graph_of
from mbdsl.plotting.figures import Page, TextTable
from mbdsl.plotting.html_tables import LIMIT, table
from mbdsl.simulation.trajectory import Trajectory
from mbdsl.studies.effects import EffectsStudy, Without
from mbdsl.studies.report import Study
from mbdsl.studies.verify import Agreement, Verification
from mbdsl.system.system import build

EVIL = "</td></pre><script>alert(1)</script><b>&amp;"
PENDULUM = f"""model Pendulum "{EVIL}"
  parameter Length L = 1.5 m "{EVIL}";
  input Real u(unit = "N.m") "a torque";
  Real twice = 2*rod.phi;
  Ground ground;
  Rod rod(m = 2 kg, length = L) "{EVIL}";
  Revolute pin(ground, rod.a);
initial equation
  pin.phi = -90 deg;
  guess pin.w = 0.5 rad/s;
  annotation(experiment(StopTime = 3 s));
end Pendulum;
"""


@pytest.fixture(scope="module")
def scene():
    return mbdsl.parse(PENDULUM)


@pytest.fixture(scope="module")
def swing(scene):
    """The pendulum with phi = 0.5 cos t about the vertical, given and not computed."""
    t = np.linspace(0.0, 2 * np.pi, 401)
    phi = 0.5 * np.cos(t) - np.pi / 2
    q = np.column_stack([0.75 * np.cos(phi), 0.75 * np.sin(phi), phi])
    stats = {"status": "done", "method": "hht-si2", "steps": 1234, "warnings": [EVIL]}
    return Trajectory(build(scene), t, q, np.gradient(q, t, axis=0), None, stats, inputs={"u": 0 * t})


def by_name(rows):
    return {row[0]: row[1:] for row in rows[1:]}


def test_a_scene(scene, read):
    shown = read(scene._repr_html_())
    components, parameters, inputs, variables, initial = shown.tables
    assert by_name(components)["rod"] == ["Rod", "", "m = 2 kg, length = 1.5 m, I = 0.375", EVIL]
    assert by_name(components)["pin"] == ["Revolute", "ground.c, rod.a", "", ""]
    assert by_name(parameters) == {"L": ["1.5", "m", EVIL]}
    assert by_name(inputs) == {"u": ["0", "N.m", "a torque"]}
    assert "twice" in by_name(variables)
    assert by_name(initial) == {"pin.phi": ["-1.5708", "rad", "fixed"], "pin.w": ["0.5", "rad/s", "guess"]}
    assert "1 body, 1 joint" in shown.texts and "experiment: start = 0, stop = 3" in shown.texts


def test_a_trajectory(swing, read):
    shown = read(swing._repr_html_())
    rows = by_name(shown.tables[0])
    assert list(rows) == swing.default_names
    assert rows["rod.phi"] == ["rad", *(f"{x - np.pi / 2:.6g}" for x in (0.5, 0.5, -0.5, 0.5))]
    for name, (unit, *numbers) in rows.items():
        x = swing[name]
        np.testing.assert_allclose([float(n) for n in numbers], [x[0], x[-1], x.min(), x.max()], rtol=1e-5, atol=1e-12)
        assert unit == swing.unit(name)
    assert "hht-si2, 1234 steps" in shown.texts and f"warning: {EVIL}" in shown.texts


def test_a_trajectory_without_values(scene, read):
    nothing = np.zeros((0, 3))
    assert read(Trajectory(build(scene), np.zeros(0), nothing, nothing, None, {"status": "failed"})._repr_html_())
    nans = np.full((1, 3), np.nan)
    shown = read(Trajectory(build(scene), np.zeros(1), nans, nans, None, {"status": "failed"})._repr_html_())
    assert by_name(shown.tables[0])["rod.phi"] == ["rad", "nan", "nan", "nan", "nan"]


def test_signals(swing, read):
    signals = swing.signals
    assert list(signals) == swing.names and len(signals) == len(swing.names)
    assert {name: info.unit for name, info in signals.items()} == {name: swing.unit(name) for name in swing.names}
    assert signals["rod.phi"] == ("rad", "angle, counting turns") and signals["pin.fx"].doc == "force along x"
    assert signals["u"].doc == "a torque" and signals["energy.total"] == ("J", "total energy")
    assert [name for name, info in signals.items() if not info.doc] == []
    rows = by_name(read(signals._repr_html_()).tables[0])
    assert rows == {name: list(info) for name, info in signals.items()}


def test_signals_are_a_mapping(swing):
    signals = swing.signals
    assert "rod.x" in signals and "rod.z" not in signals and signals.get("rod.z", 3) == 3
    chosen = signals.select("rod.v?")
    assert list(chosen) == ["rod.vx", "rod.vy"]
    assert str(chosen).splitlines() == [
        "signal  unit  meaning",
        "rod.vx  m/s   velocity along x",
        "rod.vy  m/s   velocity along y",
    ]
    for wrong in (lambda: signals["rod.z"], lambda: signals.select(["rod.z*"])):
        with pytest.raises(mbdsl.UsageError, match="there is no signal"):
            wrong()


@pytest.mark.parametrize("name", ["flexible_pendulum", "stick_slip_belt", "rolling_disc", "driven_crank"])
def test_every_signal_has_a_meaning(name, model_folder):
    nothing = np.zeros((0, 0))
    scene = mbdsl.load(model_folder / f"{name}.mbd")
    signals = Trajectory(build(scene), np.zeros(0), nothing, nothing, None, {"status": "done"}).signals
    assert len(signals) > 30 and [name for name, info in signals.items() if not info.doc] == []


def test_modes_and_an_equilibrium(scene, read):
    """A rod that hangs on its end: omega^2 = 3 g/(2 L), and the pin holds its weight m g."""
    modes, still = mbdsl.eigen(scene), mbdsl.static(scene)
    (row,) = by_name(read(modes._repr_html_()).tables[0]).values()
    frequency = np.sqrt(3 * 9.81 / (2 * 1.5)) / (2 * np.pi)
    assert [float(row[0]), float(row[1]), row[3]] == [pytest.approx(frequency, rel=1e-5)] * 2 + ["rod 100%"]
    values = by_name(read(still._repr_html_()).tables[0])
    assert float(values["pin.fy"][0]) == pytest.approx(2 * 9.81, rel=1e-5) and values["pin.fy"][1] == "N"
    assert values["rod.y"] == ["-0.75", "m"] and values["rod.x"][0] == "0"


def test_a_system_and_a_graph(swing, read):
    rows = by_name(read(swing.system._repr_html_()).tables[0])
    assert rows == {"q[0:3]": ["rod", "x, y, phi"], "Phi[0:2]": ["pin", "Revolute"]}
    shown = read(graph_of(swing.scene)._repr_html_())
    assert shown.tables[0][1] == ["rod", "Rod", "x, y, phi"]
    assert shown.tables[1][1] == ["pin", "Revolute", "ground.c, rod.a", "2"]
    assert "mobility 1 = 3 coordinates - 2 constraint rows (Gruebler count)" in shown.texts


def test_a_receipt(scene, read):
    receipt = mbdsl.explain(scene, measured=False, signals=["pin.fx"])
    effects, code, before, outputs = read(receipt._repr_html_()).tables
    assert [row[0] for row in effects[1:]] == [entry.effect for entry in receipt.entries]
    assert by_name(effects)["bodies"][-1] == "3 of 5" and by_name(effects)["gravity"][0] == "yes"
    assert by_name(code)["gravity"] == ["a constant vector"]
    assert outputs[1][0] == "pin.fx"
    # each cell is in the text of `mbdsl explain`
    assert all(cell in str(receipt) for rows in (effects, code, before) for row in rows[1:] for cell in row)


def test_a_builder(read):
    b = mbdsl.Builder(f"A{EVIL}", EVIL)
    ground = b.Ground("ground")
    b.parameter("k", "2 N/mm", doc=EVIL)
    rod = b.Rod("rod[1]", m="2 kg", length=0.5, doc="a rod")
    b.Force("push", ground, rod.b, fx=b.scene().signal("rod[1].phi"))
    with pytest.raises(mbdsl.ModelError):
        b.Rod("bad", mass=1)
    shown = read(b._repr_html_())
    rows = by_name(shown.tables[0])
    assert list(rows) == ["ground", "k", "rod[1]", "push"]
    assert rows["rod[1]"] == ["Rod", "m = 2 kg, length = 0.5", "a rod"] and rows["k"][1:] == ["= 2 N/mm", EVIL]
    assert rows["push"][1].startswith("ground, rod[1].b, fx = ")
    assert "script" not in shown.tags and repr(b).startswith("<Builder of A") and "4 declarations" in repr(b)


def test_studies(scene, read):
    seen = Verification("radau5", None, 1e-8, (Agreement("pin.phi", "rad", 6.25, 1e-7),))
    assert read(seen._repr_html_()).tables[0][1][:2] == ["pin.phi", "6.2"]
    late = Verification("radau5", 1e-3, None, problem="late")
    assert "".join(read(late._repr_html_()).texts) == str(late)
    rows = (Without(("gravity",), 0.5, 1.25),)
    study = EffectsStudy(scene, "pin.phi", "rad", -1.0, 1.0, 1e-6, 0.01, rows, ("friction",))
    assert read(study._repr_html_()).texts == [str(study)]
    assert repr(study) == "<EffectsStudy of pin.phi in Pendulum: gravity>" and "6.2 digits" in repr(seen)

    class Made(Study):
        def page(self):
            return Page(EVIL, ["said"], [TextTable("", ("a",), [("1",)])])

    shown = read(Made.__new__(Made)._repr_html_())
    assert shown.tags == {"iframe"}


def test_texts_are_short_and_markup_is_text(swing, scene, read, model_folder):
    chain = mbdsl.load(model_folder / "chain.mbd", {"N": 64})
    many = Trajectory(build(chain), np.zeros(1), *np.zeros((2, 1, 192)), None, {"status": "done"})
    things = [
        scene,
        chain,
        many,
        many.system,
        many.signals,
        swing,
        swing.signals,
        swing.system,
        graph_of(scene),
        swing.plot("rod.phi"),
    ]
    things += [mbdsl.explain(scene, measured=False), mbdsl.eigen(scene), mbdsl.static(scene)]
    for thing in things:
        text = repr(thing)
        assert len(text) < 150 and "\n" not in text and text[0] + text[-1] == "<>", text
        assert "script" not in read(thing._repr_html_()).tags


def test_long_tables_are_cut():
    shown = table(TextTable("", ("n",), [(str(k),) for k in range(LIMIT + 5)]))
    assert shown.count("<tr>") == 1 + LIMIT and f"{LIMIT} of {LIMIT + 5} rows" in shown and "overflow: auto" in shown


def test_columns_of_numbers_are_on_the_right(read):
    rows = [("a", "1", "", "x"), ("b", "-2.5e-3", "", "3"), ("c", "", "", "")]
    shown = table(TextTable("title", ("name", "value", "empty", "mixed"), rows, "note"))
    assert read(shown).tables == [[["name", "value", "mixed"], ["a", "1", "x"], ["b", "-2.5e-3", "3"], ["c", "", ""]]]
    assert shown.count("text-align:right") == 4 and shown.count("text-align:left") == 8
