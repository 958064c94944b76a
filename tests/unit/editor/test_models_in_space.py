"""Proposals and descriptions in models in space: orientations of frames, attitudes, and coordinates of joints."""

import pytest

TOP = """spatial model Top
  Ground ground;
  Body top(m = 1 kg, I = {1, 2, 2} kg.m2, frames(tip(r = {1, 0, 0} m, angles = {0, 90, 0} deg)));
  Frame side(top, n_x = {1, 1, 0}, n_y = {0, 1, 0});
  Universal joint(ground, top.tip);
  Real u = top.phi_x + side.wz_local/(1 rad/s);
initial equation
  joint.phi_a = 3 deg;
end Top;
"""


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("side(top, n_x = {1, 1, 0}, n_y = {0, 1, 0})", "side(top, |)", {"r", "n", "n_x", "angles", "quaternion"}),
        ("top.phi_x +", "top.| +", {"tip", "phi_x", "wx_local", "p0", "z"}),
        ("side.wz_local", "side.|", {"phi_y", "wz_local", "p3", "xx", "vz"}),
        ("joint.phi_a", "joint.|", {"phi_a", "phi_b", "w_a", "frame_b"}),
    ],
)
def test_completion(client, old, new, expected):
    assert expected <= set(client.complete("top.mbd", TOP.replace(old, new)))


def test_hover_and_problems(client):
    client.show("top.mbd", TOP)
    assert client.problems("top.mbd") == []

    def shown(word):
        return client.ask("textDocument/hover", client.at("top.mbd", word))["contents"]["value"]

    assert "in the xy plane" in shown("n_y")
    assert "about the own z axis" in shown("wz_local")
    assert "angle of the cross about n_a" in shown("phi_a")
    client.show("top.mbd", TOP.replace("n_y = {0, 1, 0}", "n_y = {2, 2, 0}"))
    (problem,) = client.problems("top.mbd")
    assert "are parallel" in problem["message"]
