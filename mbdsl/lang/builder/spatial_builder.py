"""Models in space, built from Python."""

from __future__ import annotations

from mbdsl.lang.builder.builder import Builder
from mbdsl.lang.builder.handles import Handle, Number, Place, Vector
from mbdsl.lang.builder.kind_methods import add_methods


class SpatialBuilder(Builder):
    """Collects the components of a model in space and makes a ``Scene`` of them.

    It is a ``Builder`` whose methods are the kinds in space: vectors have three components (of two, z = 0 is
    assumed), and joints have an axis ``n``.

    Parameters
    ----------
    name : str
        Name of the model.
    doc : str, optional
        Description, one line.

    Examples
    --------
    >>> b = SpatialBuilder("Top")
    >>> ground = b.Ground("ground", n=(0, 0, -1))
    >>> top = b.Body("top", m="15 kg", I=(0.23, 0.47, 0.23), frames={"foot": (0, -1, 0)})
    >>> ball = b.Spherical("ball", ground, top.foot)
    >>> b.initial(top.wy, "150 rad/s")
    >>> b.scene().spatial
    True
    """

    spatial = True

    def frame(  # type: ignore[override]
        self,
        name: str,
        base: Place,
        r: Vector = (0.0, 0.0, 0.0),
        n: Vector | None = None,
        phi: Number | None = None,
        *,
        n_x: Vector | None = None,
        n_y: Vector | None = None,
        angles: Vector | None = None,
        sequence: Vector | None = None,
        quaternion: Vector | None = None,
        replace: bool = False,
    ) -> Handle:
        """Add a frame that is fixed to a body.

        Its orientation is that of ``base``, or is given in one of four ways: by ``phi`` and ``n``, by ``n_x`` and
        ``n_y``, by ``angles`` and ``sequence``, or by ``quaternion``. All vectors are in the axes of ``base``.

        Parameters
        ----------
        name : str
        base : Handle or str
            A body or a frame of a body.
        r : (3,) [m], optional
            Position of the origin.
        n : (3,), optional
            Axis about which the frame is turned by ``phi``; z if it is not given.
        phi : number or str, optional [rad]
            Angle about n.
        n_x : (3,), optional
            Direction of the x axis.
        n_y : (3,), optional
            Direction in the xy plane, on the side of the y axis; not parallel to ``n_x``.
        angles : (3,), optional [rad]
            Angles of successive rotations, each about an axis of the frame turned so far.
        sequence : (3,), optional
            These axes, 1, 2, 3 for x, y, z; (1, 2, 3) if it is not given.
        quaternion : (4,), optional
            Quaternion of the rotation, scalar part first; it is normalised.
        replace : bool, optional
            True: replaces the declaration of this name, if there is one.

        Returns
        -------
        Handle
        """
        given = {"r": r, "n": n, "phi": phi, "n_x": n_x, "n_y": n_y}
        given |= {"angles": angles, "sequence": sequence, "quaternion": quaternion}
        return self._declare(name, "Frame", None, "", (base,), given, replace)


add_methods(SpatialBuilder, spatial=True)
