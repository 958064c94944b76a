"""mbdsl methods: the integrators, with order, index, enforced constraints, parameters and source."""

from __future__ import annotations

import argparse


def register(subparsers) -> argparse.ArgumentParser:
    return subparsers.add_parser(
        "methods",
        help="list the integrators",
        description="List the integrators: order, index of the formulation, enforced constraints, parameters, source.",
    )


def run(args: argparse.Namespace) -> int:
    from mbdsl.integrators import available, compiled, problems

    own = compiled()
    width = max(map(len, available())) + 2
    for name, method in available().items():
        enforces = " and ".join(method.enforces) or "nothing"
        print(f"{name:{width}}order {method.order}, index {method.index}, enforces {enforces}")
        print(f"    {method.doc}")
        for option, o in method.parameters.items():
            default = "" if o.default is None else f" {o.default:g}"
            flag = f"--{option}" if name in own else f"--option {option}="
            print(f"    {flag}{default}  ({o.lower:.4g} to {o.upper:.4g})  {o.doc}")
        print(f"    {' and '.join(method.steps)} steps")
        if method.needs:
            print(f"    needs {method.needs}")
        print(f"    {method.source}")
    for name, problem in problems().items():
        print(f"{name}: cannot be used: {problem}")
    return 0
