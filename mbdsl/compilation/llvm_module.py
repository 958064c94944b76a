"""A module of LLVM code: its functions, declarations and tables of constants."""

from __future__ import annotations

from collections.abc import Callable

from mbdsl.compilation.kernel_types import Type, Untranslatable

#: distinct types of memory: no entry of an array of floats is an entry of an array of integers
METADATA = """
!0 = !{!"mbdsl"}
!1 = !{!"floats", !0}
!2 = !{!"integers", !0}
!3 = !{!1, !1, i64 0}
!4 = !{!2, !2, i64 0}
!5 = !{!"llvm.loop.unroll.runtime.disable"}
"""


class Module:
    """The functions of a module, each a list of lines."""

    def __init__(self, translated: Callable) -> None:
        self._translated = translated  #: ``translation._translated``, which adds a kernel
        self.lines: list[str] = []
        self.declared: dict[str, str] = {}  # symbol -> declaration
        self._made: dict[tuple, tuple[str, Type]] = {}
        self._loops = 0
        self._tables: dict[tuple[str, ...], str] = {}
        self._pending: list[tuple] = []

    def text(self) -> str:
        tables = [
            f"{symbol} = internal constant [{len(x)} x {kind}] [{', '.join(f'{kind} {v}' for v in x)}]"
            for (kind, *x), symbol in self._tables.items()
        ]
        attributes = ["attributes #0 = { nounwind }", "attributes #1 = { nounwind noinline }"]
        loops = [f"!{k} = distinct !{{!{k}, !5}}" for k in range(10, 10 + self._loops)]
        return "\n".join([*tables, *self.declared.values(), *self.lines, *attributes, METADATA, *loops])

    def loop(self) -> str:
        """A mark of a new loop: LLVM unrolls it only if the number of its iterations is constant. Most loops have few
        iterations, and copies of their bodies make most of the code and of the time of its compilation."""
        self._loops += 1
        return f"!{9 + self._loops}"

    def declare(self, symbol: str, gives: str, takes: tuple[str, ...]) -> str:
        self.declared[symbol] = f"declare {gives} @{symbol}({', '.join(takes)})"
        return f"@{symbol}"

    def table(self, kind: str, entries: list[str]) -> str:
        key = (kind, *entries)
        return self._tables.setdefault(key, f"@table.{len(self._tables)}")

    def kernel(self, function: Callable, takes: tuple[Type, ...], apart: bool = False) -> tuple[str, Type]:
        """Symbol and type of the result of a kernel for these arguments; ``apart``: no two of its arrays overlap."""
        key = (function, takes, apart)
        if key in self._pending:
            raise Untranslatable(f"`{function.__name__}` calls itself")
        if key not in self._made:
            self._pending.append(key)
            symbol = f'@"{function.__module__}.{function.__name__}.{len(self._made)}"'
            gives = self._translated(self, function, symbol, takes, apart)
            self._pending.pop()
            self._made[key] = symbol, gives
        return self._made[key]
