"""One-sided contacts of points with lines and planes: equilibria and an impact by their closed forms."""

import re
from pathlib import Path

import numpy as np
import pytest

import mbdsl

PAGE = Path(__file__).parents[2] / "docs" / "language.md"
G = 9.81


def test_crate_on_a_ramp():
    """The model of the page: forces across and along the ramp, and moments about the lower corner."""
    text = re.search(r"```mbd\n(// ramp\.mbd\n.*?)^```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
    still = mbdsl.static(mbdsl.parse(text[1]))
    across, along = 20.0 * G * np.cos(np.radians(20.0)), 20.0 * G * np.sin(np.radians(20.0))
    left = (0.3 * across - 0.3 * along) / 0.8  # the centre of mass is 0.3 m behind and 0.3 m above the corner
    # the stops give way by up to a millimetre
    assert [still[f"{x}.force"] for x in ("left", "right", "block")] == pytest.approx(
        [-left, left - across, along], rel=5e-3
    )


def test_table_on_three_feet_in_space():
    """Half of the weight is on the foot behind, and the other half is shared as the distances of the others."""
    feet = {"a": (-0.5, 0.5), "b": (0.5, 0.5), "d": (0.0, -0.5)}
    frames = ", ".join(f"{x} = {{{at[0]}, 0, {at[1]}}}" for x, at in feet.items())
    stops = "".join(f"TranslationalStop s{x}(ground, t.{x}, n = {{0, 1, 0}}, s_min = 0 m, k = 1e6 N/m);" for x in feet)
    body = f"Body t(m = 20 kg, I = {{2, 2, 2}} kg.m2, com = {{0.1, 0, 0}}, frames({frames}));"
    still = mbdsl.static(
        mbdsl.parse(f"spatial model T Ground ground; {body} {stops} FreeMotion f(ground, t.c); end T;")
    )
    weight = 20.0 * G
    assert [still[f"s{x}.force"] for x in feet] == pytest.approx(
        [-0.15 * weight, -0.35 * weight, -0.5 * weight], rel=1e-4
    )


def test_a_point_bounces_off_a_slope():
    """The velocity across the slope is reversed with the coefficient of restitution, that along it stays."""
    e, normal = 0.5, np.radians(60.0)
    speed = np.sqrt(2.0 * G * 1.0)  # after a fall of 1 m
    across = speed * np.sin(normal)
    text = f"""model Bounce
      Ground ground(frames(slope = {{0, 0, 60 deg}}));
      PointMass ball(m = 1 kg);
      FreeMotion free(ground, ball);
      TranslationalStop floor(ground.slope, ball, s_min = 0 m, k = 1e8 N/m, e = {e}, v_0 = {across} m/s);
    initial equation
      ball.x = 0 m; ball.y = 1 m; ball.vx = 0 m/s; ball.vy = 0 m/s;
    end Bounce;"""
    stop = np.sqrt(2.0 / G) + 0.01
    run = mbdsl.simulate(mbdsl.parse(text), stop=stop, tol=1e-6)
    n, t = np.array([np.cos(normal), np.sin(normal)]), np.array([np.sin(normal), -np.cos(normal)])
    expected = e * across * n + speed * np.cos(normal) * t - np.array([0.0, 0.01 * G])
    assert [run["ball.vx"][-1], run["ball.vy"][-1]] == pytest.approx(expected, abs=3e-3)


FALL = """model Fall "A crate falls onto a ramp: both corners touch at once, bounce, and slide against a block"
  Ground ground(frames(ramp = {0, 0, 70 deg}, block = {0, 0, -20 deg}));
  Body crate(m = 20 kg, I = 2 kg.m2, com = {-0.3, 0.3} m, frames(left = {-0.8, 0} m, right = {0, 0}));
  FreeMotion free(ground, crate.right);
  TranslationalStop left(ground.ramp, crate.left, s_min = 0 m, k = 1e5 N/m, e = 0.3, v_0 = 2.4 m/s);
  TranslationalStop right(ground.ramp, crate.right, s_min = 0 m, k = 1e5 N/m, e = 0.3, v_0 = 2.4 m/s);
  TranslationalStop block(ground.block, crate.right, s_max = 0 m, k = 1e5 N/m, e = 0.3, v_0 = 2.4 m/s);
initial equation
  free.phi = -20 deg; free.x = 0 m; free.y = 0.3 m;
  annotation(experiment(StopTime = 0.5 s));
end Fall;"""


def test_a_contact_is_decided_while_another_one_pushes():
    """A corner touches while the force of another one changes fast; the run reaches its tolerance all the same."""
    scene = mbdsl.parse(FALL)
    run = mbdsl.simulate(scene, method="radau5", tol=1e-4, interval=0.01)
    fine = mbdsl.simulate(scene, method="radau5", step=1e-4, interval=0.01)
    assert run.status == "done"
    assert run["crate.phi"] == pytest.approx(fine["crate.phi"], abs=1e-4)
    assert run["crate.y"] == pytest.approx(fine["crate.y"], abs=1e-4)
