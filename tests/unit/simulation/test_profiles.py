"""Profiles: signals along arrays and rods at given times."""

import re

import numpy as np
import pytest

import mbdsl
from mbdsl import UsageError, cli

CHAIN = """model Chain
  Ground ground;
  Rod link[3](each m = 1, each length = 0.4);
  Revolute joint[3];
equation
  connect(joint[1].frame_a, ground.c);
  for i in 1:3 loop
    connect(joint[i].frame_b, link[i].a);
  end for;
  for i in 2:3 loop
    connect(joint[i].frame_a, link[i - 1].b);
  end for;
  annotation(experiment(StopTime = 0.1, Interval = 0.02));
end Chain;"""


@pytest.fixture(scope="module")
def chain():
    return mbdsl.simulate(mbdsl.parse(CHAIN), step=1e-3)


def test_along_an_array(chain):
    """At an output the values are those of the signals; between two of them, on the line through both."""
    profile = chain.along(["joint[:].f", "joint[:].frame_b.fx"], at=[0.04, "50 ms"])
    assert profile.at == (0.04, 0.05)
    for name, line in profile.lines.items():
        assert line.x.tolist() == [1, 2, 3] and line.unit == "N"
        signals = np.array([chain[name.replace(":", str(k))] for k in (1, 2, 3)])
        assert profile[name][0] == pytest.approx(signals[:, 2], rel=1e-12)
        assert profile[name][1] == pytest.approx(signals[:, 2:4].mean(axis=1), rel=1e-12)
    assert "linearly" in profile.notes[0]
    assert chain.along("joint[2:3].phi")["joint[2:3].phi"] == pytest.approx(
        np.array([[chain["joint[2].phi"][-1], chain["joint[3].phi"][-1]]])
    )
    assert not chain.along("joint[:].f", at=0.1).notes


@pytest.mark.parametrize("space", ["", "spatial "])
def test_coordinates_along_a_rod(space):
    run = mbdsl.simulate(mbdsl.parse(space + CHAIN), step=1e-3)
    profile = run.along(["link[2].y", "link[2].vx"])
    line, (a, b) = profile.lines["link[2].y"], (run[f"link[2].{end}.y"][-1] for end in "ab")
    assert (line.unit, profile.lines["link[2].vx"].unit) == ("m", "m/s")
    assert line.y[0] == pytest.approx(a + (b - a) * line.x / 0.4, abs=1e-12)


def test_tables_and_pictures(chain, tmp_path):
    profile = chain.along(["joint[:].phi", "link[:].w"], at=0.1)
    first, head, *rows = str(profile).splitlines()
    assert first == "Chain, t = 0.1 s" and head.split("  ")[0].strip() == "index"
    assert "joint[:].phi [rad]" in head and "link[:].w [rad/s]" in head
    assert [float(row.split()[1]) for row in rows] == pytest.approx(profile["joint[:].phi"][0], rel=1e-5)
    assert [panel.y_label for panel in profile.panels] == ["joint[:].phi [rad]", "link[:].w [rad/s]"]
    several = chain.along("joint[:].w", at=[0, 0.1], out=tmp_path / "w.svg")
    assert [s.name for s in several.panels[0].series] == ["joint[:].w, t = 0 s", "joint[:].w, t = 0.1 s"]
    assert "index of joint" in (tmp_path / "w.svg").read_text(encoding="utf-8")
    assert repr(several) == "<Profile of Chain: joint[:].w>"


@pytest.mark.parametrize(
    ("pattern", "at", "message"),
    [
        ("joint[:].tua", None, r"there is no array of signals `joint\[:\].tua` in Chain"),
        ("joints[:].tau", None, r"there is no array of signals `joints\[:\].tau` in Chain"),
        ("joint[1].phi", None, r"`joint\[1\].phi` is not a signal along an array"),
        ("joint[2:7].phi", None, r"there is no element 7"),
        ("joint[3:2].phi", None, r"contains no element"),
        ("joint[a:b].phi", None, r"`a:b` is not a slice"),
        ("link[:].q[:]", None, r"more than one slice"),
        ("link[1].z", None, r"there is no signal `z` along link\[1\]"),
        ("joint[:].phi", "1 s", r"t = 1 s is outside of the run, which is from 0 to 0.1 s"),
        ("joint[:].phi", float("nan"), r"t = nan s is outside"),
        ("joint[:].phi", [], r"at least one time"),
        ("joint[:].phi", "3 m", r"at: "),
        (["joint[:].phi", "joint[2:3].w"], None, r"are not along the same elements"),
    ],
)
def test_errors(chain, pattern, at, message):
    with pytest.raises(UsageError, match=message):
        chain.along(pattern, at)


def test_the_command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "chain.mbd").write_text(CHAIN, encoding="utf-8")
    (tmp_path / "short.csv").write_text("time,p[1].x,p[2].x\n0,1,2\n1,3,6\n", encoding="utf-8")

    def run(*words):
        code = cli.main(["plot", *words])
        out, err = capsys.readouterr()
        return code, out, err

    code, out, _ = run("chain.mbd", "--along", "link[:].a.N,link[:].b.N", "--at", "20ms,0.1s")
    assert code == 0 and out.startswith("Chain, t = 0.02, 0.1 s")
    assert len(out.splitlines()) == 5 and "link[:].a.N at 0.02 s [N]" in out
    code, out, _ = run("short.csv", "--along", "p[:].x", "--at", "0.25")
    assert (code, [row.split() for row in out.splitlines()[2:4]]) == (0, [["1", "1.5"], ["2", "3"]])
    code, out, _ = run("short.csv", "--along", "p[:].x", "--at", "0,1", "--out", "p.svg")
    assert code == 0 and out.startswith("p.svg: p[:].x [m]") and (tmp_path / "p.svg").exists()
    code, out, _ = run("short.csv", "--along", "p[:].x", "--at", "0,0.25", "--out", "p.csv")
    assert code == 0 and out.startswith("p.csv: p[:].x [m]")
    table = (tmp_path / "p.csv").read_text().splitlines()
    assert table == ["index of p,p[:].x at 0 s [m],p[:].x at 0.25 s [m]", "1.0,1.0,1.5", "2.0,2.0,3.0"]
    assert run("short.csv", "--along", "p[:].x", "--out", "p.md")[0] == 0
    assert "| 2 | 6 |" in re.sub(" +", " ", (tmp_path / "p.md").read_text())
    (tmp_path / "other.mbd").write_text(
        CHAIN.replace("each length = 0.4", "length = {0.4, 0.3, 0.2}"), encoding="utf-8"
    )
    (tmp_path / "free.mbd").write_text(re.sub(r" *annotation.*;", "", CHAIN), encoding="utf-8")
    for words, message in (
        (("short.csv", "--along", "p[:].x", "--out", "short.csv"), "short.csv"),
        (("free.mbd", "--along", "link[:].a.N"), "or plot a result of `mbdsl simulate --stop 2s`"),
        (("short.csv", "--along", "rod.M"), "profiles of rods and beams (`rod.M`) need the model or the run"),
        (("other.mbd", "--along", "link[1].N,link[2].N"), "link[1].N and link[2].N are along different bodies"),
        (("chain.mbd", "--along", "joint[:].tua"), "there is no array of signals `joint[:].tua` in Chain"),
        (("short.csv", "--along", "p[:].x", "--at", "2s"), "t = 2 s is outside of the run, which is from 0 to 1 s"),
        (("short.csv", "--along", "rod.M"), "`rod.M` is not a signal along an array"),
        (("short.csv", "--at", "1s"), "--at belongs to --along"),
        (("short.csv", "short.csv", "--along", "p[:].x"), "--along takes one result, found 2"),
        (("short.csv", "--along", "p[:].x", "--spectrum"), "--along and --spectrum exclude each other"),
    ):
        code, _, err = run(*words)
        assert code != 0 and message in err, err
