"""Names of the rows, columns and header entries of the flat buffers that compiled code works on.

The buffers have the same types for every scene:

    vectors     (rows, N)       vectors of the step, N = n + m + p
    frames      (frames, .)     poses, rates and wrenches of frames
    gradients   (rows, .)       coordinates of frame pairs, with their gradients
    numbers     (.,)            parameters, constant matrices, and the registers of expressions
    layout      (.,) integers   offsets and sizes of the tables in the other buffers
    matrices    (matrices, .)   iteration matrices; a kernel that fills one of them takes ``matrix``
    pivots      (matrices, .)   integers: pivots of the matrices, or rows and columns of their entries

What differs between the plane and space is in :mod:`mbdsl.kernels.columns`: the columns of frames and gradients, and
the sizes of blocks in numbers. ``vectors[L.POSITION, i]`` after ``from mbdsl.kernels import buffer_layout as L``.
"""

# -- rows of vectors: n entries for the coordinates, m and p for the (non)holonomic constraints --------------------
POSITION, VELOCITY = 0, 1  #: q and v at the end of the step (first n entries)
UNKNOWN = 2  #: first unknown and multipliers, as [a; lam]
UNKNOWN2 = UNKNOWN + 1  #: second unknown and multipliers of stabilised methods, as [abar; mu]
FORCE = 4  #: result of evaluate: [f; Phi; Gam], f = Q - Phi_q^T lam - Gam_v^T nu
FORCE2 = 5  #: result of evaluate: [Phi_q^T mu; Phi_q v + Phi_t; 0]
RESIDUAL, RESIDUAL2 = 6, 7  #: residuals that belong to UNKNOWN and UNKNOWN2
CORRECTION, CORRECTION2 = 8, 9  #: Newton corrections of UNKNOWN and UNKNOWN2
POSITION0, VELOCITY0, FORCE0 = 10, 11, 12  #: q, v, f at the start of the step
UNKNOWN0 = 13  #: UNKNOWN at the last four steps, newest first
PAST = 4  #: number of these steps; the rows UNKNOWN0 + PAST .. UNKNOWN0 + 2 PAST - 1 hold the same for UNKNOWN2
SCALE = 21  #: 1/scale of each coordinate, for norms
TEMPORARY, TEMPORARY2 = 22, 23  #: scratch rows
KEPT, KEPT2 = 24, 25  #: history rows of the method's own, such as q and v at the start of the previous step
LAM = 26  #: multipliers in f, for a method whose UNKNOWN holds other multipliers
PAST_FORCE = 27  #: result of evaluate for methods with psi: [Phi_q^T psi; 0] with Phi_q at the start of the step
DIAGONAL = 28  #: SCALE divided by the diagonal of the iteration matrix
BEFORE, BEFORE2 = 29, 30  #: UNKNOWN and UNKNOWN2 before a Newton correction, which may be applied only in part
MX, MX2 = 31, 32  #: M without its constant diagonal, times rows INERTIA_ROW and INERTIA_ROW2
MASS_POSITION = 33  #: coordinates at which M is evaluated, for methods that hold M constant during a step
MULTIPLIED, MULTIPLIED2 = 34, 35  #: vectors that M multiplies, for methods where these are not UNKNOWN and UNKNOWN2
E_Q, E_V, E_X = 36, 37, 38  #: local errors of q and v, and the displacement that results from the error of v
ROWS = 39

# -- header of layout ----------------------------------------------------------------------------------------------
N_Q, N_PHI, N_ALL, N_FRAMES = 0, 1, 2, 3
N_SPRINGS, N_LAWS = 4, 5  #: number of rows of gradients for linear springs, and for force laws (magnitudes on the tape)
GROUND_FRAMES = 6
FRAMES = 7  #: offset in layout of (number of coordinates nb, offset in numbers of B and (B v)_q) of each frame
PAIRS = 8  #: offset in layout, per row of gradients, of PAIR ints:
PAIR = 6
FRAME_A, FRAME_B, SLOT, SECOND_DERIVATIVE, DETAIL, LEFT_OUT = range(PAIR)
# SLOT: the pair's first slot. SECOND_DERIVATIVE: offset in numbers of d^2g/dz^2, or -1. DETAIL: of a constraint the
# offset in layout of its driver's registers (u, u', u''), or -1; of a law the offset in layout of its leaf list; of a
# spring the offset in numbers of (k, c, g0). LEFT_OUT: 1 for a redundant constraint, whose equation becomes lam = 0.
LEAVES = 3  #: ints before the leaves of a law: register, sign, number of leaves
CONSTANT_FORCE = 9  #: offset in numbers of the constant generalised force (gravity), n entries
MASS = 10  #: offset in numbers of the constant part of the diagonal of M, n entries
MASS_SLOTS = 11  #: first slot of that diagonal, relative to SLOTS
SLOTS = 12  #: offset in layout of the slots (positions in a matrix), in the order in which the loops write them
TAPE, TAPE_LENGTH, GRADIENT_LENGTH = 13, 14, 15  #: offset in layout; numbers of instructions for values, for gradients
REGISTERS = 16  #: offset in numbers of the register file
TABLES = 17  #: offset in layout of (points, offset in numbers, extrapolation) of each table
SOLVER = 18  #: 0 dense, 1 sparse
SIZE = 19  #: number of entries in which a matrix is assembled
SPARSE = 20  #: offset in layout of the sparse solver's tables
ACCELERATION = 21  #: UNKNOWN or UNKNOWN2: the row whose differences over steps are differences of accelerations
LAM_ROW, MU_ROW, LAW_ROW, PSI_ROW = 22, 23, 24, 25  #: rows of multipliers for FORCE, FORCE2, force laws, PAST_FORCE
KEEP = 26  #: 1 if the next evaluation begins a step: the last gradients become those of the start of the step
N_GAM = 27  #: number of nonholonomic constraints
GAMMAS = 28  #: offset in layout of a list with the offset of each nonholonomic constraint's record
GAMMA = 5  #: ints of such a record before its leaves
MOVING, N_MOVING = 29, 30  #: offset in layout of the records of frames that are functions of time, and their number
MASS_KIND = 31  #: 0: M is diagonal and constant; 1: M is constant; 2: M depends on q
MASS_ROW = 32  #: row of the coordinates at which M is evaluated: POSITION, or MASS_POSITION, which is read once a step
NEW_MASS = 33  #: 1 if MASS_POSITION has to be read in the next evaluation
INERTIA_ROW, INERTIA_ROW2, TANGENT_ROW = 34, 35, 36  #: rows that M multiplies; row of x in (M x)_q
# constant off-diagonal entries of M: offset in layout of (i, j, slot) of each; count; offset in numbers of their values
COUPLINGS, N_COUPLINGS, COUPLING_VALUES = 37, 38, 39
SWITCHES, N_SWITCHES = 40, 41  #: offset in layout of a list with the offset of each switch's record, and their number
TURNS, N_TURNS = 42, 43  #: offset in layout of (offset in numbers, coordinate) of each angle with counted turns; number
COUPLED, N_COUPLED = 44, 45  #: offset in layout of the records of couplings, and their number
COUPLING = 2  #: ints of such a record: offset in numbers of f or one of its derivatives, and its register
# rotations of bodies in space: offset in layout of (first coordinate, offset in numbers) of each; number
ROTATIONS, N_ROTATIONS = 46, 47
# in a run of a method, whose unknowns are changes of rotation vectors: 1, or 2 if its accelerations are psi''; else 0
CHART = 48
PAST_POSITIONS = 49  #: row with the position at the start of the previous step, of methods that have one; else 0
# angles between frames in space: offset in layout of (offset in numbers of the angle at the end of the last accepted
# step, which precedes that of the last evaluation) of each; number
COUNTED, N_COUNTED = 50, 51
OF_MULTIPLIERS = 52  #: 1 if force laws depend on multipliers, as friction does
# constraints by expression: offset in layout of a list with the offset of each record; number of constraints
RELATIONS, N_RELATIONS = 53, 54
RELATION = 5  #: ints of such a record before its leaves
TICKS = 55  #: offset in layout of the record of clocks that set discrete variables (system/clock_tables.py), or 0
N_STATES = 56  #: number of states, which are the last coordinates
BLOCKS = 57  #: first block header
BLOCK = 4  #: ints of a header. Bodies: count, offset in layout. Pairs: count, first row, offset and stride in numbers

# -- tasks of the emitted function ``inertia`` -----------------------------------------------------------------
ACT = 2  #: evaluates the right-hand sides of the when-equations of clocks, which are the last part of the tape
TIMES, INVERSE = 0, 1  #: target <- (M without its constant diagonal) row; target <- M^{-1} row, target != row
