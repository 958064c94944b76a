"""The words of the language by class, and short descriptions of keywords and functions."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from mbdsl.elements import kinds
from mbdsl.lang import modelica_names
from mbdsl.lang.classify import FRAME_TYPES, VALUE_TYPES
from mbdsl.lang.event_functions import ACTIONS
from mbdsl.lang.event_functions import FUNCTIONS as OF_EVENTS
from mbdsl.lang.functions import CONSTANTS, FUNCTIONS
from mbdsl.lang.lexer import KEYWORDS
from mbdsl.lang.quantities import TYPES

#: keyword -> description; `true` and `false` are among the constants
KEYWORD_DOCS: Mapping[str, str] = {
    "model": "Begins a model: `model Name ... end Name;`",
    "spatial": "A model in space: `spatial model Name ... end Name;`",
    "partial": "A partial model can be extended, but not used as it is.",
    "end": "Ends a model, loop or `if`; as an index, the last element: `x[end]`",
    "extends": "Includes the content of another model: `extends Base(L = 2 m);`",
    "import": 'Makes the models of another file available: `import "parts/arm.mbd" as parts;`',
    "as": "Names an import.",
    "parameter": "A value that is set before the simulation: `parameter Mass m = 3 kg;`",
    "constant": "A value that cannot be modified.",
    "input": "A value that the caller of a simulation sets: `input Torque u;`",
    "final": "A value that can be read, but not modified.",
    "each": "The value applies to all elements of an array.",
    "inner": "A component that sub-models see if they declare it as `outer`.",
    "outer": "A component of the enclosing model: `outer Ground ground;`",
    "connector": "A frame that is connected outside of the model: `connector Frame tip;`",
    "public": "Has no effect; accepted as in Modelica.",
    "protected": "Has no effect; accepted as in Modelica.",
    "initial": "`initial equation` begins the section of initial values; `initial()` is true at the start.",
    "equation": "Begins the section of connections: `connect(a, b);`",
    "for": "A loop: `for i in 1:N loop ... end for;`; inside braces, an array: `{i^2 for i in 1:N}`",
    "in": "Precedes the values of a loop variable.",
    "loop": "Begins the content of a loop.",
    "if": "A choice: `if a then b else c`; after a declaration, its condition.",
    "then": "Precedes the value or content for a true condition.",
    "elseif": "A further condition of an `if`.",
    "else": "The value or content if no condition is true.",
    "when": "Equations of an event: `when ball.y < 0 m then reinit(ball.vy, -0.8*ball.vy); end when;`",
    "elsewhen": "A further condition of a `when`, which counts if those before it do not become true.",
    "discrete": "A value that changes at events only: `discrete Real n(start = 0);`",
    "connect": "Joins two frames: `connect(spring.frame_a, rod.b);`",
    "annotation": "Settings of a simulation, `annotation(experiment(StopTime = 2 s));`, or shapes of a body.",
    "and": "True if both conditions are true.",
    "or": "True if one of the conditions is true.",
    "not": "True if the condition is false.",
    "guess": "An initial value that the assembly of the mechanism may change: `guess rod.phi = 10 deg;`",
    "fixed": "An initial value that is kept exactly; the default.",
}
#: function -> (arguments, description)
FUNCTION_DOCS: Mapping[str, tuple[str, str]] = {
    "sin": ("x", "sine of an angle or pure number"),
    "cos": ("x", "cosine of an angle or pure number"),
    "tan": ("x", "tangent of an angle or pure number"),
    "asin": ("x", "inverse sine, between -pi/2 and pi/2"),
    "acos": ("x", "inverse cosine, between 0 and pi"),
    "atan": ("x", "inverse tangent, between -pi/2 and pi/2"),
    "atan2": ("y, x", "angle of the vector (x, y), between -pi and pi"),
    "sinh": ("x", "hyperbolic sine"),
    "cosh": ("x", "hyperbolic cosine"),
    "tanh": ("x", "hyperbolic tangent"),
    "exp": ("x", "exponential function"),
    "log": ("x", "natural logarithm"),
    "ln": ("x", "natural logarithm"),
    "log10": ("x", "logarithm to the base 10"),
    "sqrt": ("x", "square root; the unit is halved: m2 to m"),
    "abs": ("x", "absolute value"),
    "sign": ("x", "-1, 0 or 1"),
    "min": ("a, b, ...", "smallest of several values, or of an array"),
    "max": ("a, b, ...", "largest of several values, or of an array"),
    "floor": ("x", "largest whole number that is not above x"),
    "ceil": ("x", "smallest whole number that is not below x"),
    "integer": ("x", "largest whole number that is not above x, as Integer"),
    "mod": ("x, y", "remainder of x/y, with the sign of y"),
    "div": ("x, y", "x/y without its fraction"),
    "hypot": ("x, y", "length of the vector (x, y)"),
    "sum": ("array", "sum of the elements"),
    "product": ("array", "product of the elements"),
    "size": ("array, k", "number of elements along dimension k; without k, of all dimensions"),
    "fill": ("value, n, ...", "array of equal values"),
    "zeros": ("n, ...", "array of zeros"),
    "ones": ("n, ...", "array of ones"),
    "linspace": ("first, last, n", "n values at equal distances"),
    "der": ("x", "time derivative of a state, a position or an angle"),
    "assert": ("condition, text", "ends the run with this text, if the condition is or becomes false"),
    "noEvent": ("x", "x, at whose jumps and corners no events are located"),
    "smooth": ("n, x", "x, which has n continuous derivatives; if n >= 1, no events are located in it"),
    "sample": ("start, period", "true at start + k period, k = 0, 1, ..., as condition of a `when`"),
    "pre": ("x", "the value of a discrete variable before the event"),
    "edge": ("b", "whether a discrete Boolean becomes true: b and not pre(b)"),
    "change": ("x", "whether a discrete variable changes: x <> pre(x)"),
    "terminal": ("", "true at the end of a run only"),
    "reinit": ("x, value", "in a `when`: a jump of a state, or of a velocity by an impulse along it"),
    "terminate": ("text", "in a `when`: ends the run, with exit code 0"),
    **{
        f"from_{name}": ("x", f"the number x in {unit}, as a quantity")
        for name, unit in modelica_names.CONVERSIONS.items()
    },
    **{f"to_{name}": ("x", f"a quantity as a number in {unit}") for name, unit in modelica_names.CONVERSIONS.items()},
}
CONSTANT_DOCS: Mapping[str, str] = {
    "pi": "3.14159..., the ratio of circumference and diameter",
    "e": "2.71828..., the base of the natural logarithm",
    "time": "The simulated time [s]",
    "true": "A condition that holds",
    "false": "A condition that does not hold",
}


@cache
def words() -> dict[str, tuple[str, ...]]:
    """Class -> its words: "keyword", "kind", "type", "function" and "constant"; a word is in one class."""
    named_kinds = {*kinds(), *kinds(spatial=True), *modelica_names.KINDS}
    constants = {name for name in CONSTANTS if "." not in name} | {"time", "true", "false"}
    classes = {
        "keyword": {*KEYWORDS, "guess", "fixed", "spatial"} - constants,
        "kind": named_kinds,
        "type": {*VALUE_TYPES[1:], *FRAME_TYPES, "Table", *TYPES} - named_kinds,
        "function": {*FUNCTIONS, *OF_EVENTS, *ACTIONS, "der"} - {"initial"},
        "constant": constants,
    }
    return {name: tuple(sorted(found)) for name, found in classes.items()}


@cache
def class_of(word: str) -> str:
    """The class of a word; "" for other words."""
    return next((name for name, found in words().items() if word in found), "")
