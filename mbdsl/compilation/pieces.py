"""Assembly of emitted modules from stored pieces: a new structure is compiled without numba.

The functions of an emitted module are sequences of calls of kernels, such as ``loops.springs(frames, gradients, ...)``.
Each of these kernels, with all code that it calls, is a *piece*: unoptimised LLVM bitcode, made by numba
(:func:`mbdsl.compilation.object_code.compile_piece`) when it is first needed, and kept in the cache folder. This module
writes the calls as LLVM code, links it with the pieces, and optimises the whole. numba's type inference takes nine
tenths of the time of a compilation; it is repeated only for kernels that no earlier structure has used.
"""

from __future__ import annotations

import ast
import hashlib
import json
from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import NamedTuple

from llvmlite import binding, ir

from mbdsl.compilation.native_call import ARRAYS, Signature

I64, I32, DOUBLE = ir.IntType(64), ir.IntType(32), ir.DoubleType()


class Object(NamedTuple):
    needs: list[str]  #: external symbols that the code refers to
    code: bytes


class Piece(NamedTuple):
    """A kernel and the kinds of its arguments, which are those of :class:`Signature`."""

    module: str
    function: str
    takes: tuple[str, ...]

    @property
    def symbol(self) -> str:
        return f"mbdsl.piece.{self.module}.{self.function}({','.join(self.takes)})"

    @property
    def file(self) -> str:
        digest = hashlib.sha256(self.symbol.encode()).hexdigest()[:16]
        return f"mbdsl_piece_{self.module.replace('.', '_')}_{self.function}_{digest}.bc"


class Call(NamedTuple):
    """A statement: a piece, and its arguments.

    An argument is the name of a parameter, an integer, or the index of an entry of ``layout`` in a tuple.
    """

    piece: Piece
    arguments: tuple[str | int | tuple[int], ...]


class Function(NamedTuple):
    names: list[str]  #: of the parameters
    calls: list[Call]


class NotStraight(Exception):
    """The text contains more than sequences of calls."""


def read(text: str, signatures: Mapping[str, Signature]) -> dict[str, Function]:
    """The functions of an emitted module.

    Raises
    ------
    NotStraight
        If one of them is not a sequence of calls.
    """
    names: dict[str, str] = {}  # alias -> module, or module.name
    found = {}
    for node in ast.parse(text).body:
        if isinstance(node, ast.Import):
            names |= {a.asname or a.name: a.name for a in node.names}
        elif isinstance(node, ast.ImportFrom):
            names |= {a.asname or a.name: f"{node.module}.{a.name}" for a in node.names}
        elif isinstance(node, ast.FunctionDef) and node.name in signatures:
            parameters = [a.arg for a in node.args.args]
            kinds = dict(zip(parameters, signatures[node.name].takes, strict=True))
            if signatures[node.name].gives != "none":
                raise NotStraight(node.name)
            found[node.name] = Function(parameters, [_call(statement, kinds, names) for statement in node.body])
        elif not isinstance(node, ast.Expr):
            raise NotStraight(ast.dump(node))
    return found


def _call(statement: ast.stmt, kinds: Mapping, names: Mapping[str, str]) -> Call:
    match statement:
        case ast.Expr(ast.Call(ast.Attribute(ast.Name(module), function), arguments, [])) if module in names:
            given = [_argument(x, kinds, names) for x in arguments]
            return Call(Piece(names[module], function, tuple(kind for kind, _ in given)), tuple(x for _, x in given))
    raise NotStraight(ast.dump(statement))


def _argument(node: ast.expr, kinds: Mapping, names: Mapping[str, str]) -> tuple[str, str | int | tuple[int]]:
    """Kind and value of an argument."""
    match node:
        case ast.Name(name) if isinstance(kinds.get(name), str):
            return kinds[name], name
        case ast.Subscript(ast.Name("layout"), index) if kinds.get("layout") == "ints":
            return "int", (_integer(index, names),)
    return "int", _integer(node, names)


def _integer(node: ast.expr, names: Mapping[str, str]) -> int:
    """A literal, or a constant that the text imports."""
    match node:
        case ast.Constant(int(value)):
            return value
        case ast.Name(name) if name in names:
            module, constant = names[name].rsplit(".", 1)
            if isinstance(value := getattr(import_module(module), constant), int):
                return value
    raise NotStraight(ast.dump(node))


# -- LLVM code -----------------------------------------------------------------------------------------------


def _type(kind: str) -> ir.Type:
    """The LLVM type of an argument; numba's arrays are structures that are passed by value."""
    if kind not in ARRAYS:
        return DOUBLE if kind == "float" else I64
    axes, entry = ARRAYS[kind]
    pointer, item = ir.IntType(8).as_pointer(), DOUBLE if entry.kind == "f" else I64
    shape = ir.ArrayType(I64, axes)
    return ir.LiteralStructType([pointer, pointer, I64, I64, item.as_pointer(), shape, shape])


def _entries(name: str, functions: Mapping[str, Function], signatures: Mapping[str, Signature]) -> ir.Module:
    """The functions ``name.function``, and ``name.function.packed`` with the arguments in one block of words."""
    module = ir.Module("mbdsl")
    pieces = {call.piece: None for f in functions.values() for call in f.calls}
    declared = {
        p: ir.Function(module, ir.FunctionType(ir.VoidType(), [_type(k) for k in p.takes]), p.symbol) for p in pieces
    }
    for key, function in functions.items():
        takes = signatures[key].takes
        outer = ir.Function(module, ir.FunctionType(ir.VoidType(), [_type(k) for k in takes]), f"{name}.{key}")  # type: ignore[arg-type]
        builder = ir.IRBuilder(outer.append_basic_block())
        given = dict(zip(function.names, outer.args, strict=True))
        for call in function.calls:
            builder.call(declared[call.piece], [_value(builder, x, given) for x in call.arguments])
        builder.ret_void()
        _add_packed(module, outer, takes)
    return module


def _value(builder: ir.IRBuilder, argument: str | int | tuple[int], given: Mapping[str, ir.Value]) -> ir.Value:
    if isinstance(argument, str):
        return given[argument]
    if isinstance(argument, int):
        return I64(argument)
    return builder.load(builder.gep(builder.extract_value(given["layout"], 4), [I64(argument[0])]))


def _add_packed(module: ir.Module, function: ir.Function, takes: tuple) -> None:
    """As :func:`mbdsl.compilation.object_code._add_packed`: arrays are in the block as address and shape."""
    packed = ir.Function(module, ir.FunctionType(I64, [I64.as_pointer()]), f"{function.name}.packed")
    builder = ir.IRBuilder(packed.append_basic_block())
    words = iter(range(1 << 16))

    def load(kind: ir.Type) -> ir.Value:
        place = builder.gep(packed.args[0], [I32(next(words))])
        return builder.load(builder.bitcast(place, kind.as_pointer()))

    given = []
    for kind in takes:
        whole = _type(kind)
        if kind not in ARRAYS:
            given.append(load(whole))
            continue
        address, shape = load(whole.elements[4]), [load(I64) for _ in range(ARRAYS[kind][0])]
        eight = I64(8)
        strides = [builder.mul(shape[1], eight), eight] if len(shape) == 2 else [eight]
        count = builder.mul(shape[0], shape[1]) if len(shape) == 2 else shape[0]
        value = ir.Constant(whole, None)  # no memory that numba manages
        value = builder.insert_value(value, count, 2)
        value = builder.insert_value(value, eight, 3)
        value = builder.insert_value(value, address, 4)
        for axis, (length, stride) in enumerate(zip(shape, strides, strict=True)):
            value = builder.insert_value(value, length, [5, axis])
            value = builder.insert_value(value, stride, [6, axis])
        given.append(value)
    builder.call(function, given)
    builder.ret(I64(0))


# -- objects -------------------------------------------------------------------------------------------------


class Stored(NamedTuple):
    """A piece from the cache folder: settings of the target machine, and bitcode."""

    settings: bytes
    bitcode: bytes


def link(
    name: str, functions: Mapping[str, Function], signatures: Mapping[str, Signature], stored: Mapping[Piece, Stored]
) -> Object:
    """One object with the functions of a module and all pieces that they call."""
    _initialise()
    settings = {piece.settings for piece in stored.values()}
    if len(settings) != 1:
        raise RuntimeError("pieces for different machines")
    entries = _entries(name, functions, signatures)
    parts = [binding.parse_bitcode(piece.bitcode) for piece in stored.values()]
    entries.triple, entries.data_layout = parts[0].triple, parts[0].data_layout
    module = binding.parse_assembly(str(entries))
    for part in parts:
        module.link_in(part)
    exported = {n for key in functions for n in (f"{name}.{key}", f"{name}.{key}.packed")}
    internalise(module, exported)
    machine = binding.Target.from_triple(module.triple).create_target_machine(**json.loads(settings.pop()))
    _optimise(module, machine)
    module.verify()
    return Object(list(needs(module)), machine.emit_object(module))


def internalise(module, exported: set[str]) -> None:
    """Hide all symbols but ``exported``."""
    for part in (*module.functions, *module.global_variables):
        if not part.is_declaration and part.name not in exported:
            part.linkage = "internal"


def needs(module) -> Iterator[str]:
    """External functions that a module calls."""
    return (f.name for f in module.functions if f.is_declaration and not f.name.startswith("llvm."))


def _initialise() -> None:
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()


def _optimise(module, machine) -> None:
    """LLVM's passes of level 3 without vectorisation: most loops have few iterations, and the setup of vectorised code
    costs more time than it saves."""
    if hasattr(binding, "create_pass_builder"):
        options = binding.create_pipeline_tuning_options(3)
        options.loop_vectorization = options.slp_vectorization = False
        builder = binding.create_pass_builder(machine, options)
        builder.getModulePassManager().run(module, builder)
    else:  # llvmlite before 0.44
        builder, passes = binding.create_pass_manager_builder(), binding.create_module_pass_manager()
        builder.opt_level, builder.inlining_threshold = 3, 225
        machine.add_analysis_passes(passes)
        builder.populate(passes)
        passes.run(module)
