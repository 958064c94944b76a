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
        print(f"{name:12}order {method.order}, index {method.index}, enforces {' and '.join(method.enforces)}")
        print(f"    {method.doc}")
        for option, o in method.parameters.items():
            default = "" if o.default is None else f" {o.default:g}"
            print(f"    --{option}{default}  ({o.lower:.4g} to {o.upper:.4g})  {o.doc}")
        print(f"    {method.source}")
    return 0
