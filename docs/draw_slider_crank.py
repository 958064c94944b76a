"""Draws docs/slider_crank.png from a run of models/slider_crank.mbd:  python docs/draw_slider_crank.py"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from mbdsl import simulate

HERE = Path(__file__).resolve().parent
SHOWN = np.linspace(0.0, 0.35, 8)  #: times at which the mechanism is drawn [s]


def main(target: Path = HERE / "slider_crank.png") -> None:
    trajectory = simulate(HERE.parent / "models" / "slider_crank.mbd", method="hht-si2", step=1e-3)
    t = trajectory.t
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.6), width_ratios=(1, 1.2), layout="constrained")

    for k, at in enumerate(SHOWN):
        points = [
            [np.interp(at, t, trajectory[f"{frame}.{axis}"]) for frame in ("crank.a", "crank.b", "rod.b")]
            for axis in ("x", "y")
        ]
        shade = plt.get_cmap("viridis")(k / len(SHOWN))
        left.plot(*points, "o-", color=shade, linewidth=3, markersize=5, solid_capstyle="round")
    left.axhline(0.0, color="0.7", linewidth=1, zorder=0)
    left.set(aspect="equal", title="every 50 ms, from dark to bright", xlabel="x [m]", ylabel="y [m]")

    right.plot(t, np.degrees(trajectory["crank.phi"]), color="tab:blue")
    right.set(title="models/slider_crank.mbd, hht-si2", xlabel="time [s]", xlim=(t[0], t[-1]))
    right.set_ylabel("angle of the crank [deg]", color="tab:blue")
    speed = right.twinx()
    speed.plot(t, trajectory["crank.w"], color="tab:orange")
    speed.set_ylabel("angular velocity [rad/s]", color="tab:orange")

    figure.savefig(target, dpi=110)


if __name__ == "__main__":
    main()
