"""Models built from Python: the Builder, its methods for all kinds, and the declarations that they collect."""

from mbdsl.lang.builder.builder import Builder as Builder
from mbdsl.lang.builder.handles import Handle as Handle
