"""Scene to System: tables, specialised code, the DAE itself, and its consistent initial values."""

from mbdsl.system.system import System, Workspace, build

__all__ = ["System", "Workspace", "build"]
