#!/usr/bin/env python3
"""Says whether two source trees compile to the same code, function by function.

    same_code.py OLD NEW [--core m4f] [--level Os]

For changes that must move no instruction: code that moves to another file, a name, a macro.  What is
compared are the instructions of each function and the symbols they refer to, without addresses; which
file a function stands in and the order of functions don't count.
"""
import argparse
import collections
import os
import re
import subprocess
import sys
import tempfile

CORES = {
    "host": ("", "gcc", []),
    "m4f": ("arm-none-eabi-", "gcc", ["-mthumb", "-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]),
    "m0": ("arm-none-eabi-", "gcc", ["-mthumb", "-mcpu=cortex-m0"]),
    "rv32": ("riscv64-unknown-elf-", "gcc", ["--specs=picolibc.specs", "-march=rv32imac", "-mabi=ilp32"]),
    "avr": ("avr-", "gcc", ["-mmcu=atmega2560"]),
}
FLAGS = ["-std=c11", "-ffunction-sections", "-fdata-sections", "-fno-math-errno", "-ffp-contract=off",
         "-fno-tree-loop-distribute-patterns", "--param=max-inline-insns-single=15"]


def functions(tree, core, level, renamed):
    """Each function's text; several where files have static functions of one name."""
    prefix, compiler, machine = CORES[core]
    texts = collections.defaultdict(collections.Counter)
    sources = sorted(name for name in os.listdir(f"{tree}/src") if name.endswith(".c"))
    if core == "avr":
        sources = [name for name in sources if "_f64" not in name]
    with tempfile.TemporaryDirectory() as work:
        for source in sources:
            subprocess.run([prefix + compiler, *machine, *FLAGS, "-" + level, f"-I{tree}/include", "-c",
                            f"{tree}/src/{source}", "-o", f"{work}/object"], check=True)
            listing = subprocess.run([prefix + "objdump", "-dr", "--no-show-raw-insn", f"{work}/object"],
                                     check=True, capture_output=True, text=True).stdout
            for block in re.split(r"\n\n", listing):
                match = re.match(r"(?:Disassembly of section .*\n\n?)?[0-9a-f]+ <(.+)>:\n", block)
                if match:
                    name, text = renamed(match.group(1)), renamed(plain(block[match.end():]).rstrip())
                    texts[re.sub(r"\.(isra|part|constprop|lto_priv|cold)[.\d]*", r".\1", name)][text] += 1
    return texts


def plain(text):
    text = re.sub(r"^\s*[0-9a-f]+:\t?", "", text, flags=re.M)             # addresses of instructions
    text = re.sub(r"\b[0-9a-f]+ <([^>]*)>", r"<\1>", text)                # and of what they refer to
    text = re.sub(r"\.(isra|part|constprop)\.\d+", r".\1", text)
    text = re.sub(r"(__func__|\b[A-Za-z_]\w*)\.\d+\b", r"\1", text)       # numbers of static data
    return re.sub(r"\.L\w+|\.LC\d+|\.LANCHOR\d+", ".L", text)


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("old")
    options.add_argument("new")
    options.add_argument("--core", choices=CORES, default="m4f")
    options.add_argument("--level", default="Os", help="O0, O2, Os, ...")
    options.add_argument("--rename", action="append", default=[], metavar="OLD=NEW")
    options.add_argument("--show", action="store_true", help="print the lines that differ")
    options = options.parse_args()
    names = dict(pair.split("=") for pair in options.rename)
    pattern = re.compile(r"\b(" + "|".join(map(re.escape, names)) + r")\b") if names else None

    def renamed(text):
        return pattern.sub(lambda match: names[match.group(1)], text) if pattern else text

    old = functions(options.old, options.core, options.level, renamed)
    new = functions(options.new, options.core, options.level, lambda text: text)
    same = sum((old[name] & new[name]).total() for name in old)
    for name in sorted(set(old) | set(new)):
        if old[name] == new[name]:
            continue
        only_old, only_new = (old[name] - new[name]).total(), (new[name] - old[name]).total()
        print(f"{name}: {only_old} only before, {only_new} only after")
        if options.show:
            import difflib
            for a, b in zip((old[name] - new[name]).elements(), (new[name] - old[name]).elements()):
                print("\n".join(difflib.unified_diff(a.split("\n"), b.split("\n"), lineterm="", n=1)))
    count = sum(texts.total() for texts in old.values())
    print(f"{same} of {count} functions compile to the same code ({options.core} -{options.level})")
    return same != count or sum(texts.total() for texts in new.values()) != count


if __name__ == "__main__":
    sys.exit(main())
