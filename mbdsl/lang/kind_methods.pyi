"""One method of the Builder for each kind of component: made by ``python -m mbdsl.lang.kind_stub``."""

from inspect import Signature
from typing import Literal

from mbdsl.elements.kind import Kind
from mbdsl.lang.handles import Frames, Handle, Law, Number, Place, Places, Start, Vector

def known(spatial: bool = False) -> dict[str, Kind]: ...
def missing(spatial: bool) -> list[str]: ...
def add_methods(to: type, spatial: bool = False) -> None: ...
def signature(kind: Kind) -> Signature: ...
def documentation(name: str, kind: Kind) -> str: ...

class KindMethods:
    """The methods of a Builder that add components."""

    def BeltDrive(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        r_a: Number,
        r_b: Number,
        crossed: bool | str | Handle = False,
        phi0: Number = 0.0,
        theta: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a BeltDrive: a belt or chain around two pulleys or sprockets about
        the frame origins, without slip or stretch.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        r_a : number or str [m]
            Radius about frame_a; positive.
        r_b : number or str [m]
            Radius about frame_b; positive.
        crossed : bool, optional
            Whether the strands cross, so that the pulleys turn in opposite senses.
        phi0 : number or str, optional [rad]
            Angle of frame_b when frame_a and the line of centres are at angle 0.
        theta, phi, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``theta``
            [rad] (angle of the line from frame_a to frame_b), ``phi`` [rad] (angle
            of frame_b relative to frame_a), ``w`` [rad/s] (relative angular
            velocity), ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force
            along y on frame_b), ``tau`` [N.m] (torque on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Body(
        self,
        name: str,
        *,
        m: Number,
        I: Number | None = None,
        length: Number | None = None,
        com: Vector = (0.0, 0.0),
        frames: Frames = {},
        x: Start | None = None,
        y: Start | None = None,
        phi: Start | None = None,
        vx: Start | None = None,
        vy: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Body: a planar rigid body. With a length it has frames a and b at
        its ends, and by default a uniform bar's inertia.

        Parameters
        ----------
        name : str
            Name of the component.
        m : number or str [kg]
            Mass; at least 0.
        I : number or str, optional [kg.m2]
            Moment of inertia about the centre of mass; default m length^2/12; at
            least 0.
        length : number or str, optional [m]
            Distance of the frames a and b, reference point halfway; positive.
        com : (2,) numbers or str, optional [m]
            Centre of mass, from the reference point.
        frames : mapping, optional
            Further frames: ``{"tip": (x, y)}`` [m] or ``{"tip": (x, y, phi)}`` [m,
            rad], from the reference point.
        x, y, phi, vx, vy, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its frames, and its signals ``x`` [m]
            (centre of mass), ``y`` [m] (centre of mass), ``phi`` [rad] (angle,
            counting turns), ``vx`` [m/s], ``vy`` [m/s], ``w`` [rad/s].

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Bushing(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        k: Vector = (0.0, 0.0),
        c: Vector = (0.0, 0.0),
        k_phi: Number = 0.0,
        c_phi: Number = 0.0,
        phi0: Number = 0.0,
        axes: Literal["frame_a", "world"] | Handle = "frame_a",
        x: Start | None = None,
        y: Start | None = None,
        phi: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Bushing: a compliant joint: spring and damper along x and y of
        frame_a, or of the world, and about the angle.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        k : (2,) numbers or str, optional [N/m]
            Stiffness along x and y of `axes`.
        c : (2,) numbers or str, optional [N.s/m]
            Damping along x and y of `axes`.
        k_phi : number or str, optional [N.m/rad]
            Torsional stiffness.
        c_phi : number or str, optional [N.m.s/rad]
            Torsional damping.
        phi0 : number or str, optional [rad]
            Angle without torque.
        axes : {"frame_a", "world"}, optional
            Axes of k and c, those of frame_a or of the world; one of "frame_a",
            "world".
        x, y, phi : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``x`` [m],
            ``y`` [m], ``phi`` [rad], ``power`` [W] (power delivered to the
            mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Cam(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        s: Law | Start,
        phi: Start | None = None,
        w: Start | None = None,
        v: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Cam: a cam about the origin of frame_a moves the origin of frame_b
        along the x axis of frame_b, as a function of the cam angle.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        s : number, str or Expr [m]
            Position of the follower at the cam angle phi; an expression of `phi`,
            parameters and tables.
        phi, w, v : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``phi``
            [rad] (angle of the cam relative to the axis of the follower), ``w``
            [rad/s] (angular velocity of the cam), ``s`` [m] (position of the
            follower along its x axis, from the centre of the cam), ``v`` [m/s] (its
            rate), ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force along y
            on frame_b), ``tau`` [N.m] (torque on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def CircleContact(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        r_a: Number,
        r_b: Number,
        internal: bool | str | Handle = False,
        k: Number,
        e: Number = 1.0,
        v_0: Number | None = None,
        s: Start | None = None,
        v: Start | None = None,
        depth: Start | None = None,
        force: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a CircleContact: contact of two circles about the frame origins,
        which push each other apart where they overlap; without friction.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        r_a : number or str [m]
            Radius about frame_a; positive.
        r_b : number or str [m]
            Radius about frame_b; positive.
        internal : bool, optional
            Whether circle a is a round hole that contains circle b.
        k : number or str [N/m]
            Stiffness; positive.
        e : number or str, optional
            Coefficient of restitution of an impact at the speed v_0; positive.
        v_0 : number or str, optional [m/s]
            Speed of approach of this impact; required with e < 1; positive.
        s, v, depth, force : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s`` [m]
            (distance of the frames), ``v`` [m/s] (its rate), ``depth`` [m]
            (overlap; negative: the gap), ``force`` [N] (contact force along the
            line of centres, positive if it pushes the centres apart), ``power`` [W]
            (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Coupling(
        self,
        name: str,
        a: Law,
        b: Law,
        *,
        ratio: Number = 1.0,
        offset: Law = 0.0,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Coupling: two coordinates in a fixed ratio: b = ratio*a + offset.
        They are angles or lengths, of joints or bodies, or expressions of
        these. It has no frames.

        Parameters
        ----------
        name : str
            Name of the component.
        a : number, str or Expr
            The first coordinate, such as `pin.phi`; may be an expression of
            positions.
        b : number, str or Expr
            The second coordinate; may be an expression of positions.
        ratio : number or str, optional [any]
            B divided by a, with the unit of b/a; required if a and b have different
            units.
        offset : number, str or Expr, optional
            B where a is zero, an expression in time with the unit of b; without
            signals and inputs.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``force``
            (generalised force on b: a torque [N.m] on an angle, else a force [N] on
            frame_b), ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Distance(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        length: Number,
        s: Start | None = None,
        v: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Distance: a massless rigid link: the distance of the two frame
        origins stays constant.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        length : number or str [m]
            The constant distance; positive.
        s, v : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s`` [m]
            (distance of the frames), ``v`` [m/s] (its rate), ``fx`` [N] (force
            along x on frame_b), ``fy`` [N] (force along y on frame_b), ``force``
            [N] (axial force, positive in tension).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def DistanceDriver(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        s: Law | Start,
        v: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a DistanceDriver: a linear actuator whose length is a given function
        of time.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        s : number, str or Expr [m]
            The distance, an expression in time; stays above zero; without signals
            and inputs.
        v : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s`` [m]
            (distance of the frames), ``v`` [m/s] (its rate), ``fx`` [N] (force
            along x on frame_b), ``fy`` [N] (force along y on frame_b), ``force``
            [N] (axial force, positive in tension), ``power`` [W] (power delivered
            to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def ElasticBelt(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        r_a: Number,
        r_b: Number,
        crossed: bool | str | Handle = False,
        k: Number,
        c: Number = 0.0,
        stretch: Start | None = None,
        force: Start | None = None,
        theta: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add an ElasticBelt: a belt or chain around two pulleys about the frame
        origins, which stretches and does not slip; without force at the start.
        The ratio of the radii is that of the speeds.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        r_a : number or str [m]
            Radius about frame_a; positive.
        r_b : number or str [m]
            Radius about frame_b; positive.
        crossed : bool, optional
            Whether the strands cross, so that the pulleys turn in opposite senses.
        k : number or str [N/m]
            Stiffness: twice that of one strand; positive.
        c : number or str, optional [N.s/m]
            Damping; at least 0.
        stretch, force, theta, phi, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``stretch``
            [m] (how far the rim of one pulley has run ahead of the other since the
            start), ``force`` [N] (difference of the tensions of the strands),
            ``theta`` [rad] (angle of the line from frame_a to frame_b), ``phi``
            [rad] (angle of frame_b relative to frame_a), ``w`` [rad/s] (relative
            angular velocity), ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Fixed(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        phi0: Number = 0.0,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Fixed: a weld: frame_b keeps position and angle relative to
        frame_a.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        phi0 : number or str, optional [rad]
            The constant angle of frame_b relative to frame_a.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``fx`` [N]
            (force along x on frame_b), ``fy`` [N] (force along y on frame_b),
            ``tau`` [N.m] (torque on frame_b), ``N`` [N] (normal force along x of
            frame_a, tension), ``Q`` [N] (shear force along y of frame_a), ``M``
            [N.m] (bending moment).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def FlexibleBeam(
        self,
        name: str,
        *,
        length: Number,
        density: Number | None = None,
        mass: Number | None = None,
        S: Number,
        I: Number,
        E: Number,
        rotary: Number = 0.0,
        formulation: Literal["floating", "ancf"] | Handle = "floating",
        elements: Number | None = None,
        modes: Number | None = None,
        axial: Number | None = None,
        basis: Literal["eigenmodes", "craig-bampton"] | Handle = "eigenmodes",
        reference: Literal["pinned-pinned", "clamped-free", "mean-axis"] | Handle = "pinned-pinned",
        stiffening: bool | str | Handle = True,
        zeta: Number = 0.0,
        alpha: Number = 0.0,
        beta: Number = 0.0,
        shape: Literal["undeformed", "static"] | Handle = "undeformed",
        frames: Frames = {},
        x: Start | None = None,
        y: Start | None = None,
        phi: Start | None = None,
        vx: Start | None = None,
        vy: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a FlexibleBeam: a uniform straight beam that bends and stretches in
        the plane, with frames a and b at its ends, c in its middle, and further
        frames on its axis; each frame rotates with its cross-section.

        Parameters
        ----------
        name : str
            Name of the component.
        length : number or str [m]
            Length, undeformed; positive.
        density : number or str, optional [kg/m3]
            Of the material; or give the mass; positive.
        mass : number or str, optional [kg]
            Of the whole beam; or give the density; positive.
        S : number or str [m2]
            Area of the section; positive.
        I : number or str [m4]
            Second moment of area of the section; positive.
        E : number or str [Pa]
            Young's modulus; positive.
        rotary : number or str, optional [kg.m]
            Rotary inertia of the section per length; at least 0.
        formulation : {"floating", "ancf"}, optional
            Small deformation in a floating frame, or large deformation by absolute
            nodal coordinates ("ancf"); one of "floating", "ancf".
        elements : number or str, optional
            Number of finite elements; default 4, with modes at least 16, with ANCF
            8.
        modes : number or str, optional
            Number of elastic coordinates; 0: a rigid rod; default: all those of the
            elements; at least 0.
        axial : number or str, optional
            Number of axial modes; default: those among the lowest frequencies; at
            least 0.
        basis : {"eigenmodes", "craig-bampton"}, optional
            Kind of the modes: eigenmodes under the reference conditions, or static
            shapes for displacements of the ends and eigenmodes between fixed ends
            (Craig-Bampton), orthogonalised; one of "eigenmodes", "craig-bampton".
        reference : {"pinned-pinned", "clamped-free", "mean-axis"}, optional
            Position of the floating frame: through both ends, tangent at frame a,
            or the mean axis; one of "pinned-pinned", "clamped-free", "mean-axis".
        stiffening : bool, optional
            Geometric stiffening: bending shortens the beam (floating frame).
        zeta : number or str, optional
            Damping ratio of every mode; at least 0.
        alpha : number or str, optional [1/s]
            Rayleigh damping: factor on the mass matrix of the elastic coordinates;
            at least 0.
        beta : number or str, optional [s]
            Rayleigh damping: factor on the stiffness matrix, as of a viscous
            material; at least 0.
        shape : {"undeformed", "static"}, optional
            Initial shape: undeformed, or that of the static equilibrium under the
            initial loads; one of "undeformed", "static".
        frames : mapping, optional
            Further frames: ``{"tip": (x, y)}`` [m] or ``{"tip": (x, y, phi)}`` [m,
            rad], from the reference point.
        x, y, phi, vx, vy, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its frames, and its signals ``x`` [m]
            (centre of mass), ``y`` [m] (centre of mass), ``phi`` [rad] (angle,
            counting turns), ``vx`` [m/s], ``vy`` [m/s], ``w`` [rad/s].

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Force(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        fx: Law = 0.0,
        fy: Law = 0.0,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Force: a force on the origin of frame_b, with components in the
        axes of frame_a, or of the world without frame_a. No reaction acts on
        frame_a. With frame_a = frame_b it is a follower force.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a`` (optional), ``frame_b``. A joint
            stands for its two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        fx : number, str or Expr, optional [N]
            Component along x, a number or an expression; may be an expression in
            time and signals.
        fy : number, str or Expr, optional [N]
            Component along y, a number or an expression; may be an expression in
            time and signals.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``power``
            [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def FreeMotion(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        x: Start | None = None,
        y: Start | None = None,
        phi: Start | None = None,
        vx: Start | None = None,
        vy: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a FreeMotion: no constraint on frame_b: declares that a body without
        joints or forces may move freely.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        x, y, phi, vx, vy, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``x`` [m]
            (in world axes), ``y`` [m] (in world axes), ``phi`` [rad], ``vx`` [m/s],
            ``vy`` [m/s], ``w`` [rad/s].

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def GearPair(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        r_a: Number,
        r_b: Number,
        internal: bool | str | Handle = False,
        phi0: Number = 0.0,
        theta: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a GearPair: two gears in mesh: their pitch circles about the frame
        origins roll on each other. Other joints hold the centres apart, on the
        ground or on a moving carrier.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        r_a : number or str [m]
            Pitch radius about frame_a; positive.
        r_b : number or str [m]
            Pitch radius about frame_b; positive.
        internal : bool, optional
            Whether frame_b is a ring gear with internal teeth, around frame_a.
        phi0 : number or str, optional [rad]
            Angle of frame_b when frame_a and the line of centres are at angle 0.
        theta, phi, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``theta``
            [rad] (angle of the line from frame_a to frame_b), ``phi`` [rad] (angle
            of frame_b relative to frame_a), ``w`` [rad/s] (relative angular
            velocity), ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force
            along y on frame_b), ``tau`` [N.m] (torque on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Ground(
        self,
        name: str,
        *,
        g: Number = 9.81,
        n: Vector = (0.0, -1.0),
        frames: Frames = {},
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Ground: the inertial world. Its name stands for the frame at the
        origin; gravity acts on every body.

        Parameters
        ----------
        name : str
            Name of the component.
        g : number or str, optional [m/s2]
            Gravitational acceleration; at least 0.
        n : (2,) numbers or str, optional
            Direction of gravity, of length 1.
        frames : mapping, optional
            Further frames: ``{"tip": (x, y)}`` [m] or ``{"tip": (x, y, phi)}`` [m,
            rad], from the reference point.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component.

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def KnifeEdge(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        v: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a KnifeEdge: a blade at the origin of frame_b: it moves along its x
        axis and turns, but does not slip along its y axis.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a`` (optional), ``frame_b``. A joint
            stands for its two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        v, phi, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``v`` [m/s]
            (velocity along the blade), ``phi`` [rad] (angle of frame_b relative to
            frame_a), ``w`` [rad/s] (relative angular velocity), ``fx`` [N] (force
            along x on frame_b), ``fy`` [N] (force along y on frame_b), ``tau``
            [N.m] (torque on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def PlanarWorld(
        self,
        name: str,
        *,
        g: Number = 9.81,
        n: Vector = (0.0, -1.0),
        frames: Frames = {},
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a PlanarWorld: the inertial world. Its name stands for the frame at
        the origin; gravity acts on every body.

        Parameters
        ----------
        name : str
            Name of the component.
        g : number or str, optional [m/s2]
            Gravitational acceleration; at least 0.
        n : (2,) numbers or str, optional
            Direction of gravity, of length 1.
        frames : mapping, optional
            Further frames: ``{"tip": (x, y)}`` [m] or ``{"tip": (x, y, phi)}`` [m,
            rad], from the reference point.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component.

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def PlanetaryGear(
        self,
        name: str,
        sun: Law,
        carrier: Law,
        ring: Law,
        *,
        ratio: Number,
        phi0: Number = 0.0,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a PlanetaryGear: a planetary stage as one part: sun - carrier =
        -ratio*(ring - carrier) + phi0, with the angles of the three shafts, of
        joints on one axis or of bodies. It has no frames.

        Parameters
        ----------
        name : str
            Name of the component.
        sun : number, str or Expr [rad]
            Angle of the sun, such as `sun_pin.phi`; may be an expression of
            positions.
        carrier : number, str or Expr [rad]
            Angle of the carrier of the planets; may be an expression of positions.
        ring : number, str or Expr [rad]
            Angle of the ring; may be an expression of positions.
        ratio : number or str
            Teeth of the ring divided by teeth of the sun.
        phi0 : number or str, optional [rad]
            Angle of the sun where those of ring and carrier are zero.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``tau_sun``
            [N.m] (torque on the sun on frame_b), ``tau_carrier`` [N.m] (torque on
            the carrier on frame_b), ``tau_ring`` [N.m] (torque on the ring on
            frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def PointMass(
        self,
        name: str,
        *,
        m: Number,
        x: Start | None = None,
        y: Start | None = None,
        phi: Start | None = None,
        vx: Start | None = None,
        vy: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a PointMass: a mass at a point. Its name stands for its only frame,
        which only welds and sliding joints can turn.

        Parameters
        ----------
        name : str
            Name of the component.
        m : number or str [kg]
            Mass; zero where joints hold the point; at least 0.
        x, y, phi, vx, vy, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its frames, and its signals ``x`` [m]
            (centre of mass), ``y`` [m] (centre of mass), ``phi`` [rad] (always 0),
            ``vx`` [m/s], ``vy`` [m/s], ``w`` [rad/s] (always 0).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def PointOnCircle(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        radius: Number,
        theta: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a PointOnCircle: a pin in a circular slot: the origin of frame_b
        stays on a circle about the origin of frame_a.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        radius : number or str [m]
            Radius of the circle; positive.
        theta, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``theta``
            [rad] (angle of the point from the x axis of frame_a), ``w`` [rad/s]
            (its rate), ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force
            along y on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def PointOnLine(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        mu: Number = 0.0,
        mu_s: Number | None = None,
        v_s: Number = 0.001,
        v_st: Number | None = None,
        s: Start | None = None,
        v: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a PointOnLine: a pin in a slot: the origin of frame_b stays on the x
        axis of frame_a.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        mu : number or str, optional
            Coefficient of friction; 0: none; at least 0.
        mu_s : number or str, optional
            Coefficient around standstill; default mu; at least 0.
        v_s : number or str, optional [m/s]
            Speed over which friction changes its sign: tanh(v/v_s); positive.
        v_st : number or str, optional [m/s]
            Stribeck speed; default 40 v_s; positive.
        s, v, phi, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s`` [m]
            (position of frame_b along the axis), ``v`` [m/s] (sliding velocity),
            ``phi`` [rad] (angle of frame_b relative to frame_a), ``w`` [rad/s]
            (relative angular velocity), ``fx`` [N] (force along x on frame_b),
            ``fy`` [N] (force along y on frame_b), ``power`` [W] (power delivered to
            the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Prismatic(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        phi0: Number = 0.0,
        mu: Number = 0.0,
        mu_s: Number | None = None,
        v_s: Number = 0.001,
        v_st: Number | None = None,
        s: Start | None = None,
        v: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Prismatic: a sliding joint: frame_b moves on the x axis of frame_a
        and keeps its angle to it.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        phi0 : number or str, optional [rad]
            The constant angle of frame_b relative to frame_a.
        mu : number or str, optional
            Coefficient of friction; 0: none; at least 0.
        mu_s : number or str, optional
            Coefficient around standstill; default mu; at least 0.
        v_s : number or str, optional [m/s]
            Speed over which friction changes its sign: tanh(v/v_s); positive.
        v_st : number or str, optional [m/s]
            Stribeck speed; default 40 v_s; positive.
        s, v : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s`` [m]
            (position of frame_b along the axis), ``v`` [m/s] (sliding velocity),
            ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force along y on
            frame_b), ``tau`` [N.m] (torque on frame_b), ``power`` [W] (power
            delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def RackAndPinion(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        radius: Number,
        s0: Number = 0.0,
        s: Start | None = None,
        v: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a RackAndPinion: a pinion about the origin of frame_b rolls on a
        rack along the x axis of frame_a, above it. Other joints guide the rack
        and hold the pinion.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        radius : number or str [m]
            Pitch radius of the pinion; positive.
        s0 : number or str, optional [m]
            Position of the pinion along the rack when frame_b is at the angle of
            frame_a.
        s, v, phi, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s`` [m]
            (position of frame_b along the axis), ``v`` [m/s] (sliding velocity),
            ``phi`` [rad] (angle of frame_b relative to frame_a), ``w`` [rad/s]
            (relative angular velocity), ``fx`` [N] (force along x on frame_b),
            ``fy`` [N] (force along y on frame_b), ``tau`` [N.m] (torque on
            frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Revolute(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        radius: Number | None = None,
        mu: Number = 0.0,
        mu_s: Number | None = None,
        w_s: Number = 0.01,
        w_st: Number | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Revolute: a pin joint: the origins of frame_a and frame_b
        coincide.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        radius : number or str, optional [m]
            Radius of the pin; required with friction; positive.
        mu : number or str, optional
            Coefficient of friction; 0: none; at least 0.
        mu_s : number or str, optional
            Coefficient around standstill; default mu; at least 0.
        w_s : number or str, optional [rad/s]
            Speed over which friction changes its sign: tanh(w/w_s); positive.
        w_st : number or str, optional [rad/s]
            Stribeck speed; default 40 w_s; positive.
        phi, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``phi``
            [rad] (angle of frame_b relative to frame_a), ``w`` [rad/s] (relative
            angular velocity), ``fx`` [N] (force along x on frame_b), ``fy`` [N]
            (force along y on frame_b), ``power`` [W] (power delivered to the
            mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Rod(
        self,
        name: str,
        *,
        m: Number,
        length: Number,
        frames: Frames = {},
        x: Start | None = None,
        y: Start | None = None,
        phi: Start | None = None,
        vx: Start | None = None,
        vy: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Rod: a uniform rigid bar: centre of mass at the midpoint, I = m
        length^2/12, frames a and b at its ends.

        Parameters
        ----------
        name : str
            Name of the component.
        m : number or str [kg]
            Mass; at least 0.
        length : number or str [m]
            Distance of the frames a and b; positive.
        frames : mapping, optional
            Further frames: ``{"tip": (x, y)}`` [m] or ``{"tip": (x, y, phi)}`` [m,
            rad], from the reference point.
        x, y, phi, vx, vy, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its frames, and its signals ``x`` [m]
            (centre of mass), ``y`` [m] (centre of mass), ``phi`` [rad] (angle,
            counting turns), ``vx`` [m/s], ``vy`` [m/s], ``w`` [rad/s].

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def RollingDisc(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        radius: Number,
        s: Start | None = None,
        v: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a RollingDisc: a disc with its centre at the origin of frame_b rolls
        without slip on the x axis of frame_a, above it.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        radius : number or str [m]
            Radius of the disc; positive.
        s, v, phi, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s`` [m]
            (position of frame_b along the axis), ``v`` [m/s] (velocity of the
            centre along the axis), ``phi`` [rad] (angle of frame_b relative to
            frame_a), ``w`` [rad/s] (relative angular velocity), ``fx`` [N] (force
            along x on frame_b), ``fy`` [N] (force along y on frame_b), ``tau``
            [N.m] (torque on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Rope(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        k: Number,
        c: Number = 0.0,
        length: Number | None = None,
        over: Places = (),
        radius: Number | Vector | None = None,
        turns: Number | Vector = 0.0,
        mu: Number | None = None,
        v_s: Number = 0.001,
        drum: Number | Vector = 0.0,
        s: Start | None = None,
        v: Start | None = None,
        stretch: Start | None = None,
        tension: Start | None = None,
        taken: Start | None = None,
        tension_b: Start | None = None,
        slack: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Rope: a rope, cable or chain that pulls its ends together and
        never pushes. It may run over discs, and be wound on drums.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        k : number or str [N/m]
            Stiffness of the whole rope; positive.
        c : number or str, optional [N.s/m]
            Damping; at least 0.
        length : number or str, optional [m]
            Free length at the start, without what is wound on drums; default: that
            of the path at the start; positive.
        over : Handle, str or sequence of them, optional
            Frames, or bodies with their centres of mass, at the centres of the
            discs that it runs over, from frame_a to frame_b: `{wheel,
            block.sheave}`.
        radius : number or str, optional [m]
            Radius of each disc, or of all of them; positive if the rope turns to
            the left around the disc (in space: counter-clockwise about the z axis
            of its frame), negative if it turns to the right.
        turns : number or str, optional
            Full turns around each disc, in addition to less than one.
        mu : number or str, optional
            Coefficient of friction between rope and discs (0: none); without it,
            the rope does not slide: the discs turn with it; at least 0.
        v_s : number or str, optional [m/s]
            Speed over which this friction changes its sign: tanh(v/v_s); positive.
        drum : number or str, optional [m]
            Radius of a drum about frame_b, or of drums about both ends, on which it
            is wound; signs as of `radius`.
        s, v, stretch, tension, taken, tension_b, slack : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s`` [m]
            (length of the path), ``v`` [m/s] (its rate), ``stretch`` [m] (by how
            much the rope is longer than its free length), ``tension`` [N] (tension
            at frame_a), ``taken`` [m] (rope used by the first span, with what its
            discs have wound up or paid out), ``tension_b`` [N] (tension at
            frame_b), ``slack`` (1 where the rope is not stretched), ``power`` [W]
            (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def RotationalCam(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        beta: Law | Start,
        theta: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        w_b: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a RotationalCam: a cam about the origin of frame_a turns frame_b
        about its origin, as a function of the cam angle. Both angles are
        measured from the line between the origins.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        beta : number, str or Expr [rad]
            Angle of the follower at the cam angle phi; an expression of `phi`,
            parameters and tables.
        theta, phi, w, w_b : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``theta``
            [rad] (angle of the line from frame_a to frame_b), ``phi`` [rad] (angle
            of the cam, from this line), ``beta`` [rad] (angle of the follower, from
            this line), ``w`` [rad/s] (angular velocity of the cam), ``w_b`` [rad/s]
            (angular velocity of the follower), ``fx`` [N] (force along x on
            frame_b), ``fy`` [N] (force along y on frame_b), ``tau`` [N.m] (torque
            on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def RotationalDriver(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        phi: Law | Start,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a RotationalDriver: a drive that turns a joint as a given function
        of time.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        phi : number, str or Expr [rad]
            The angle, an expression in time; without signals and inputs.
        w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``phi``
            [rad] (angle of frame_b relative to frame_a), ``w`` [rad/s] (relative
            angular velocity), ``tau`` [N.m] (torque on frame_b), ``power`` [W]
            (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def RotationalSpringDamper(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        k: Number = 0.0,
        c: Number = 0.0,
        phi0: Number = 0.0,
        torque: Law | Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a RotationalSpringDamper: a torsional spring and damper between two
        frames; positive torque resists a growing angle.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        k : number or str, optional [N.m/rad]
            Stiffness.
        c : number or str, optional [N.m.s/rad]
            Damping.
        phi0 : number or str, optional [rad]
            Angle without torque.
        torque : number, str or Expr, optional [N.m]
            Torque as an expression, e.g. of phi and w; instead of k and c; may be
            an expression in time and signals.
        phi, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``phi``
            [rad] (angle of frame_b relative to frame_a), ``w`` [rad/s] (relative
            angular velocity), ``torque`` [N.m] (resisting torque), ``power`` [W]
            (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def RotationalStop(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        phi_min: Number | None = None,
        phi_max: Number | None = None,
        k: Number,
        e: Number = 1.0,
        w_0: Number | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        torque: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a RotationalStop: limits of an angle: beyond them a stiff torsional
        spring pushes back; it never pulls.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        phi_min : number or str, optional [rad]
            Lower limit; no limit if omitted.
        phi_max : number or str, optional [rad]
            Upper limit; no limit if omitted.
        k : number or str [N.m/rad]
            Stiffness; positive.
        e : number or str, optional
            Coefficient of restitution of an impact at the speed w_0; positive.
        w_0 : number or str, optional [rad/s]
            Speed of approach of this impact; required with e < 1; positive.
        phi, w, torque : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``phi``
            [rad] (angle of frame_b relative to frame_a), ``w`` [rad/s] (relative
            angular velocity), ``torque`` [N.m] (resisting torque), ``power`` [W]
            (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def RotationalVelocityDriver(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        w: Law | Start,
        phi: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a RotationalVelocityDriver: a drive that turns a joint with a given
        angular velocity.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        w : number, str or Expr [rad/s]
            The angular velocity; may be an expression in time and signals.
        phi : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``phi``
            [rad] (angle of frame_b relative to frame_a), ``w`` [rad/s] (relative
            angular velocity), ``tau`` [N.m] (torque on frame_b), ``power`` [W]
            (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Sensor(
        self,
        name: str,
        *frames: Place,
        frame: Place | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Sensor: measures at a frame, in the axes of this frame: an
        accelerometer, a gyroscope, and the load of all joints and forces that
        are attached to the frame, on its body. It acts on nothing.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame``. A joint stands for its two frames.
        frame : Handle or str, optional
            The same frames by name.
        w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``w``
            [rad/s] (angular velocity), ``ax`` [m/s2] (specific force along x:
            acceleration minus gravity), ``ay`` [m/s2] (specific force along y:
            acceleration minus gravity), ``fx`` [N] (force on the body along x),
            ``fy`` [N] (force on the body along y), ``tau`` [N.m] (torque on the
            body about the origin of the frame).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def SpringDamper(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        k: Number = 0.0,
        c: Number = 0.0,
        s0: Number = 0.0,
        force: Law | Start | None = None,
        s: Start | None = None,
        v: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a SpringDamper: a spring and damper along the line between two
        points; positive force pulls them together.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        k : number or str, optional [N/m]
            Stiffness.
        c : number or str, optional [N.s/m]
            Damping.
        s0 : number or str, optional [m]
            Free length.
        force : number, str or Expr, optional [N]
            Tension as an expression, e.g. of s and v; instead of k and c; may be an
            expression in time and signals.
        s, v : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s`` [m]
            (distance of the frames), ``v`` [m/s] (its rate), ``force`` [N]
            (tension), ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Torque(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        tau: Law,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Torque: a torque on frame_b and its reaction on frame_a; positive
        is counter-clockwise on frame_b.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a`` (optional), ``frame_b``. A joint
            stands for its two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        tau : number, str or Expr [N.m]
            The torque, a number or an expression; may be an expression in time and
            signals.
        phi, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``phi``
            [rad] (angle of frame_b relative to frame_a), ``w`` [rad/s] (relative
            angular velocity), ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def TranslationalDriver(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        s: Law | Start,
        v: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a TranslationalDriver: a drive that moves a sliding joint as a given
        function of time.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        s : number, str or Expr [m]
            The position, an expression in time; without signals and inputs.
        v : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s`` [m]
            (position of frame_b along the axis), ``v`` [m/s] (sliding velocity),
            ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force along y on
            frame_b), ``force`` [N] (axial force, positive in tension), ``power``
            [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def TranslationalSpringDamper(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        k: Number = 0.0,
        c: Number = 0.0,
        s0: Number = 0.0,
        force: Law | Start | None = None,
        s: Start | None = None,
        v: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a TranslationalSpringDamper: a spring and damper along the x axis of
        frame_a; positive force resists a growing position s.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        k : number or str, optional [N/m]
            Stiffness.
        c : number or str, optional [N.s/m]
            Damping.
        s0 : number or str, optional [m]
            Position without force.
        force : number, str or Expr, optional [N]
            Force as an expression, e.g. of s and v; instead of k and c; may be an
            expression in time and signals.
        s, v : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s`` [m]
            (position of frame_b along the axis), ``v`` [m/s] (sliding velocity),
            ``force`` [N] (resisting force), ``power`` [W] (power delivered to the
            mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def TranslationalStop(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        s_min: Number | None = None,
        s_max: Number | None = None,
        k: Number,
        e: Number = 1.0,
        v_0: Number | None = None,
        s: Start | None = None,
        v: Start | None = None,
        force: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a TranslationalStop: end stops of a sliding joint, or one-sided
        contact of a point with a line: beyond its limits a stiff spring pushes
        back; it never pulls.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        s_min : number or str, optional [m]
            Lower limit; no limit if omitted.
        s_max : number or str, optional [m]
            Upper limit; no limit if omitted.
        k : number or str [N/m]
            Stiffness; positive.
        e : number or str, optional
            Coefficient of restitution of an impact at the speed v_0; positive.
        v_0 : number or str, optional [m/s]
            Speed of approach of this impact; required with e < 1; positive.
        s, v, force : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s`` [m]
            (position of frame_b along the axis), ``v`` [m/s] (sliding velocity),
            ``force`` [N] (resisting force), ``power`` [W] (power delivered to the
            mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def TranslationalVelocityDriver(
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        v: Law | Start,
        s: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a TranslationalVelocityDriver: a drive that moves a sliding joint
        with a given velocity.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        v : number, str or Expr [m/s]
            The velocity; may be an expression in time and signals.
        s : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s`` [m]
            (position of frame_b along the axis), ``v`` [m/s] (sliding velocity),
            ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force along y on
            frame_b), ``force`` [N] (axial force, positive in tension), ``power``
            [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def VelocityConstraint(
        self,
        name: str,
        *,
        gamma: Law,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a VelocityConstraint: an expression of velocities that remains zero,
        such as the ratio of a gear. It has no frames.

        Parameters
        ----------
        name : str
            Name of the component.
        gamma : number, str or Expr
            An expression of velocities that remains zero, of any unit; may be an
            expression in time and signals.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component.

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def World(
        self,
        name: str,
        *,
        g: Number = 9.81,
        n: Vector = (0.0, -1.0),
        frames: Frames = {},
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a World: the inertial world. Its name stands for the frame at the
        origin; gravity acts on every body.

        Parameters
        ----------
        name : str
            Name of the component.
        g : number or str, optional [m/s2]
            Gravitational acceleration; at least 0.
        n : (2,) numbers or str, optional
            Direction of gravity, of length 1.
        frames : mapping, optional
            Further frames: ``{"tip": (x, y)}`` [m] or ``{"tip": (x, y, phi)}`` [m,
            rad], from the reference point.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component.

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """
