"""mbdsl: a Modelica-style declarative tool for multibody dynamics."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mbdsl import results as results
    from mbdsl import study as study
    from mbdsl.analysis.eigenmodes import eigen as eigen
    from mbdsl.analysis.equilibria import static as static
    from mbdsl.analysis.frequency_response import response as response
    from mbdsl.analysis.linearisation import linearise as linearise
    from mbdsl.api import simulate as simulate
    from mbdsl.errors import AccuracyWarning as AccuracyWarning
    from mbdsl.errors import EquilibriumError as EquilibriumError
    from mbdsl.errors import InitialisationError as InitialisationError
    from mbdsl.errors import IntegrationError as IntegrationError
    from mbdsl.errors import Interrupted as Interrupted
    from mbdsl.errors import MbdslError as MbdslError
    from mbdsl.errors import ModelError as ModelError
    from mbdsl.errors import SyntaxProblem as SyntaxProblem
    from mbdsl.errors import UsageError as UsageError
    from mbdsl.explanation.receipt import explain as explain
    from mbdsl.integrators.method_table import methods as methods
    from mbdsl.lang.builder import Builder as Builder
    from mbdsl.lang.builder.spatial_builder import SpatialBuilder as SpatialBuilder
    from mbdsl.lang.load import load as load
    from mbdsl.lang.load import parse_text as parse
    from mbdsl.mechanism.scene import Scene as Scene
    from mbdsl.reporting.views import animate as animate
    from mbdsl.reporting.views import check as check
    from mbdsl.reporting.views import graph as graph
    from mbdsl.reporting.views import plot as plot
    from mbdsl.reporting.views import report as report
    from mbdsl.simulation.checkpoint import Checkpoint as Checkpoint
    from mbdsl.simulation.interactive import Simulation as Simulation
    from mbdsl.simulation.resume import resume as resume
    from mbdsl.simulation.trajectory import Trajectory as Trajectory
    from mbdsl.studies.recommendation import recommend as recommend
    from mbdsl.studies.solve import solve as solve
    from mbdsl.studies.sweep import sweep as sweep
    from mbdsl.version import __version__ as __version__

#: public name -> (module, its name there, or "" for the module); loaded when first used: `import mbdsl` is quick
_PUBLIC = {
    "__version__": ("mbdsl.version", "__version__"),
    "load": ("mbdsl.lang.load", "load"),
    "parse": ("mbdsl.lang.load", "parse_text"),
    "Builder": ("mbdsl.lang.builder", "Builder"),
    "SpatialBuilder": ("mbdsl.lang.builder.spatial_builder", "SpatialBuilder"),
    "Scene": ("mbdsl.mechanism.scene", "Scene"),
    "static": ("mbdsl.analysis.equilibria", "static"),
    "eigen": ("mbdsl.analysis.eigenmodes", "eigen"),
    "linearise": ("mbdsl.analysis.linearisation", "linearise"),
    "response": ("mbdsl.analysis.frequency_response", "response"),
    "sweep": ("mbdsl.studies.sweep", "sweep"),
    "solve": ("mbdsl.studies.solve", "solve"),
    "simulate": ("mbdsl.api", "simulate"),
    "check": ("mbdsl.reporting.views", "check"),
    "graph": ("mbdsl.reporting.views", "graph"),
    "plot": ("mbdsl.reporting.views", "plot"),
    "report": ("mbdsl.reporting.views", "report"),
    "animate": ("mbdsl.reporting.views", "animate"),
    "resume": ("mbdsl.simulation.resume", "resume"),
    "Checkpoint": ("mbdsl.simulation.checkpoint", "Checkpoint"),
    "explain": ("mbdsl.explanation.receipt", "explain"),
    "Simulation": ("mbdsl.simulation.interactive", "Simulation"),
    "Trajectory": ("mbdsl.simulation.trajectory", "Trajectory"),
    "methods": ("mbdsl.integrators.method_table", "methods"),
    "recommend": ("mbdsl.studies.recommendation", "recommend"),
    "study": ("mbdsl.study", ""),
    "results": ("mbdsl.results", ""),
    "MbdslError": ("mbdsl.errors", "MbdslError"),
    "SyntaxProblem": ("mbdsl.errors", "SyntaxProblem"),
    "ModelError": ("mbdsl.errors", "ModelError"),
    "UsageError": ("mbdsl.errors", "UsageError"),
    "InitialisationError": ("mbdsl.errors", "InitialisationError"),
    "EquilibriumError": ("mbdsl.errors", "EquilibriumError"),
    "IntegrationError": ("mbdsl.errors", "IntegrationError"),
    "AccuracyWarning": ("mbdsl.errors", "AccuracyWarning"),
    "Interrupted": ("mbdsl.errors", "Interrupted"),
}
# a literal list, as type checkers read no other
__all__ = [
    "AccuracyWarning",
    "Builder",
    "Checkpoint",
    "EquilibriumError",
    "InitialisationError",
    "IntegrationError",
    "Interrupted",
    "MbdslError",
    "ModelError",
    "Scene",
    "Simulation",
    "SpatialBuilder",
    "SyntaxProblem",
    "Trajectory",
    "UsageError",
    "__version__",
    "animate",
    "check",
    "eigen",
    "explain",
    "graph",
    "linearise",
    "load",
    "methods",
    "parse",
    "plot",
    "recommend",
    "report",
    "response",
    "results",
    "resume",
    "simulate",
    "solve",
    "static",
    "study",
    "sweep",
]


if not TYPE_CHECKING:  # which would accept any name

    def __getattr__(name: str) -> Any:
        if name not in _PUBLIC:
            raise AttributeError(f"module 'mbdsl' has no attribute {name!r}")
        from importlib import import_module

        module, attribute = _PUBLIC[name]
        value = getattr(import_module(module), attribute) if attribute else import_module(module)
        globals()[name] = value
        return value


def load_ipython_extension(shell: Any) -> None:
    """Add the cell magic ``%%mbd`` to IPython: called by ``%load_ext mbdsl``."""
    from mbdsl.notebook.cell_magic import register

    register(shell)


def __dir__() -> list[str]:
    return sorted({*__all__, *(name for name in globals() if name.startswith("__") and name.endswith("__"))})
