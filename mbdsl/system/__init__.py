"""From the Scene to the System: tables, specialised code, and the DAE."""

from mbdsl.system.system import System, build
from mbdsl.system.workspace import Workspace

__all__ = ["System", "Workspace", "build"]
