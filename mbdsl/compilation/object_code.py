"""Native object code from kernels, by numba: the only file that knows numba's inside.

numba optimises every function by itself, writes machine code for it, and does so again for whatever calls it. Here a
function is only a container of its unoptimised code; what is called from outside is linked with everything it needs,
optimised once, and becomes one object, which llvmlite alone can load (:mod:`mbdsl.compilation.code_cache`).

Seen from outside the functions are C functions. An array is handed over piece by piece, as numba's own ``cfunc`` does.
Checked with numba 0.60 and 0.68; where anything of it fails, ``cfunc`` takes over.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

from llvmlite import ir
from numba import config, njit
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import CompilerBase, DefaultPassBuilder
from numba.core.compiler_machinery import register_pass
from numba.core.registry import cpu_target
from numba.core.typed_passes import NativeLowering
from numba.np.arrayobj import populate_array

from mbdsl.compilation.native_call import ARRAYS, Signature
from mbdsl.compilation.numba_cfunc import numba_signature

#: without numba's runtime nothing can be allocated, and no time goes into counting references
OPTIONS = {"error_model": "numpy", "_nrt": False, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


class Object(NamedTuple):
    needs: list[str]  #: symbols that have to be there
    code: bytes


class Container(JITCodeLibrary):
    """The code of one function, and what it calls; never executed by itself."""

    def finalize(self) -> None:
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0

    @property
    def codegen(self):
        return self  # asked for by numba to make a function callable, which takes:

    def set_env(self, name: str, env: object) -> None:
        pass

    def everything(self, seen: set | None = None) -> Iterator[JITCodeLibrary]:
        """The libraries needed, each once, behind all that it needs."""
        seen = set() if seen is None else seen
        for library in self._linking_libraries:
            if library not in seen:
                seen.add(library)
                if isinstance(library, Container):
                    yield from library.everything(seen)
                yield library

    def link(self, entries: set[str]) -> Object:
        """All of it as one object, where nothing but ``entries`` can be seen from outside."""
        module = self._final_module
        # LLVM drops a function that nobody has asked for yet, and a library may be listed for a branch that is gone:
        # whoever asks comes first
        for library in reversed(list(self.everything())):
            module.link_in(library._get_module_for_linking(), preserve=True)
        for part in (*module.functions, *module.global_variables):
            if not part.is_declaration and part.name not in entries:
                part.linkage = "internal"
        former, config.LOOP_VECTORIZE = config.LOOP_VECTORIZE, 0
        try:  # most loops are over a few entries: what prepares a vector costs more than it saves
            self._optimize_final_module()
        finally:
            config.LOOP_VECTORIZE = former
        module.verify()
        needs = [f.name for f in module.functions if f.is_declaration and not f.name.startswith("llvm.")]
        return Object(needs, self._codegen._tm.emit_object(module))


@register_pass(mutates_CFG=True, analysis_only=False)
class Lowering(NativeLowering):
    """numba's, into a container."""

    _name = "mbdsl_lowering"

    def run_pass(self, state) -> bool:
        state.library = Container(state.targetctx.codegen(), state.func_id.func_qualname)
        return super().run_pass(state)


class Compiler(CompilerBase):
    """numba's, with our lowering."""

    def define_pipelines(self):
        pipeline = DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes = [(Lowering if step is NativeLowering else step, why) for step, why in pipeline.passes]
        if passes == pipeline.passes:
            raise RuntimeError("numba compiles in another way than it used to")
        pipeline.passes = passes
        pipeline.finalize()
        return [pipeline]


def compile_kernel(function: Callable, **options):
    """``function`` as other kernels may call it."""
    return njit(pipeline_class=Compiler, **OPTIONS, **options)(function)


def compile_object(functions: Mapping[str, tuple[Callable, Signature]]) -> Object:
    """An object with C functions by these names, and for each one that takes its arguments in one block."""
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


def _add_packed(context, module, function, signature: Signature, wanted) -> None:
    """``function`` with its arguments in one block of words; arrays as address and shape."""
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
