"""``python -m mbdsl``, and the command ``mbdsl``: the command line with the garbage collector set for short processes.

Nearly all objects that a command creates while it loads its modules persist until its end. With Python's defaults,
the collector visits them again and again during the start, and several times at the end of the process: a sixth of the
processor time of ``mbdsl check``.
"""

import gc
import sys

#: number of new objects after which the youngest ones are collected; Python's default is 700
YOUNG = 100_000


def main() -> int:
    """Run the command in ``sys.argv`` and return its exit code."""
    gc.set_threshold(YOUNG)
    from mbdsl.cli import main

    code = main()
    gc.freeze()  # the operating system takes the memory back: no collection at the end has to look for cycles
    return code


if __name__ == "__main__":
    sys.exit(main())
