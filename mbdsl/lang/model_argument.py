"""The argument ``model`` of public functions: a Scene, a Builder, or the path of a ``.mbd`` file."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, ParamSpec, TypeVar, cast

from mbdsl.errors import UsageError
from mbdsl.mechanism.extreme_numbers import blame_extremes
from mbdsl.mechanism.scene import Scene
from mbdsl.numerics.blas_threads import with_one_thread

if TYPE_CHECKING:
    from mbdsl.lang.builder import Builder

P = ParamSpec("P")
R = TypeVar("R")


def as_scene(
    model: Scene | Builder | str | PathLike, parameters: Mapping | None = None, without: Sequence[str] = ()
) -> Scene:
    """The Scene of a model, which is given as a Scene, a Builder, or the path of a ``.mbd`` file."""
    if isinstance(model, Scene):
        return model.changed(parameters or {}, without) if parameters or without else model
    if isinstance(model, (str, PathLike)):
        from mbdsl.lang.load import load

        return load(cast("str | PathLike[str]", model), {} if parameters is None else parameters, without=without)
    if not hasattr(model, "scene"):
        raise UsageError(f"a model is a path, a Scene or a Builder, not {type(model).__name__}")
    return model.scene(parameters, without)


def blame_model(function: Callable[P, R]) -> Callable[P, R]:
    """Decorate a function with an argument ``model``: see :func:`mbdsl.mechanism.extreme_numbers.blame_extremes`.

    It computes with one thread of BLAS: see :mod:`mbdsl.numerics.blas_threads`.
    """
    return with_one_thread(blame_extremes(function, as_scene))
