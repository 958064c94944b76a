"""The files of an editor: texts that are open, possibly not saved, and models in the folders."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping

from mbdsl.editor.library import LooseLibrary
from mbdsl.editor.names import NameIndex
from mbdsl.errors import UsageError
from mbdsl.lang import syntax as s
from mbdsl.lang.library import Allowed, SourceUnit, key_of, read

FILES = 500  #: files of the folders that are searched for a name
FOLDERS = 2000  #: folders that are searched for files
SIZE = 250_000  #: characters; a longer text is checked, but its names are not searched while it is typed


class OpenFiles:
    """Open texts and folders.

    Parameters
    ----------
    allowed : bool or path, optional
        Folders that imports may lead to, as for ``mbdsl.load``.

    Attributes
    ----------
    texts : dict of str to str
        Path -> text of the files that are open.
    folders : list of str
        Folders that the user has opened.
    """

    def __init__(self, allowed: Allowed | None = None) -> None:
        self.texts: dict[str, str] = {}
        self.folders: list[str] = []
        self._allowed = allowed
        self._names: dict[str, NameIndex] = {}

    def open(self, path: str, text: str) -> None:
        """Set the text of a file."""
        self.texts[path] = text
        self.changed()

    def close(self, path: str) -> None:
        """Use the file on the disk again."""
        self.texts.pop(path, None)
        self.changed()

    def changed(self) -> None:
        """Read files again when they are needed."""
        self._names.clear()

    def text(self, path: str) -> str:
        """The text of a file, as it is in the editor or on the disk.

        Raises
        ------
        UsageError
            If it cannot be read.
        """
        known = next((text for name, text in self.texts.items() if key_of(name) == key_of(path)), None)
        return read(path) if known is None else known

    def names(self, path: str) -> NameIndex:
        """The names of a file.

        Raises
        ------
        UsageError
            If it cannot be read.
        """
        key = key_of(path)
        if key not in self._names:
            self._names[key] = self.names_with(path, self.texts)
        return self._names[key]

    def names_with(self, path: str, texts: Mapping[str, str]) -> NameIndex:
        """The names of a file, with other texts of open files."""
        known = next((text for name, text in texts.items() if key_of(name) == key_of(path)), None)
        text = self.text(path) if known is None else known
        if len(text) > SIZE:
            return NameIndex(SourceUnit(s.File(path, (), ()), text))
        return NameIndex(LooseLibrary(self._allowed, unsaved=texts).add(text, path))

    def files(self, path: str, others: Iterable[str] = ()) -> Iterator[str]:
        """The files that may refer to names of the file ``path``, itself first, and ``others``, each once."""
        seen = set()
        folders = [*self.folders, *([os.path.dirname(path)] if os.path.isabs(path) else [])]
        for name in (path, *others, *self.texts, *_models(folders)):
            if key_of(name) not in seen:
                seen.add(key_of(name))
                yield name

    def with_word(self, path: str, word: str, others: Iterable[str] = ()) -> Iterator[NameIndex]:
        """The names of all files that contain a word; files that cannot be read are left out."""
        for name in self.files(path, others):
            try:
                if word in self.text(name):
                    yield self.names(name)
            except UsageError:
                continue


def _models(folders: list[str]) -> Iterator[str]:
    """Models in folders and their folders; hidden folders are left out."""
    files = visited = 0
    for folder in folders:
        for path, inner, names in os.walk(folder):
            visited += 1
            inner[:] = sorted(name for name in inner if not name.startswith((".", "node_modules", "__pycache__")))
            for name in sorted(names):
                if name.endswith(".mbd"):
                    files += 1
                    yield os.path.join(path, name)
            if files >= FILES or visited >= FOLDERS:
                return
