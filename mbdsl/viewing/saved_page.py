"""Pages of animations as files: a page, or a film or picture of it; and their frame in a notebook."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod

from mbdsl.mechanism.scene import Scene
from mbdsl.plotting import html_tables
from mbdsl.storage.output_files import check, suffix_of, write_text, writing

PAGES, FILMS, VECTORS = (".html", ".htm"), (".gif", ".mp4"), (".svg", ".pdf")
PICTURES = (".png", *VECTORS)
HEIGHT = 560  #: of the frame in a notebook [px]


class SavedPage(ABC):
    """A page, and its film or picture; subclasses have ``html``, ``scene`` and ``_content``."""

    suffixes: tuple[str, ...] = (*PAGES, *FILMS)

    @property
    @abstractmethod
    def html(self) -> str:
        """The page as the text of one HTML file."""

    @property
    @abstractmethod
    def scene(self) -> Scene:
        """The model."""

    @abstractmethod
    def _content(self, suffix: str, width: int, height: int) -> bytes:
        """The content of a film or a picture."""

    def _repr_html_(self) -> str:
        """The page in a frame of its own, for notebooks."""
        return html_tables.frame(self.html, HEIGHT)

    def save(self, path: str | os.PathLike, size: tuple[int, int] = (640, 400)) -> None:
        """Write the page, or a film or picture of it.

        Parameters
        ----------
        path : path
            The file; its suffix selects the format.
        size : (int, int), optional [px]
            Width and height of a film or a picture.

        Raises
        ------
        UsageError
            If the suffix is unknown, the file cannot be written, the model was read from it, or a film needs a package
            or a program that is missing.
        """
        suffix = suffix_of(path, self.suffixes)
        check([path], self.scene.files)
        if suffix in PAGES:
            write_text(path, self.html)
            return
        content = self._content(suffix, *size)
        with writing(path) as stream:
            stream.write(content)
