"""The files that an editor shows, and those that they import, read without errors."""

from __future__ import annotations

from dataclasses import replace

from mbdsl.editor.repair import repaired
from mbdsl.errors import MbdslError
from mbdsl.lang.library import Library, SourceUnit, key_of


class LooseLibrary(Library):
    """Files of a model, without statements and imports that have errors; imports lead where those of a model may."""

    def _parse(self, text: str, file: str) -> SourceUnit:
        unit = SourceUnit(repaired(text, file).file, text)
        self.units[key_of(file)] = unit
        return unit

    def _import(self, unit: SourceUnit) -> list[SourceUnit]:
        found, file = [], unit.file
        for item in file.imports:
            unit.file = replace(file, imports=(item,))
            try:
                found += super()._import(unit)
            except MbdslError:
                continue
            finally:
                unit.file = file
        return found
