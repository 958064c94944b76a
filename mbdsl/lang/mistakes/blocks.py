"""Blocks and shafts of Modelica's libraries for control: the variables, states and events that do the same here."""

from __future__ import annotations

from collections.abc import Callable

from mbdsl.elements import find
from mbdsl.lang import syntax as s
from mbdsl.lang.mistakes.frames import Ends, Given
from mbdsl.lang.mistakes.names import with_unit
from mbdsl.lang.unparse import inner, write

EXPRESSION = "there are no blocks: write the expression where its value is used, as in `tau = 3 N.m*sin(2*time)`"
#: signals of blocks have no units
_NUMBERS = (
    "; as in blocks, these are numbers: measured values are divided by a unit, `pin.w/(1 rad/s)`, and results are "
)
_NUMBERS += "multiplied by one, `tau = 1 N.m*y`"
_SECTION = "in the equation section"


def _value(given: Given, name: str, unit: str, default: str) -> str:
    """A value as a factor or divisor; a number has its unit."""
    if (e := given.get(name)) is None:
        return default
    bare = isinstance(e, s.Number) and e.unit is None
    return f"({write(e)} {unit})" if bare and unit else inner(e)


def _times(gain: str, text: str) -> str:
    return text if gain in ("1", "1.0") else f"{gain}*{text}"


def _steady(name: str, given: Given) -> str:
    """What starts a state in equilibrium, if that is asked for."""
    initial = given.get("initType")
    steady = initial is not None and write(initial).endswith("SteadyState")
    return f", and `der({name}) = 0;` under `initial equation`" if steady else ""


def _integrator(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    rate = _times(_value(given, "k", "", "1"), "u") + "/(1 s)"
    start = _value(given, "y_start", "", "0")
    made = f"an integrator is a state: `Real {name}(start = {start});`, and `der({name}) = {rate};` {_SECTION}"
    return f"{made}, with its input u{_steady(name, given)}{_NUMBERS}"


def _first_order(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    k, T = _value(given, "k", "", "1"), _value(given, "T", "s", "T")
    made = f"a filter is a state: `Real {name}(start = 0);`, and `der({name}) = ({_times(k, 'u')} - {name})/{T};`"
    return f"{made} {_SECTION}{_steady(name, given)}{_NUMBERS}"


def _derivative(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    T = _value(given, "T", "s", "T")
    made = (
        f"the derivative of a position or an angle is its velocity, as `pin.w`; that of other signals is `der({name})`"
    )
    return f"{made} of a state that follows them: `Real {name}(start = 0);`, and `der({name}) = (u - {name})/{T};`"


def _controller(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    """P, PI, PD and PID, with limits of the output and anti-windup if these are given."""
    written = given.get("controllerType")
    kind = write(written).rpartition(".")[2] if written is not None else "PID"
    k, limit = _value(given, "k", "", "1"), _value(given, "yMax", "", "")
    Ti, Td = _value(given, "Ti", "s", _value(given, "T", "s", "Ti")), _value(given, "Td", "s", "Td")
    parts = [f"{name}_e", *([f"{name}_x"] if "I" in kind else []), *([f"{Td}*der({name}_d)"] if "D" in kind else [])]
    output = _times(k, f"({' + '.join(parts)})" if len(parts) > 1 else parts[0])
    low = _value(given, "yMin", "", f"-{limit}")
    limited = f", {name}_y = max({low}, min({limit}, {name}_ask))" if limit else ""
    windup = f" + ({name}_y - {name}_ask)/({k}*{_value(given, 'Ni', '', '0.9')})" if limit else ""
    equations = []
    if "I" in kind:
        total = f"({name}_e{windup})" if windup else f"{name}_e"
        equations.append(f"`der({name}_x) = {total}/{Ti};`")
    if "D" in kind:
        equations.append(f"`der({name}_d) = ({name}_e - {name}_d)/({Td}/{_value(given, 'Nd', '', '10')});`")
    states = "".join(f", {name}_{x}(start = 0)" for x, part in (("x", "I"), ("d", "D")) if part in kind)
    made = f"a controller is variables and states: `Real {name}_e = ... - ...{states}, {name}_ask = {output}{limited};`"
    rules = f", and {' '.join(equations)} {_SECTION}" if equations else ""
    return f"{made}{rules}{_steady(name + '_x', given) if 'I' in kind else ''}{_NUMBERS}"


def _pi(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    k, T = _value(given, "k", "", "1"), _value(given, "T", "s", "T")
    made = (
        f"a controller is a state and a variable: `Real {name}_x(start = 0), {name} = {_times(k, f'(u + {name}_x)')};`"
    )
    return f"{made}, and `der({name}_x) = u/{T};` {_SECTION}{_steady(name + '_x', given)}{_NUMBERS}"


def _sampled(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    start, period = _value(given, "startTime", "s", "0 s").strip("()"), _value(given, "samplePeriod", "s", "1 ms")
    y = f"discrete Real {name}(start = {_value(given, 'y_start', '', '0')})"
    return f"write `{y};`, and `when sample({start}, {period.strip('()')}) then {name} = u; end when;` {_SECTION}"


def _unit_delay(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    start = _value(given, "y_start", "", "0")
    made = _sampled(name, given, ends, spatial).replace(";`, and", f", {name}_u(start = {start});`, and", 1)
    return made.replace(f"{name} = u;", f"{name} = pre({name}_u); {name}_u = u;")


def _hysteresis(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    low, high = _value(given, "uLow", "", "low"), _value(given, "uHigh", "", "high")
    start = _value(given, "pre_y_start", "", "false")
    return (
        f"write `Boolean {name}(start = {start});`, and `when u > {high} then {name} = true; elsewhen u < {low} then "
        f"{name} = false; end when;` {_SECTION}"
    )


def _on_off(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    half, start = f"{_value(given, 'bandwidth', '', 'band')}/2", _value(given, "pre_y_start", "", "false")
    return (
        f"write `Boolean {name}(start = {start});`, and `when u < reference - {half} then {name} = true; elsewhen "
        f"u > reference + {half} then {name} = false; end when;` {_SECTION}"
    )


def _limiter(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    high = _value(given, "uMax", "", "high")
    return f"write `max({_value(given, 'uMin', '', f'-{high}')}, min({high}, u))` where its value is used"


def _point_to_point(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    def of(key: str, example: str) -> str:
        e = given.get(key)
        return example if e is None else inner(e.items[0] if isinstance(e, s.ArrayNode) and e.items else e)

    start = _value(given, "startTime", "s", "0 s").strip("()")
    v, a = of("qd_max", "v"), of("qdd_max", "a")
    times = f"t1 = {start}, t2 = t1 + {v}/{a}*(1 s), t3 = t1 + {of('deltaq', 'd')}/{v}*(1 s), t4 = t3 + t2 - t1"
    law = "if time < t1 then 0 else if time < t2 then 1 else if time < t3 then 0 else if time < t4 then -1 else 0"
    return f"write a law of time, `parameter Time {times};` and `Real {name} = {_times(a, f'({law})')};`, if t3 > t2"


def _inertia(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    body = find("Body", spatial=spatial)
    J = with_unit(body, "I", given["J"]) if "J" in given else "... kg.m2"
    J = f"{{{J}, {J}, {J}}}" if spatial else J
    shaft = f"{name}_shaft"
    return (
        f"a rotor is a Body on a Revolute: `Body {name}(m = 1 kg, I = {J}); Revolute {shaft}(ground, {name}.c);`, with "
        f"`{shaft}.phi` and `{shaft}.w`; elements between two shafts take the frames of bodies, `{name}.c`; fixed "
        "starts are initial equations, for `a = 0` of the positions in which the forces balance"
    )


def _constant_torque(name: str, given: Given, ends: Ends, spatial: bool) -> str:
    law = with_unit(find("Torque"), "tau", given["tau_constant"]) if "tau_constant" in given else "..."
    return f"write `Torque {name}(shaft, tau = {law});` on the Revolute of the shaft, a law of time and signals"


#: end of a name -> what to write instead
MADE: dict[str, Callable[[str, Given, Ends, bool], str]] = {
    "Integrator": _integrator,
    "LimIntegrator": _integrator,
    "FirstOrder": _first_order,
    "Derivative": _derivative,
    "LimPID": _controller,
    "Continuous.PID": _controller,
    "Continuous.PI": _pi,
    "Limiter": _limiter,
    "Hysteresis": _hysteresis,
    "OnOffController": _on_off,
    **dict.fromkeys(("ZeroOrderHold", "Discrete.Sampler"), _sampled),
    "UnitDelay": _unit_delay,
    "KinematicPTP": _point_to_point,
    "KinematicPTP2": _point_to_point,
    "Rotational.Components.Inertia": _inertia,
    "Inertia": _inertia,
    "ConstantTorque": _constant_torque,
    "Rotational.Sources.Torque": _constant_torque,
}
#: a part of a name -> what to write instead
TEXTS = {
    "Blocks.Interfaces": "an input is declared `input Real u;`, an output `Real y = ...;`",
    "Blocks.Sources": EXPRESSION,
    "Blocks.Discrete": "write `discrete Real y;`, and `when sample(0 s, 1 ms) then y = u; end when;` in the equation "
    "section; `pre(y)` is the value of the sample before",
    "Switch": "write `(if condition then a else b)` where its value is used",
    "RSFlipFlop": "write `Boolean on(start = false);`, and `when set then on = true; elsewhen reset then on = false; "
    "end when;` in the equation section",
    "DeadZone": "write `(u - max(-width, min(width, u)))` where its value is used",
    "Blocks.Continuous": "there are no blocks: one with a memory is states, `Real x[2];`, whose derivatives are given "
    "in the equation section, `der(x) = {x[2], u - x[1]}/(1 s);`",
    "Blocks": EXPRESSION,
}
