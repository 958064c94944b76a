"""The Builder of models in space: made by ``python -m mbdsl.lang.kind_stub``."""

from typing import Literal

from mbdsl.lang.builder import Builder
from mbdsl.lang.handles import Frames, Handle, Law, Number, Place, Places, Start, Vector

class SpatialBuilder(Builder):
    """Collects the components of a model in space and makes a ``Scene`` of them."""

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
    ) -> Handle: ...
    FlexibleBeam: None  # type: ignore[assignment]
    PlanarWorld: None  # type: ignore[assignment]

    def BeltDrive(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        r_a: Number,
        r_b: Number,
        crossed: bool | str | Handle = False,
        phi0: Number = 0.0,
        n: Vector = (0.0, 0.0, 1.0),
        theta: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        phi_a: Start | None = None,
        phi_b: Start | None = None,
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
        n : (3,) numbers or str, optional
            Axis of the rotation, in frame_a.
        theta, phi, w, phi_a, phi_b : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``theta``
            [rad] (angle of the line from frame_a to frame_b about the z axis of the
            world), ``phi`` [rad] (angle of frame_b about the axis of frame_a),
            ``w`` [rad/s] (its rate), ``phi_a`` [rad] (angle of frame_a from the
            line of centres), ``phi_b`` [rad] (angle of frame_b from the line of
            centres), ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force along
            y on frame_b), ``fz`` [N] (force along z on frame_b), ``tx`` [N.m]
            (torque about x on frame_b), ``ty`` [N.m] (torque about y on frame_b),
            ``tz`` [N.m] (torque about z on frame_b), ``tau`` [N.m] (torque about
            the z axis of the world on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Body(  # type: ignore[override]
        self,
        name: str,
        *,
        m: Number,
        I: Vector | None = None,
        length: Number | None = None,
        com: Vector = (0.0, 0.0, 0.0),
        frames: Frames = {},
        x: Start | None = None,
        y: Start | None = None,
        z: Start | None = None,
        phi: Start | None = None,
        vx: Start | None = None,
        vy: Start | None = None,
        vz: Start | None = None,
        wx: Start | None = None,
        wy: Start | None = None,
        wz: Start | None = None,
        w: Start | None = None,
        phi_x: Start | None = None,
        phi_y: Start | None = None,
        phi_z: Start | None = None,
        wx_local: Start | None = None,
        wy_local: Start | None = None,
        wz_local: Start | None = None,
        p0: Start | None = None,
        p1: Start | None = None,
        p2: Start | None = None,
        p3: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Body: a rigid body in space.

        Parameters
        ----------
        name : str
            Name of the component.
        m : number or str [kg]
            Mass; at least 0.
        I : (3,) numbers or str, optional [kg.m2]
            Moments of inertia {Ixx, Iyy, Izz} about the centre of mass, the matrix
            of inertia, or one moment, which is the same about all axes.
        length : number or str, optional [m]
            Distance of the frames a and b, reference point halfway; positive.
        com : (3,) numbers or str, optional [m]
            Centre of mass, from the reference point.
        frames : mapping, optional
            Further frames: ``{"tip": (x, y, z)}`` [m], from the reference point, or
            with an orientation as of the method ``frame``: ``{"tip": {"r": (x, y,
            z), "angles": (a, b, c)}}`` [m, rad].
        x, y, z, phi, vx, vy, vz, wx, wy, wz, w, phi_x : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        phi_y, phi_z, wx_local, wy_local, wz_local, p0, p1, p2, p3 : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its frames, and its signals ``x`` [m]
            (centre of mass), ``y`` [m] (centre of mass), ``z`` [m] (centre of
            mass), ``phi`` [rad] (angle of the x axis about the z axis of the
            world), ``vx`` [m/s], ``vy`` [m/s], ``vz`` [m/s], ``wx`` [rad/s]
            (angular velocity, in world axes), ``wy`` [rad/s] (angular velocity, in
            world axes), ``wz`` [rad/s] (angular velocity, in world axes), ``w``
            [rad/s] (angular velocity about the z axis of the world), ``phi_x``
            [rad] (first Cardan angle, about the x axis of the world), ``phi_y``
            [rad] (second Cardan angle, about the turned y axis), ``phi_z`` [rad]
            (third Cardan angle, about the own z axis), ``wx_local`` [rad/s]
            (angular velocity about the own x axis), ``wy_local`` [rad/s] (angular
            velocity about the own y axis), ``wz_local`` [rad/s] (angular velocity
            about the own z axis), ``p0`` (quaternion, scalar part), ``p1``
            (quaternion, x part), ``p2`` (quaternion, y part), ``p3`` (quaternion, z
            part).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Box(  # type: ignore[override]
        self,
        name: str,
        *,
        m: Number | None = None,
        rho: Number | None = None,
        length: Number,
        width: Number,
        height: Number,
        frames: Frames = {},
        x: Start | None = None,
        y: Start | None = None,
        z: Start | None = None,
        phi: Start | None = None,
        vx: Start | None = None,
        vy: Start | None = None,
        vz: Start | None = None,
        wx: Start | None = None,
        wy: Start | None = None,
        wz: Start | None = None,
        w: Start | None = None,
        phi_x: Start | None = None,
        phi_y: Start | None = None,
        phi_z: Start | None = None,
        wx_local: Start | None = None,
        wy_local: Start | None = None,
        wz_local: Start | None = None,
        p0: Start | None = None,
        p1: Start | None = None,
        p2: Start | None = None,
        p3: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Box: a uniform cuboid; frames a and b are in the middle of its
        ends, at -length/2 and length/2 on its x axis.

        Parameters
        ----------
        name : str
            Name of the component.
        m : number or str, optional [kg]
            Mass; or give the density; at least 0.
        rho : number or str, optional [kg/m3]
            Density, in place of the mass; positive.
        length : number or str [m]
            Edge along x; positive.
        width : number or str [m]
            Edge along y; positive.
        height : number or str [m]
            Edge along z; positive.
        frames : mapping, optional
            Further frames: ``{"tip": (x, y, z)}`` [m], from the reference point, or
            with an orientation as of the method ``frame``: ``{"tip": {"r": (x, y,
            z), "angles": (a, b, c)}}`` [m, rad].
        x, y, z, phi, vx, vy, vz, wx, wy, wz, w, phi_x : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        phi_y, phi_z, wx_local, wy_local, wz_local, p0, p1, p2, p3 : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its frames, and its signals ``x`` [m]
            (centre of mass), ``y`` [m] (centre of mass), ``z`` [m] (centre of
            mass), ``phi`` [rad] (angle of the x axis about the z axis of the
            world), ``vx`` [m/s], ``vy`` [m/s], ``vz`` [m/s], ``wx`` [rad/s]
            (angular velocity, in world axes), ``wy`` [rad/s] (angular velocity, in
            world axes), ``wz`` [rad/s] (angular velocity, in world axes), ``w``
            [rad/s] (angular velocity about the z axis of the world), ``phi_x``
            [rad] (first Cardan angle, about the x axis of the world), ``phi_y``
            [rad] (second Cardan angle, about the turned y axis), ``phi_z`` [rad]
            (third Cardan angle, about the own z axis), ``wx_local`` [rad/s]
            (angular velocity about the own x axis), ``wy_local`` [rad/s] (angular
            velocity about the own y axis), ``wz_local`` [rad/s] (angular velocity
            about the own z axis), ``p0`` (quaternion, scalar part), ``p1``
            (quaternion, x part), ``p2`` (quaternion, y part), ``p3`` (quaternion, z
            part).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Bushing(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        k: Vector = (0.0, 0.0, 0.0),
        c: Vector = (0.0, 0.0, 0.0),
        k_phi: Vector = (0.0, 0.0, 0.0),
        c_phi: Vector = (0.0, 0.0, 0.0),
        c_w: Vector = (0.0, 0.0, 0.0),
        phi0: Number = 0.0,
        axes: Literal["frame_a", "world"] | Handle = "frame_a",
        x: Start | None = None,
        y: Start | None = None,
        z: Start | None = None,
        phi_x: Start | None = None,
        phi_y: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Bushing: a compliant joint: spring and damper along and about x, y
        and z of frame_a; along those of the world with `axes = "world"`.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        k : (3,) numbers or str, optional [N/m]
            Stiffness along x, y and z of `axes`.
        c : (3,) numbers or str, optional [N.s/m]
            Damping along x, y and z of `axes`.
        k_phi : (3,) numbers or str, optional [N.m/rad]
            Stiffness about x, y and z; a number: about z.
        c_phi : (3,) numbers or str, optional [N.m.s/rad]
            Damping of the rates of phi_x, phi_y and phi; a number: of phi.
        c_w : (3,) numbers or str, optional [N.m.s/rad]
            Damping of the relative angular velocity about x, y and z of frame_a; a
            number: about all axes.
        phi0 : number or str, optional [rad]
            Twist without torque.
        axes : {"frame_a", "world"}, optional
            Axes of k and c, those of frame_a or of the world; one of "frame_a",
            "world".
        x, y, z, phi_x, phi_y, phi, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``x`` [m]
            (position along x of the axes of k and c), ``y`` [m] (position along y
            of the axes of k and c), ``z`` [m] (position along z of the axes of k
            and c), ``phi_x`` [rad] (tilt about x of frame_a), ``phi_y`` [rad] (tilt
            about y of frame_a), ``phi`` [rad] (twist about z of frame_a), ``w``
            [rad/s] (rate of the twist), ``power`` [W] (power delivered to the
            mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Cam(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        s: Law | Start,
        n: Vector = (1.0, 0.0, 0.0),
        axis: Vector = (0.0, 0.0, 1.0),
        phi: Start | None = None,
        w: Start | None = None,
        v: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Cam: a cam about the origin of frame_a moves the origin of frame_b
        along n of frame_b, as a function of the cam angle.

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
        n : (3,) numbers or str, optional
            Direction of the follower's motion.
        axis : (3,) numbers or str, optional
            Axis of the cam, at right angles to n.
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
            [rad] (angle of the cam relative to frame_b), ``w`` [rad/s] (angular
            velocity of the cam), ``s`` [m] (position of the follower along n, from
            the centre of the cam), ``v`` [m/s] (its rate), ``fx`` [N] (force along
            x on frame_b), ``fy`` [N] (force along y on frame_b), ``fz`` [N] (force
            along z on frame_b), ``tx`` [N.m] (torque about x on frame_b), ``ty``
            [N.m] (torque about y on frame_b), ``tz`` [N.m] (torque about z on
            frame_b), ``tau`` [N.m] (torque about the z axis of the world on
            frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def CircleContact(  # type: ignore[override]
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
        """Add a CircleContact: contact of two balls about the frame origins, which
        push each other apart where they overlap; without friction.

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

    def ConstantVelocity(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        n: Vector = (0.0, 0.0, 1.0),
        phi_x: Start | None = None,
        phi_y: Start | None = None,
        w_x: Start | None = None,
        w_y: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a ConstantVelocity: a homokinetic joint: shafts along n at any bend,
        with the same rotation about them.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        n : (3,) numbers or str, optional
            Direction of the shafts, in both frames.
        phi_x, phi_y, w_x, w_y : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``phi_x``
            [rad] (bend of the shaft of frame_b about the x axis of the joint in
            frame_a), ``phi_y`` [rad] (bend about the y axis, which phi_x has
            turned), ``w_x`` [rad/s] (rate of phi_x), ``w_y`` [rad/s] (rate of
            phi_y), ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force along y
            on frame_b), ``fz`` [N] (force along z on frame_b), ``tx`` [N.m] (torque
            about x on frame_b), ``ty`` [N.m] (torque about y on frame_b), ``tz``
            [N.m] (torque about z on frame_b), ``tau`` [N.m] (torque about the z
            axis of the world on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Coupling(  # type: ignore[override]
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

    def Cylinder(  # type: ignore[override]
        self,
        name: str,
        *,
        m: Number | None = None,
        rho: Number | None = None,
        length: Number,
        radius: Number,
        bore: Number = 0.0,
        n: Vector = (1.0, 0.0, 0.0),
        frames: Frames = {},
        x: Start | None = None,
        y: Start | None = None,
        z: Start | None = None,
        phi: Start | None = None,
        vx: Start | None = None,
        vy: Start | None = None,
        vz: Start | None = None,
        wx: Start | None = None,
        wy: Start | None = None,
        wz: Start | None = None,
        w: Start | None = None,
        phi_x: Start | None = None,
        phi_y: Start | None = None,
        phi_z: Start | None = None,
        wx_local: Start | None = None,
        wy_local: Start | None = None,
        wz_local: Start | None = None,
        p0: Start | None = None,
        p1: Start | None = None,
        p2: Start | None = None,
        p3: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Cylinder: a uniform circular cylinder or tube; frames a and b are
        in the middle of its ends, b in the direction n.

        Parameters
        ----------
        name : str
            Name of the component.
        m : number or str, optional [kg]
            Mass; or give the density; at least 0.
        rho : number or str, optional [kg/m3]
            Density, in place of the mass; positive.
        length : number or str [m]
            Length along the axis; positive.
        radius : number or str [m]
            Radius; positive.
        bore : number or str, optional [m]
            Radius of the bore, of a tube; at least 0.
        n : (3,) numbers or str, optional
            Direction of the axis.
        frames : mapping, optional
            Further frames: ``{"tip": (x, y, z)}`` [m], from the reference point, or
            with an orientation as of the method ``frame``: ``{"tip": {"r": (x, y,
            z), "angles": (a, b, c)}}`` [m, rad].
        x, y, z, phi, vx, vy, vz, wx, wy, wz, w, phi_x : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        phi_y, phi_z, wx_local, wy_local, wz_local, p0, p1, p2, p3 : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its frames, and its signals ``x`` [m]
            (centre of mass), ``y`` [m] (centre of mass), ``z`` [m] (centre of
            mass), ``phi`` [rad] (angle of the x axis about the z axis of the
            world), ``vx`` [m/s], ``vy`` [m/s], ``vz`` [m/s], ``wx`` [rad/s]
            (angular velocity, in world axes), ``wy`` [rad/s] (angular velocity, in
            world axes), ``wz`` [rad/s] (angular velocity, in world axes), ``w``
            [rad/s] (angular velocity about the z axis of the world), ``phi_x``
            [rad] (first Cardan angle, about the x axis of the world), ``phi_y``
            [rad] (second Cardan angle, about the turned y axis), ``phi_z`` [rad]
            (third Cardan angle, about the own z axis), ``wx_local`` [rad/s]
            (angular velocity about the own x axis), ``wy_local`` [rad/s] (angular
            velocity about the own y axis), ``wz_local`` [rad/s] (angular velocity
            about the own z axis), ``p0`` (quaternion, scalar part), ``p1``
            (quaternion, x part), ``p2`` (quaternion, y part), ``p3`` (quaternion, z
            part).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Cylindrical(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        n: Vector = (1.0, 0.0, 0.0),
        radius: Number | None = None,
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
        """Add a Cylindrical: frame_b slides along the axis n of frame_a and turns
        about it.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        n : (3,) numbers or str, optional
            Axis of the motion, in frame_a.
        radius : number or str, optional [m]
            Radius of the shaft; without it, rotation has no friction; positive.
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
            (position of frame_b along the axis), ``v`` [m/s] (its rate), ``phi``
            [rad] (angle of frame_b about the axis), ``w`` [rad/s] (its rate),
            ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force along y on
            frame_b), ``fz`` [N] (force along z on frame_b), ``tx`` [N.m] (torque
            about x on frame_b), ``ty`` [N.m] (torque about y on frame_b), ``tz``
            [N.m] (torque about z on frame_b), ``tau`` [N.m] (torque about the z
            axis of the world on frame_b), ``power`` [W] (power delivered to the
            mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Distance(  # type: ignore[override]
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
            along x on frame_b), ``fy`` [N] (force along y on frame_b), ``fz`` [N]
            (force along z on frame_b), ``force`` [N] (axial force, positive in
            tension).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def DistanceDriver(  # type: ignore[override]
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
            along x on frame_b), ``fy`` [N] (force along y on frame_b), ``fz`` [N]
            (force along z on frame_b), ``force`` [N] (axial force, positive in
            tension), ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def DoubleUniversal(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        length: Number,
        n_a: Vector = (0.0, 0.0, 1.0),
        n_b: Vector = (0.0, 0.0, 1.0),
        psi: Number = 0.0,
        s: Start | None = None,
        v: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a DoubleUniversal: a shaft without mass with a Cardan joint at each
        end, whose crosses have the axes n_a of frame_a and n_b of frame_b; the
        other axes of the crosses enclose the angle psi about the shaft.

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
            Length of the shaft between the centres of the crosses; positive.
        n_a : (3,) numbers or str, optional
            Axis of the cross in frame_a.
        n_b : (3,) numbers or str, optional
            Axis of the cross in frame_b.
        psi : number or str, optional [rad]
            Angle between the axes of the crosses in the shaft.
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
            along x on frame_b), ``fy`` [N] (force along y on frame_b), ``fz`` [N]
            (force along z on frame_b), ``tx`` [N.m] (torque about x on frame_b),
            ``ty`` [N.m] (torque about y on frame_b), ``tz`` [N.m] (torque about z
            on frame_b), ``tau`` [N.m] (torque about the z axis of the world on
            frame_b), ``force`` [N] (axial force, positive in tension).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def ElasticBelt(  # type: ignore[override]
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
        n: Vector = (0.0, 0.0, 1.0),
        theta: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        phi_a: Start | None = None,
        phi_b: Start | None = None,
        stretch: Start | None = None,
        force: Start | None = None,
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
        n : (3,) numbers or str, optional
            Axis of the rotation, in frame_a.
        theta, phi, w, phi_a, phi_b, stretch, force : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``theta``
            [rad] (angle of the line from frame_a to frame_b about the z axis of the
            world), ``phi`` [rad] (angle of frame_b about the axis of frame_a),
            ``w`` [rad/s] (its rate), ``phi_a`` [rad] (angle of frame_a from the
            line of centres), ``phi_b`` [rad] (angle of frame_b from the line of
            centres), ``stretch`` [m] (how far the rim of one pulley has run ahead
            of the other since the start), ``force`` [N] (difference of the tensions
            of the strands), ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Fixed(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        phi0: Number = 0.0,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Fixed: a weld: frame_b keeps position and attitude relative to
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
            The constant angle of frame_b about the z axis of frame_a.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``fx`` [N]
            (force along x on frame_b), ``fy`` [N] (force along y on frame_b),
            ``fz`` [N] (force along z on frame_b), ``tx`` [N.m] (torque about x on
            frame_b), ``ty`` [N.m] (torque about y on frame_b), ``tz`` [N.m] (torque
            about z on frame_b), ``tau`` [N.m] (torque about the z axis of the world
            on frame_b), ``N`` [N] (normal force along x of frame_a, tension),
            ``Qy`` [N] (shear force along y of frame_a), ``Qz`` [N] (shear force
            along z of frame_a), ``Mx`` [N.m] (torsional moment about x of frame_a),
            ``My`` [N.m] (bending moment about y of frame_a), ``Mz`` [N.m] (bending
            moment about z of frame_a), ``Q`` [N] (shear force along y of frame_a,
            as in the plane), ``M`` [N.m] (bending moment about z of frame_a, as in
            the plane).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Force(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        fx: Law = 0.0,
        fy: Law = 0.0,
        fz: Law = 0.0,
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
        fz : number, str or Expr, optional [N]
            Component along z, a number or an expression; may be an expression in
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

    def FreeMotion(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        x: Start | None = None,
        y: Start | None = None,
        z: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        vx: Start | None = None,
        vy: Start | None = None,
        vz: Start | None = None,
        wx: Start | None = None,
        wy: Start | None = None,
        wz: Start | None = None,
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
        x, y, z, phi, w, vx, vy, vz, wx, wy, wz : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``x`` [m]
            (in world axes), ``y`` [m] (in world axes), ``z`` [m] (in world axes),
            ``phi`` [rad] (angle of frame_b about the axis of frame_a), ``w``
            [rad/s] (its rate), ``vx`` [m/s], ``vy`` [m/s], ``vz`` [m/s], ``wx``
            [rad/s] (relative angular velocity, in world axes), ``wy`` [rad/s]
            (relative angular velocity, in world axes), ``wz`` [rad/s] (relative
            angular velocity, in world axes).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Gear(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        ratio: Number,
        n_a: Vector = (0.0, 0.0, 1.0),
        n_b: Vector = (1.0, 0.0, 0.0),
        phi0: Number = 0.0,
        phi_a: Start | None = None,
        phi_b: Start | None = None,
        w_a: Start | None = None,
        w_b: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Gear: two shafts in mesh with axes that are not parallel, as of
        bevel and worm gears: the angles about n_a and n_b, relative to the
        plane of both axes, obey phi_a + ratio phi_b = phi0. Other joints hold
        the shafts, on the ground or on a moving carrier. Parallel axes:
        GearPair.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        ratio : number or str
            Turns of frame_a for one of frame_b in the opposite sense; negative: the
            same.
        n_a : (3,) numbers or str, optional
            Axis of the shaft, in frame_a.
        n_b : (3,) numbers or str, optional
            Axis of the shaft, in frame_b.
        phi0 : number or str, optional [rad]
            Phi_a where phi_b is zero.
        phi_a, phi_b, w_a, w_b : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``phi_a``
            [rad] (angle of frame_a about n_a), ``phi_b`` [rad] (angle of frame_b
            about n_b), ``w_a`` [rad/s] (rate of phi_a), ``w_b`` [rad/s] (rate of
            phi_b), ``tx`` [N.m] (torque about x on frame_b), ``ty`` [N.m] (torque
            about y on frame_b), ``tz`` [N.m] (torque about z on frame_b), ``tau``
            [N.m] (torque about the z axis of the world on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def GearPair(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        r_a: Number,
        r_b: Number,
        internal: bool | str | Handle = False,
        phi0: Number = 0.0,
        n: Vector = (0.0, 0.0, 1.0),
        theta: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        phi_a: Start | None = None,
        phi_b: Start | None = None,
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
        n : (3,) numbers or str, optional
            Axis of the rotation, in frame_a.
        theta, phi, w, phi_a, phi_b : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``theta``
            [rad] (angle of the line from frame_a to frame_b about the z axis of the
            world), ``phi`` [rad] (angle of frame_b about the axis of frame_a),
            ``w`` [rad/s] (its rate), ``phi_a`` [rad] (angle of frame_a from the
            line of centres), ``phi_b`` [rad] (angle of frame_b from the line of
            centres), ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force along
            y on frame_b), ``fz`` [N] (force along z on frame_b), ``tx`` [N.m]
            (torque about x on frame_b), ``ty`` [N.m] (torque about y on frame_b),
            ``tz`` [N.m] (torque about z on frame_b), ``tau`` [N.m] (torque about
            the z axis of the world on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Ground(  # type: ignore[override]
        self,
        name: str,
        *,
        g: Number = 9.81,
        n: Vector = (0.0, -1.0, 0.0),
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
        n : (3,) numbers or str, optional
            Direction of gravity, of length 1.
        frames : mapping, optional
            Further frames: ``{"tip": (x, y, z)}`` [m], from the reference point, or
            with an orientation as of the method ``frame``: ``{"tip": {"r": (x, y,
            z), "angles": (a, b, c)}}`` [m, rad].
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

    def KnifeEdge(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        n: Vector = (0.0, 0.0, 1.0),
        v: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a KnifeEdge: a blade at the origin of frame_b: it moves along its x
        axis and turns, but does not slip sideways on a plane.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a`` (optional), ``frame_b``. A joint
            stands for its two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        n : (3,) numbers or str, optional
            Normal of the plane, in frame_a.
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
            (velocity along the blade), ``phi`` [rad] (angle of frame_b about the
            axis of frame_a), ``w`` [rad/s] (its rate), ``fx`` [N] (force along x on
            frame_b), ``fy`` [N] (force along y on frame_b), ``fz`` [N] (force along
            z on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Planar(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        n: Vector = (0.0, 0.0, 1.0),
        mu: Number = 0.0,
        mu_s: Number | None = None,
        v_s: Number = 0.001,
        v_st: Number | None = None,
        s_x: Start | None = None,
        s_y: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Planar: frame_b moves in the plane with the normal n through the
        origin of frame_a, and turns about n.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        n : (3,) numbers or str, optional
            Normal of the plane, in frame_a.
        mu : number or str, optional
            Coefficient of friction; 0: none; at least 0.
        mu_s : number or str, optional
            Coefficient around standstill; default mu; at least 0.
        v_s : number or str, optional [m/s]
            Speed over which friction changes its sign: tanh(v/v_s); positive.
        v_st : number or str, optional [m/s]
            Stribeck speed; default 40 v_s; positive.
        s_x, s_y, phi, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s_x`` [m]
            (position of frame_b along the x axis of the plane), ``s_y`` [m]
            (position of frame_b along the y axis of the plane), ``phi`` [rad]
            (angle of frame_b about the axis of frame_a), ``w`` [rad/s] (its rate),
            ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force along y on
            frame_b), ``fz`` [N] (force along z on frame_b), ``tx`` [N.m] (torque
            about x on frame_b), ``ty`` [N.m] (torque about y on frame_b), ``tz``
            [N.m] (torque about z on frame_b), ``tau`` [N.m] (torque about the z
            axis of the world on frame_b), ``power`` [W] (power delivered to the
            mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def PlanetaryGear(  # type: ignore[override]
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

    def PointMass(  # type: ignore[override]
        self,
        name: str,
        *,
        m: Number,
        x: Start | None = None,
        y: Start | None = None,
        z: Start | None = None,
        phi: Start | None = None,
        vx: Start | None = None,
        vy: Start | None = None,
        vz: Start | None = None,
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
        x, y, z, phi, vx, vy, vz, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its frames, and its signals ``x`` [m]
            (centre of mass), ``y`` [m] (centre of mass), ``z`` [m] (centre of
            mass), ``phi`` [rad] (always 0), ``vx`` [m/s], ``vy`` [m/s], ``vz``
            [m/s], ``w`` [rad/s] (always 0).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def PointOnCircle(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        radius: Number,
        n: Vector = (0.0, 0.0, 1.0),
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
        n : (3,) numbers or str, optional
            Axis of the rotation, in frame_a.
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
            along y on frame_b), ``fz`` [N] (force along z on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def PointOnCurve(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        f1: Law,
        f2: Law,
        mu: Number = 0.0,
        mu_s: Number | None = None,
        v_s: Number = 0.001,
        v_st: Number | None = None,
        x: Start | None = None,
        y: Start | None = None,
        z: Start | None = None,
        vx: Start | None = None,
        vy: Start | None = None,
        vz: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a PointOnCurve: the origin of frame_b stays on the curve f1 = f2 = 0
        of frame_a, free to turn.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        f1 : number, str or Expr
            Function of the coordinates in frame_a that is zero on the curve, of any
            unit; an expression of `x`, `y`, `z`, parameters and tables.
        f2 : number, str or Expr
            Another function, whose gradient has another direction; an expression of
            `x`, `y`, `z`, parameters and tables.
        mu : number or str, optional
            Coefficient of friction; 0: none; at least 0.
        mu_s : number or str, optional
            Coefficient around standstill; default mu; at least 0.
        v_s : number or str, optional [m/s]
            Speed over which friction changes its sign: tanh(v/v_s); positive.
        v_st : number or str, optional [m/s]
            Stribeck speed; default 40 v_s; positive.
        x, y, z, vx, vy, vz : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``x`` [m]
            (position in frame_a), ``y`` [m] (position in frame_a), ``z`` [m]
            (position in frame_a), ``vx`` [m/s] (its rate), ``vy`` [m/s] (its rate),
            ``vz`` [m/s] (its rate), ``fx`` [N] (force along x on frame_b), ``fy``
            [N] (force along y on frame_b), ``fz`` [N] (force along z on frame_b),
            ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def PointOnLine(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        n: Vector = (1.0, 0.0, 0.0),
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
        """Add a PointOnLine: a pin in a slot: the origin of frame_b stays on the
        line along n through the origin of frame_a.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        n : (3,) numbers or str, optional
            Axis of the motion, in frame_a.
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
            (position of frame_b along the axis), ``v`` [m/s] (its rate), ``phi``
            [rad] (angle of frame_b about the axis of frame_a), ``w`` [rad/s] (its
            rate), ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force along y
            on frame_b), ``fz`` [N] (force along z on frame_b), ``power`` [W] (power
            delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def PointOnPlane(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        n: Vector = (0.0, 0.0, 1.0),
        mu: Number = 0.0,
        mu_s: Number | None = None,
        v_s: Number = 0.001,
        v_st: Number | None = None,
        s_x: Start | None = None,
        s_y: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a PointOnPlane: the origin of frame_b stays on the plane with the
        normal n through the origin of frame_a.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        n : (3,) numbers or str, optional
            Normal of the plane, in frame_a.
        mu : number or str, optional
            Coefficient of friction; 0: none; at least 0.
        mu_s : number or str, optional
            Coefficient around standstill; default mu; at least 0.
        v_s : number or str, optional [m/s]
            Speed over which friction changes its sign: tanh(v/v_s); positive.
        v_st : number or str, optional [m/s]
            Stribeck speed; default 40 v_s; positive.
        s_x, s_y : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``s_x`` [m]
            (position of frame_b along the x axis of the plane), ``s_y`` [m]
            (position of frame_b along the y axis of the plane), ``fx`` [N] (force
            along x on frame_b), ``fy`` [N] (force along y on frame_b), ``fz`` [N]
            (force along z on frame_b), ``power`` [W] (power delivered to the
            mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def PointOnSurface(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        f: Law,
        mu: Number = 0.0,
        mu_s: Number | None = None,
        v_s: Number = 0.001,
        v_st: Number | None = None,
        x: Start | None = None,
        y: Start | None = None,
        z: Start | None = None,
        vx: Start | None = None,
        vy: Start | None = None,
        vz: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a PointOnSurface: the origin of frame_b stays on the surface f = 0
        of frame_a, free to turn.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        f : number, str or Expr
            Function of the coordinates in frame_a that is zero on the surface, of
            any unit; an expression of `x`, `y`, `z`, parameters and tables.
        mu : number or str, optional
            Coefficient of friction; 0: none; at least 0.
        mu_s : number or str, optional
            Coefficient around standstill; default mu; at least 0.
        v_s : number or str, optional [m/s]
            Speed over which friction changes its sign: tanh(v/v_s); positive.
        v_st : number or str, optional [m/s]
            Stribeck speed; default 40 v_s; positive.
        x, y, z, vx, vy, vz : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``x`` [m]
            (position in frame_a), ``y`` [m] (position in frame_a), ``z`` [m]
            (position in frame_a), ``vx`` [m/s] (its rate), ``vy`` [m/s] (its rate),
            ``vz`` [m/s] (its rate), ``fx`` [N] (force along x on frame_b), ``fy``
            [N] (force along y on frame_b), ``fz`` [N] (force along z on frame_b),
            ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Prismatic(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        n: Vector = (1.0, 0.0, 0.0),
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
        """Add a Prismatic: a sliding joint: frame_b moves along the axis n of
        frame_a and does not turn.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        n : (3,) numbers or str, optional
            Axis of the motion, in frame_a.
        phi0 : number or str, optional [rad]
            The constant angle of frame_b about the z axis of frame_a.
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
            (position of frame_b along the axis), ``v`` [m/s] (its rate), ``fx`` [N]
            (force along x on frame_b), ``fy`` [N] (force along y on frame_b),
            ``fz`` [N] (force along z on frame_b), ``tx`` [N.m] (torque about x on
            frame_b), ``ty`` [N.m] (torque about y on frame_b), ``tz`` [N.m] (torque
            about z on frame_b), ``tau`` [N.m] (torque about the z axis of the world
            on frame_b), ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def RackAndPinion(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        radius: Number,
        s0: Number = 0.0,
        n: Vector = (1.0, 0.0, 0.0),
        axis: Vector = (0.0, 0.0, 1.0),
        s: Start | None = None,
        v: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a RackAndPinion: a pinion about the origin of frame_b rolls on a
        rack along n of frame_a, on the side of axis x n. Other joints guide the
        rack and hold the pinion.

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
        n : (3,) numbers or str, optional
            Direction of the rack.
        axis : (3,) numbers or str, optional
            Axis of the pinion, at right angles to n.
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
            (position of frame_b along the axis), ``v`` [m/s] (its rate), ``phi``
            [rad] (angle of frame_b about the axis of frame_a), ``w`` [rad/s] (its
            rate), ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force along y
            on frame_b), ``fz`` [N] (force along z on frame_b), ``tx`` [N.m] (torque
            about x on frame_b), ``ty`` [N.m] (torque about y on frame_b), ``tz``
            [N.m] (torque about z on frame_b), ``tau`` [N.m] (torque about the z
            axis of the world on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Revolute(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        n: Vector = (0.0, 0.0, 1.0),
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
        """Add a Revolute: a hinge: the origins of frame_a and frame_b coincide,
        and so does the axis n in both.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        n : (3,) numbers or str, optional
            Axis of the rotation, in frame_a.
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
            [rad] (angle of frame_b about the axis of frame_a), ``w`` [rad/s] (its
            rate), ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force along y
            on frame_b), ``fz`` [N] (force along z on frame_b), ``tx`` [N.m] (torque
            about x on frame_b), ``ty`` [N.m] (torque about y on frame_b), ``tz``
            [N.m] (torque about z on frame_b), ``tau`` [N.m] (torque about the z
            axis of the world on frame_b), ``power`` [W] (power delivered to the
            mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Rod(  # type: ignore[override]
        self,
        name: str,
        *,
        m: Number,
        length: Number,
        frames: Frames = {},
        x: Start | None = None,
        y: Start | None = None,
        z: Start | None = None,
        phi: Start | None = None,
        vx: Start | None = None,
        vy: Start | None = None,
        vz: Start | None = None,
        wx: Start | None = None,
        wy: Start | None = None,
        wz: Start | None = None,
        w: Start | None = None,
        phi_x: Start | None = None,
        phi_y: Start | None = None,
        phi_z: Start | None = None,
        wx_local: Start | None = None,
        wy_local: Start | None = None,
        wz_local: Start | None = None,
        p0: Start | None = None,
        p1: Start | None = None,
        p2: Start | None = None,
        p3: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Rod: a thin uniform bar: I = m length^2/12 about y and z, 0 about
        its axis x, frames a and b at its ends.

        Parameters
        ----------
        name : str
            Name of the component.
        m : number or str [kg]
            Mass; at least 0.
        length : number or str [m]
            Distance of the frames a and b; positive.
        frames : mapping, optional
            Further frames: ``{"tip": (x, y, z)}`` [m], from the reference point, or
            with an orientation as of the method ``frame``: ``{"tip": {"r": (x, y,
            z), "angles": (a, b, c)}}`` [m, rad].
        x, y, z, phi, vx, vy, vz, wx, wy, wz, w, phi_x : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        phi_y, phi_z, wx_local, wy_local, wz_local, p0, p1, p2, p3 : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its frames, and its signals ``x`` [m]
            (centre of mass), ``y`` [m] (centre of mass), ``z`` [m] (centre of
            mass), ``phi`` [rad] (angle of the x axis about the z axis of the
            world), ``vx`` [m/s], ``vy`` [m/s], ``vz`` [m/s], ``wx`` [rad/s]
            (angular velocity, in world axes), ``wy`` [rad/s] (angular velocity, in
            world axes), ``wz`` [rad/s] (angular velocity, in world axes), ``w``
            [rad/s] (angular velocity about the z axis of the world), ``phi_x``
            [rad] (first Cardan angle, about the x axis of the world), ``phi_y``
            [rad] (second Cardan angle, about the turned y axis), ``phi_z`` [rad]
            (third Cardan angle, about the own z axis), ``wx_local`` [rad/s]
            (angular velocity about the own x axis), ``wy_local`` [rad/s] (angular
            velocity about the own y axis), ``wz_local`` [rad/s] (angular velocity
            about the own z axis), ``p0`` (quaternion, scalar part), ``p1``
            (quaternion, x part), ``p2`` (quaternion, y part), ``p3`` (quaternion, z
            part).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def RollingDisc(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        radius: Number,
        n: Vector = (0.0, 0.0, 1.0),
        normal: Vector = (0.0, 1.0, 0.0),
        s: Start | None = None,
        v: Start | None = None,
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a RollingDisc: a thin disc with its centre at the origin of frame_b
        rolls without slip on a plane through that of frame_a.

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
        n : (3,) numbers or str, optional
            Axis of the disc, in frame_b.
        normal : (3,) numbers or str, optional
            Normal of the plane, in frame_a, towards the disc.
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
            (position of the centre along the direction normal x n at the start),
            ``v`` [m/s] (its rate), ``phi`` [rad] (angle about the disc's axis),
            ``w`` [rad/s] (angular velocity about the disc's axis), ``fx`` [N]
            (force along x on frame_b), ``fy`` [N] (force along y on frame_b),
            ``fz`` [N] (force along z on frame_b), ``tx`` [N.m] (torque about x on
            frame_b), ``ty`` [N.m] (torque about y on frame_b), ``tz`` [N.m] (torque
            about z on frame_b), ``tau`` [N.m] (torque about the z axis of the world
            on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Rope(  # type: ignore[override]
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

    def RotationalCam(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        beta: Law | Start,
        n: Vector = (0.0, 0.0, 1.0),
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
        n : (3,) numbers or str, optional
            Axis of the rotation, in frame_a.
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
            [rad] (angle of the line from frame_a to frame_b about the z axis of the
            world), ``phi`` [rad] (angle of the cam, from the line of centres),
            ``beta`` [rad] (angle of the follower, from this line), ``w`` [rad/s]
            (angular velocity of the cam), ``w_b`` [rad/s] (angular velocity of the
            follower), ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force
            along y on frame_b), ``fz`` [N] (force along z on frame_b), ``tx`` [N.m]
            (torque about x on frame_b), ``ty`` [N.m] (torque about y on frame_b),
            ``tz`` [N.m] (torque about z on frame_b), ``tau`` [N.m] (torque about
            the z axis of the world on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def RotationalDriver(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        phi: Law | Start,
        n: Vector = (0.0, 0.0, 1.0),
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
        n : (3,) numbers or str, optional
            Axis of the rotation, in frame_a.
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
            [rad] (angle of frame_b about the axis of frame_a), ``w`` [rad/s] (its
            rate), ``tx`` [N.m] (torque about x on frame_b), ``ty`` [N.m] (torque
            about y on frame_b), ``tz`` [N.m] (torque about z on frame_b), ``tau``
            [N.m] (torque about the axis n on frame_b), ``power`` [W] (power
            delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def RotationalSpringDamper(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        k: Number = 0.0,
        c: Number = 0.0,
        phi0: Number = 0.0,
        torque: Law | Start | None = None,
        n: Vector = (0.0, 0.0, 1.0),
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
        n : (3,) numbers or str, optional
            Axis of the rotation, in frame_a.
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
            [rad] (angle of frame_b about the axis of frame_a), ``w`` [rad/s] (its
            rate), ``torque`` [N.m] (resisting torque), ``power`` [W] (power
            delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def RotationalStop(  # type: ignore[override]
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
        n: Vector = (0.0, 0.0, 1.0),
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
        n : (3,) numbers or str, optional
            Axis of the rotation, in frame_a.
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
            [rad] (angle of frame_b about the axis of frame_a), ``w`` [rad/s] (its
            rate), ``torque`` [N.m] (resisting torque), ``power`` [W] (power
            delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def RotationalVelocityDriver(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        w: Law | Start,
        n: Vector = (0.0, 0.0, 1.0),
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
        n : (3,) numbers or str, optional
            Axis of the rotation, in frame_a.
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
            [rad] (angle of frame_b about the axis of frame_a), ``w`` [rad/s] (its
            rate), ``tx`` [N.m] (torque about x on frame_b), ``ty`` [N.m] (torque
            about y on frame_b), ``tz`` [N.m] (torque about z on frame_b), ``tau``
            [N.m] (torque about the axis n on frame_b), ``power`` [W] (power
            delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Screw(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        pitch: Number,
        n: Vector = (1.0, 0.0, 0.0),
        radius: Number | None = None,
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
        """Add a Screw: a nut on a spindle: frame_b slides along the axis n of
        frame_a, and turns about it once for each pitch.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        pitch : number or str [m]
            Displacement of a turn to the right; negative for a left-hand thread.
        n : (3,) numbers or str, optional
            Axis of the motion, in frame_a.
        radius : number or str, optional [m]
            Mean radius of the thread; required with friction; positive.
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
            (position of frame_b along the axis), ``v`` [m/s] (its rate), ``phi``
            [rad] (angle of frame_b about the axis, in proportion to s), ``w``
            [rad/s] (its rate), ``fx`` [N] (force along x on frame_b), ``fy`` [N]
            (force along y on frame_b), ``fz`` [N] (force along z on frame_b),
            ``tx`` [N.m] (torque about x on frame_b), ``ty`` [N.m] (torque about y
            on frame_b), ``tz`` [N.m] (torque about z on frame_b), ``tau`` [N.m]
            (torque about the z axis of the world on frame_b), ``power`` [W] (power
            delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Sensor(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame: Place | None = None,
        wx: Start | None = None,
        wy: Start | None = None,
        wz: Start | None = None,
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
        wx, wy, wz, w : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``wx``
            [rad/s] (angular velocity about x), ``wy`` [rad/s] (angular velocity
            about y), ``wz`` [rad/s] (angular velocity about z), ``w`` [rad/s]
            (angular velocity about z), ``ax`` [m/s2] (specific force along x:
            acceleration minus gravity), ``ay`` [m/s2] (specific force along y:
            acceleration minus gravity), ``az`` [m/s2] (specific force along z:
            acceleration minus gravity), ``fx`` [N] (force on the body along x),
            ``fy`` [N] (force on the body along y), ``fz`` [N] (force on the body
            along z), ``tx`` [N.m] (torque on the body about x), ``ty`` [N.m]
            (torque on the body about y), ``tz`` [N.m] (torque on the body about z),
            ``tau`` [N.m] (torque on the body about z).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Sphere(  # type: ignore[override]
        self,
        name: str,
        *,
        m: Number | None = None,
        rho: Number | None = None,
        radius: Number,
        bore: Number = 0.0,
        frames: Frames = {},
        x: Start | None = None,
        y: Start | None = None,
        z: Start | None = None,
        phi: Start | None = None,
        vx: Start | None = None,
        vy: Start | None = None,
        vz: Start | None = None,
        wx: Start | None = None,
        wy: Start | None = None,
        wz: Start | None = None,
        w: Start | None = None,
        phi_x: Start | None = None,
        phi_y: Start | None = None,
        phi_z: Start | None = None,
        wx_local: Start | None = None,
        wy_local: Start | None = None,
        wz_local: Start | None = None,
        p0: Start | None = None,
        p1: Start | None = None,
        p2: Start | None = None,
        p3: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Sphere: a uniform ball or spherical shell.

        Parameters
        ----------
        name : str
            Name of the component.
        m : number or str, optional [kg]
            Mass; or give the density; at least 0.
        rho : number or str, optional [kg/m3]
            Density, in place of the mass; positive.
        radius : number or str [m]
            Radius; positive.
        bore : number or str, optional [m]
            Inner radius, of a shell; at least 0.
        frames : mapping, optional
            Further frames: ``{"tip": (x, y, z)}`` [m], from the reference point, or
            with an orientation as of the method ``frame``: ``{"tip": {"r": (x, y,
            z), "angles": (a, b, c)}}`` [m, rad].
        x, y, z, phi, vx, vy, vz, wx, wy, wz, w, phi_x : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        phi_y, phi_z, wx_local, wy_local, wz_local, p0, p1, p2, p3 : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its frames, and its signals ``x`` [m]
            (centre of mass), ``y`` [m] (centre of mass), ``z`` [m] (centre of
            mass), ``phi`` [rad] (angle of the x axis about the z axis of the
            world), ``vx`` [m/s], ``vy`` [m/s], ``vz`` [m/s], ``wx`` [rad/s]
            (angular velocity, in world axes), ``wy`` [rad/s] (angular velocity, in
            world axes), ``wz`` [rad/s] (angular velocity, in world axes), ``w``
            [rad/s] (angular velocity about the z axis of the world), ``phi_x``
            [rad] (first Cardan angle, about the x axis of the world), ``phi_y``
            [rad] (second Cardan angle, about the turned y axis), ``phi_z`` [rad]
            (third Cardan angle, about the own z axis), ``wx_local`` [rad/s]
            (angular velocity about the own x axis), ``wy_local`` [rad/s] (angular
            velocity about the own y axis), ``wz_local`` [rad/s] (angular velocity
            about the own z axis), ``p0`` (quaternion, scalar part), ``p1``
            (quaternion, x part), ``p2`` (quaternion, y part), ``p3`` (quaternion, z
            part).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Spherical(  # type: ignore[override]
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
        phi_x: Start | None = None,
        phi_y: Start | None = None,
        phi_z: Start | None = None,
        w_x: Start | None = None,
        w_y: Start | None = None,
        w_z: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Spherical: a ball joint: the origins of frame_a and frame_b
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
            Radius of the ball; required with friction; positive.
        mu : number or str, optional
            Coefficient of friction; 0: none; at least 0.
        mu_s : number or str, optional
            Coefficient around standstill; default mu; at least 0.
        w_s : number or str, optional [rad/s]
            Speed over which friction changes its sign: tanh(w/w_s); positive.
        w_st : number or str, optional [rad/s]
            Stribeck speed; default 40 w_s; positive.
        phi_x, phi_y, phi_z, w_x, w_y, w_z : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``phi_x``
            [rad] (first Cardan angle of frame_b, about the x axis of frame_a),
            ``phi_y`` [rad] (second Cardan angle, about the turned y axis),
            ``phi_z`` [rad] (third Cardan angle, about the z axis of frame_b),
            ``w_x`` [rad/s] (rate of phi_x), ``w_y`` [rad/s] (rate of phi_y),
            ``w_z`` [rad/s] (rate of phi_z), ``fx`` [N] (force along x on frame_b),
            ``fy`` [N] (force along y on frame_b), ``fz`` [N] (force along z on
            frame_b), ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def SpringDamper(  # type: ignore[override]
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

    def Torque(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        tau: Law,
        n: Vector = (0.0, 0.0, 1.0),
        axes: Literal["frame_a", "frame_b"] | Handle = "frame_a",
        phi: Start | None = None,
        w: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Torque: a torque on frame_b about the axis n of frame_a, or of
        frame_b, and its reaction on frame_a.

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
        n : (3,) numbers or str, optional
            Axis of the torque, in the frame of `axes`.
        axes : {"frame_a", "frame_b"}, optional
            The frame whose axes n has; one of "frame_a", "frame_b".
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
            [rad] (angle of frame_b about the axis of frame_a), ``w`` [rad/s] (its
            rate), ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def TranslationalDriver(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        s: Law | Start,
        n: Vector = (1.0, 0.0, 0.0),
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
        n : (3,) numbers or str, optional
            Axis of the motion, in frame_a.
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
            (position of frame_b along the axis), ``v`` [m/s] (its rate), ``fx`` [N]
            (force along x on frame_b), ``fy`` [N] (force along y on frame_b),
            ``fz`` [N] (force along z on frame_b), ``force`` [N] (axial force,
            positive in tension), ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def TranslationalSpringDamper(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        k: Number = 0.0,
        c: Number = 0.0,
        s0: Number = 0.0,
        force: Law | Start | None = None,
        n: Vector = (1.0, 0.0, 0.0),
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
        n : (3,) numbers or str, optional
            Axis of the motion, in frame_a.
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
            (position of frame_b along the axis), ``v`` [m/s] (its rate), ``force``
            [N] (resisting force), ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def TranslationalStop(  # type: ignore[override]
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
        n: Vector = (1.0, 0.0, 0.0),
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
        n : (3,) numbers or str, optional
            Axis of the motion, in frame_a.
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
            (position of frame_b along the axis), ``v`` [m/s] (its rate), ``force``
            [N] (resisting force), ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def TranslationalVelocityDriver(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        v: Law | Start,
        n: Vector = (1.0, 0.0, 0.0),
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
        n : (3,) numbers or str, optional
            Axis of the motion, in frame_a.
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
            (position of frame_b along the axis), ``v`` [m/s] (its rate), ``fx`` [N]
            (force along x on frame_b), ``fy`` [N] (force along y on frame_b),
            ``fz`` [N] (force along z on frame_b), ``force`` [N] (axial force,
            positive in tension), ``power`` [W] (power delivered to the mechanism).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def Universal(  # type: ignore[override]
        self,
        name: str,
        *frames: Place,
        frame_a: Place | None = None,
        frame_b: Place | None = None,
        n_a: Vector = (1.0, 0.0, 0.0),
        n_b: Vector = (0.0, 1.0, 0.0),
        phi_a: Start | None = None,
        phi_b: Start | None = None,
        w_a: Start | None = None,
        w_b: Start | None = None,
        doc: str = "",
        replace: bool = False,
    ) -> Handle:
        """Add a Universal: a Cardan joint: the origins coincide, and the axis n_a
        of frame_a stays at right angles to n_b of frame_b.

        Parameters
        ----------
        name : str
            Name of the component.
        *frames : Handle or str
            Frames, in this order: ``frame_a``, ``frame_b``. A joint stands for its
            two frames.
        frame_a, frame_b : Handle or str, optional
            The same frames by name.
        n_a : (3,) numbers or str, optional
            Axis of the cross in frame_a.
        n_b : (3,) numbers or str, optional
            Axis of the cross in frame_b.
        phi_a, phi_b, w_a, w_b : mapping, optional
            Initial values of its signals: ``{"start": value, "fixed": True}``.
        doc : str, optional
            Description, one line.
        replace : bool, optional
            True: replaces the component of this name, if there is one.

        Returns
        -------
        Handle
            The component; its attributes are its ports, and its signals ``phi_a``
            [rad] (angle of the cross about n_a), ``phi_b`` [rad] (angle of frame_b
            about n_b), ``w_a`` [rad/s] (rate of phi_a), ``w_b`` [rad/s] (rate of
            phi_b), ``fx`` [N] (force along x on frame_b), ``fy`` [N] (force along y
            on frame_b), ``fz`` [N] (force along z on frame_b), ``tx`` [N.m] (torque
            about x on frame_b), ``ty`` [N.m] (torque about y on frame_b), ``tz``
            [N.m] (torque about z on frame_b), ``tau`` [N.m] (torque about the z
            axis of the world on frame_b).

        Raises
        ------
        ModelError, UsageError
            If a value is wrong; the model does not change.
        """

    def VelocityConstraint(  # type: ignore[override]
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

    def World(  # type: ignore[override]
        self,
        name: str,
        *,
        g: Number = 9.81,
        n: Vector = (0.0, -1.0, 0.0),
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
        n : (3,) numbers or str, optional
            Direction of gravity, of length 1.
        frames : mapping, optional
            Further frames: ``{"tip": (x, y, z)}`` [m], from the reference point, or
            with an orientation as of the method ``frame``: ``{"tip": {"r": (x, y,
            z), "angles": (a, b, c)}}`` [m, rad].
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
