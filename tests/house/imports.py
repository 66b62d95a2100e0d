#!/usr/bin/env python3
"""Checks what the Python packages in tools/ import: imports.py [ROOT].

A folder imports from folders before it in ORDER, kalmanq nothing of kalmanq_studies, and no module comes to itself
again by its imports.  Imports inside functions and for type checkers alone count.  kalmanq's own names are said in two
places, which agree.
Answers 0 where that holds.
"""
import ast
import functools
import pathlib
import sys

# First to last.  Those of one tuple don't import each other.
ORDER = [("errors",), ("core",), ("model",), ("data",), ("formulas", "run"), ("nonlinear",), ("firmware",), ("compiler",), ("fitting",),
         ("pages", "tune"), ("studies",), ("commands",), ("studies' commands", "command_line"), ("__main__",)]
RANK = {folder: rank for rank, folders in enumerate(ORDER) for folder in folders}
BUILT = {"kalmanq._core"}  # by tools/CMakeLists.txt
APART = ("native", "examples")  # programs of the build and of users, no modules of the package


def unit(module):
    """The folder, or the file beside the folders"""
    package, *rest = module.split(".")
    if package == "kalmanq_studies":
        return "studies' commands" if rest[:1] == ["commands"] else "studies"
    return rest[0] if rest else ""


@functools.lru_cache(maxsize=None)
def imported(text):
    """What a text imports of the packages: module, name in it or None, line"""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            found += [(one.name, None, node.lineno) for one in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            found += [(node.module, one.name, node.lineno) for one in node.names]
    return [one for one in found if one[0].split(".")[0] in ("kalmanq", "kalmanq_studies")]


class Imports:
    def __init__(self, root):
        self.faults = []
        self.texts = {}
        for folder in ("kalmanq", "studies/kalmanq_studies"):
            base = root / "tools" / folder
            for path in sorted(base.rglob("*.py")):
                inside = path.relative_to(base).with_suffix("").parts
                if inside[0] not in APART:
                    name = ".".join([base.name, *inside]).removesuffix(".__init__")
                    self.texts[name] = path.read_text(encoding="utf-8")

    def fault(self, module, what):
        self.faults.append(f"{module}: {what}")

    def imports(self, module):
        """Modules, and the lines where they are imported"""
        for other, name, line in imported(self.texts[module]):
            yield f"{other}.{name}" if f"{other}.{name}" in self.texts else other, line

    def check_order(self):
        for module in self.texts:
            if module == "kalmanq":
                continue  # its names are imported when they are used
            if unit(module) not in RANK:
                self.fault(module, f"{unit(module)} has no place in the order")
                continue
            for other, line in self.imports(module):
                if other in BUILT:
                    allowed = module == "kalmanq.core"
                elif other not in self.texts:
                    self.fault(module, f"line {line}: there is no {other}")
                    continue
                else:
                    ours, theirs = unit(module), unit(other)
                    allowed = ours == theirs or not theirs or theirs in RANK and RANK[theirs] < RANK[ours]
                if not allowed or unit(other).startswith("studies") and not unit(module).startswith("studies"):
                    self.fault(module, f"line {line}: imports {other}, which is not before it")

    def check_circles(self):
        """A folder's __init__ is no module of a circle: what it imports is for users of the folder."""
        done = set()

        def visit(module, way):
            if module in way:
                self.fault(module, "imports itself by " + " -> ".join([*way[way.index(module) + 1:], module]))
                return
            if module in done:
                return
            for other, _ in self.imports(module):
                if other in self.texts and other != "kalmanq":
                    visit(other, [*way, module])
            done.add(module)

        for module in self.texts:
            if module != "kalmanq":
                visit(module, [])

    def check_names(self):
        """kalmanq/__init__.py: what type checkers read is what is imported at run time."""
        tree = ast.parse(self.texts["kalmanq"])
        read = {f"{node.module}.{one.name}" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)
                and node.module.startswith("kalmanq.") for one in node.names}
        [places] = [node.value for node in tree.body if isinstance(node, ast.Assign) and node.targets[0].id == "_PLACES"]
        found = {f"kalmanq.{place}.{name}" for place, names in ast.literal_eval(places).items() for name in names.split()}
        for name in sorted(read ^ found):
            self.fault("kalmanq", f"{name} is in one list of names and not in the other")


def main():
    house = Imports(pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).parents[2]))
    house.check_order()
    house.check_circles()
    house.check_names()
    for line in house.faults:
        print(line)
    print(f"{len(house.texts)} modules, {len(house.faults)} faults")
    return bool(house.faults) or len(house.texts) < 20


if __name__ == "__main__":
    sys.exit(main())
