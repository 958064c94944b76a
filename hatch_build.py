"""Stubs of the Builders are written when the package is built or installed, in the folder of the sources as well."""

from __future__ import annotations

import sys
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class Stubs(BuildHookInterface):
    """The hook of ``pyproject.toml``; it needs none of mbdsl's dependencies."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        sys.path.insert(0, self.root)
        try:
            from mbdsl.lang.builder import kind_stub

            kind_stub.write()
        finally:
            sys.path.remove(self.root)
