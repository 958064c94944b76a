"""The order of the nodes of an expression."""

from mbdsl.expressions.symbolic import call, coordinate, walk

X, Y = coordinate("a", "x"), coordinate("a", "y")


def test_each_node_once_and_arguments_first():
    sine = call("sin", X)
    product = sine * Y
    root = product + sine
    assert walk(root) == [X, sine, Y, product, root]
    assert walk(Y, root) == [Y, X, sine, product, root]
    assert walk(root, known={sine: 1}) == [Y, product, root]
    assert walk(root, known=[root]) == []
