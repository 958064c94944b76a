"""Long columns of numbers of tables, as values that are compared and hashed quickly."""

from __future__ import annotations

from array import array
from hashlib import sha256


class Points(tuple):
    """Many numbers, whose hash and digest are computed once."""

    def __hash__(self) -> int:
        return hash(self.digest)

    @property
    def digest(self) -> str:
        """The SHA-256 of their 64-bit binary numbers, in hexadecimal digits."""
        found = self.__dict__.get("digest_")
        if found is None:
            found = self.__dict__["digest_"] = sha256(array("d", self).tobytes()).hexdigest()
        return found
