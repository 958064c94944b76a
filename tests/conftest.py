"""Settings of every test process; read before numpy is imported, and passed on to the workers of pytest-xdist."""

import os

# Tests run side by side, one a core: threads of BLAS would wait for each other instead of computing.
for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(name, "1")
