from types import FunctionType

import pytest

from mbdsl import cli


@pytest.fixture
def say(capsys, tmp_path, monkeypatch):
    """Run a command in an empty folder: exit code, standard output, standard error."""
    monkeypatch.chdir(tmp_path)

    def run(*argv):
        return (cli.main([str(a) for a in argv]), *capsys.readouterr())

    return run


def _plain(kernel):
    function = getattr(kernel, "py_func", kernel)
    names = {n: function.__globals__[n] for n in function.__code__.co_names if n in function.__globals__}
    kernels = {n: _plain(f) for n, f in names.items() if hasattr(f, "__mbdsl_kernel__") or hasattr(f, "py_func")}
    return FunctionType(function.__code__, {"__builtins__": __builtins__, **names, **kernels})


@pytest.fixture
def plain():
    """A kernel as a Python function; skipped if it has been compiled for others in this process."""
    return _plain
