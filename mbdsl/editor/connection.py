"""What an editor sends: the headers of its messages are checked before pygls reads as many bytes as they say."""

from __future__ import annotations

import re
from typing import BinaryIO

from mbdsl.lang import limits
from mbdsl.messages import visible

LARGEST = 64 * limits.FILE_SIZE  #: bytes of a message
LINE = 1000  #: bytes of a line of a header
_LENGTH = re.compile(rb"content-length:[ \t]*(.*?)\s*", re.IGNORECASE | re.DOTALL)


class MessageInput:
    """A binary stream of messages, which ends at the first one that the protocol does not allow.

    Behind a length that is wrong there is no place at which the next message is known to begin.

    Parameters
    ----------
    stream : binary file
        Standard input.

    Attributes
    ----------
    problem : str
        Why the stream was ended; "" if the editor has closed it.
    """

    def __init__(self, stream: BinaryIO) -> None:
        self._stream = stream
        self.problem = ""

    def readline(self) -> bytes:
        """The next line of a header."""
        line = b"" if self.problem else self._stream.readline(LINE)
        found = _LENGTH.fullmatch(line)
        if found is None:
            return line
        length = found[1].decode(errors="replace")
        if not (length.isascii() and length.isdecimal() and 0 < int(length[:20]) <= LARGEST):
            said = visible(length[:40], line=True)
            self.problem = f"found `Content-Length: {said}`, expected a number of bytes from 1 to {LARGEST}"
            return b""
        return b"Content-Length: %d\r\n" % int(length)  # as pygls reads it

    def read(self, count: int) -> bytes:
        """The content of a message; nothing if the stream ends before it does."""
        found = self._stream.read(count)
        if len(found) < count:
            self.problem = f"the connection ended after {len(found)} of the {count} bytes of a message"
            return b""
        return found
