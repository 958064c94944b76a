"""Moments of inertia of uniform solids by quadrature over their volume, and bodies with a matrix of inertia."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mbdsl
from mbdsl.errors import ModelError

RHO = 7800.0


def body(text):
    scene = mbdsl.parse(f"spatial model M\n Ground ground;\n {text};\n Spherical ball(ground, part.c);\nend M;")
    return scene.components["part"].values


def quadrature(points, weights):
    """Mass and matrix of inertia from points (N, 3) and volumes (N,)."""
    m = RHO * weights.sum()
    square = (points**2).sum(axis=1)
    J = RHO * (np.eye(3) * (weights @ square) - np.einsum("k,ki,kj->ij", weights, points, points))
    return m, J


def gauss(low, high, count=6):
    x, w = np.polynomial.legendre.leggauss(count)  # exact for polynomials of degree 11
    return (low + high) / 2 + (high - low) / 2 * x, (high - low) / 2 * w


def grid(*axes):
    points = np.stack(np.meshgrid(*(x for x, _ in axes), indexing="ij"), axis=-1).reshape(-1, 3)
    weights = np.prod(np.meshgrid(*(w for _, w in axes), indexing="ij"), axis=0).ravel()
    return points, weights


def around():
    phi = 2 * np.pi * np.arange(8) / 8  # exact for sines and cosines of up to 7 times the angle
    return phi, np.full(8, 2 * np.pi / 8)


def test_box():
    found = body(f"Box part(rho = {RHO} kg/m3, length = 2 m, width = 0.3 m, height = 0.1 m)")
    m, J = quadrature(*grid(gauss(-1, 1), gauss(-0.15, 0.15), gauss(-0.05, 0.05)))
    assert found["m"] == pytest.approx(m, rel=1e-12)
    assert found["I"] == pytest.approx(np.diag(J), rel=1e-12)


@pytest.mark.parametrize("inner", [0.0, 0.15])
@pytest.mark.parametrize("n", [(1, 0, 0), (0, 0, 1), (2, -1, 2)])
def test_cylinder(inner, n):
    words = f"rho = {RHO} kg/m3, length = 0.5 m, radius = 0.2 m, bore = {inner} m"
    found = body(f"Cylinder part({words}, n = {{{n[0]}, {n[1]}, {n[2]}}})")
    points, weights = grid(gauss(-0.25, 0.25), gauss(inner, 0.2), around())
    along, r, phi = points.T
    turn, _ = Rotation.align_vectors([np.array(n) / np.linalg.norm(n)], [[0, 0, 1]])
    m, J = quadrature(turn.apply(np.stack([r * np.cos(phi), r * np.sin(phi), along], axis=-1)), weights * r)
    assert found["m"] == pytest.approx(m, rel=1e-12)
    assert np.array(found["I"]) == pytest.approx(J, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("inner", [0.0, 0.0999])
def test_sphere(inner):
    found = body(f"Sphere part(rho = {RHO} kg/m3, radius = 0.1 m, bore = {inner} m)")
    points, weights = grid(gauss(inner, 0.1), gauss(-1, 1), around())
    r, cos, phi = points.T
    sin = np.sqrt(1 - cos**2)
    place = np.stack([r * sin * np.cos(phi), r * sin * np.sin(phi), r * cos], axis=-1)
    m, J = quadrature(place, weights * r**2)
    assert found["m"] == pytest.approx(m, rel=1e-10)  # of the difference of both volumes
    assert np.array(found["I"]) == pytest.approx(np.diag(J), rel=1e-10)


MATRIX = """
spatial model Free
  Ground ground(g = 0);
  Body part(m = 1 kg, I = {I} kg.m2);
  Force none(part.c);
initial equation
  part.vx = 0; part.vy = 0; part.vz = 0;
  part.wx = {w[0]!r}; part.wy = {w[1]!r}; part.wz = {w[2]!r};
end Free;
"""


def test_matrix_of_inertia():
    """A free body whose axes are other ones: the same motion, seen from axes that are turned alike."""
    principal, w = np.array([1.0, 2.0, 2.5]), np.array([0.3, 2.0, -0.4])
    turn = Rotation.from_rotvec([0.4, -0.7, 1.1])
    J = turn.as_matrix() @ np.diag(principal) @ turn.as_matrix().T
    rows = ", ".join("{" + ", ".join(map(repr, row)) + "}" for row in ((J + J.T) / 2).tolist())
    diagonal = "{" + ", ".join(map(repr, principal.tolist())) + "}"
    runs = [
        mbdsl.simulate(mbdsl.parse(MATRIX.format(I=I, w=start.tolist())), stop=2.0, step=1e-3, interval=0.1)
        for I, start in ((diagonal, w), (f"{{{rows}}}", turn.apply(w)))
    ]
    spins = [np.stack([run[f"part.w{i}"] for i in "xyz"], axis=-1) for run in runs]
    assert turn.apply(spins[0]) == pytest.approx(spins[1], abs=1e-9)  # Newton's iteration
    assert np.ptp(spins[0]) > 1.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Box part(length = 1 m, width = 1 m, height = 1 m)", "the mass is missing: give m or rho"),
        ("Sphere part(m = 1 kg, rho = 1 kg/m3, radius = 1 m)", "give either m or rho"),
        ("Sphere part(m = 1 kg, radius = 1 m, bore = 1 m)", "the inner radius is not smaller than the radius"),
        ("Cylinder part(m = 1 kg, length = 1 m, radius = 1 m, n = {0, 0, 0})", "the axis n is zero"),
        ("Body part(m = 1 kg, I = {1, -1, 1} kg.m2)", "the moment of inertia Iyy in I is -1 kg.m2"),
        (
            "Body part(m = 1 kg, I = {{1, 0.5, 0}, {0.4, 1, 0}, {0, 0, 1}} kg.m2)",
            "the matrix of inertia I is not symmetric: I[1, 2] = 0.5, but I[2, 1] = 0.4 kg.m2",
        ),
        ("Body part(m = 1 kg, I = {{1, 2, 0}, {2, 1, 0}, {0, 0, 1}} kg.m2)", "has a negative principal moment"),
    ],
)
def test_refused(text, message):
    with pytest.raises(ModelError) as caught:
        body(text)
    assert message in str(caught.value)
