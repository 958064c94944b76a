"""Names for the rows, columns and header entries of the flat buffers that compiled code works on.

Every scene has the same types:

    vectors     (rows, N)       vectors of the step, N = n + m + p
    frames      (frames, .)     poses, rates and wrenches of frames
    gradients   (rows, .)       coordinates of frame pairs, with their gradients
    numbers     (.,)            parameters, constant matrices, and the registers of expressions
    layout      (.,) integers   where in the other buffers what is
    matrices    (matrices, .)   iteration matrices; a kernel that fills one of them takes ``matrix``
    pivots      (matrices, .)   integers: their pivots, or rows and columns of their entries
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
PAST = 4  #: the same for UNKNOWN2 stands so many rows below
SCALE = 21  #: 1/scale of each coordinate, for norms
TEMPORARY, TEMPORARY2 = 22, 23  #: scratch of the linear solver
KEPT, KEPT2 = 24, 25  #: what else a method keeps of the past: as q and v one step before POSITION0 and VELOCITY0
LAM = 26  #: multipliers of a method whose UNKNOWN does not hold those that f is made of
PAST_FORCE = 27  #: result of evaluate where it is asked for: [Phi_q^T psi; 0] with Phi_q of the start of the step
DIAGONAL = 28  #: scale over the diagonal of an iteration matrix
BEFORE, BEFORE2 = 29, 30  #: UNKNOWN and UNKNOWN2 before a correction that may be taken back in part
MX, MX2 = 31, 32  #: M without its constant diagonal, times rows INERTIA_ROW and INERTIA_ROW2
MASS_POSITION = 33  #: the coordinates that M is evaluated at, for methods that keep it throughout a step
MULTIPLIED, MULTIPLIED2 = 34, 35  #: what a method multiplies with M where that is not UNKNOWN and UNKNOWN2
E_Q, E_V, E_X = 36, 37, 38  #: local errors of q and v, and what becomes of that of v
ROWS = 39

# -- columns of frames: the pose x, y, phi; then these --------------------------------------------------------------
POSE = 3  #: entries of a pose, of its rate, and of a wrench
RATE = 3  #: rates of the pose, 3 .. 5
WRENCH = 6  #: accumulated force and torque, 6 .. 8
LEVER = 9  #: l_x, l_y of frames on rigid bodies
MU_WRENCH = 11  #: the wrench of mu, 11 .. 13
PAST_WRENCH, PAST_LEVER = 14, 17  #: the wrench of psi, and the lever, with the pose at the start of the step
COLUMNS = 19

# -- columns of gradients: dg/dz, value g, magnitude s (of forces), rate of the gradient w^T d^2g/dz^2 -------------
PAIR_POSE = 2 * POSE  #: entries of z, the poses of both frames, and so of dg/dz
VALUE, MAGNITUDE = 6, 7
GRADIENT_RATE = 8  #: 8 .. 13
PAST_GRADIENT = 14  #: dg/dz at the start of the step, 14 .. 19
GRADIENT_COLUMNS = 20

# -- blocks in numbers ---------------------------------------------------------------------------------------------
SQUARE = PAIR_POSE * PAIR_POSE  #: a matrix over the poses of a pair, row by row
HALF = POSE * PAIR_POSE  #: its upper rows, which belong to the first frame
BLOCK_SIZE = POSE * POSE  #: a matrix over one pose
TANGENT_SCRATCH = 2 * SQUARE  #: scratch of the tangents, at the end of numbers

# -- header of layout ----------------------------------------------------------------------------------------------
N_Q, N_PHI, N_ALL, N_FRAMES = 0, 1, 2, 3
N_SPRINGS, N_LAWS = 4, 5  #: rows of gradients that are linear springs, then those with magnitudes from expressions
GROUND_FRAMES = 6
FRAMES = 7  #: offset in layout of (number of coordinates nb, offset in numbers of B and (B v)_q) of each frame
PAIRS = 8  #: offset in layout, per row of gradients, of PAIR ints:
PAIR = 6
FRAME_A, FRAME_B, SLOT, SECOND_DERIVATIVE, DETAIL, LEFT_OUT = range(PAIR)
# the first slot; the offset in numbers of d^2g/dz^2, or -1; detail: the offset in layout of the registers (u, u', u'')
# of a driver, or -1, of a law's leaf list, or that in numbers of a spring's (k, c, g0); left out: 1 for a redundant
# constraint, whose equation becomes lam = 0
LEAVES = 3  #: ints before the leaves of a law: register, sign, number of leaves
LEAF = 1 + PAIR_POSE  #: ints of a leaf: a frame, and the registers of the derivatives with respect to pose and rate
CONSTANT_FORCE = 9  #: offset in numbers of the constant generalised force (gravity), n entries
MASS = 10  #: offset in numbers of the constant part of the diagonal of M, n entries
MASS_SLOTS = 11  #: first slot of that diagonal, relative to SLOTS
SLOTS = 12  #: offset in layout of the slots (positions in a matrix), in the order in which the loops write them
TAPE, TAPE_LENGTH, GRADIENT_LENGTH = 13, 14, 15  #: its offset in layout; instructions for values, then gradients
REGISTERS = 16  #: offset in numbers of the register file
TABLES = 17  #: offset in layout of (points, offset in numbers, extrapolation) of each table
SOLVER = 18  #: 0 dense, 1 sparse
SIZE = 19  #: entries that a matrix is assembled in
SPARSE = 20  #: offset in layout of the sparse solver's tables
ACCELERATION = 21  #: row, UNKNOWN or UNKNOWN2, that differences of are those of accelerations
LAM_ROW, MU_ROW, LAW_ROW, PSI_ROW = 22, 23, 24, 25  #: rows of multipliers in FORCE, in FORCE2, of laws, in PAST_FORCE
KEEP = 26  #: 1 where the next evaluation begins a step: the gradients found last become those of its start
N_GAM = 27  #: number of nonholonomic constraints
GAMMAS = 28  #: offset in layout of (offset of its record) per nonholonomic constraint
GAMMA = 5  #: ints of a record before its leaves
MOVING, N_MOVING = 29, 30  #: records of frames that move as functions of time, MOVED ints each, and their number
MOVED = 10  #: row of the frame table; registers of pose, rates and accelerations (3 each)
MASS_KIND = 31  #: 0: M is diagonal and constant; 1: constant; 2: it depends on q
MASS_ROW = 32  #: row with the coordinates that M belongs to: POSITION, or MASS_POSITION, which is read once a step
NEW_MASS = 33  #: 1 where that row is to be looked at
INERTIA_ROW, INERTIA_ROW2, TANGENT_ROW = 34, 35, 36  #: rows that M is multiplied with; x in cA (M x)_q
COUPLINGS, N_COUPLINGS, COUPLING_VALUES = 37, 38, 39  #: constant entries of M off the diagonal: i, j, slot; in numbers
SWITCHES, N_SWITCHES = 40, 41  #: offset in layout of (offset of its record) per switch, and their number
TURNS, N_TURNS = 42, 43  #: offset in layout of (offset in numbers, coordinate) per angle that turns are counted on from
BLOCKS = 44  #: first block header
BLOCK = 4  #: ints: count, then of a body: offset in layout; of a pair: first row, offset and stride in numbers

# -- tasks of the emitted function ``inertia`` -----------------------------------------------------------------
TIMES, INVERSE = 0, 1  #: target <- (M - its constant diagonal) row; target <- M^{-1} row (not the same row)
