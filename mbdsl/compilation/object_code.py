"""Native object code from LLVM code, which :mod:`mbdsl.compilation.translation` writes."""

from __future__ import annotations

import os
from collections.abc import Iterator
from functools import cache
from typing import NamedTuple

from llvmlite import binding


class Object(NamedTuple):
    needs: list[str]  #: external symbols that the code refers to
    code: bytes


def compile_object(text: str) -> Object:
    """Optimise a module and generate its machine code.

    ``MBDSL_OPTIMISATION=0`` compiles in an eighth of the time code that takes two to four times as long: for test
    suites, whose runs are short. Results have the same bits.
    """
    level = optimisation()
    machine = _machine(os.environ.get("MBDSL_CPU_NAME"), os.environ.get("MBDSL_CPU_FEATURES"), level)
    module = binding.parse_assembly(text)
    module.triple, module.data_layout = machine.triple, str(machine.target_data)
    module.verify()
    # Most loops have few iterations: the setup of vectorised code costs more time than it saves.
    options = binding.create_pipeline_tuning_options(level)
    options.loop_vectorization = options.slp_vectorization = False
    passes = binding.create_pass_builder(machine, options)
    if level:
        manager = passes.getModulePassManager()
    else:
        manager = binding.create_new_module_pass_manager()
        manager.add_sroa_pass()  # variables in registers: half of the machine code, and of the time to generate it
    manager.run(module, passes)
    return Object(list(_needs(module)), machine.emit_object(module))


def optimisation() -> int:
    """The level of optimisation, 3 or what ``MBDSL_OPTIMISATION`` says."""
    return 0 if os.environ.get("MBDSL_OPTIMISATION") == "0" else 3


@cache
def engine():
    """The engine that objects are added to and addresses of functions are taken from."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    machine = binding.Target.from_triple(binding.get_process_triple()).create_target_machine()
    return binding.create_mcjit_compiler(binding.parse_assembly(""), machine)


def load(code: bytes):
    """Load an object; the engine with its functions."""
    engine().add_object_file(binding.ObjectFileRef.from_data(code))
    engine().finalize_object()
    return engine()


def _needs(module) -> Iterator[str]:
    """External functions that a module calls."""
    return (f.name for f in module.functions if f.is_declaration and not f.name.startswith("llvm."))


@cache
def _machine(name: str | None, features: str | None, level: int):
    """The processor of this machine, or the one that MBDSL_CPU_NAME and MBDSL_CPU_FEATURES name."""
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    if features is None:
        features = "" if name is not None else binding.get_host_cpu_features().flatten()
    target, cpu = binding.Target.from_default_triple(), name or binding.get_host_cpu_name()
    return target.create_target_machine(
        cpu=cpu, features=features, opt=level, reloc="static", codemodel="jitdefault", jit=True
    )
