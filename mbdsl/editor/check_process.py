"""Runs :mod:`mbdsl.editor.checking` in a process that can be ended."""

from __future__ import annotations

import asyncio
import json
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

from mbdsl.editor.checking import failed

LONGEST = 2**28  #: bytes of an answer


class CheckProcess:
    """A process that checks one text after the other: its start takes ten times as long as the check of a model.

    It is killed if a check takes too long or is cancelled, and another one is started for the next check.
    """

    def __init__(self) -> None:
        self._free = asyncio.Lock()
        self._process: asyncio.subprocess.Process | None = None

    async def check(self, request: dict[str, Any], limit: float) -> dict[str, Any]:
        """The answer to a request, as ``checking.check`` describes it.

        Parameters
        ----------
        request : dict
            The arguments of ``checking.check``.
        limit : float
            Time [s] after which the process is killed; the answer says so.

        Returns
        -------
        dict
        """
        async with self._free:
            try:
                return await asyncio.wait_for(self._answer(request), limit)
            except asyncio.TimeoutError:
                return failed(
                    f"the check was ended after {limit:g} s: this model is too large to be checked while it is typed"
                )

    async def _answer(self, request: dict[str, Any]) -> dict[str, Any]:
        process, self._process = self._process or await _started(), None
        answer = b""
        try:
            assert process.stdin is not None and process.stdout is not None
            with suppress(ConnectionError):  # it has ended
                process.stdin.write(json.dumps(request).encode() + b"\n")
                await process.stdin.drain()
                answer = await process.stdout.readline()
        finally:
            if answer.endswith(b"\n"):
                self._process = process
            else:
                await _killed(process)
        return json.loads(answer) if self._process else failed(f"the check failed: exit code {process.returncode}")


async def _started() -> asyncio.subprocess.Process:
    return await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "mbdsl.editor.checking"),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.DEVNULL,
        limit=LONGEST,
        # Python searches modules in the working folder: a folder of models must not supply any.
        cwd=Path(__file__).parents[2],
    )


async def _killed(process: asyncio.subprocess.Process) -> None:
    with suppress(ProcessLookupError):
        process.kill()
    await process.wait()
