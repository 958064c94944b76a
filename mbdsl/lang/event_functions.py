"""Names of the functions of events."""

#: functions that have a meaning at events only
FUNCTIONS = ("pre", "edge", "change", "initial", "terminal", "sample")
#: what a `when` does beside assignments
ACTIONS = ("reinit", "terminate", "assert")
