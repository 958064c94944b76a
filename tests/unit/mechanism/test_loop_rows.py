"""Which joints get rows in axes of the joint: those in loops of moving bodies, and pickles of such models."""

import pickle

import numpy as np

import mbdsl

TEXT = """spatial model Loops
  Ground ground;
  Body cart(m = 1 kg, I = {1, 1, 1} kg.m2, frames(A = {0, 0, 0}, D = {0.3, 0, 0} m));
  Rod crank(m = 1 kg, length = 0.1 m); Rod link(m = 1 kg, length = 0.3 m); Rod rocker(m = 1 kg, length = 0.25 m);
  Rod tail(m = 1 kg, length = 0.2 m);
  Spherical hold(ground, cart.A);
  Revolute A(cart.A, crank.a); Revolute B(crank.b, link.a); Revolute C(link.b, rocker.b); Revolute D(cart.D, rocker.a);
  Revolute end(rocker.b, tail.a);
  RotationalDriver drive(A, phi = 80 deg + 1 rad/s*time);
initial equation
  guess D.phi = 100 deg; guess B.phi = -60 deg;
end Loops;""".replace("Revolute end", "Revolute last")


def variants(scene):
    return {name for name, c in scene.components.items() if c.kind.variant}


def test_joints_in_loops_of_moving_bodies():
    scene = mbdsl.parse(TEXT)
    assert variants(scene) == {"A", "B", "C", "D"}
    assert {c.kind.name for c in scene.components.values()} >= {"Revolute"} and "in_axes" not in repr(scene)
    grounded = TEXT.replace("Spherical hold(ground, cart.A);", "Fixed hold(ground, cart.A);")
    assert variants(mbdsl.parse(grounded)) == {"A", "B", "C", "D"}  # welds are resolved later
    direct = TEXT.replace("Revolute A(cart.A,", "Revolute A(ground,").replace("Revolute D(cart.D,", "Revolute D(wall,")
    direct = direct.replace("  Spherical hold", "  Frame wall(ground, r = {0.3, 0, 0} m);\n  Spherical hold")
    assert variants(mbdsl.parse(direct)) == set()


def test_pickles_keep_the_rows():
    scene = mbdsl.parse(TEXT)
    again = pickle.loads(pickle.dumps(scene))
    assert variants(again) == variants(scene) and again == scene
    one, two = (mbdsl.simulate(x, step=1e-3, stop=0.02, method="hht-i3") for x in (scene, again))
    assert np.array_equal(one["B.fx"], two["B.fx"]) and np.array_equal(one.q, two.q)
