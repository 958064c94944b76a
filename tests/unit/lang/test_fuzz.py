"""Every text gives a Scene or an MbdslError, and no other exception; a hang shows as a test that does not end."""

# ruff: noqa: E501  models in one line

import os
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from mbdsl.errors import MbdslError
from mbdsl.lang.load import load, parse_text
from mbdsl.lang.parser import parse_expression
from mbdsl.mechanism.scene import Scene

ROOT = Path(__file__).parents[3]
VALID = [p.read_text(encoding="utf-8") for p in sorted((ROOT / "models").glob("*.mbd"))]
VALID += [p.read_text(encoding="utf-8") for p in sorted((ROOT / "tests/data/wrong").glob("[a-m]*.mbd"))]
MANY = int(os.environ.get("MBDSL_FUZZ", "1"))  #: a longer search: MBDSL_FUZZ=50 pytest tests/unit/lang/test_fuzz.py
relaxed = settings(
    max_examples=150 * MANY, deadline=None, derandomize=MANY == 1, suppress_health_check=list(HealthCheck)
)

TOKENS = (
    "model end for in loop if then else elseif parameter constant Real Integer Boolean String Mass Frame Ground Body "
    "Rod Revolute SpringDamper Torque Table extends import connect equation initial annotation experiment each final "
    "inner outer connector partial guess fixed true false and or not M A x y k N i ground rod J m length phi s v tau "
    "force frame_a a b c time noEvent assert when n r FixedTranslation BodyBox Modelica.Math.sin Joints.Revolute "
    "der sin sqrt size fill sum 1 2 0 3 -1 1e9 0.3 kg m/s2 deg N.m ( ) [ ] { } ; , . : = == "
    '<> < > + - * / ^ "text" "other.mbd" // /* */'
).split()


def outcome(text: str) -> None:
    try:
        assert isinstance(parse_text(text), Scene)
    except MbdslError as problem:
        problem.render()


@relaxed
@given(st.lists(st.sampled_from(TOKENS), max_size=60), st.booleans())
def test_token_soup(tokens, inside):
    text = " ".join(tokens)
    outcome(f"model M Ground ground; Rod rod(m = 1, length = 1); {text} end M;" if inside else text)


@relaxed
@given(st.text(max_size=200))
def test_any_text(text):
    outcome(text)
    outcome(f"model M {text} end M;")


@relaxed
@given(content=st.binary(max_size=200))
def test_any_bytes(content, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "bytes.mbd"
    path.write_bytes(content)
    try:
        load(path)
    except MbdslError as problem:
        problem.render()


@settings(max_examples=400 * MANY, deadline=None, derandomize=MANY == 1, suppress_health_check=list(HealthCheck))
@given(st.data())
def test_mutated_models(data):
    text = data.draw(st.sampled_from(VALID))
    words = text.split(" ")
    for _ in range(data.draw(st.integers(1, 4))):
        i = data.draw(st.integers(0, len(words) - 1))
        j = data.draw(st.integers(0, len(words) - 1))
        match data.draw(st.sampled_from(["drop", "swap", "double", "replace", "cut", "char"])):
            case "drop":
                del words[i]
            case "swap":
                words[i], words[j] = words[j], words[i]
            case "double":
                words.insert(i, words[j])
            case "replace":
                words[i] = data.draw(st.sampled_from(TOKENS))
            case "cut":
                words = words[: max(1, i)]
            case "char":
                words[i] = words[i][::-1]
        words = words or [""]
    outcome(" ".join(words))


EXPRESSIONS = st.recursive(
    st.sampled_from(
        ["1", "2 m", "0", "x", "k", "time", "true", "rod.phi", "J.w", "{1, 2}", "v[1]", '"t"', "1e300", "pi"]
    ),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+ - * / ^ < == and or".split()), inner).map(
            lambda t: "(" + " ".join(t) + ")"
        ),
        inner.map(lambda e: f"({e})"),
        inner.map(lambda e: f"(-({e}))"),
        st.tuples(st.sampled_from("sin sqrt log exp abs max sum size der floor".split()), inner).map(
            lambda t: f"{t[0]}({t[1]})"
        ),
        st.tuples(inner, inner, inner).map(lambda t: f"(if {t[0]} then {t[1]} else {t[2]})"),
        st.tuples(inner, inner).map(lambda t: f"{{{t[0]} for i in ({t[1]}):3}}"),
    ),
    max_leaves=12,
)


@relaxed
@given(EXPRESSIONS, EXPRESSIONS)
def test_expressions(first, second):
    parse_expression(first)
    parse_expression(second)
    outcome(
        f"model M Ground ground; parameter x = {first}; parameter Real k = 2; parameter Real v[2] = {{1, 2}}; "
        f"Rod rod(m = 1, length = 1); Revolute J(ground, rod.a); Torque t(J, tau = {second}); end M;"
    )


#: texts that would run forever, or exhaust the memory, without limits
BOMBS = {
    "brackets": "model M parameter x = " + "(" * 100_000,
    "minus signs": "model M parameter x = " + "-" * 100_000 + "1; Ground g; end M;",
    "not": "model M parameter x = " + "not " * 50_000 + "true; Ground g; end M;",
    "powers": "model M parameter x = " + "^".join(["2"] * 20_000) + "; Ground g; end M;",
    "nested if": "model M parameter x = " + "if true then 1 else " * 20_000 + "2; Ground g; end M;",
    "long sum": "model M parameter x = " + "+".join(["1"] * 60_000) + "; Ground g; end M;",
    "long sum of signals": "model M Ground g; Rod r(m=1,length=1); Revolute J(g, r.a); Torque t(J, tau = "
    + "+".join(["J.phi"] * 20_000) + "); end M;",
    "nested loops": "model M Ground g; " + "for i in 1:100 loop " * 50 + "Rod r[1](m = 1); " + "end for; " * 50 + "end M;",
    "loops of nothing": "model M Ground g; equation " + "".join(f"for i{k} in 1:1000 loop " for k in range(5))
    + "end for; " * 5 + "end M;",
    "squares": "model M parameter Integer a0 = 9; "
    + "".join(f"parameter Integer a{i + 1} = a{i}*a{i}; " for i in range(60)) + "Ground g; end M;",
    "tower": "model M parameter x = 9^9^9^9^9; Ground g; end M;",
    "digits": "model M parameter x = " + "9" * 100_000 + "; Ground g; end M;",
    "fill of fill": "model M parameter x = sum(fill(fill(1, 250000), 250000)); Ground g; end M;",
    "many fills": "model M parameter x = size({" + ",".join(["zeros(250000)"] * 500) + "}, 1); Ground g; end M;",
    "comprehension": "model M parameter x = {{{{1 for a in 1:1000} for b in 1:1000} for c in 1:1000} for d in 1:1000}; "
    "Ground g; end M;",
    "chain of parameters": "model M parameter p0 = 1; "
    + "".join(f"parameter p{i + 1} = p{i} + 1; " for i in range(3000)) + "parameter q = p3000; Ground g; end M;",
    "backward chain": "model M " + "".join(f"parameter p{i} = p{i + 1} + 1; " for i in range(3000)) + "Ground g; end M;",
    "empty models": "model E0 end E0; "
    + "".join(f"model E{i + 1} E{i} e[100]; end E{i + 1}; " for i in range(10)) + "model M E10 e; Ground g; end M;",
    "bases": "model E0 parameter x = 1; end E0; "
    + "".join(f"model E{i + 1} extends E{i}; extends E{i}; end E{i + 1}; " for i in range(30))
    + "model M extends E30; Ground g; end M;",
    "chain of bases": "model E0 parameter x = 1; end E0; "
    + "".join(f"model E{i + 1} extends E{i}(x = {i}); end E{i + 1}; " for i in range(300))
    + "model M extends E300; Ground g; end M;",
    "sub-models": "".join(f"model E{i} E{i + 1} a; E{i + 1} b; end E{i}; " for i in range(39)) + "model E39 end E39; "
    "model M E0 e; Ground g; end M;",
    "comment": "/* " * 50_000,
    "blanks": " " * 900_000,
    "text": '"' * 100_001,
    "dots": "model M parameter x = " + "a." * 50_000 + "a; Ground g; end M;",
    "indices": "model M parameter x = " + "a[" * 90 + "1" + "]" * 90 + "; Ground g; end M;",
    "annotation": "model M annotation(" + "a(" * 90 + ")" * 90 + "); Ground g; end M;",
    "units": "model M parameter x = 1 " + ".".join(["m"] * 50_000) + "; Ground g; end M;",
    "unit brackets": "model M parameter x = 1 m/" + "(" * 90 + "m" + ")" * 90 + "; Ground g; end M;",
    "huge": "x" * 1_000_001,
    "modifiers": "model M Ground g; Rod r(" + ", ".join(f"m{i} = 1" for i in range(20_000)) + "); end M;",
    "connects": "model M Ground g; Rod r(m=1,length=1); Revolute J; equation " + "connect(J.frame_a, g); " * 20_000 + "end M;",
    "mbdyn": "/*" + "a" * 20_000 + "*/ " * 50 + "set" * 1000,
}  # fmt: skip


@pytest.mark.parametrize("name", BOMBS)
def test_bombs(name):
    outcome(BOMBS[name])
