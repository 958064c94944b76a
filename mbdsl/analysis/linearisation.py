"""Linear state-space models: x' = A x + B u, y = C x + D u, about a state of a mechanism.

The equations of motion, linearised as in :mod:`mbdsl.analysis.eigenmodes` and in its notation, with forces Q_u du of
the inputs:

    M da + D dv + (K + (M a)_q) dq + U dlam = Q_u du,   dq = Z y,   dv = Z y' + W y,   y' = T s + S y

The states are the coordinates y and the speeds s. Reactions dlam follow from the first equation. All derivatives are
exact at rest; about a motion, the rates of W, T and S are differences along the motion, as in ``eigen``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from typing import TYPE_CHECKING, Any
from warnings import warn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mbdsl.analysis import linear_responses, operating_points
from mbdsl.analysis.eigenmodes import LARGEST_MOVING
from mbdsl.analysis.excitations import DRIVER, INPUT, RATE, Excitation, columns, read
from mbdsl.analysis.linear_equations import IN_SPACE, LinearEquations
from mbdsl.analysis.linear_responses import FrequencyResponse, StepResponse
from mbdsl.analysis.operating_points import OperatingPoint, about
from mbdsl.errors import UsageError
from mbdsl.expressions.symbolic import leaves
from mbdsl.lang.asked_signals import AskedSignals
from mbdsl.lang.model_argument import as_scene, blame_model
from mbdsl.mechanism.scene import Scene
from mbdsl.mechanism.signal_names import ACCELERATIONS
from mbdsl.messages import did_you_mean
from mbdsl.numerics.saddle_point import Array
from mbdsl.system import System
from mbdsl.system.signals import values

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder


@dataclass(eq=False)
class Linearisation:
    """A linear model x' = A x + B u, y = C x + D u of deviations from a state; in SI units.

    It unpacks into its matrices: ``scipy.signal.StateSpace(*linear)``, ``control.ss(*linear)``.

    Attributes
    ----------
    system : System
        The equations of motion of the model as written.
    at : str
        State of the linearisation: "static", "start" or "t = 1.5 s".
    t : float [s]
        Time of the state.
    q, v : (n,) [m, rad; m/s, rad/s]
        Coordinates and velocities of the state.
    A, B, C, D : (r, r), (r, i), (o, r), (o, i)
        The matrices.
    states, inputs, outputs : list of str
        Names: of coordinates, then speeds; of inputs; of signals.
    state_units, input_units, output_units : list of str
        Their SI units; "" for pure numbers.
    x0, u0, y0 : (r,), (i,), (o,)
        Values of states, inputs and outputs at the state, of which x, u and y are the deviations. Coordinates of
        flexible bodies, which are not signals, have nan.
    notes : list of str
        Remarks, such as that the state is not an equilibrium.
    """

    system: System
    at: str
    t: float
    q: Array
    v: Array
    A: Array
    B: Array
    C: Array
    D: Array
    states: list[str]
    inputs: list[str]
    outputs: list[str]
    state_units: list[str]
    input_units: list[str]
    output_units: list[str]
    x0: Array
    u0: Array
    y0: Array
    notes: list[str]

    def __iter__(self) -> Iterator[Array]:
        return iter((self.A, self.B, self.C, self.D))

    @property
    def scene(self) -> Scene:
        """The model."""
        return self.system.scene

    def poles(self) -> NDArray[np.complex128]:
        """Return the eigenvalues of A.

        Returns
        -------
        (r,) array of complex [1/s]
            The slowest first; about an equilibrium, those of ``mbdsl.eigen`` with their conjugates.
        """
        return linear_responses.poles(self)

    def step_response(self, t: ArrayLike | None = None) -> StepResponse:
        """Return the response to a unit step of each input at t = 0, exactly at the given times.

        Parameters
        ----------
        t : (N,) array, optional [s]
            Ascending times from 0 on. Default: 501 times, until the slowest pole has settled.

        Returns
        -------
        StepResponse
            Times ``t`` (N,) and deviations ``y`` (N, o, i) of the outputs from ``y0``.

        Raises
        ------
        UsageError
            If the times do not ascend.
        """
        return linear_responses.step_response(self, t)

    def bode(self, f: ArrayLike | None = None) -> FrequencyResponse:
        """Return the frequency response C (j w I - A)^{-1} B + D, w = 2 pi f.

        Parameters
        ----------
        f : (N,) array, optional [Hz]
            Default: 501 frequencies, from far below the slowest to far above the fastest pole.

        Returns
        -------
        FrequencyResponse
            Frequencies ``f`` (N,) [Hz], ``amplitude`` and ``phase`` [rad], of shape (N, o, i) each.

        Raises
        ------
        UsageError
            If a frequency is negative, or that of an undamped pole.
        """
        return linear_responses.bode(self, f)

    def to_control(self) -> Any:
        """Return the model for python-control, with names in which ``_`` stands for ``.``.

        Returns
        -------
        control.StateSpace

        Raises
        ------
        UsageError
            If python-control is not installed.
        """
        return linear_responses.to_control(self, self.scene.name)

    def to_dict(self) -> dict[str, object]:
        """Return all content but the equations as arrays, lists and numbers.

        Returns
        -------
        dict
            The matrices, the names, units and values of states, inputs and outputs, the state and the notes.
        """
        found: dict[str, object] = {"model": self.scene.name, "at": self.at, "t": self.t}
        for name in ("A", "B", "C", "D", "states", "inputs", "outputs"):
            found[name] = getattr(self, name)
        for name in ("state_units", "input_units", "output_units", "x0", "u0", "y0", "notes"):
            found[name] = getattr(self, name)
        return found

    def __repr__(self) -> str:
        sizes = f"{len(self.states)} states, {len(self.inputs)} inputs, {len(self.outputs)} outputs"
        return f"<linear model of {self.scene.name} about {self.at}: {sizes}>"

    def __str__(self) -> str:
        from mbdsl.analysis.linear_tables import listed, matrix_rows

        lines = [f"{self.scene.name}: x' = A x + B u, y = C x + D u about its {about(self.at, self.t)}"]
        lines += listed("x", self.states, self.state_units, self.x0)
        lines += listed("u", self.inputs, self.input_units, self.u0)
        lines += listed("y", self.outputs, self.output_units, self.y0)
        rates = [f"{name}'" for name in self.states]
        lines += matrix_rows("A", self.A, rates, self.states) + matrix_rows("B", self.B, rates, self.inputs)
        lines += matrix_rows("C", self.C, self.outputs, self.states)
        lines += matrix_rows("D", self.D, self.outputs, self.inputs)
        return "\n".join([*lines, *(f"note: {note}" for note in self.notes)])

    def _repr_html_(self) -> str:
        from mbdsl.plotting.html_tables import preformatted

        return preformatted(str(self))


@blame_model
def linearise(
    model: Scene | Builder | str | PathLike,
    at: str | float | Mapping[str, Any] = "static",
    inputs: Sequence[str] | None = None,
    signals: str | Sequence[str] | None = None,
    *,
    without: Sequence[str] = (),
    parameters: Mapping[str, str | float] | None = None,
    announce: Callable[[str], None] | None = None,
    outputs: str | Sequence[str] | None = None,
) -> Linearisation:
    """Compute a linear state-space model about a state, in minimal coordinates.

    Parameters
    ----------
    model : Scene, Builder or path
        The mechanism. Its inputs have their start values.
    at : str, float or mapping, optional
        "static": the equilibrium that ``mbdsl.static`` finds. "start": the initial state with its velocities, such as
        an upright pose. A time [s]: the state at that time of a simulation with the model's settings. A mapping such as
        ``{"pin.phi": "80 deg"}``: the initial state with these values, as with ``initial`` of ``mbdsl.simulate``.
    inputs : sequence of str, optional
        Names of inputs of the model that act by forces, or of force elements for an additional force. Default: all
        inputs of the model.
    signals : str or sequence of str, optional
        The outputs: names and patterns of signals, also reactions and accelerations. Default: the states.
    without, parameters, announce : optional
        As for ``mbdsl.simulate``.
    outputs : optional
        The former name of ``signals``.

    Returns
    -------
    Linearisation

    Raises
    ------
    ModelError, UsageError
        If the model or the arguments are invalid.
    EquilibriumError, InitialisationError, IntegrationError
        If the state is not found.
    """
    if outputs is not None:
        warn("`outputs` of linearise is called `signals` now, as in other functions", DeprecationWarning, stacklevel=2)
        signals = outputs
    scene = as_scene(model, parameters, without)
    _inputs(scene, inputs)
    if signals is not None:
        outputs_of(scene, AskedSignals(scene), signals)
    return linearised(operating_points.find(scene, at, (), None, announce), inputs, signals)


def linearised(
    point: OperatingPoint, inputs: Sequence[str] | None = None, signals: str | Sequence[str] | None = None
) -> Linearisation:
    """The linear model about a state; see :func:`linearise`."""
    system, t, q, v = point.system, point.t, point.q, point.v
    chosen, known = _inputs(system.scene, inputs), AskedSignals(system.scene)
    wanted = None if signals is None else outputs_of(system.scene, known, signals)
    equations = equations_of(point, chosen)
    states = [*equations.coordinates, *equations.speeds]
    names = [x.name for x in states]
    C, D, y0 = np.eye(len(names)), np.zeros((3, len(names), len(chosen))), _values(known, point, names)
    x0 = y0
    if wanted is not None:
        C, D, y0 = equations.outputs(known, wanted)
    units = [x.unit for x in states]
    return Linearisation(
        *(system, point.at, t, q, v, equations.A, equations.B[0], C, D[0]),
        *(names, [e.name for e in chosen], list(names if wanted is None else wanted)),
        *(units, [e.unit for e in chosen]),
        units if wanted is None else [known.unit(name) for name in wanted],
        *(x0, np.array([system.scene.inputs[e.name].start if e.sort == INPUT else 0.0 for e in chosen]), y0),
        point.notes + point.warning("matrices"),
    )


def equations_of(point: OperatingPoint, chosen: Sequence[Excitation]) -> LinearEquations:
    """The linearised equations about a state with these excitations.

    Raises
    ------
    UsageError
        If the system is too large, or an excitation is impossible.
    """
    system = point.system
    if system.unknowns > LARGEST_MOVING:
        raise UsageError(
            f"a linear model needs dense matrices: {system.unknowns} unknowns are too many",
            hint=f"up to {LARGEST_MOVING}; `mbdsl eigen` finds the lowest modes of large models",
        )
    return LinearEquations(point, chosen, columns(system, chosen, point.t, point.q, point.v, point.lam))


def _inputs(scene: Scene, names: Sequence[str] | None) -> list[Excitation]:
    """The inputs of a model with one matrix B: those that act by forces."""
    found = read(scene, names, drivers=False)
    for e in found:
        if e.sort in (DRIVER, RATE):
            raise UsageError(
                f"`{e.name}` acts by its rates as well, and x' = A x + B u has none",
                hint="`mbdsl response` takes drivers as inputs",
            )
        for c in scene.components.values():
            if any(leaf.op == "input" and leaf.value == e.name for leaf in leaves(*c.velocity_constraints)):
                raise UsageError(
                    f"the input `{e.name}` prescribes a velocity in `{c.name}`, which jumps with it",
                    hint="inputs of a linear model act by forces: choose them with `--inputs`, in Python `inputs`; "
                    "`mbdsl response` takes this input",
                )
    return found


def outputs_of(scene: Scene, known: AskedSignals, patterns: str | Sequence[str]) -> list[str]:
    """The signals that patterns select; only those with exact derivatives."""
    found = known.select(patterns)
    for name in found:
        if name not in known.formulas and (entry := known.entry(name)) is not None and not known.computed_in(entry[0]):
            known.formulas.entries[name] = entry
        owner, _, key = name.rpartition(".")
        rigid = key in (IN_SPACE if scene.spatial else ACCELERATIONS) and owner not in known.flexible
        if name not in known.formulas and not (name in known.computed and rigid):
            hint = did_you_mean(name, known.formulas) or "positions, velocities, forces, reactions, accelerations"
            if name in known.sections:
                hint = "forces in sections are those of a run; reactions of joints, such as `pin.fx`, can be outputs"
            raise UsageError(f"`{name}` cannot be an output of a linear model", hint=hint)
    return found


def _values(known: AskedSignals, point: OperatingPoint, names: Sequence[str]) -> Array:
    """Values of signals at a state; nan for other names."""
    roots = {name: known.formulas[name][0] for name in names if name in known.formulas}
    state = np.array([point.t]), point.q[None], point.v[None], point.lam[None]
    found = dict(zip(roots, values(point.system, [*roots.values()], *state), strict=True))
    return np.array([float(found[name][0]) if name in found else np.nan for name in names])
