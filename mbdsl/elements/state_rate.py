"""StateRate: the equation `der(x) = f` of a state, as a force f on its body."""

from mbdsl.elements.declaration import Parameter
from mbdsl.elements.kind import ForceKind, in_space
from mbdsl.elements.row import Row

KIND = ForceKind(
    "StateRate",
    doc="The derivative of a state.",
    g=(Row("frame_b.vx", "frame_b.vx"),),
    optional_ports=("frame_a",),
    parameters=(Parameter("rate", "any", 0.0, "the derivative, an expression", law=True),),
    reacts=False,
    laws=("rate",),
    sign=1.0,
    drawing="nothing",
    variant="state_rate",
)
IN_SPACE = in_space(KIND)
