import pytest

from mbdsl import cli


@pytest.fixture
def say(capsys, tmp_path, monkeypatch):
    """Run a command in an empty folder: exit code, standard output, standard error."""
    monkeypatch.chdir(tmp_path)

    def run(*argv):
        return (cli.main([str(a) for a in argv]), *capsys.readouterr())

    return run
