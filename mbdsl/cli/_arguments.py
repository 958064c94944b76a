"""The argument parser: its errors have the form of all other errors, with the nearest known name as a remedy."""

from __future__ import annotations

import argparse
import os
import re
from collections.abc import Iterable
from itertools import pairwise
from typing import Any, NoReturn

from mbdsl.errors import UsageError
from mbdsl.messages import did_you_mean

FILE = re.compile(r"\.(mbd|csv|npz|mat|nc|ckpt)$", re.IGNORECASE)  #: names of models, results and checkpoints
NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?", re.IGNORECASE)


class Parser(argparse.ArgumentParser):
    """Reports argument errors in the same form as all other errors."""

    def error(self, message: str) -> NoReturn:
        raise UsageError(message, hint=f"see {self.prog} --help")

    def parse_known_args(self, args: Iterable[str] | None = None, namespace: Any = None) -> tuple[Any, list[str]]:
        words = self._with_flags(list(args or ()))
        nested = any(isinstance(action, argparse._SubParsersAction) for action in self._actions)
        if not nested and not {"-h", "--help"} & set(words):  # otherwise the nested parser checks
            self._check_options(words)
            self._check_units(words)
        return super().parse_known_args(words, namespace)

    def _with_flags(self, words: list[str]) -> list[str]:
        """The words, where `--units` before the name of a file has no list of units: `--units model.mbd`."""
        action = self._option_string_actions.get("--units")
        if action is None or action.nargs != "?":
            return words
        found = list(words)
        for k, (option, following) in enumerate(pairwise(words)):
            is_file = os.path.exists(following) or FILE.search(following)
            if option == "--units" and is_file and not _is_unit(following):
                found[k] = "--units="
        return found

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            name = "/".join(action.option_strings) or str(action.metavar or action.dest)
            known = list(map(str, action.choices))
            nearest = did_you_mean(str(value), known, "known values")
            raise UsageError(f"argument {name}: unknown value `{value}`", hint=nearest or f"see {self.prog} --help")

    def has_options(self, words: Iterable[str]) -> bool:
        """Whether all options among the words are options of this parser, in full."""
        options = [word.partition("=")[0] for word in words if word.startswith("--")]
        return all(option in self._option_string_actions for option in options)

    def _check_options(self, words: Iterable[str]) -> None:
        """Find an unknown option before argparse reports what it lacks instead."""
        known = [option for option in self._option_string_actions if option.startswith("--")]
        names = [option[2:] for option in known]
        for word in words:
            if word == "--":
                return
            option = word.partition("=")[0]
            if option.startswith("--") and not any(name.startswith(option) for name in known):
                nearest = (did_you_mean(option[2:], names) or f"see {self.prog} --help").replace(" `", " `--")
                raise UsageError(f"{self.prog} has no option `{option}`", hint=nearest)

    def _check_units(self, words: list[str]) -> None:
        """Find a number and its unit as two words: ``--stop 2 s``."""
        for option, value, unit in zip(words, words[1:], words[2:], strict=False):
            action = self._option_string_actions.get(option)
            _, equals, number = value.rpartition("=")
            if action is None or action.nargs is not None or not NUMBER.fullmatch(number.strip()) or not _is_unit(unit):
                continue
            quoted, joined = f'{option} "{value} {unit}"', f"{option} {value}{unit}"
            raise UsageError(
                f"`{value} {unit}` after {option} is two words: the value ends at the space",
                hint=f"write  {quoted}" if equals or unit[0].isdigit() else f"write  {joined}  or  {quoted}",
            )


def _is_unit(word: str) -> bool:
    """Whether a word is a unit, and not a file of that name."""
    from mbdsl.lang import units

    return units.parse(word) is not None and not os.path.exists(word)
