"""mbdsl methods: the integrators, with order, index, enforced constraints, parameters and source."""

from __future__ import annotations

import argparse

from mbdsl.cli._options import Command

COMMAND = Command(
    "list the integrators",
    "List the integrators: order, index of the formulation, enforced constraints, parameters, source.",
    """
    methods NAME ...  integrators, or Python files (NAME.py); default: all
    """,
)


def run(args: argparse.Namespace) -> int:
    from mbdsl.integrators import available, declared, own, problems
    from mbdsl.integrators.method_files import spelled

    known = {name for name in own() if spelled(name) == name}
    chosen = {name: declared(name) for name in args.methods} or available()
    width = max(map(len, chosen)) + 2
    for name, method in chosen.items():
        enforces = " and ".join(method.enforces) or "nothing"
        print(f"{name:{width}}order {method.order}, index {method.index}, enforces {enforces}")
        print(f"    {method.doc}")
        for option, o in method.parameters.items():
            default = "" if o.default is None else f" {o.default:g}"
            flag = f"--{option}" if name in known else f"--option {option}="
            print(f"    {flag}{default}  ({o.lower:.4g} to {o.upper:.4g})  {o.doc}")
        print(f"    {' and '.join(method.steps)} steps")
        if method.needs:
            print(f"    needs {method.needs}")
        print(f"    {method.source}")
    for name, problem in problems().items() if not args.methods else ():
        print(f"{name}: cannot be used: {problem}")
    return 0
