"""Numbers that overflow the computation end in a message with their name and place, and not in a traceback."""

import numpy as np
import pytest

from mbdsl import eigen, explain, parse, simulate, static
from mbdsl.cli import main
from mbdsl.errors import ModelError
from mbdsl.mechanism.extreme_numbers import blame_extremes

MODEL = """\
model A
  Ground ground;
  {}
  Revolute p(ground, r.a);
  annotation(experiment(StopTime = 0.01 s, Step = 1 ms));
end A;
"""
BEAM = "FlexibleBeam r(length = {} m, S = 1 m2, E = {} Pa, I = {} m4, density = {} kg/m3, modes = 2);"
ANCF = 'FlexibleBeam r(length = {} m, S = 1 m2, E = 1 Pa, I = 1 m4, mass = {} kg, formulation = "ancf", elements = 2);'
WELD = "Rod r(m = 1 kg, length = {0} m); Rod s(m = {0} kg, length = {0} m); Fixed f(r.b, s.a);"
ROLL = (
    "Rod r(m = 1 kg, length = 1 m); Rod s(m = 1 kg, length = 1 m); Revolute q(ground, s.a);"
    "VelocityConstraint c(gamma = {0}*r.w + {0}*s.w);"
)
EXTREME = [
    (simulate, BEAM.format("1e300", 1, 1, 1), "`length` of FlexibleBeam `r` is 1e+300"),
    (simulate, BEAM.format("1e-150", 1, 1, 1), "`length` of FlexibleBeam `r` is 1e-150"),
    (eigen, BEAM.format(1, "1e308", 1, 1), "`E` of FlexibleBeam `r` is 1e+308"),
    (static, BEAM.format(1, "5e-324", 1, 1), "`E` of FlexibleBeam `r` is 4.94066e-324"),
    (simulate, BEAM.format(1, 1, 1, "1e-300").replace("S = 1 m2", "S = 1e-200 m2"), "`density` of FlexibleBeam `r`"),
    (simulate, ANCF.format("1e300", 1), "`length` of FlexibleBeam `r` is 1e+300"),
    (explain, ANCF.format("5e-324", 1), "`length` of FlexibleBeam `r` is 4.94066e-324"),
    (simulate, WELD.format("5e-324"), "is 4.94066e-324"),
    (static, ROLL.format("5e-324"), "`gamma` of VelocityConstraint `c` is 4.94066e-324"),
    (static, "Rod r(m = 1 kg, length = 1e-300 m);", "`length` of Rod `r` is 1e-300"),
]


@pytest.mark.parametrize(("run", "line", "said"), EXTREME, ids=range(len(EXTREME)))
def test_the_number_is_named(run, line, said, capfd):
    with pytest.raises(ModelError) as caught:
        run(parse(MODEL.format(line), "a.mbd"))
    assert said in caught.value.message
    assert caught.value.span.line == 3
    captured = capfd.readouterr()
    assert "On entry to" not in captured.out + captured.err  # LAPACK prints it, bypassing Python's streams


def test_on_the_command_line(tmp_path, capsys):
    model = tmp_path / "a.mbd"
    model.write_text(MODEL.format(BEAM.format("1e300", 1, 1, 1)))
    for command in (["simulate"], ["static"], ["eigen"], ["explain", "--no-time"], ["show", "--stage", "system"]):
        assert main([*command, str(model)]) == 2
        captured = capsys.readouterr().err
        assert captured.startswith(f"{model}:3:16: error: `length` of FlexibleBeam `r` is 1e+300: numbers so large")


def test_other_failures_pass_on_as_they_are():
    @blame_extremes
    def fails(model, problem):
        raise problem

    plain = parse(MODEL.format("Rod r(m = 1 kg, length = 1 m);"))
    for problem in (ValueError("a"), np.linalg.LinAlgError("b"), KeyError("c")):
        with pytest.raises(type(problem)) as caught:
            fails(plain, problem)
        assert caught.value is problem
    large = parse(MODEL.format("Rod r(m = 1e30 kg, length = 1 m);"))
    with pytest.raises(KeyError):
        fails(large, KeyError("c"))
    with pytest.raises(ModelError, match="`m` of Rod `r` is 1e"):
        fails(large, np.linalg.LinAlgError("b"))
    assert simulate(large).status == "done"  # they are not forbidden
