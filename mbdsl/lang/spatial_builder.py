"""Models in space, built from Python."""

from __future__ import annotations

from mbdsl.lang.builder import Builder
from mbdsl.lang.handles import Handle, Number, Place, Vector
from mbdsl.lang.kind_methods import add_methods


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
        phi: Number = 0.0,
        *,
        replace: bool = False,
    ) -> Handle:
        """Add a frame that is fixed to a body.

        Parameters
        ----------
        name : str
        base : Handle or str
            A body or a frame of a body.
        r : (3,) [m], optional
            Position of the origin, in the axes of ``base``.
        n : (3,), optional
            Axis about which the frame is turned, in the axes of ``base``; z if it is not given.
        phi : number or str, optional [rad]
            Angle about n.
        replace : bool, optional
            True: replaces the declaration of this name, if there is one.

        Returns
        -------
        Handle
        """
        return self._declare(name, "Frame", None, "", (base,), {"r": r, "n": n, "phi": phi}, replace)


add_methods(SpatialBuilder, spatial=True)
