"""Runs :mod:`mbdsl.editor.checking` in a process that can be ended."""

from __future__ import annotations

import asyncio
import json
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any


async def check_in_process(request: dict[str, Any], limit: float) -> dict[str, Any]:
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
    try:
        return await asyncio.wait_for(_answer(request), limit)
    except asyncio.TimeoutError:
        return _failed(
            f"the check was ended after {limit:g} s: this model is too large to be checked while it is typed"
        )


def _failed(message: str) -> dict[str, Any]:
    problem = {"message": message, "hint": "", "severity": "warning", "span": None, "notes": []}
    return {"problems": [problem], "model": "", "values": {}}


async def _answer(request: dict[str, Any]) -> dict[str, Any]:
    """The answer of a new process, which is killed if the check is cancelled."""
    process = await asyncio.create_subprocess_exec(
        *(sys.executable, "-m", "mbdsl.editor.checking"),
        stdin=asyncio.subprocess.PIPE,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.PIPE,
        # Python searches modules in the working folder: a folder of models must not supply any.
        cwd=Path(__file__).parents[2],
    )
    try:
        out, err = await process.communicate(json.dumps(request).encode())
    finally:
        if process.returncode is None:
            with suppress(ProcessLookupError):
                process.kill()
            await process.wait()
    if process.returncode != 0:
        reason = err.decode(errors="replace").strip().rpartition("\n")[2] or f"exit code {process.returncode}"
        return _failed(f"internal error of the check: {reason}")
    return json.loads(out)
