"""A robot in space of sub-models, arrays, loops, a table and an input: its motion is that of the model written out."""

import numpy as np
import pytest

import mbdsl

ROBOT = """
spatial partial model Link "What all links have"
  parameter Mass m = 1 kg;
  parameter Length L = 0.4 m;
  parameter Real n[3] = {0, 0, 1} "axis of the hinge";
  connector Frame base;
  connector Frame tip;
  Body body(m = m, I = {1e-3 kg.m2, m*L^2/12, m*L^2/12}, frames(a = {-L/2, 0, 0}, b(r = {L/2, 0, 0}, phi = 5 deg)));
  Revolute hinge(base, body.a, n = n);
equation
  connect(tip, body.b);
end Link;

spatial model MotorLink "A link with a controlled motor"
  extends Link;
  input Angle target;
  Torque motor(hinge, n = n, tau = 200 N.m*(target - hinge.phi) - 8 N.m.s*hinge.w);
end MotorLink;

spatial model Robot
  parameter Integer N = 2 "links";
  parameter Mass load = 0.5 kg;
  constant Real axes[3, 3] = {{0, 1, 0}, {0, 0, 1}, {0, 0, 1}};
  input Real gain(start = 2);
  Table path(table = [0 s, 0 rad; 0.2 s, 0.4 rad; 0.4 s, 0.3 rad], smoothness = "cubic");
  Real wish = gain*path(time);
  Ground ground;
  Frame foot(ground, r = {0, 300, 0} mm, angles = {0, 90, 0} deg);
  MotorLink link[N](n = axes[1:N, :], each m = 2 kg, each L = 0.3 m, each target = wish);
  Sphere ball(m = load, radius = 50 mm);
  Spherical wrist(link[N].tip, ball.c);
equation
  connect(foot, link[1].base);
  for i in 2:N loop
    connect(link[i-1].tip, link[i].base);
  end for;
initial equation
  for i in 1:N loop
    link[i].hinge.phi = 10 deg;
  end for;
  wrist.phi_y = 20 deg;
  wrist.phi_x = 0 deg;
  wrist.phi_z = 0 deg;
  ball.wx_local = 1 rad/s;
  annotation(experiment(StopTime = 0.2 s, Interval = 10 ms, Step = 1 ms));
end Robot;
"""


def written_out():
    b = mbdsl.SpatialBuilder("Robot")
    b.Ground("ground")
    b.table("path", [(0, 0), (0.2, 0.4), (0.4, 0.3)], smoothness="cubic")
    b.frame("foot", "ground", r=(0, 0.3, 0), angles=(0, "90 deg", 0))
    frame = "foot"
    for k, n in ((1, (0, 1, 0)), (2, (0, 0, 1))):
        I = (1e-3, "2 kg*(0.3 m)^2/12", "2 kg*(0.3 m)^2/12")
        end = {"r": (0.3 / 2, 0, 0), "phi": "5 deg"}
        b.Body(f"body{k}", m=2, I=I, frames={"a": (-0.3 / 2, 0, 0), "b": end})
        b.Revolute(f"hinge{k}", frame, f"body{k}.a", n=n)
        law = f"200 N.m*(2*path(time) - hinge{k}.phi) - 8 N.m.s*hinge{k}.w"
        b.Torque(f"motor{k}", f"hinge{k}", n=n, tau=law)
        b.initial(f"hinge{k}.phi", "10 deg")
        frame = f"body{k}.b"
    b.Sphere("ball", m=0.5, radius=0.05)
    b.Spherical("wrist", frame, "ball.c")
    b.initial("wrist.phi_y", "20 deg")
    b.initial("wrist.phi_x", 0)
    b.initial("wrist.phi_z", 0)
    b.initial("ball.wx_local", 1)
    return b.scene()


def test_the_motion_of_sub_models_is_that_of_the_model_written_out():
    given = {"stop": 0.2, "interval": 1e-2, "step": 1e-3}
    a, b = mbdsl.simulate(mbdsl.parse(ROBOT), **given), mbdsl.simulate(written_out(), **given)
    assert np.ptp(a["link[1].hinge.phi"]) > 0.1
    pairs = {f"link[{k}].hinge.{key}": f"hinge{k}.{key}" for k in (1, 2) for key in ("phi", "w", "fy", "tz")}
    pairs |= {name: name for name in ("ball.x", "ball.phi_x", "ball.wz_local", "wrist.fx", "wrist.phi_z")}
    for name, other in pairs.items():
        size = max(1.0, np.abs(b[other]).max())
        # the same equations in another order: Newton's iteration stops at errors of this size
        assert a[name] == pytest.approx(b[other], abs=1e-8 * size)


def test_parameters_by_name_change_elements_and_sizes():
    scene = mbdsl.parse(ROBOT)
    assert scene.with_parameters({"link[2].m": "3 kg"}).components["link[2].body"].values["m"] == 3.0
    assert "link[3].body" in scene.with_parameters(N=3).components
    assert "link[3].body" not in scene.components


def test_a_linear_model_has_quaternions_as_outputs():
    """Their derivatives by rotations about the axes of the world: p' = (0, w) p/2, a product of quaternions."""
    names = [f"ball.p{k}" for k in range(4)]
    found = mbdsl.linearise(mbdsl.parse(ROBOT), at="start", signals=names)
    p0, p1, p2, p3 = found.y0
    columns = [list(found.states).index(f"ball.c:r{i}") for i in "xyz"]  # not the Cardan angles of the ball joint
    by_rotation = np.array([[-p1, -p2, -p3], [p0, p3, -p2], [-p3, p0, p1], [p2, -p1, p0]]) / 2
    assert found.C[:, columns] == pytest.approx(by_rotation, abs=1e-13)
    assert p1**2 + p2**2 + p3**2 > 0.1
