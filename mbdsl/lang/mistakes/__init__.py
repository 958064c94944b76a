"""Help with mistakes: names and statements of other programs, typing mistakes, values that are probably not meant."""
