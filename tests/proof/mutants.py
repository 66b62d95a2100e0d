"""Mutants of src/, all compiled in: which places can be changed, by clang's syntax tree, and a text that chooses at run time.

An expression becomes (KQ_MUTANT(7) ? changed : as it is), a statement { if (!KQ_MUTANT(7)) as it is; }.  What the compiler has to
know cannot be chosen so: static initialisers, labels of cases, sizes of arrays, the preprocessor, bodies of macros."""

import ctypes
import hashlib
import re
from collections import Counter, namedtuple
from pathlib import Path

from clang import cindex
from clang.cindex import CursorKind as K

Mutant = namedtuple("Mutant", "kind file function begin end old new is_statement nth", defaults=(1,))

OPERATORS = {"+": "-", "-": "+", "*": "/", "/": "*", "%": "*", "<<": ">>", ">>": "<<", "&": "|", "|": "&", "^": "|",
             "+=": "-=", "-=": "+=", "*=": "/=", "/=": "*=", "|=": "&=", "&=": "|=", "<<=": ">>=", ">>=": "<<="}
COMPARISONS = {"<": "<=", "<=": "<", ">": ">=", ">=": ">", "==": "!=", "!=": "=="}
LOGICAL = {"&&": "||", "||": "&&"}
BINARY = {**{old: ("operator", new) for old, new in OPERATORS.items()}, **{old: ("comparison", new) for old, new in COMPARISONS.items()},
          **{old: ("logical", new) for old, new in LOGICAL.items()}}
KINDS = ("operator", "comparison", "logical", "constant", "removed statement", "removed guard", "negated condition", "swapped arguments")
LEAVES = (K.RETURN_STMT, K.CONTINUE_STMT, K.BREAK_STMT)


def blank_comments(text):
    return re.sub(r"/\*.*?\*/|//[^\n]*", lambda match: re.sub(r"[^\n]", " ", match.group()), text, flags=re.S)


def one_line(text):
    return " ".join(text.split())


class Finder:
    """The mutants of the files below a folder, from any number of translation units"""

    def __init__(self, folder):
        self.folder, self.texts, self.found, self.visited, self.left_out = Path(folder), {}, {}, set(), Counter()

    def parse(self, source, options, name="unit.c"):
        unit = cindex.Index.create().parse(name, args=["-std=c11", "-w", *options], unsaved_files=[(name, source)])
        if errors := [str(said) for said in unit.diagnostics if said.severity >= cindex.Diagnostic.Error]:
            raise SystemExit(f"mutants.py: {errors[:3]}")
        for cursor in unit.cursor.get_children():
            where = self.place(cursor.extent.start)
            if cursor.kind == K.FUNCTION_DECL and cursor.is_definition() and where and where not in self.visited:
                self.visited.add(where)
                self.file, self.function = where[0], re.sub(r"_(f32|f64|q31)$", "", cursor.spelling)
                for child in cursor.get_children():
                    if child.kind == K.COMPOUND_STMT:
                        self.visit(child, None)

    @staticmethod
    def file_offset(location):
        """Where it is written, if in the argument of a macro, too"""
        file, line, column, offset = cindex.c_object_p(), ctypes.c_uint(), ctypes.c_uint(), ctypes.c_uint()
        cindex.conf.lib.clang_getFileLocation(location, *(ctypes.byref(one) for one in (file, line, column, offset)))
        return (cindex.conf.lib.clang_getFileName(cindex.File(file)) if file else None), offset.value

    def place(self, location):
        name, offset = self.file_offset(location)
        path = Path(str(name)).resolve() if name else None
        return (str(path.relative_to(self.folder)), offset) if path and self.folder in path.parents else None

    def span(self, cursor):
        begin, end = self.place(cursor.extent.start), self.place(cursor.extent.end)
        return (begin[1], end[1]) if begin and end and begin[0] == end[0] == self.file else (0, 0)

    def text(self, file, begin, end):
        if file not in self.texts:
            self.texts[file] = blank_comments((self.folder / file).read_text())
        return self.texts[file][begin:end]

    def add(self, kind, begin, end, new, is_statement=False):
        old = self.text(self.file, begin, end)
        if not old or "#" in old or any(old.count(a) != old.count(b) for a, b in ("()", "[]", "{}")):
            self.left_out["text of a macro"] += 1
            return
        self.found[kind, self.file, begin, end, new] = Mutant(kind, self.file, self.function, begin, end, one_line(old), one_line(new), is_statement)

    def visit(self, cursor, statement_of):
        """statement_of: the statement that this one is in, or nothing for an expression's part"""
        begin, end = self.span(cursor)
        text = self.text(self.file, begin, end)
        children = list(cursor.get_children())
        if text.startswith("sizeof"):
            self.left_out["sizeof"] += 1
            return
        if cursor.kind == K.VAR_DECL:
            children = self.initialiser(cursor, begin, text, children)
        elif cursor.kind == K.CASE_STMT:
            self.left_out["label"] += 1
            children = children[1:]
        elif cursor.kind in (K.BINARY_OPERATOR, K.COMPOUND_ASSIGNMENT_OPERATOR):
            self.binary(begin, end, children)
        elif cursor.kind in (K.INTEGER_LITERAL, K.FLOATING_LITERAL):
            self.constant(begin, end, text)
        elif cursor.kind == K.CALL_EXPR:
            self.call(begin, end, list(cursor.get_arguments()))
            children = self.without_promise(cursor, children)
        elif cursor.kind in (K.IF_STMT, K.WHILE_STMT, K.CONDITIONAL_OPERATOR):
            self.condition(cursor.kind, children)
        if statement_of:
            self.statement(cursor, begin, end, text)
        for number, child in enumerate(children):
            is_body = cursor.kind in (K.COMPOUND_STMT, K.DEFAULT_STMT, K.CASE_STMT) or (cursor.kind == K.IF_STMT and number > 0) or (
                cursor.kind in (K.FOR_STMT, K.WHILE_STMT) and number == len(children) - 1)
            self.visit(child, cursor if is_body else None)

    def initialiser(self, cursor, begin, text, children):
        if cursor.storage_class == cindex.StorageClass.STATIC:
            self.left_out["static initialiser"] += 1
            return []
        equals = text.find("=")
        inside = [child for child in children if equals >= 0 and self.span(child)[0] > begin + equals]
        self.left_out["size of an array"] += len([child for child in children if child.kind.is_expression()]) - len(inside)
        return inside

    def binary(self, begin, end, children):
        (_, left_end), (right, right_end) = self.span(children[0]), self.span(children[1])
        operator = self.text(self.file, left_end, right).strip() if begin < left_end <= right < right_end else ""
        if operator not in BINARY:
            self.left_out["text of a macro"] += operator not in ("=", ",")
            return
        kind, new = BINARY[operator]
        are_pointers = [child.type.get_canonical().kind in (cindex.TypeKind.POINTER, cindex.TypeKind.CONSTANTARRAY) for child in children]
        if kind == "operator" and (are_pointers[1] or (are_pointers[0] and operator[0] not in "+-")):
            return
        self.add(kind, begin, end, self.text(self.file, begin, left_end) + f" {new} " + self.text(self.file, right, end))

    def constant(self, begin, end, text):
        if not re.fullmatch(r"[\d.][\w.]*", text) or re.search(r"_C\($", self.text(self.file, max(begin - 12, 0), begin)):
            self.left_out["text of a macro"] += 1
            return
        for sign in "+-":
            self.add("constant", begin, end, f"{text} {sign} 1")

    def call(self, begin, end, arguments):
        spans = [self.span(one) for one in arguments]
        for k in range(len(arguments) - 1):
            (a, b), (c, d) = spans[k], spans[k + 1]
            types = {re.sub(r"\bconst\b ?", "", one.type.spelling) for one in arguments[k:k + 2]}
            first, second = self.text(self.file, a, b), self.text(self.file, c, d)
            if begin < a < b < c < d < end and len(types) == 1 and first != second and self.text(self.file, b, c).strip() == ",":
                self.add("swapped arguments", begin, end, self.text(self.file, begin, a) + second + ", " + first + self.text(self.file, d, end))

    def without_promise(self, cursor, children):
        """The operations of arithmetic/fixed.h do not read their last argument: tests/checked does"""
        called = cursor.referenced
        where = called and self.place(called.location)
        if not where or where[0] != "arithmetic/fixed.h" or [one.spelling for one in called.get_arguments()][-1:] != ["bits"]:
            return children
        self.left_out["promise to tests/checked"] += 1
        return children[:-1]

    def condition(self, kind, children):
        begin, end = self.span(children[0])
        text = self.text(self.file, begin, end)
        self.add("negated condition", begin, end, f"!({text})")
        inside = list(children[1].get_children()) if kind == K.IF_STMT and children[1].kind == K.COMPOUND_STMT else children[1:2]
        if kind == K.IF_STMT and len(children) == 2 and inside and inside[-1].kind in LEAVES:
            self.add("removed guard", begin, end, f"0 && ({text})")

    def statement(self, cursor, begin, end, text):
        is_call = cursor.kind == K.CALL_EXPR or (text.startswith("(void)") and text.endswith(")"))
        is_change = cursor.kind in (K.COMPOUND_ASSIGNMENT_OPERATOR, K.BINARY_OPERATOR) and not text.startswith("(void)")
        is_step = cursor.kind == K.UNARY_OPERATOR and ("++" in text or "--" in text)
        if is_call or is_change or is_step:
            closing = re.match(r"\s*;", self.text(self.file, end, end + 3))
            if closing and text:
                self.add("removed statement", begin, end + closing.end(), ";", is_statement=True)


def key_of(mutant):
    """What names a mutant when lines have shifted: rows of survivors.txt begin so"""
    nth = f" ({mutant.nth})" if mutant.nth > 1 else ""
    return f"{mutant.file} | {mutant.function}{nth} | {mutant.kind} | {mutant.old} => {mutant.new}"


def numbered(found):
    """Those of one key, in their order: nth"""
    seen = Counter()
    for mutant in sorted(found.values(), key=lambda one: (one.file, one.begin, one.end, one.kind, one.new)):
        seen[key_of(mutant)] += 1
        yield mutant._replace(nth=seen[key_of(mutant)])


def sample(found, count, seed):
    """As many of each kind, in an order that a change of other text does not move"""
    def rank(mutant):
        return hashlib.sha256(f"{seed} {key_of(mutant)}".encode()).hexdigest()
    ranked = sorted(numbered(found), key=rank)
    return [mutant for kind in KINDS for mutant in [one for one in ranked if one.kind == kind][:count // len(KINDS)]]


def instrumented(text, mutants):
    """The text with numbered mutants of it: [(number, mutant)].  What is changed has no other mutants in it."""
    order = sorted(mutants, key=lambda one: (one[1].begin, -one[1].end, one[1].is_statement))

    def render(begin, end, inside):
        out, at = "", begin
        while inside:
            number, mutant = inside[0]
            within = [one for one in inside[1:] if one[1].end <= mutant.end]
            kept = render(mutant.begin, mutant.end, within)
            out += text[at:mutant.begin] + (f"{{ if (!KQ_MUTANT({number})) {kept} }}" if mutant.is_statement else
                                            f"(KQ_MUTANT({number}) ? ({mutant.new}) : ({kept}))")
            at, inside = mutant.end, inside[1 + len(within):]
        return out + text[at:end]

    return render(0, len(text), order)
