"""Why a run costs what it costs: the effects that a scene calls for, and the time of every statement."""
