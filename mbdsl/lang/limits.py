"""Limits of a model. They bound the time and memory for reading a file; each has a clear message.

They are far beyond the needs of a mechanism; a model that reaches one contains a mistake.
"""

FILE_SIZE = 1_000_000  #: characters of one source text
FILES = 200  #: files of one model, with all that they import
NESTING = 100  #: brackets, statements or expressions inside each other
INSTANCE_DEPTH = 40  #: sub-models inside sub-models
COMPONENTS = 200_000  #: components of the flat model
ARRAY = 250_000  #: numbers of one array
NODES = 3_000_000  #: operations evaluated for one model, all together
DATA_SIZE = 200_000_000  #: bytes of a file of numbers
DATA_ROWS = 2_000_000  #: rows of such a file
DATA_NUMBERS = 8_000_000  #: numbers that a model takes from such files, all together
INTEGER = 2**53  #: integers beyond this are not exact as floating-point numbers
SHAPE_POINTS = 200_000  #: points of all shapes of bodies
TEXT = 10_000  #: characters of a string value
