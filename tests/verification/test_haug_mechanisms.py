"""Haug's slider crank and four-link, driven and free: positions, attitudes, angular velocities, reactions and torques.

Both have one degree of freedom, the angle psi of the crank or rotor, and return after a turn. Their positions and
attitudes at ``N`` angles follow from the closed form of the slider crank, and from the loop of the four-link closed by
SciPy. Fourier series of these give derivatives with respect to psi, the equation of motion of the free mechanism, and
the Newton-Euler equations of the bodies with the forces and torques of all joints. Nothing of this uses mbdsl.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve
from scipy.spatial.transform import Rotation

import mbdsl
from mbdsl.integrators import modules

SPACE = Path(__file__).parents[2] / "models" / "space"
#: angles of a turn: the coefficients of the Fourier series fall to rounding at a sixth of them
N = 256
EVERY = 16  #: outputs are at each of these angles
METHODS = {name: module.METHOD for name, module in modules().items() if module.METHOD.chosen}
METHODS = {name: method for name, method in METHODS.items() if not hasattr(modules()[name], "take")}
GRAVITY = np.array([0.0, 0.0, -9.81])
X, Y, Z = np.eye(3)


@dataclass
class Body:
    """At N angles: r (N, 3) [m] and R (N, 3, 3); the mass [kg], and moments of inertia (3,) in body axes [kg.m2]."""

    r: np.ndarray
    R: np.ndarray
    m: float
    inertia: np.ndarray

    def spin(self):
        """The angular velocity per rate of psi, in world axes (N, 3), from R' = w x R."""
        W = derivative(self.R) @ self.R.transpose(0, 2, 1)
        return np.stack([W[:, 2, 1] - W[:, 1, 2], W[:, 0, 2] - W[:, 2, 0], W[:, 1, 0] - W[:, 0, 1]], axis=-1) / 2

    def momentum(self):
        """The moment of momentum about the centre of mass per rate of psi, in world axes (N, 3)."""
        return np.einsum("nij,j,nkj,nk->ni", self.R, self.inertia, self.R, self.spin())


@dataclass
class Joint:
    """Its bodies (None: the ground), its point (N, 3), and the directions of torques and forces on the second body."""

    a: str | None
    b: str
    point: np.ndarray
    torques: list[np.ndarray]
    forces: tuple[np.ndarray, ...] = (X, Y, Z)


def derivative(y):
    """With respect to psi, of y (N, ...), which is periodic."""
    k = np.fft.fftfreq(N, 1.0 / N) * 1j
    k[N // 2] = 0.0
    return np.fft.ifft(k.reshape(-1, *[1] * (y.ndim - 1)) * np.fft.fft(y, axis=0), axis=0).real


def reactions(bodies, joints, speed, acceleration):
    """(force, torque), each (N, 3), of every joint on its second body at its point, for psi' and psi''."""
    names = list(bodies)
    columns, needed = [], np.zeros((N, 6 * len(names)))
    for k, body in enumerate(bodies.values()):
        for d, y, factor in ((0, derivative(body.r), body.m), (3, body.momentum(), 1.0)):
            needed[:, 6 * k + d : 6 * k + d + 3] = factor * (y * acceleration + derivative(y) * speed**2)
        needed[:, 6 * k : 6 * k + 3] -= body.m * GRAVITY
    for name, joint in joints.items():
        for kind, directions in enumerate((joint.forces, joint.torques)):
            for direction in directions:
                u, column = np.broadcast_to(direction, (N, 3)), np.zeros_like(needed)
                for end, sign in ((joint.a, -1.0), (joint.b, 1.0)):
                    if end is not None:
                        k = 6 * names.index(end)
                        column[:, k : k + 3] = 0.0 if kind else sign * u
                        column[:, k + 3 : k + 6] = sign * (u if kind else np.cross(joint.point - bodies[end].r, u))
                columns.append((name, kind, u, column))
    matrix = np.stack([column for *_, column in columns], axis=-1)
    sizes = np.linalg.solve(matrix, needed[..., None])[..., 0]
    found = {name: np.zeros((2, N, 3)) for name in joints}
    for (name, kind, u, _), size in zip(columns, sizes.T, strict=True):
        found[name][kind] += size[:, None] * u
    return found


def slider_crank(psi):
    """The rod does not turn about its own axis: its y axis is at right angles to the slider's path."""
    o = 0 * psi
    pin = np.stack([o, 0.1 + 0.08 * np.cos(psi), 0.12 + 0.08 * np.sin(psi)], axis=-1)
    slider = np.stack([np.sqrt(0.09 - (pin**2).sum(axis=1)), o, o], axis=-1)
    along = (slider - pin) / 0.3
    across = np.cross(X, along) / np.linalg.norm(np.cross(X, along), axis=1)[:, None]
    rod = np.stack([along, across, np.cross(along, across)], axis=-1)
    bearing = np.tile([0, 0.1, 0.12], (N, 1))
    turned = Rotation.from_rotvec(np.multiply.outer(psi, X)).as_matrix()
    bodies = {
        "crank": Body(bearing, turned, 0.12, np.array([1e-4, 1e-5, 1e-4])),
        "rod": Body((pin + slider) / 2, rod, 0.5, np.array([4e-3, 4e-4, 4e-3])),
        "slider": Body(slider, np.tile(np.eye(3), (N, 1, 1)), 2.0, np.full(3, 1e-4)),
    }
    joints = {
        "A": Joint(None, "crank", bearing, [Y, Z]),
        "B": Joint("crank", "rod", pin, []),
        "C": Joint("slider", "rod", slider, [np.cross(X, across)]),
        "D": Joint(None, "slider", slider, [X, Y, Z], (Y, Z)),
        "motor": Joint(None, "crank", bearing, [X], ()),
    }
    return bodies, joints


def four_link(psi):
    """The loop closed from the published start, psi = 0, on; the rotation vectors of the link stay below pi."""
    cross = np.array([0.75, -0.662, 0])

    def away(u, angle):
        rotor, link = Rotation.from_rotvec([angle, 0, 0]), Rotation.from_rotvec(u[:3])
        end = rotor.apply([0, 0, 2]) - link.apply([0, 12.2, 0])
        ball = [-4 - 7.4 * np.cos(u[3]), -8.5, 7.4 * np.sin(u[3])]
        return np.append(end - ball, rotor.apply(cross) @ link.apply(Z))

    # the pin at (0, 0, 2) and the centre of the link give its y axis, and the rotor's cross its z axis
    y = ([0, 0, 2] - np.array([-3.74555772, -4.25, 4.26236544])) / 6.1
    z = np.cross(cross, y) / np.linalg.norm(np.cross(cross, y))
    start = Rotation.from_matrix(np.stack([np.cross(y, z), y, z], axis=-1))
    u, closed = np.append(start.as_rotvec(), np.arctan2(3.26236544, 1.74555772)), []
    for angle in np.concatenate([np.linspace(0, psi[0], 20)[:-1], psi]):
        u, _, solved, message = fsolve(away, u, (angle,), xtol=1e-13, full_output=True)
        assert solved == 1, message
        closed.append(u)
    u, o = np.array(closed[-N:]), np.zeros((N, 3))
    rotor = Rotation.from_rotvec(np.multiply.outer(psi, X)).as_matrix()
    link = Rotation.from_rotvec(u[:, :3]).as_matrix()
    arm = np.stack([-np.cos(u[:, 3]), 0 * psi, np.sin(u[:, 3])], axis=-1)  # from the hinge to the ball
    pin, hinge = rotor @ [0, 0, 2], o + [-4, -8.5, 0]
    bodies = {
        "rotor": Body(o, rotor, 2.0, np.array([4.0, 2.0, 0.0])),
        "link": Body(pin - 6.1 * link[:, :, 1], link, 1.0, np.array([12.4, 0.01, 0.0])),
        "rocker": Body(
            hinge + 3.7 * arm, np.stack([o - Y, -arm, np.cross(Y, arm)], axis=-1), 1.0, np.array([4.54, 0.01, 0.0])
        ),
    }
    joints = {
        "A": Joint(None, "rotor", o, [Y, Z]),
        "B": Joint("rotor", "link", pin, [np.cross(rotor @ cross, link[:, :, 2])]),
        "C": Joint("link", "rocker", hinge + 7.4 * arm, []),
        "D": Joint(None, "rocker", hinge, [X, Z]),
        "motor": Joint(None, "rotor", o, [X], ()),
    }
    return bodies, joints


@dataclass
class Mechanism:
    """Its kinematics, and the angle [rad] and speed [rad/s] at the start."""

    name: str
    at: object
    start: float
    speed: float

    def turn(self, psi):
        """Bodies and joints at N angles of a turn from psi on, against the sense of ``speed`` if this is negative."""
        return self.at(psi + 2 * np.pi * np.arange(N) / N)

    @property
    def period(self):
        return 2 * np.pi / abs(self.speed)

    @property
    def order(self):
        """The angles of the turn at equal times."""
        return (np.arange(0, N, EVERY) * int(np.sign(self.speed))) % N


SLIDER_CRANK = Mechanism("haug_slider_crank", slider_crank, np.pi / 2, -2 * np.pi)
FOUR_LINK = Mechanism("haug_four_link", four_link, 0.0, np.pi)
MECHANISMS = [SLIDER_CRANK, FOUR_LINK]
CASES = [(m, name) for m in MECHANISMS for name in METHODS if not (m is FOUR_LINK and METHODS[name].inverts_mass)]


def vectors(found, name, keys="xyz"):
    return np.stack([found[f"{name}.{key}"] for key in keys], axis=-1)


def deviations(found, bodies, joints, speed, acceleration):
    """Largest differences of positions, attitudes, angular velocities, forces, and torques; all (K, ...) in time."""
    off = np.zeros(5)
    for name, body in bodies.items():
        R = Rotation.from_quat(vectors(found, name, ("p1", "p2", "p3", "p0"))).as_matrix()
        w = vectors(found, name, ("wx", "wy", "wz"))
        differences = (vectors(found, name) - body["r"], R - body["R"], w - speed * body["spin"])
        off[:3] = np.maximum(off[:3], [np.abs(x).max() for x in differences])
    for name, (force, torque) in joints.items():
        for k, (keys, expected) in enumerate(((("fx", "fy", "fz"), force), (("tx", "ty", "tz"), torque))):
            if f"{name}.{keys[0]}" in found:
                off[3 + k] = max(off[3 + k], np.abs(vectors(found, name, keys) - expected).max())
    return off


def picked(bodies, joints, at):
    """Of a turn, the angles ``at``."""
    chosen = {name: {"r": b.r[at], "R": b.R[at], "spin": b.spin()[at]} for name, b in bodies.items()}
    return chosen, {name: reaction[:, at] for name, reaction in joints.items()}


@pytest.fixture(scope="module")
def driven():
    """Of each mechanism the motion with constant speed, and the sizes of forces and torques."""
    found = {}
    for mechanism in MECHANISMS:
        bodies, joints = mechanism.turn(mechanism.start)
        motion = picked(bodies, reactions(bodies, joints, mechanism.speed, 0.0), mechanism.order)
        sizes = np.array([max(np.abs(r[k]).max() for r in motion[1].values()) for k in (0, 1)])
        found[mechanism.name] = motion, sizes
    return found


def run_driven(mechanism, **given):
    every = mechanism.period * EVERY / N
    return mbdsl.simulate(SPACE / f"{mechanism.name}.mbd", stop=mechanism.period - every, interval=every, **given)


@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda m: m.name)
def test_driven(mechanism, driven):
    """Drivers leave no freedom: everything is exact, as far as the Fourier series are, and fsolve closes the loop.

    Second derivatives of series of N terms enlarge errors of 1e-14 by up to (N/6)^2."""
    motion, sizes = driven[mechanism.name]
    off = deviations(run_driven(mechanism, step=mechanism.period / 512), *motion, mechanism.speed, 0.0)
    assert off[:2].max() < 1e-10 and off[2] < 1e-9
    assert (off[3:] / sizes).max() < 1e-9


def test_outputs_between_steps(driven):
    """The errors of interpolated positions and attitudes fall with h^4: steps of the slider crank are exact."""
    motion, _ = driven[SLIDER_CRANK.name]
    coarse, fine = (
        deviations(run_driven(SLIDER_CRANK, step=h), *motion, SLIDER_CRANK.speed, 0.0)[:2] for h in (8e-3, 4e-3)
    )
    assert np.log2(coarse / fine).min() > 3.5


@pytest.mark.parametrize("name", METHODS)
def test_orders_of_the_driven_slider_crank(name, driven):
    """With all equations solved by each method: reactions have its order, and velocities order 2 where the constraints
    of velocities are not enforced (their errors are c h^2 of the third derivative for NEWMARK, too). hht-add has no
    errors, because its accelerations satisfy the constraints as well."""
    mechanism, given = SLIDER_CRANK, {"method": name, "general": True}
    motion, sizes = driven[mechanism.name]
    off = [
        deviations(run_driven(mechanism, step=mechanism.period / n, **given), *motion, mechanism.speed, 0.0)
        for n in (1024, 2048)
    ]
    assert off[1][:2].max() < 1e-10
    if METHODS[name].index == 3:
        assert np.log2(off[0][2] / off[1][2]) == pytest.approx(2.0, abs=0.1)
    else:
        assert off[1][2] < 1e-9
    if METHODS[name].inverts_mass:
        assert (off[1][3:] / sizes).max() < 1e-9
    else:
        assert np.log2(off[0][3:] / off[1][3:]) == pytest.approx(METHODS[name].order, abs=0.15)
    assert (off[1][3:] / sizes).max() < (1e-2 if METHODS[name].order == 1 else 3e-4)


def free_motion(mechanism, stop):
    """psi, psi', psi'' at ``stop`` without the driver: M(psi) psi'' + M' psi'^2/2 + V' = 0."""
    bodies, _ = mechanism.turn(mechanism.start)
    mass, potential = np.zeros(N), np.zeros(N)
    for body in bodies.values():
        mass += body.m * (derivative(body.r) ** 2).sum(axis=1) + (body.spin() * body.momentum()).sum(axis=1)
        potential -= body.m * body.r @ GRAVITY
    k = np.fft.fftfreq(N, 1.0 / N)
    series = np.fft.fft(np.stack([mass, derivative(mass) / 2, derivative(potential)], axis=-1), axis=0) / N

    def acceleration(psi, speed):
        M, half, force = (np.exp(1j * k * (psi - mechanism.start)) @ series).real
        return -(half * speed**2 + force) / M

    start = [mechanism.start, mechanism.speed]
    found = solve_ivp(lambda t, y: [y[1], acceleration(*y)], (0, stop), start, "DOP853", rtol=1e-12, atol=1e-12)
    psi, speed = found.y[:, -1]
    return psi, speed, acceleration(psi, speed)


@pytest.fixture(scope="module")
def free():
    """Of each mechanism the motion without driver after half of its period, and the text of the model."""
    found = {}
    for mechanism in MECHANISMS:
        text = (SPACE / f"{mechanism.name}.mbd").read_text(encoding="utf-8")
        text = re.sub(r"  RotationalDriver.*\n", "", text)
        begin = f"initial equation\n  A.phi = {mechanism.start!r} rad;\n  A.w = {mechanism.speed!r} rad/s;"
        psi, speed, acceleration = free_motion(mechanism, mechanism.period / 2)
        bodies, joints = mechanism.turn(psi)
        joints.pop("motor")
        # without this torque there would be one unknown less than equations: it is zero if the motion is right
        joints["no motor"] = Joint(None, next(iter(bodies)), bodies[next(iter(bodies))].r, [X], ())
        motion = picked(bodies, reactions(bodies, joints, speed, acceleration), np.array([0]))
        motor = motion[1].pop("no motor")
        assert np.abs(motor).max() < 1e-9 * max(np.abs(reaction).max() for reaction in motion[1].values())
        found[mechanism.name] = mbdsl.parse(text.replace("initial equation", begin)), motion, speed, acceleration
    return found


@pytest.mark.parametrize(("mechanism", "name"), CASES, ids=lambda x: getattr(x, "name", x))
def test_orders_of_the_free_mechanisms(mechanism, name, free):
    """Positions, attitudes, angular velocities, forces, and torques after half of the driven mechanism's period."""
    scene, motion, speed, acceleration = free[mechanism.name]
    stop = mechanism.period / 2
    off = []
    for n in (2048, 4096):
        t = mbdsl.simulate(scene, method=name, step=stop / n, stop=stop, interval=stop)
        off.append(deviations(t[stop:], *motion, speed, acceleration))
    assert np.log2(off[0] / off[1]) == pytest.approx(METHODS[name].order, abs=0.15)
