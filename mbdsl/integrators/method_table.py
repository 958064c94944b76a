"""The integration methods as a mapping that shows itself as a table."""

from __future__ import annotations

from mbdsl.integrators import available, declared
from mbdsl.integrators.method import Method
from mbdsl.messages import count, few

COLUMNS = ("method", "order", "index", "enforces", "steps", "description")


class Methods(dict[str, Method]):
    """The integration methods by name; ``print`` and notebooks show a table.

    The values are declarations: order, index of the formulation, enforced constraints, parameters, source.
    ``mbdsl.methods`` makes it.

    Examples
    --------
    ``mbdsl.methods()["newmark"].parameters["gamma"].default`` is 0.6.
    """

    def __missing__(self, name: str) -> Method:
        return declared(name)  # raises an error with similar names

    def _rows(self) -> list[tuple[str, ...]]:
        return [
            (name, str(m.order), str(m.index), ", ".join(m.enforces), " or ".join(m.steps), m.doc)
            for name, m in self.items()
        ]

    def __repr__(self) -> str:
        return f"<{count(len(self), 'method')}: {few(self)}>"

    def __str__(self) -> str:
        """Without the descriptions: lines of at most 80 characters."""
        rows = [row[:-1] for row in (COLUMNS, *self._rows())]
        widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
        return "\n".join("  ".join(map(str.ljust, row, widths)).rstrip() for row in rows)

    def _repr_html_(self) -> str:
        from mbdsl.plotting.figures import TextTable
        from mbdsl.plotting.html_tables import fragment

        note = "mbdsl.methods()[name] has the parameters and the source of a method"
        return fragment(count(len(self), "integration method"), (), [TextTable("", COLUMNS, self._rows())], [note])


def methods() -> Methods:
    """List the integration methods.

    Returns
    -------
    Methods
        Name -> ``Method``, mbdsl's own methods first, then third-party integrators. ``print`` and notebooks show a
        table.
    """
    return Methods(available())
