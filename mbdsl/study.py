"""Studies: several runs of a model, to measure errors, run times and effects.

``mbdsl.study.convergence("models/pendulum.mbd", methods=["newmark"])`` returns a study, which prints its tables, shows
its page in a notebook and is saved by ``write``. Further arguments of these functions are the fields of ``Asked``.
"""

from mbdsl.studies.convergence import convergence
from mbdsl.studies.drift import drift
from mbdsl.studies.effects import effects
from mbdsl.studies.energy import energy
from mbdsl.studies.runtime import runtime
from mbdsl.studies.survey import Asked
from mbdsl.studies.verify import verify
from mbdsl.studies.work_precision import work_precision

__all__ = ["Asked", "convergence", "drift", "effects", "energy", "runtime", "verify", "work_precision"]


def __dir__() -> list[str]:
    return sorted(__all__)
