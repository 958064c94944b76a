"""The inputs of a model, which the caller of a ``Simulation`` sets between steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, MutableMapping, Sequence
from math import isfinite

from mbdsl.errors import UsageError
from mbdsl.mechanism.scene import Scene


class Inputs(MutableMapping[str, float]):
    """The inputs of a model by name, in SI units; a change takes effect in the next step.

    ``inputs["u"] = 2.0`` sets an input, and so does ``inputs.u = 2.0`` if ``u`` is no attribute of this class.

    Parameters
    ----------
    scene : Scene
        The model.
    """

    def __init__(self, scene: Scene) -> None:
        self._scene = scene
        self._index = {name: k for k, name in enumerate(scene.inputs)}
        self._numbers = [x.start for x in scene.inputs.values()]
        self._changed = False

    def __getattr__(self, name: str) -> float:
        if name.startswith("_") or name not in self._index:
            raise AttributeError(str(self._unknown(name)) if not name.startswith("_") else name)
        return self[name]

    def __setattr__(self, name: str, value: float) -> None:
        if name in _OWN:
            object.__setattr__(self, name, value)
        elif hasattr(Inputs, name):
            raise UsageError(f"`inputs.{name}` is no input", hint=f'an input of this name is set by `inputs["{name}"]`')
        else:
            self[name] = value

    def __getitem__(self, name: str) -> float:
        if name not in self._index:
            raise self._unknown(name)
        return self._numbers[self._index[name]]

    def __setitem__(self, name: str, value: float) -> None:
        if name not in self._index:
            raise self._unknown(name)
        number = _number(name, value)
        k = self._index[name]
        if number != self._numbers[k]:
            self._numbers[k], self._changed = number, True

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return tuple(self._index)

    def __delitem__(self, name: str) -> None:
        raise UsageError("inputs of a model cannot be removed")

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __len__(self) -> int:
        return len(self.names)

    def __repr__(self) -> str:
        return f"<inputs of {self._scene.name}: {dict(self)}>"

    def writer(self, names: Sequence[str]) -> Callable[[Sequence[float]], None]:
        """Return a function that sets several inputs to the values of a sequence.

        Parameters
        ----------
        names : sequence of str
            Names of inputs.

        Returns
        -------
        callable
            A function of a sequence of values (k,) in SI units.

        Raises
        ------
        UsageError
            If there is no such input, or one is named twice.
        """
        for name in names:
            if name not in self._index:
                raise self._unknown(name)
        if len(set(names)) < len(names):
            raise UsageError(f"an input is named twice: {', '.join(names)}")
        places = [self._index[name] for name in names]

        def write(values: Sequence[float]) -> None:
            given = [float(x) for x in values]
            if len(given) != len(places):
                raise UsageError(f"found {len(given)} values for {len(places)} inputs: {', '.join(names)}")
            numbers = self._numbers
            for k, x in zip(places, given, strict=True):
                if not isfinite(x):
                    _number(self.names[k], x)
            for k, x in zip(places, given, strict=True):
                if numbers[k] != x:
                    numbers[k], self._changed = x, True

        return write

    def _take(self) -> tuple[float, ...] | None:
        """The values of all inputs, if one was set to a new value since the last call."""
        if not self._changed:
            return None
        self._changed = False
        return tuple(self._numbers)

    def _put(self, numbers: Sequence[float], changed: bool) -> None:
        """Set all inputs; ``changed`` is whether the next step has to take them over."""
        self._numbers[:] = numbers
        self._changed = changed

    def _unknown(self, name: str) -> UsageError:
        has = ", ".join(self.names) or "none"
        return UsageError(f"{self._scene.name} has no input `{name}`", hint=f"its inputs: {has}")


#: attributes that the class itself sets
_OWN = frozenset(("_scene", "_index", "_numbers", "_changed"))


def _number(name: str, value: float) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise UsageError(f"the input {name} is set to {value!r}, which is not a number") from None
    if not isfinite(number):
        raise UsageError(f"the input {name} is set to {number}, which is not a finite number")
    return number
