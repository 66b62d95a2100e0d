#!/usr/bin/env python3
"""Writes src/sys.rs, the declarations of the C library in Rust, from its headers: `bindings.py [OUTPUT]`.  It needs
pycparser and a C preprocessor."""

import os
import re
import subprocess
import sys
from pathlib import Path

from pycparser import c_ast, c_parser

ROOT = Path(__file__).resolve().parents[2]
STAND_INS = ROOT / "tools/kalmanq/native/freestanding"  # empty headers of C; the parser gets the types below
KNOWN = {"uint8_t": "u8", "uint16_t": "u16", "uint32_t": "u32", "uint64_t": "u64", "int8_t": "i8", "int16_t": "i16",
         "int32_t": "i32", "int64_t": "i64", "size_t": "usize", "float": "f32", "double": "f64", "void": "c_void",
         "char": "c_char", "int": "c_int", "unsigned": "c_uint", "unsigned int": "c_uint", "long": "c_long"}
WORDS = {"as", "in", "loop", "match", "mod", "move", "ref", "type", "use", "where", "fn", "let", "box", "final", "yield"}


KNOWN["kq_length"] = "u64"  # 64 bits everywhere; the headers say it by the width of size_t
FUNCTION = 'unsafe extern "C" fn'


def name_of(name):
    return f"r#{name}" if name in WORDS else name


class Writer:
    def __init__(self):
        self.items, self.numbers, self.functions, self.opaque, self.defined = [], {}, [], set(), set()

    def type(self, node):
        """A type as a field or an argument has it"""
        if isinstance(node, c_ast.TypeDecl):
            return self.type(node.type)
        if isinstance(node, c_ast.IdentifierType):
            name = " ".join(node.names)
            return KNOWN.get(name, name)
        if isinstance(node, c_ast.PtrDecl):
            return self.pointer(node.type)
        if isinstance(node, c_ast.ArrayDecl):
            return f"[{self.type(node.type)}; {self.number(node.dim)}]"
        if isinstance(node, (c_ast.Struct, c_ast.Union)):
            if node.decls is None:
                self.opaque.add(node.name)
            return node.name
        if isinstance(node, c_ast.Enum):
            return "c_int"
        raise NotImplementedError(node)

    def pointer(self, to):
        if isinstance(to, c_ast.FuncDecl):
            return f"Option<{self.signature(to, FUNCTION)}>"
        if isinstance(to, c_ast.TypeDecl) and getattr(to.type, "names", None) and self.type(to) in self.functions_of_users:
            return self.type(to)  # such a type is a pointer already
        return f"*{'const' if 'const' in getattr(to, 'quals', []) else 'mut'} {self.type(to)}"

    functions_of_users = set()

    def signature(self, node, head):
        arguments = []
        for index, one in enumerate(node.args.params if node.args else []):
            if isinstance(one, c_ast.Typename) and self.type(one.type) == "c_void":
                continue
            type_ = one.type
            written = self.pointer(type_.type) if isinstance(type_, c_ast.ArrayDecl) else self.type(type_)
            arguments.append(f"{name_of(one.name or f'a{index}')}: {written}")
        result = self.type(node.type)
        return f"{head}({', '.join(arguments)})" + ("" if result == "c_void" else f" -> {result}")

    def number(self, node):
        """The value of a constant expression"""
        if isinstance(node, c_ast.Constant):
            return int(node.value.rstrip("uUlL"), 0)
        if isinstance(node, c_ast.ID):
            return self.numbers[node.name]
        if isinstance(node, c_ast.UnaryOp) and node.op == "-":
            return -self.number(node.expr)
        if isinstance(node, c_ast.BinaryOp):
            left, right = self.number(node.left), self.number(node.right)
            return {"+": left + right, "-": left - right, "*": left * right, "<<": left << right if right >= 0 else 0,
                    "/": left // right if right else 0}[node.op]
        raise NotImplementedError(node)

    def enumeration(self, node):
        value = -1
        for one in node.values.enumerators:
            value = value + 1 if one.value is None else self.number(one.value)
            self.numbers[one.name] = value
            kind = "c_uint" if one.name.startswith("KQ_EVENT_") else "c_int"
            if not one.name.endswith("_IS_INT"):
                self.items.append(f"pub const {one.name}: {kind} = {value};")

    def struct(self, name, node):
        self.defined.add(name)
        fields = []
        for index, one in enumerate(node.decls):
            inner = one.type.type if isinstance(one.type, c_ast.TypeDecl) else one.type
            one.name = one.name or f"nameless_{index}"
            if isinstance(inner, (c_ast.Struct, c_ast.Union)) and inner.decls:
                inner.name = inner.name or f"{name}_{one.name}"
                self.struct(inner.name, inner)
            fields.append(f"    pub {name_of(one.name)}: {self.type(one.type)},")
        kind = "union" if isinstance(node, c_ast.Union) else "struct"
        self.items.append("\n".join(["#[repr(C)]", "#[derive(Clone, Copy)]", f"pub {kind} {name} {{", *fields, "}"]))

    def typedef(self, node):
        of = node.type.type if isinstance(node.type, c_ast.TypeDecl) else None
        if isinstance(of, (c_ast.Struct, c_ast.Union)) and of.decls:
            self.struct(node.name, of)
        elif isinstance(of, c_ast.Struct):
            self.opaque.add(of.name)
            if of.name != node.name:
                self.items.append(f"pub type {node.name} = {of.name};")
        elif isinstance(of, c_ast.Enum):
            self.enumeration(of)
            self.items.append(f"pub type {node.name} = c_int;")
        elif isinstance(node.type, c_ast.FuncDecl):
            self.functions_of_users = self.functions_of_users | {node.name}
            self.items.append(f"pub type {node.name} = Option<{self.signature(node.type, FUNCTION)}>;")
        elif node.name not in KNOWN:
            self.items.append(f"pub type {node.name} = {self.type(node.type)};")

    def declaration(self, node):
        if isinstance(node.type, c_ast.FuncDecl):
            self.functions.append(f"    {self.signature(node.type, f'pub fn {node.name}')};")
        elif isinstance(node.type, c_ast.Struct) and node.type.decls:
            self.struct(node.type.name, node.type)
        elif isinstance(node.type, c_ast.Enum):
            self.enumeration(node.type)
        elif "extern" in node.storage:
            self.functions.append(f"    pub static {node.name}: {self.type(node.type)};")


def text():
    command = [os.environ.get("CC", "cc"), "-E", "-P", "-nostdinc", f"-I{STAND_INS}", f"-I{ROOT / 'include'}",
               str(ROOT / "include/kalmanq/kalmanq.h")]
    headers = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    headers = re.sub(r"__attribute__\(\(warn_unused_result\)\)|\[\[nodiscard\]\]", "", headers)
    types = "".join(f"typedef int {name};" for name in KNOWN if name.endswith("_t"))
    writer = Writer()
    for node in c_parser.CParser().parse(types + headers).ext:
        writer.typedef(node) if isinstance(node, c_ast.Typedef) else writer.declaration(node)
    hidden = [f"#[repr(C)]\npub struct {name} {{\n    _private: [u8; 0],\n}}" for name in sorted(writer.opaque - writer.defined)]
    return "\n".join(["//! The C library's declarations, made by bindings.py from its headers.", "",
                      "#![allow(non_camel_case_types, non_snake_case, missing_docs)]", "",
                      "use core::ffi::{c_char, c_int, c_uint, c_void};", "", *hidden, *writer.items, "",
                      'unsafe extern "C" {', *writer.functions, "}", ""])


def main():
    output = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent / "src/sys.rs"
    output.write_text(text())


if __name__ == "__main__":
    main()
