"""The integration methods as a mapping that shows itself as a table."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from mbdsl.integrators import available, declared
from mbdsl.integrators.method import Method
from mbdsl.messages import count, few

COLUMNS = ("method", "order", "index", "enforces", "steps", "description")


class Methods(Mapping[str, Method]):
    """The integration methods by name; ``print`` and notebooks show a table.

    ``mbdsl.methods`` makes it.

    Parameters
    ----------
    entries : mapping of str to Method
        Name -> declaration: order, index of the formulation, enforced constraints, parameters, source.

    Examples
    --------
    ``mbdsl.methods()["newmark"].parameters["beta"].default`` is 0.3025.
    """

    def __init__(self, entries: Mapping[str, Method]) -> None:
        self._entries = dict(entries)

    def __getitem__(self, name: str) -> Method:
        return self._entries[name] if name in self._entries else declared(name)

    def get(self, name: str, default: Any = None) -> Any:
        """Return the declaration of a method, or a default.

        Parameters
        ----------
        name : str
            Name of a method.
        default : optional
            Value if there is no such method.

        Returns
        -------
        Method
            Or ``default``.
        """
        return self._entries.get(name, default)

    def __contains__(self, name: object) -> bool:
        return name in self._entries

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def _rows(self) -> list[tuple[str, ...]]:
        return [
            (name, str(m.order), str(m.index), ", ".join(m.enforces), " or ".join(m.steps), m.doc)
            for name, m in self._entries.items()
        ]

    def __repr__(self) -> str:
        return f"<{count(len(self), 'method')}: {few(self)}>"

    def __str__(self) -> str:
        """Without the descriptions: lines of at most 80 characters."""
        rows = [row[:-1] for row in (COLUMNS, *self._rows())]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)

    def _repr_html_(self) -> str:
        from mbdsl.plotting.figures import Table
        from mbdsl.plotting.html_tables import fragment

        note = "mbdsl.methods()[name] has the parameters and the source of a method"
        return fragment(count(len(self), "integration method"), (), [Table("", COLUMNS, self._rows())], [note])


def methods() -> Methods:
    """List the integration methods.

    Returns
    -------
    Methods
        Name -> ``Method``, mbdsl's own methods first, then third-party integrators. ``print`` and notebooks show a
        table.
    """
    return Methods(available())
