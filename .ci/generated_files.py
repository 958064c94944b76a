"""Generated files: ``python .ci/generated_files.py`` writes those that are out of date, and fails if there were any.

With ``--check`` it only lists them. A file of the table below is made from declarations in ``mbdsl/``; each function is
in the module that describes the file.
"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))  # the code of this checkout, even if another version of mbdsl is installed

from mbdsl.cli import _options
from mbdsl.editor import textmate
from mbdsl.integrators import method_reference
from mbdsl.lang import kind_reference


def generated() -> dict[str, str]:
    """File, relative to the project -> its content, made from the present declarations."""

    def page(name: str) -> str:
        return (ROOT / name).read_text(encoding="utf-8")

    grammar = "editors/vscode/syntaxes/mbd.tmLanguage.json"
    return {
        "docs/command-line.md": _options.insert(page("docs/command-line.md")),
        "docs/language.md": kind_reference.insert(page("docs/language.md")),
        "docs/space.md": kind_reference.insert(page("docs/space.md")),
        "docs/methods.md": method_reference.insert(page("docs/methods.md")),
        grammar: textmate.content(grammar).decode(),
    }


def outdated() -> dict[str, str]:
    """The files whose content is not the generated one, with that content."""
    found = generated()
    return {name: text for name, text in found.items() if (ROOT / name).read_text(encoding="utf-8") != text}


def main(arguments: list[str]) -> int:
    found = outdated()
    for name, text in found.items():
        if "--check" in arguments:
            print(f"{name} is out of date: run `python .ci/generated_files.py`")
        else:
            (ROOT / name).write_text(text, encoding="utf-8", newline="\n")
            print(f"{name} was out of date and is written again: add it to the commit")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
