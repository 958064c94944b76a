"""From the Scene to the System: tables, specialised code, and the DAE."""

from mbdsl.system.system import System, Workspace, build

__all__ = ["System", "Workspace", "build"]
