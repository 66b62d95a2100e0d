#!/usr/bin/env python3
"""Writes src/sys.rs, the declarations of the C library in Rust, from its headers: `bindings.py [OUTPUT]`.

It needs a C preprocessor, and reads the C that our headers use: no functions by pointer, sizes that are numbers.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
STAND_INS = ROOT / "tools/kalmanq/native/freestanding"  # empty headers of C; the reader knows the types below
KNOWN = {"uint8_t": "u8", "uint16_t": "u16", "uint32_t": "u32", "uint64_t": "u64", "int8_t": "i8", "int16_t": "i16",
         "int32_t": "i32", "int64_t": "i64", "size_t": "usize", "float": "f32", "double": "f64", "void": "c_void",
         "char": "c_char", "int": "c_int", "unsigned": "c_uint", "unsigned int": "c_uint", "long": "c_long",
         "kq_length": "u64"}  # 64 bits everywhere; the headers say it by the width of size_t
WORDS = {"as", "in", "loop", "match", "mod", "move", "ref", "type", "use", "where", "fn", "let", "box", "final", "yield"}
FUNCTION = 'unsafe extern "C" fn'


def name_of(name):
    return f"r#{name}" if name in WORDS else name


def answering(arguments, type_):
    return f"({', '.join(arguments)})" + ("" if type_ == "c_void" else f" -> {type_}")


class Writer:
    """Reads declarations from tokens, and keeps what they are in Rust"""

    def __init__(self, text):
        self.tokens = re.findall(r"\w+|[^\w\s]", text)
        self.at, self.items, self.functions, self.opaque, self.defined, self.calls = 0, [], [], set(), set(), set()

    def next(self, wanted=None):
        """The next token; None if it is another than the wanted one"""
        if wanted not in (None, self.tokens[self.at]):
            return None
        self.at += 1
        return self.tokens[self.at - 1]

    def need(self, wanted):
        if not self.next(wanted):
            raise SystemExit(f"bindings.py: {' '.join(self.tokens[self.at - 8:self.at + 8])}: no {wanted} where it is needed")

    def declaration(self):
        is_typedef, is_extern = self.next("typedef"), self.next("extern")
        base = self.base()
        while not self.next(";"):
            name, type_, arguments = self.declarator(base)
            if is_typedef:
                self.typedef(name, base, type_, arguments)
            elif arguments is not None:
                self.functions.append(f"    pub fn {name}{answering(arguments, type_)};")
            elif is_extern:
                self.functions.append(f"    pub static {name}: {type_};")
            self.next(",")
        if isinstance(base[0], list) and not is_typedef:
            self.struct(base[2], base[0], base[3])

    def base(self):
        """The type, or the fields where a struct or union is defined; whether it is const; tag and kind"""
        is_const = bool(self.next("const"))
        kind = self.next("struct") or self.next("union")
        if self.next("enum"):
            self.enumeration()
            return "c_int", is_const, "", "enum"
        if not kind:
            name = self.next()
            name += " int" if name == "unsigned" and self.next("int") else ""
            return KNOWN.get(name, name), is_const, "", ""
        tag = self.next() if self.tokens[self.at] != "{" else ""
        if self.next("{"):
            return self.fields(), is_const, tag, kind
        self.opaque.add(tag)
        return tag, is_const, tag, kind

    def fields(self):
        """Base, name and type of each"""
        made = []
        while not self.next("}"):
            base = self.base()
            if self.tokens[self.at] == ";":
                made.append((base, f"nameless_{len(made)}", ""))
            while not self.next(";"):
                made.append((base, *self.declarator(base)[:2]))
                self.next(",")
        return made

    def enumeration(self):
        self.need("{")
        value = -1
        while not self.next("}"):
            name = self.next()
            value = int(("-" if self.next("-") else "") + self.next(), 0) if self.next("=") else value + 1
            if not name.endswith("_IS_INT"):
                self.items.append(f"pub const {name}: {'c_uint' if name.startswith('KQ_EVENT_') else 'c_int'} = {value};")
            self.next(",")

    def declarator(self, base, is_argument=False):
        """A name, its type, and the arguments of a function"""
        type_, is_const = base[0], base[1]
        while self.next("*"):
            is_call = isinstance(type_, str) and type_ in self.calls  # which is a pointer already
            type_ = type_ if is_call else f"*{'const' if is_const else 'mut'} {type_}"
            is_const = bool(self.next("const"))
        name = self.next() if self.tokens[self.at] not in ",);[" else ""
        if self.next("["):
            size = "" if self.tokens[self.at] == "]" else self.next()
            self.need("]")
            type_ = f"*{'const' if is_const else 'mut'} {type_}" if is_argument else f"[{type_}; {size}]"
        return name, type_, self.arguments() if self.next("(") else None

    def arguments(self):
        made = []
        while not self.next(")"):
            name, type_, _ = self.declarator(self.base(), is_argument=True)
            made += [] if type_ == "c_void" else [f"{name_of(name or f'a{len(made)}')}: {type_}"]
            self.next(",")
        return made

    def struct(self, name, fields, kind):
        self.defined.add(name)
        lines = []
        for base, field, type_ in fields:
            if isinstance(base[0], list):
                type_ = base[2] or f"{name}_{field}"
                self.struct(type_, base[0], base[3])
            lines.append(f"    pub {name_of(field)}: {type_},")
        self.items.append("\n".join(["#[repr(C)]", "#[derive(Clone, Copy)]", f"pub {kind} {name} {{", *lines, "}"]))

    def typedef(self, name, base, type_, arguments):
        if arguments is not None:
            self.calls.add(name)
            type_ = f"Option<{FUNCTION}{answering(arguments, type_)}>"
        if isinstance(type_, list):
            self.struct(name, type_, base[3])
        elif name not in KNOWN and name != type_:
            self.items.append(f"pub type {name} = {type_};")


def text():
    command = [os.environ.get("CC", "cc"), "-E", "-P", "-nostdinc", f"-I{STAND_INS}", f"-I{ROOT / 'include'}",
               str(ROOT / "include/kalmanq/kalmanq.h")]
    headers = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    writer = Writer(re.sub(r"__attribute__\(\(warn_unused_result\)\)|\[\[nodiscard\]\]", "", headers))
    while writer.at < len(writer.tokens):
        writer.declaration()
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
