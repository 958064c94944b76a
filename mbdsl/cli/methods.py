"""mbdsl methods: the integrators, with order, index, what they enforce, parameters and source."""

from __future__ import annotations

import argparse


def register(subparsers) -> argparse.ArgumentParser:
    return subparsers.add_parser(
        "methods",
        help="list the integrators",
        description="List the integrators: order, index of the formulation, what they enforce, parameters, source.",
    )


def run(args: argparse.Namespace) -> int:
    from mbdsl.integrators import methods

    for name, method in methods().items():
        print(f"{name}  order {method.order}, index {method.index}, enforces {method.enforces}")
        if method.parameters:
            print(f"    parameters: {parameters(method.parameters)}")
        print(f"    {method.source}")
    return 0


def parameters(given) -> str:
    """Names with their defaults."""
    pairs = given.items() if hasattr(given, "items") else given
    return ", ".join(f"{p[0]} = {p[1]:g}" if isinstance(p, tuple) else str(p) for p in pairs)
