"""Static equilibria compared with closed forms, from distant starts and from saddles; models without equilibrium; the
command."""

import json
from pathlib import Path

import numpy as np
import pytest

import mbdsl
from mbdsl import cli, results
from mbdsl.analysis.equilibria import static
from mbdsl.errors import EquilibriumError, InitialisationError, UsageError
from mbdsl.system import system as system_module

G = 9.81
MODELS = Path(__file__).parents[3] / "models"
PENDULUM = """model P Ground ground; Rod rod(m = 2 kg, length = 1 m); Revolute pin(ground, rod.a);{more}
initial equation pin.phi = {phi} deg; end P;"""
#: a chain of N links between two walls, whose distance is 0.6 of its length
CHAIN = """model C Ground ground(frames(wall = {{{span} m, 0 m, 0}}));
Rod link[{N}](each m = 1 kg, each length = 0.5 m); Revolute J[1](ground, link[1].a);
for i in 2:{N} loop Revolute J[i](link[i - 1].b, link[i].a); end for; Revolute E(link[{N}].b, ground.wall);
initial equation for i in 1:{N} loop guess link[i].phi = if i <= {half} then 50 deg else -50 deg; end for; end C;"""
ROW = """model C Ground ground; Rod link[{N}](each m = 1 kg, each length = 1 m); Revolute J[1](ground, link[1].a);
for i in 2:{N} loop Revolute J[i](link[i - 1].b, link[i].a); end for;
initial equation for i in 1:{N} loop link[i].phi = {phi} deg; end for; end C;"""


def found(text):
    return static(mbdsl.parse(text))


def check_balance(e):
    """Forces and constraints, evaluated again."""
    system = e.system
    f, Phi, _ = system.evaluate(e.t, e.q, np.zeros(system.n), e.lam)
    size = np.abs(system.velocity_jacobian(e.t, e.q, np.zeros(system.n)).T @ e.lam).max(initial=1.0)
    assert np.abs(f).max() <= 1e-11 * size
    assert np.abs(Phi).max(initial=0.0) <= 1e-12 * (1.0 + np.abs(e.q).max())


# -- pendulums -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("phi", [-170.0, -90.0, -30.0, 0.0, 60.0, 89.999999, 90.0, 179.0])
def test_a_pendulum_hangs(phi):
    e = found(PENDULUM.format(phi=phi, more=""))
    check_balance(e)
    assert np.sin(e["rod.phi"]) == pytest.approx(-1.0, abs=1e-14)
    assert (e["pin.fx"], e["pin.fy"]) == pytest.approx((0.0, 2.0 * G), abs=1e-12)
    assert e.stability == "stable" and e.stable
    # off an unstable one, an implicit step at most doubles the distance: 24 times from 1e-6 deg to 0.3 rad, then
    # Newton's
    assert e.iterations <= 40
    assert ("unstable" in " ".join(e.notes)) == (phi == 90.0)
    assert e["energy.kinetic"] == e["rod.alpha"] == e["rod.w"] == 0.0


@pytest.mark.parametrize("torque", [0.1, 5.0, 9.0, 9.8])
def test_a_torque_lifts_it(torque):
    """cos(phi) = tau/(m g l)."""
    e = found(PENDULUM.format(phi=-90, more=f" Torque T(rod.c, tau = {torque} N.m);"))
    assert e["rod.phi"] == pytest.approx(-np.arccos(torque / G), abs=1e-10)


def test_a_torque_too_large_turns_it_for_ever():
    with pytest.raises(EquilibriumError, match="no equilibrium: rod keeps moving") as wrong:
        found(PENDULUM.format(phi=-90, more=" Torque T(rod.c, tau = 10 N.m);"))
    assert wrong.value.exit_code == 3
    assert wrong.value.span.line == 1


def test_many_turns():
    text = PENDULUM.format(phi=0, more=" Torque T(rod.c, tau = 700 N.m); RotationalSpringDamper s(pin, k = 1 N.m/rad);")
    assert found(text.replace("ground;", "ground(g = 0);", 1))["pin.phi"] == pytest.approx(700.0, rel=1e-12)


@pytest.mark.parametrize(("N", "phi"), [(2, 90), (5, 90), (8, 0), (8, 45), (90, 90)])
def test_rows_of_links_hang(N, phi):
    """For any number of saddles on the way; 90 links are solved sparsely. Rounding of N weights, each known to eps of
    the total, is N^2 eps of one weight."""
    e = found(ROW.format(N=N, phi=phi))
    rounding = max(1e-12, 10 * N**2 * np.finfo(float).eps)
    check_balance(e)
    assert e.stable
    assert e[f"link[{N}].b.y"] == pytest.approx(-N, rel=rounding)
    assert e["J[1].fy"] == pytest.approx(N * G, rel=rounding)


@pytest.mark.parametrize("N", [20, 100])
def test_a_hanging_chain(N):
    """By symmetry, each end carries half the weight; the horizontal force follows from the statics of each link."""
    e = found(CHAIN.format(N=N, half=N // 2, span=0.3 * N))
    check_balance(e)
    assert e.stable
    assert (e["J[1].fy"], -e["E.fy"]) == pytest.approx((N * G / 2, N * G / 2), rel=1e-11)
    y = np.array([e[f"link[{i}].y"] for i in range(1, N + 1)])
    assert y == pytest.approx(y[::-1], abs=1e-11)
    assert y.max() < 0.0
    # each link is along the force through its middle: tan(phi) = (weight above its middle)/H
    V = G * (np.arange(N) + 0.5) - N * G / 2
    phi = np.array([e[f"link[{i}].phi"] for i in range(1, N + 1)])
    assert np.tan(phi) == pytest.approx(V / -e["J[1].fx"], rel=1e-9)
    assert 0.5 * np.cos(phi).sum() == pytest.approx(0.3 * N, rel=1e-12)


def test_the_sparse_way_is_the_dense_one(monkeypatch):
    text = CHAIN.format(N=90, half=45, span=27)
    sparse = found(text)
    for name in ("mbdsl.system.system", "mbdsl.statics.pseudo_transient", "mbdsl.system.signals"):
        monkeypatch.setattr(f"{name}.DENSE_LIMIT", 10_000)
    full = found(text)
    assert system_module.DENSE_LIMIT == 10_000
    turn = np.array([name.endswith(".phi") for name in full.system.names()])
    assert sparse.q[~turn] == pytest.approx(full.q[~turn], abs=1e-9)
    assert np.cos(sparse.q - full.q)[turn] == pytest.approx(1.0)  # links may have turned over on the way
    assert sparse.lam == pytest.approx(full.lam, abs=1e-8)
    assert sparse.stability == full.stability == "stable"
    assert sparse.stiffness == pytest.approx(full.stiffness, rel=1e-6)


def test_a_large_inverted_row_is_seen_to_be_unstable():
    """At the top of 90 links, and where all but the last hang."""
    e = found(ROW.format(N=90, phi=90))
    assert e.notes[0].startswith("the start is an unstable equilibrium")
    text = ROW.format(N=90, phi=-90).replace("end C;", "link[90].w = 0 rad/s; end C;")
    last = text.replace("link[i].phi = -90 deg", "link[i].phi = if i < 90 then -90 deg else 90 deg")
    e = found(last)
    assert e.notes[0].startswith("the start is an unstable equilibrium")
    assert e["link[90].b.y"] == pytest.approx(-90.0)


# -- springs -----------------------------------------------------------------------------------------------------------


def test_a_mass_on_a_spring():
    e = static(MODELS / "spring_mass.mbd")
    assert e["slide.s"] == pytest.approx(0.5 + 2 * G / 200, rel=1e-14)
    assert e["spring.force"] == pytest.approx(2 * G, rel=1e-13)
    assert static(MODELS / "spring_mass.mbd", parameters={"g": 0.0})["slide.s"] == pytest.approx(0.5, rel=1e-14)
    assert static(MODELS / "spring_mass.mbd", without=["gravity"])["slide.s"] == pytest.approx(0.5, rel=1e-14)


def test_soft_and_stiff_together():
    """A mass of a tonne on a spring of 1 N/m falls ten kilometres; the support of the spring yields by 10 um."""
    e = found("""model S Ground ground; Body a(m = 1 kg, I = 1 kg.m2); Body b(m = 1000 kg, I = 1 kg.m2);
        Prismatic s(ground, a.c); RotationalSpringDamper r(ground, b.c, k = 1 N.m/rad);
        SpringDamper stiff(ground, a.c, k = 1e9 N/m, s0 = 1 m); SpringDamper soft(a.c, b.c, k = 1 N/m, s0 = 1 m);
        initial equation a.x = 1 m; b.x = 1.1 m; b.y = -0.5 m; end S;""")
    check_balance(e)
    assert e["soft.s"] == pytest.approx(1.0 + 1000 * G, rel=1e-12)
    assert e.stable


@pytest.mark.parametrize("load", [1.0, 5.0, 8.0])
def test_a_truss_that_softens(load):
    """Two springs between walls, pushed down at their joint: 2 k (s - s0) y/s = F, before and after the
    snap-through."""
    e = found(f"""model T Ground ground(g = 0, frames(l = {{-1 m, 0 m, 0}}, r = {{1 m, 0 m, 0}}));
        PointMass m(m = 1 kg); SpringDamper a(ground.l, m, k = 100 N/m, s0 = 1.2 m);
        SpringDamper b(ground.r, m, k = 100 N/m, s0 = 1.2 m); Force f(m, fy = -{load} N);
        initial equation guess m.x = 0.05 m; guess m.y = 0.7 m; end T;""")
    check_balance(e)
    y, s = e["m.y"], np.hypot(1.0, e["m.y"])
    assert e["m.x"] == pytest.approx(0.0, abs=1e-12)
    assert -2.0 * 100.0 * (s - 1.2) * y / s == pytest.approx(load, rel=1e-10)
    # the largest force is 2 k (s0^(2/3) - 1)^(3/2), as for a von Mises truss
    assert (y > 0.0) == (load < 200.0 * (1.2 ** (2 / 3) - 1.0) ** 1.5)
    assert e.stable


def test_from_the_ridge_it_falls_to_a_side():
    e = found("""model T Ground ground(g = 0, frames(l = {-1 m, 0 m, 0}, r = {1 m, 0 m, 0})); PointMass m(m = 1 kg);
        SpringDamper a(ground.l, m, k = 100 N/m, s0 = 1.2 m); SpringDamper b(ground.r, m, k = 100 N/m, s0 = 1.2 m);
        end T;""")
    assert abs(e["m.y"]) == pytest.approx(np.sqrt(0.44), rel=1e-12)
    assert e.notes[0].startswith("the start is an unstable equilibrium")


def test_springs_that_balance_each_other():
    """The residual of 1 kN against 1 kN is only rounding."""
    e = found("""model T Ground ground(g = 0, frames(l = {-1 m, 0 m, 0}, r = {1 m, 0 m, 0})); PointMass m(m = 1 kg);
        SpringDamper a(ground.l, m, k = 1234.5 N/m, s0 = 0.1 m);
        SpringDamper b(ground.r, m, k = 1234.5 N/m, s0 = 0.1 m);
        initial equation m.x = 0.2 m; m.y = 0.3 m; end T;""")
    assert (e["m.x"], e["m.y"]) == pytest.approx((0.0, 0.0), abs=1e-13)


def test_forces_that_depend_on_reactions():
    """k phi + m g l cos(phi)/2 = tau = r fy with fy = m g."""
    e = found("""model R Ground ground; Rod a(m = 1 kg, length = 1 m); Revolute A(ground, a.a);
        RotationalSpringDamper s(A, k = 5 N.m/rad); Torque T(a.c, tau = 0.1 m*A.fy); end R;""")
    check_balance(e)
    phi = e["A.phi"]
    assert 5.0 * phi + G / 2 * np.cos(phi) == pytest.approx(0.1 * G, rel=1e-10)


def test_friction_has_no_force_at_rest():
    e = found(PENDULUM.format(phi=0, more="").replace("rod.a)", "rod.a, mu = 0.5, radius = 1 cm)"))
    assert e["rod.y"] == pytest.approx(-0.5)


# -- constraints -------------------------------------------------------------------------------------------------------

PARALLEL = """model R Ground ground(frames(b = {1 m, 0 m, 0}, w = {2 m, 0 m, 0}));
Rod r[3](each m = 1 kg, each length = 1 m); Rod t(m = 3 kg, length = 2 m);
Revolute A(ground, r[1].a); Revolute B(ground.b, r[2].a); Revolute C(ground.w, r[3].a);
Revolute D(r[1].b, t.a); Revolute E(r[2].b, t.c); Revolute F(r[3].b, t.b);
initial equation for i in 1:3 loop guess r[i].phi = -30 deg; end for; end R;"""


def test_redundant_parallelogram():
    e = found(PARALLEL)
    check_balance(e)
    assert e.stable
    assert len(e.redundant) == 1 and "redundant" in e.notes[0]
    assert all(e.lam[e.system.constraint_names().index(name)] == 0.0 for name in e.redundant)
    assert e["A.fy"] + e["B.fy"] + e["C.fy"] == pytest.approx(6.0 * G)
    assert e["t.y"] == pytest.approx(-1.0)


def test_drivers_are_taken_at_rest():
    e = static(MODELS / "driven_crank.mbd")
    check_balance(e)
    assert e.stability == "held" and e.stable and e.stiffness is None
    assert e.notes == ["velocities set to zero at t = 0 s: drive"]
    assert e["drive.tau"] == pytest.approx(e.system.Q(0.0, e.q) @ _virtual(e.system, e.q, "crank.phi") * -1.0)
    later = static(MODELS / "driven_crank.mbd", start=0.25)
    assert later["crank.phi"] == pytest.approx(np.deg2rad(30) + np.pi / 2)


def _virtual(system, q, name):
    """dq for one unit of the crank's angle, without the driver's row."""
    J = system.Phi_q(0.0, q)
    row = np.zeros(system.n)
    row[system.names().index(name)] = 1.0
    J = np.vstack([J[[k for k, c in enumerate(system.constraint_names()) if not c.startswith("drive")]], row])
    return np.linalg.solve(J, np.eye(system.n)[-1])


def test_gears_hold():
    """a.w + 3 b.w = 0: the angles go together, and their moments balance through the ratio."""
    e = found("""model R Ground ground; Rod a(m = 1 kg, length = 1 m); Rod b(m = 1 kg, length = 0.5 m);
        Revolute A(ground, a.a); Revolute B(ground, b.a); VelocityConstraint c(gamma = a.w + 3*b.w); end R;""")
    check_balance(e)
    assert e["a.phi"] + 3.0 * e["b.phi"] == pytest.approx(0.0, abs=1e-12)
    assert 3.0 * e["a.x"] == pytest.approx(e["b.x"], rel=1e-10)
    assert e.notes == ["at rest, the reaction of the velocity constraint `c` carries part of the load"]


def test_rolling():
    e = static(MODELS / "rolling_disc.mbd")
    check_balance(e)
    assert e["contact.s"] == pytest.approx(0.3 + 2.0 * G / 2 / 50)
    assert e["disc.phi"] == pytest.approx(-2.0 * G / 2 / 50 / 0.1)  # it has rolled there


def test_what_nothing_acts_on_stays():
    e = found("""model W Ground ground; Body wheel(m = 2 kg, I = 1 kg.m2); Revolute pin(ground, wheel.c);
        Rod rod(m = 1 kg, length = 1 m); Revolute hook(wheel.c, rod.a); initial equation wheel.phi = 0.7 rad; end W;""")
    assert e.stability == "indifferent" and not e.stable
    assert e["wheel.phi"] == 0.7
    assert e["rod.y"] == pytest.approx(-0.5)
    assert e.notes == ["indifferent: nothing resists a motion of wheel, which stays where it starts"]
    afloat = found("model F Ground g(g = 0); Rod rod(m = 2 kg, length = 1 m); FreeMotion f(g, rod.c); end F;")
    assert (afloat.stability, afloat.iterations) == ("indifferent", 0)


# -- models without equilibrium
# -----------------------------------------------------------------------------------------------------


def test_what_falls():
    with pytest.raises(EquilibriumError, match="no equilibrium: stone keeps moving") as wrong:
        found("""model F Ground g; Rod rod(m = 2 kg, length = 1 m); Revolute p(g, rod.a);
            PointMass stone(m = 1 kg); FreeMotion f(g, stone); end F;""")
    assert wrong.value.span.line == 2


def test_forces_that_are_no_numbers():
    with pytest.raises(EquilibriumError, match="not finite"):
        found(PENDULUM.format(phi=-30, more=" Torque t(rod.c, tau = 1 N.m*sqrt(rod.phi));"))


def test_what_cannot_be_assembled():
    with pytest.raises(InitialisationError):
        found(PENDULUM.format(phi=0, more=" Distance d(ground, rod.b, length = 3 m);"))


def test_arguments():
    with pytest.raises(UsageError, match="not a finite number"):
        static(MODELS / "pendulum.mbd", start=np.inf)
    with pytest.raises(UsageError, match=r"no signal `rod\.z`"):
        found(PENDULUM.format(phi=0, more=""))["rod.z"]
    with pytest.raises(UsageError, match="a model is a path"):
        static(3)


# -- the command -------------------------------------------------------------------------------------------------------


@pytest.fixture
def say(capsys, tmp_path, monkeypatch):
    """Run a command in an empty folder: exit code, standard output, standard error without lines about compilation."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "p.mbd").write_text(PENDULUM.format(phi=90, more=""), encoding="utf-8")

    def run(*argv):
        code = cli.main([str(a) for a in argv])
        out, err = capsys.readouterr()
        return code, out, "".join(x for x in err.splitlines(True) if not x.startswith("compiling"))

    return run


def test_the_command_tells_positions_and_reactions(say):
    code, out, err = say("static", "p.mbd")
    assert (code, err) == (0, "")
    lines = out.splitlines()
    assert lines[0].startswith("P: equilibrium at t = 0 s, stable (")
    assert lines[1:4] == ["  rod.x               0 m", "  rod.y            -0.5 m", "  rod.phi       4.71239 rad"]
    assert "  pin.fy          19.62 N" in lines
    assert lines[-1].startswith("note: the start is an unstable equilibrium")


def test_the_command_writes_files(say):
    code, out, _ = say(
        "static", "p.mbd", "--output", "p.csv", "--signals", "rod.?,energy.*"
    )  # x, y, w, v, a and three energies
    assert code == 0 and out.endswith("p.csv: 1 row, time and 8 signals\n")
    columns, meta = results.read("p.csv")
    assert meta["complete"] and columns["rod.y"] == pytest.approx([-0.5])
    assert say("static", "p.mbd", "--output", "p.npz")[0] == 0
    columns, meta = results.read("p.npz")
    assert (meta["method"], meta["stability"]) == ("static", "stable")
    assert columns["pin.fy"] == pytest.approx([2.0 * G])
    json.dumps(meta)


def test_wrong_requests(say, tmp_path):
    (tmp_path / "f.mbd").write_text("model F Ground g; PointMass m(m = 1 kg); FreeMotion f(g, m); end F;")
    code, out, err = say("static", "f.mbd")
    assert (code, out) == (3, "")
    assert err.startswith("f.mbd:1:29: error: no equilibrium: m keeps moving\n")
    for argv, message in (
        (["p.mbd", "--signals", "rod.z"], "there is no signal `rod.z`"),
        (["p.mbd", "--output", "no/p.csv"], "there is no folder `no`"),
        (["p.mbd", "--output", "p.xls"], "known suffixes are .csv"),
        (["p.mbd", "--start", "1kg"], "wrong unit"),
        (["p.mbd", "--set", "x=1"], "x"),
        (["none.mbd"], "none.mbd"),
    ):
        code, out, err = say("static", *argv)
        assert (code, out) == (2, "") and message in err and "Traceback" not in err
