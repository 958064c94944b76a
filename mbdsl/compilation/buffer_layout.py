"""Names for the rows, columns and header entries of the flat buffers that compiled code works on.

Every scene has the same types: ``Y`` (rows, N) vectors of the step, ``Z`` (frames, columns) the frame table, ``C``
(coordinates of frame pairs, columns) the gradient table, ``F`` float tables and registers, ``I`` integer tables, ``A``
(matrices, size) and ``P`` pivots of the iteration matrices.
"""

# -- rows of Y, each N = n + m + p entries: n for the coordinates, m and p for the (non)holonomic constraints ----
Q, V = 0, 1  #: q and v at the end of the step (first n entries)
X = 2  #: first unknown and multipliers, as [a; lam]
X2 = X + 1  #: second unknown and multipliers of stabilised methods, as [abar; mu]
FP = 4  #: result of evaluate: [f; Phi; Gam], f = Q - Phi_q^T lam - Gam_v^T nu
GD = 5  #: result of evaluate: [Phi_q^T mu; Phi_q v + Phi_t; 0]
R, R2 = 6, 7  #: residuals that belong to X and X2
D, D2 = 8, 9  #: Newton corrections of X and X2
Q0, V0, F0 = 10, 11, 12  #: q, v, f at the start of the step
XA = 13  #: X at the last four steps, newest first
PAST = 4  #: the same for X2 stands so many rows below
SCALE = 21  #: 1/scale of each coordinate, for norms
T1, T2 = 22, 23  #: scratch of the linear solver
Q1, V1 = 24, 25  #: what else a method keeps of the past: q and v one step before Q0 and V0
LAM = 26  #: multipliers of a method whose X does not hold those that f is made of
GP = 27  #: result of evaluate where it is asked for: [Phi_q^T psi; 0] with Phi_q of the start of the step
DIAGONAL = 28  #: scale over the diagonal of an iteration matrix
BEFORE, BEFORE2 = 29, 30  #: X and X2 before a correction that may be taken back in part
MX, MX2 = 31, 32  #: what M has beside its constant diagonal, times the rows I[INERTIA_ROW], I[INERTIA_ROW2]
Q_MASS = 33  #: the coordinates that M is evaluated at, for methods that keep it throughout a step
Y1, Y2 = 34, 35  #: what a method multiplies with M where that is not X and X2
E_Q, E_V, E_X = 36, 37, 38  #: local errors of q and v, and what becomes of that of v
ROWS = 39

# -- columns of Z: pose x, y, phi; rates 3-5; then these ----------------------------------------------------------
WRENCH = 6  #: accumulated force and torque, 6 .. 8
LEVER = 9  #: l_x, l_y of frames on rigid bodies
MU_WRENCH = 11  #: the wrench of mu, 11 .. 13
PAST_WRENCH, PAST_LEVER = 14, 17  #: the wrench of psi, and the lever, with the pose at the start of the step
COLUMNS = 19

# -- columns of C: gradient dg/dz, value g, magnitude s (of forces), rate of the gradient w^T d^2g/dz^2 ----------
VALUE, MAGNITUDE = 6, 7
GRADIENT_RATE = 8  #: 8 .. 13
PAST_GRADIENT = 14  #: dg/dz at the start of the step, 14 .. 19
GRADIENT_COLUMNS = 20

# -- header of I ---------------------------------------------------------------------------------------------
N_Q, N_PHI, N_ALL, N_FRAMES = 0, 1, 2, 3
N_SPRINGS, N_LAWS = 4, 5  #: rows of C that are linear springs, then those with magnitudes from expressions
GROUND_FRAMES = 6
FRAMES = 7  #: offset in I of (number of coordinates nb, offset in F of B and (B v)_q) of each frame
PAIRS = 8  #: offset in I, per row of C: a, b, first slot, offset in F of d^2g/dz^2 (36) or -1, detail, left out
# detail: offset in I of (u, u', u'') registers of a driver or -1; of (k, c, g0) in F; of a law's leaf list in I
# left out: 1 for a redundant constraint, whose equation becomes lam = 0
PAIR = 6  #: ints a row
FORCE0 = 9  #: offset in F of the constant generalised force (gravity), n entries
MASS = 10  #: offset in F of the constant part of the diagonal of M, n entries
MASS_SLOTS = 11  #: first slot of that diagonal, relative to SLOTS
SLOTS = 12  #: offset in I of the slots (positions in A), in the order in which the loops write them
TAPE, TAPE_LENGTH, GRADIENT_LENGTH = 13, 14, 15  #: offset in I of the tape; instructions for values, then gradients
REGISTERS = 16  #: offset in F of the register file
TABLES = 17  #: offset in I of (points, offset in F, extrapolation) of each table
SOLVER = 18  #: 0 dense, 1 sparse
SIZE = 19  #: entries of one row of A that a matrix is assembled in
SPARSE = 20  #: offset in I of the sparse solver's tables
ACCELERATION = 21  #: row of Y, X or X2, that differences of are those of accelerations
LAM_ROW, MU_ROW, LAW_ROW, PSI_ROW = 22, 23, 24, 25  #: rows of Y: multipliers in f, in GD, as laws read them, in GP
KEEP = 26  #: 1 where the next evaluation begins a step: the gradients found last become those of its start
N_GAM = 27  #: number of nonholonomic constraints
GAMMAS = 28  #: offset in I of (offset of its record) per nonholonomic constraint
MOVING, N_MOVING = 29, 30  #: records of frames that move as functions of time, MOVED ints each, and their number
MOVED = 10  #: row of the frame table; registers of pose, rates and accelerations (3 each)
MASS_KIND = 31  #: 0: M is diagonal and constant; 1: constant; 2: it depends on q
MASS_ROW = 32  #: row of Y with the coordinates that M belongs to: Q, or Q_MASS, which is looked at once a step
NEW_MASS = 33  #: 1 where that row is to be looked at
INERTIA_ROW, INERTIA_ROW2, TANGENT_ROW = 34, 35, 36  #: rows of Y that M is multiplied with; x in cA (M x)_q
COUPLINGS, N_COUPLINGS, COUPLING_VALUES = 37, 38, 39  #: constant entries of M beside the diagonal: i, j, slot; in F
SWITCHES, N_SWITCHES = 40, 41  #: offset in I of (offset of its record) per switch, and their number
TURNS, N_TURNS = 42, 43  #: offset in I of (offset in F, coordinate) per angle that turns are counted on from
BLOCKS = 44  #: first block header
BLOCK = 4  #: ints of a block: count, then body: offset in I; pair: first row of C, offset and stride in F

# -- tasks of the emitted function ``inertia`` -----------------------------------------------------------------
TIMES, INVERSE = 0, 1  #: target <- (M - its constant diagonal) row; target <- M^{-1} row (not the same row)
