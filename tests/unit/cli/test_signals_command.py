"""`mbdsl signals`: names, units and meanings, grouped and in machine formats."""

import csv
import io
import json
import re
from itertools import product
from pathlib import Path

import pytest

from mbdsl.cli._signal_text import ranges
from mbdsl.lang.load import load
from mbdsl.mechanism.signal_names import SignalNames

MODELS = Path(__file__).parents[3] / "models"
ARM = """model Arm
  Ground ground;
  parameter Integer N = 2;
  input Force push(start = 2 N) "push to the right";
  Rod link[N](each m = 1 kg, each length = 1 m);
  Revolute J[N];
  Force hand(link[1].c, fx = push);
equation
  connect(ground, J[1].frame_a);
  for i in 1:N loop
    connect(J[i].frame_b, link[i].a);
  end for;
  for i in 2:N loop
    connect(link[i-1].b, J[i].frame_a);
  end for;
end Arm;
"""
GROUPS = """\
Arm: 98 signals
A full name has both parts, such as link[1].x. [1:3] stands for [1], [2], [3];
the pattern for all is [*].

model
  time              s  time
  push              N  push to the right
  energy.kinetic    J  kinetic energy
  energy.potential  J  energy of gravity and springs
  energy.total      J  total energy

Rod: link[1:2]
  x      m       centre of mass, x
  y      m       centre of mass, y
  phi    rad     angle, counting turns
  vx     m/s     velocity along x
  vy     m/s     velocity along y
  w      rad/s   angular velocity
  v      m/s     size of the velocity
  ax     m/s2    acceleration along x
  ay     m/s2    acceleration along y
  alpha  rad/s2  angular acceleration
  a      m/s2    size of the acceleration

Revolute: J[1:2]
  phi        rad    angle of frame_b relative to frame_a
  w          rad/s  relative angular velocity
  fx         N      force along x
  fy         N      force along y
  f          N      size of the force
  Phi[1:2]          residual of a constraint
  dPhi[1:2]         residual of a constraint, its rate

Force: hand
  fx     N  component along x
  fy     N  component along y
  power  W  power delivered to the mechanism
  f      N  size of the force

frames: ground.c, link[1:2].c, link[1:2].a, link[1:2].b
  x    m      position along x
  y    m      position along y
  phi  rad    angle
  vx   m/s    velocity along x
  vy   m/s    velocity along y
  w    rad/s  angular velocity
  v    m/s    size of the velocity

what joints and forces exert, not among `*`: J[1:2].frame_a, J[1:2].frame_b,
  hand.frame_a, hand.frame_b
  fx   N    force on the body along x of this frame
  fy   N    force on the body along y of this frame
  tau  N.m  torque on the body about z of this frame
  f    N    size of the force

sections of rods and beams, not among `*`: link[1:2].c, link[1:2].a, link[1:2].b
  N  N    normal force, positive in tension
  Q  N    shear force along y of the section
  M  N.m  bending moment about z of the section
"""


@pytest.fixture
def arm(say, tmp_path):
    (tmp_path / "arm.mbd").write_text(ARM, encoding="utf-8")
    return lambda *words: say("signals", "arm.mbd", *words)


def test_components_and_frames_with_the_same_signals_are_listed_once(arm):
    assert arm() == (0, GROUPS, "")


def test_a_large_model_is_as_long_as_a_small_one_but_for_its_title(arm):
    _, small, _ = arm()
    _, large, _ = arm("--set", "N=300")
    assert large.splitlines()[0] == "Arm: 12316 signals"  # 98 + 298*41
    longer = small.replace("[1:2]", "[1:300]").replace("Phi[1:300]", "Phi[1:2]")
    assert large.split()[2:] == longer.split()[2:]  # lines are broken elsewhere


def test_patterns_list_full_names(arm):
    expected = "Arm: 3 signals\nJ[2].fx  N  force along x\nJ[2].fy  N  force along y\npush     N  push to the right\n"
    assert arm("J[2].f?", "push") == (0, expected, "")
    assert arm("J[2].f?,push") == (0, expected, "")


def test_a_pattern_of_a_frame_has_what_is_not_among_all(arm):
    """`link[1].a.*` has the forces in the section, `link[1].*` has not; residuals have to be named, or `*`."""
    assert {"link[1].a.N", "link[1].a.Q", "link[1].a.M", "link[1].a.x"} <= set(arm("link[1].a.*")[1].split())
    assert "link[1].a.N" not in arm("link[1].*")[1] and "J[1].frame_a.fx" not in arm("J[1].*")[1]
    assert "J[1].phi" in arm("J[1].*")[1] and "Phi" not in arm("J[1].*")[1]
    assert "J[1].Phi[1]" in arm("J[1].Phi*")[1] and "J[1].Phi[1]" in arm("*")[1]


def test_forces_in_sections_without_a_section(arm):
    assert "varies along link[1]: name a section, `link[1].a.N`, or use `mbdsl plot MODEL" in arm("link[1].N")[2]
    assert "forces in this section: link[1].a.N, link[1].a.Q, link[1].a.M" in arm("link[1].a.T")[2]


def test_machine_formats_have_every_signal(arm):
    scene = load("arm.mbd")
    names = SignalNames(scene)
    header, *rows = csv.reader(io.StringIO(arm("--format", "csv")[1]))
    objects = json.loads(arm("--format", "json")[1])
    assert header == ["signal", "unit", "meaning"]
    assert [row[0] for row in rows] == names.names
    assert [(row[0], row[1]) for row in rows] == [(name, names.unit(name)) for name in names.names]
    assert [dict(zip(header, row, strict=True)) for row in rows] == objects


@pytest.mark.parametrize("model", ["slider_crank", "flexible_slider_crank", "seven_body", "driven_crank"])
def test_the_groups_have_every_signal_once(say, model):
    """Owners times names, with slices written out, are the names of the model."""
    _, out, _ = say("signals", MODELS / f"{model}.mbd")
    assert max(map(len, out.splitlines())) <= 80
    found = []
    for block in out.split("\n\n")[1:]:
        head, *rows = re.sub(r",\n +", ", ", block).splitlines()
        owners = [""] if head == "model" else [f"{owner}." for owner in head.partition(": ")[2].split(", ")]
        keys = [row.split()[0] for row in rows]
        found += ["".join(pair) for pair in product(_written_out(owners), _written_out(keys))]
    names = SignalNames(load(MODELS / f"{model}.mbd"))
    assert sorted(found) == sorted([*names.names, *names.unlisted])


def _written_out(names):
    for name in names:
        bounds = re.search(r"\[(\d+):(\d+)\]", name)
        if bounds is None:
            yield name
        else:
            numbers = range(int(bounds[1]), int(bounds[2]) + 1)
            yield from _written_out(name.replace(bounds[0], f"[{k}]", 1) for k in numbers)


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        ([], []),
        (["a", "b.c"], ["a", "b.c"]),
        (["a[1]", "a[2]", "a[4]", "b[3]"], ["a[1:2]", "a[4]", "b[3]"]),
        (["a[1].x", "a[1].y", "a[2].x", "a[2].y"], ["a[1:2].x", "a[1:2].y"]),
        ([f"r[{i}].s[{j}]" for i in (1, 2) for j in (1, 2, 3)], ["r[1:2].s[1:3]"]),
        (["a[1]", "a", "a[2].b[7]"], ["a[1]", "a", "a[2].b[7]"]),
    ],
)
def test_consecutive_indices_are_slices(names, expected):
    assert ranges(names) == expected


def test_an_unknown_signal(arm):
    code, out, err = arm("hand.fz")
    assert (code, out) == (2, "")
    assert err == "error: there is no signal `hand.fz` in Arm\n  = did you mean `hand.f` or `hand.fy` or `hand.fx`?\n"
    assert "`mbdsl signals MODEL`" in arm("qqqqq")[2]
