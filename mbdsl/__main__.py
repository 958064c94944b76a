"""``python -m mbdsl``."""

import sys

from mbdsl.cli import main

sys.exit(main())
