"""Compilation of kernels to native object code, by numba's internals, which only this file uses.

numba optimises every function separately and generates its machine code, and repeats this for each caller. Here a
function is compiled only to unoptimised code, kept in a container. The entry functions are linked with all code that
they call, optimised once, and written as one object, which llvmlite loads without numba
(:mod:`mbdsl.compilation.code_cache`).

The entry functions have the C calling convention. Arrays are passed by their fields, as by numba's ``cfunc``. Tested
with numba 0.60 and 0.68; if any of it fails, :mod:`mbdsl.compilation.numba_cfunc` compiles the kernels instead.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from llvmlite import ir
from numba import config, njit
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.registry import cpu_target
from numba.core.typed_passes import NativeLowering
from numba.np.arrayobj import populate_array

from mbdsl.compilation.native_call import ARRAYS, Signature
from mbdsl.compilation.numba_cfunc import TYPES, numba_signature
from mbdsl.compilation.pieces import Object, Piece, Stored, internalise, needs

#: without numba's runtime (_nrt) kernels cannot allocate memory, and no references are counted
OPTIONS = {"error_model": "numpy", "_nrt": False, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


class Container(JITCodeLibrary):
    """The unoptimised code of one function, with the libraries of the functions that it calls; never executed."""

    def finalize(self) -> None:
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0

    @property
    def codegen(self):
        return self  # numba calls set_env of it to make a function callable

    def set_env(self, name: str, env: object) -> None:
        pass

    def everything(self, seen: set | None = None) -> Iterator[JITCodeLibrary]:
        """All libraries that this one needs, directly or not, each once and after those that it needs itself."""
        seen = set() if seen is None else seen
        for library in self._linking_libraries:
            if library not in seen:
                seen.add(library)
                if isinstance(library, Container):
                    yield from library.everything(seen)
                yield library

    def linked(self, entries: set[str]):
        """The module with all code, not optimised, that exports only ``entries``."""
        module = self._final_module
        # LLVM drops functions that the code linked so far does not call, and a listed library may be needed only by a
        # branch that was removed: link every caller before the functions that it calls
        for library in reversed(list(self.everything())):
            module.link_in(library._get_module_for_linking(), preserve=True)
        internalise(module, entries)
        return module

    def link(self, entries: set[str]) -> Object:
        """Link all code into one object that exports only ``entries``."""
        module = self.linked(entries)
        former, config.LOOP_VECTORIZE = config.LOOP_VECTORIZE, 0
        try:  # most loops have few iterations: the setup of vectorised code costs more time than it saves
            self._optimize_final_module()
        finally:
            config.LOOP_VECTORIZE = former
        module.verify()
        return Object(list(needs(module)), self._codegen._tm.emit_object(module))


@register_pass(mutates_CFG=True, analysis_only=False)
class Lowering(NativeLowering):
    """numba's pass that generates native code; the code goes into a :class:`Container`."""

    _name = "mbdsl_lowering"

    def run_pass(self, state) -> bool:
        state.library = Container(state.targetctx.codegen(), state.func_id.func_qualname)
        return super().run_pass(state)


class Compiler(CompilerBase):
    """numba's compiler with :class:`Lowering` in place of numba's pass."""

    def define_pipelines(self):
        pipeline = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes = [(Lowering if step is NativeLowering else step, why) for step, why in pipeline.passes]
        if passes == pipeline.passes:
            raise RuntimeError("this version of numba has other compiler passes")
        pipeline.passes = passes
        pipeline.finalize()
        return [pipeline]


def compile_kernel(function: Callable, **options):
    """Compile ``function`` for calls from other kernels."""
    return njit(pipeline_class=Compiler, **OPTIONS, **options)(function)


def compile_object(functions: Mapping[str, tuple[Callable, Signature]]) -> Object:
    """Compile an object that exports each function by its name, and by ``name.packed`` with arguments in one block."""
    context = cpu_target.target_context
    library = Container(context.codegen(), "mbdsl")
    module = library.create_ir_module("entries")
    for name, (function, signature) in functions.items():
        wanted = numba_signature(signature)
        compiled = compile_kernel(function, forceinline=True)
        compiled.compile(wanted)
        made = compiled.overloads[wanted.args]
        library.add_linking_library(made.library)
        described = made.fndesc
        kind = context.call_conv.get_function_type(described.restype, described.argtypes)
        inner = ir.Function(module, kind, described.llvm_func_name)
        values = [context.get_value_type(t) for t in (wanted.return_type, *wanted.args)]
        outer = ir.Function(module, ir.FunctionType(values[0], values[1:]), name)
        builder = ir.IRBuilder(outer.append_basic_block())
        _status, result = context.call_conv.call_function(
            builder, inner, described.restype, described.argtypes, outer.args
        )
        builder.ret(result)
        _add_packed(context, module, outer, signature, wanted)
    library.add_ir_module(module)
    return library.link({n for name in functions for n in (name, f"{name}.packed")})


def compile_piece(piece: Piece, kernel: Any) -> Stored:
    """The unoptimised code of a kernel that :func:`compile_kernel` has returned, with all code that it calls.

    It exports one function, ``piece.symbol``, which takes arrays as structures and returns nothing.
    """
    context = cpu_target.target_context
    library = Container(context.codegen(), piece.function)
    module = library.create_ir_module("piece")
    wanted = tuple(TYPES[kind] for kind in piece.takes)
    kernel.compile(wanted)
    made = kernel.overloads[wanted]
    library.add_linking_library(made.library)
    described = made.fndesc
    kind = context.call_conv.get_function_type(described.restype, described.argtypes)
    inner = ir.Function(module, kind, described.llvm_func_name)
    takes = [context.get_value_type(t) for t in wanted]
    outer = ir.Function(module, ir.FunctionType(ir.VoidType(), takes), piece.symbol)
    outer.attributes.add("alwaysinline")
    builder = ir.IRBuilder(outer.append_basic_block())
    context.call_conv.call_function(builder, inner, described.restype, described.argtypes, outer.args)
    builder.ret_void()
    library.add_ir_module(module)
    settings: dict[str, object] = {"opt": 3}
    context.codegen()._customize_tm_options(settings)
    return Stored(json.dumps(settings).encode(), library.linked({piece.symbol}).as_bitcode())


def _add_packed(context, module, function, signature: Signature, wanted) -> None:
    """Add to ``module`` a function that unpacks its arguments from one block of words, and calls ``function``.

    Arrays are in the block as address and shape.
    """
    word = ir.IntType(64)
    packed = ir.Function(module, ir.FunctionType(word, [word.as_pointer()]), f"{function.name}.packed")
    builder = ir.IRBuilder(packed.append_basic_block())
    at = 0

    def load(kind):
        nonlocal at
        place = builder.gep(packed.args[0], [ir.IntType(32)(at)])
        at += 1
        return builder.load(builder.bitcast(place, kind.as_pointer()))

    given = []
    for kind, numba_kind in zip(signature.takes, wanted.args, strict=True):
        if kind not in ARRAYS:
            given.append(load(context.get_value_type(numba_kind)))
            continue
        array = context.make_array(numba_kind)(context, builder)
        address, shape = load(array.data.type), [load(word) for _ in range(ARRAYS[kind][0])]
        eight = word(8)
        strides = [builder.mul(shape[1], eight), eight] if len(shape) == 2 else [eight]
        populate_array(array, address, shape, strides, eight, None)
        given.append(array._getvalue())
    result = builder.call(function, given)
    builder.ret(result if signature.gives == "int" else word(0))
