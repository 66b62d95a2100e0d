#!/usr/bin/env python3
"""Stages kalmanq for a package manager: `packages.py NAME FOLDER`.  tools/package.sh calls it.

The version is that of include/kalmanq/version.h, the description that of CMakeLists.txt.  KALMANQ_URL is the address of
the repository, which a manifest has to name."""

import hashlib
import json
import os
import re
import shutil
import sys
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
VERSION = re.search(r'KQ_VERSION_STRING "(.*)"', (ROOT / "include/kalmanq/version.h").read_text()).group(1)
DESCRIPTION = re.search(r'DESCRIPTION "(.*)"', (ROOT / "CMakeLists.txt").read_text()).group(1)
URL = os.environ.get("KALMANQ_URL", "https://kalmanq.invalid")  # a name that no registry resolves
AUTHORS = "the kalmanq authors"
ARITHMETICS = ("f32", "f64", "q31")
SOURCES = sorted(path.name for path in ROOT.glob("src/kq_*.c"))
LICENSE = (ROOT / "LICENSE").read_text()


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text.strip("\n") + "\n")


def tree(to, *names):
    """The library's own files, and `names` of the root, in the places that they have here."""
    for name in ("include", "src", "LICENSE", "README.md", *names):
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        (to / name).parent.mkdir(parents=True, exist_ok=True)
        copy(ROOT / name, to / name)


def arduino(to):
    """All that Arduino compiles and finds is in src/."""
    shutil.copytree(ROOT / "src", to / "src")
    shutil.copytree(ROOT / "include/kalmanq", to / "src/kalmanq")
    write(to / "src/kalmanq.h", '/* For `#include <kalmanq.h>` in a sketch. */\n#include "kalmanq/kalmanq.h"')
    for name in ("LICENSE", "port/packages/arduino/README.md"):
        shutil.copy(ROOT / name, to)
    write(to / "keywords.txt", keywords())
    sketches(to, "kalmanq.h")
    write(to / "library.properties", f"""
name=kalmanq
version={VERSION}
author={AUTHORS}
maintainer={AUTHORS}
sentence={DESCRIPTION}.
paragraph=1 to 16 states in float, double or 32-bit fixed point, without a heap.
category=Data Processing
url={URL}
architectures=*
includes=kalmanq.h""")


def sketches(to, header):
    """The examples of sensors, and the README's program"""
    for path in sorted((ROOT / "port/packages/arduino/examples").glob("*/*.ino")):
        write(to / "examples" / path.stem / path.name, path.read_text().replace("<kalmanq.h>", f"<{header}>"))
    first = re.search(r"```cpp\n(.*?)```", (ROOT / "port/packages/arduino/README.md").read_text(), re.S)[1]
    write(to / "examples/first/first.ino", f"/* A level that drifts, and a gauge with noise at A0. */\n{first}".replace("<kalmanq.h>", f"<{header}>"))


def keywords():
    """What Arduino's editor colours: types, functions and macros of the headers"""
    text = "".join(path.read_text() for path in sorted((ROOT / "include/kalmanq").glob("*.h")))
    kinds = (("KEYWORD1", r"^(?:\}|typedef .*\}?) (kq_\w+);"), ("KEYWORD2", r"^(?:KQ_NODISCARD [a-z]\w* |[a-z]\w* |#define )\*?(kq_\w+)\("),
             ("LITERAL1", r"^#define (KQ_(?!PRIVATE)\w+)"))
    return "\n".join(f"{word}\t{kind}" for kind, pattern in kinds for word in sorted(set(re.findall(pattern, text, re.M))))


def platformio(to):
    tree(to)
    sketches(to, "kalmanq/kalmanq.h")
    examples = [{"name": path.stem, "base": f"examples/{path.stem}", "files": [path.name]} for path in sorted(to.glob("examples/*/*.ino"))]
    write(to / "library.json", json.dumps({
        "name": "kalmanq", "version": VERSION, "description": DESCRIPTION, "license": "MIT",
        "keywords": ["kalman", "filter", "smoother", "fixed-point"],
        "repository": {"type": "git", "url": URL}, "authors": [{"name": AUTHORS, "maintainer": True}],
        "headers": "kalmanq/kalmanq.h", "examples": examples, "frameworks": "*", "platforms": "*",
        "build": {"includeDir": "include", "srcDir": "src", "flags": ["-fno-math-errno", "-ffp-contract=off", "-lm"]}}, indent=2))


def zephyr(to):
    tree(to)
    shutil.copytree(ROOT / "port/packages/zephyr", to / "port/packages/zephyr")
    module = (ROOT / "port/packages/zephyr/module.yml").read_text()  # at the root, where west looks for it
    write(to / "zephyr/module.yml", module.replace(": zephyr", ": port/packages/zephyr"))


def esp_idf(to):
    tree(to)
    component = (ROOT / "port/packages/esp-idf/kalmanq/CMakeLists.txt").read_text()
    write(to / "CMakeLists.txt", component.replace("/../../../..", ""))
    write(to / "idf_component.yml", f"""
version: "{VERSION}"
description: {DESCRIPTION}
url: {URL}
license: MIT
dependencies:
  idf: ">=4.4" """)


def cmsis_pack(to):
    tree(to)
    parts = []
    for arithmetic in ARITHMETICS:
        # what messages of q31 need comes with it; prepare calculates in double, on the host
        names = [name for name in SOURCES if arithmetic in name and "prepare" not in name]
        files = "".join(f'\n        <file category="source" name="src/{name}"/>' for name in names)
        parts.append(f"""
      <component Cclass="DSP" Cgroup="kalmanq" Csub="{arithmetic}" Cversion="{VERSION}" condition="status">
        <description>{arithmetic}</description>
        <files>{files}
        </files>
      </component>""")
    write(to / "kalmanq.kalmanq.pdsc", f"""
<?xml version="1.0" encoding="UTF-8"?>
<package schemaVersion="1.7.7" xmlns:xs="http://www.w3.org/2001/XMLSchema-instance" xs:noNamespaceSchemaLocation="PACK.xsd">
  <vendor>kalmanq</vendor>
  <name>kalmanq</name>
  <description>{DESCRIPTION}</description>
  <url>{URL}/</url>
  <license>LICENSE</license>
  <releases>
    <release version="{VERSION}">CHANGELOG.md has what changed</release>
  </releases>
  <conditions>
    <condition id="status">
      <require Cclass="DSP" Cgroup="kalmanq" Csub="status"/>
    </condition>
  </conditions>
  <components>
      <component Cclass="DSP" Cgroup="kalmanq" Csub="status" Cversion="{VERSION}">
        <description>Headers, and statuses in words</description>
        <files>
          <file category="include" name="include/"/>
          <file category="doc" name="README.md"/>
          <file category="source" name="src/kq_status.c"/>
        </files>
      </component>{"".join(parts)}
  </components>
</package>""")


def conan(to):
    tree(to, "CMakeLists.txt", "port")
    consumer = to / "test_package"
    write(to / "conanfile.py", f'''
from conan import ConanFile
from conan.tools.cmake import CMake, CMakeDeps, CMakeToolchain, cmake_layout


class Kalmanq(ConanFile):
    name = "kalmanq"
    version = "{VERSION}"
    description = {json.dumps(DESCRIPTION)}
    license = "MIT"
    url = "{URL}"
    languages = "C"
    settings = "os", "compiler", "build_type", "arch"
    options = {{"shared": [True, False], "arithmetics": ["ANY"]}}
    default_options = {{"shared": False, "arithmetics": "{";".join(ARITHMETICS)}"}}
    exports_sources = "CMakeLists.txt", "LICENSE", "include/*", "src/*", "port/*"

    def layout(self):
        cmake_layout(self)

    def generate(self):
        chain = CMakeToolchain(self)
        chain.cache_variables.update(KALMANQ_BUILD_TESTS=False, KALMANQ_ARITHMETICS=str(self.options.arithmetics))
        chain.generate()
        CMakeDeps(self).generate()

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def package(self):
        CMake(self).install()

    def package_info(self):
        self.cpp_info.set_property("cmake_target_name", "kalmanq::kalmanq")
        self.cpp_info.libs = ["kalmanq"]
        self.cpp_info.system_libs = ["m"] if self.settings.os != "Windows" else []
''')
    write(consumer / "conanfile.py", '''
import os

from conan import ConanFile
from conan.tools.build import can_run
from conan.tools.cmake import CMake, cmake_layout


class Consumer(ConanFile):
    settings = "os", "compiler", "build_type", "arch"
    generators = "CMakeToolchain", "CMakeDeps"

    def requirements(self):
        self.requires(self.tested_reference_str)

    def layout(self):
        cmake_layout(self)

    def build(self):
        cmake = CMake(self)
        cmake.configure()
        cmake.build()

    def test(self):
        if can_run(self):
            self.run(os.path.join(self.cpp.build.bindir, "first"), env="conanrun")
''')
    write(consumer / "CMakeLists.txt", """
cmake_minimum_required(VERSION 3.22)
project(first C)
find_package(kalmanq REQUIRED CONFIG)
add_executable(first first.c)
target_link_libraries(first kalmanq::kalmanq)""")
    shutil.copy(ROOT / "tests/package/first.c", consumer)


def vcpkg(to):
    """An overlay port: the sources lie in its folder."""
    port = to / "kalmanq"
    tree(port / "source", "CMakeLists.txt", "port")
    write(port / "vcpkg.json", json.dumps({
        "name": "kalmanq", "version": VERSION, "description": DESCRIPTION, "homepage": URL, "license": "MIT",
        "dependencies": [{"name": name, "host": True} for name in ("vcpkg-cmake", "vcpkg-cmake-config")]}, indent=2))
    write(port / "portfile.cmake", """
vcpkg_cmake_configure(SOURCE_PATH "${CURRENT_PORT_DIR}/source" OPTIONS -DKALMANQ_BUILD_TESTS=OFF)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(PACKAGE_NAME kalmanq CONFIG_PATH lib/cmake/kalmanq)
vcpkg_fixup_pkgconfig()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include")
vcpkg_install_copyright(FILE_LIST "${CURRENT_PORT_DIR}/source/LICENSE")""")


def meson(to):
    """subprojects/: the tree with a meson.build, and the wrap that provides its dependency."""
    tree(to / "kalmanq")
    files = ",\n  ".join(f"'src/{name}'" for name in SOURCES)
    write(to / "kalmanq.wrap", "[wrap-file]\ndirectory = kalmanq\n\n[provide]\nkalmanq = kalmanq_dep")
    write(to / "kalmanq/meson.build", f"""
project('kalmanq', 'c', version: '{VERSION}', license: 'MIT',
  default_options: ['c_std=c11', 'buildtype=release', 'optimization=2', 'default_library=static'])
compiler = meson.get_compiler('c')
flags = compiler.get_supported_arguments('-ffunction-sections', '-fdata-sections', '-fno-math-errno',
  '-fno-tree-loop-distribute-patterns', '-ffp-contract=off')
headers = include_directories('include')
library = library('kalmanq',
  {files},
  include_directories: headers, c_args: flags, dependencies: compiler.find_library('m', required: false))
kalmanq_dep = declare_dependency(link_with: library, include_directories: headers)
""")


def python(to):
    """What a source distribution is made of: tools/, with the C library in core/."""
    for name in ("include", "src", "CMakeLists.txt", "port/armv6m", "port/armv7m", "port/avr"):
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        (to / "core" / name).parent.mkdir(parents=True, exist_ok=True)
        copy(ROOT / name, to / "core" / name)
    shutil.copytree(ROOT / "tools/kalmanq", to / "kalmanq", ignore=shutil.ignore_patterns("__pycache__", "_core.*.so", "_core.*.pyd"))
    shutil.copy(ROOT / "tools/CMakeLists.txt", to)
    shutil.copy(ROOT / "LICENSE", to)
    project = (ROOT / "tools/pyproject.toml").read_text()
    project = project.replace("../build/tools/", "build/")
    project = project.replace('license = "MIT"', 'license = "MIT"\nlicense-files = ["LICENSE"]')
    write(to / "pyproject.toml", project.replace(f'description = "', f'urls.Home = "{URL}"\ndescription = "'))


def rust(to):
    """A crate, with the C library in core/ and its declarations."""
    sys.path.insert(0, str(ROOT / "port/rust"))
    import bindings

    shutil.copytree(ROOT / "port/rust", to, ignore=shutil.ignore_patterns("target", "Cargo.lock", "bindings.py", "sys.rs", "__pycache__", "chip", "rust.sh", "CMakeLists.txt"))
    write(to / "src/sys.rs", bindings.text())
    shutil.copy(ROOT / "LICENSE", to)
    for name in ("include", "src"):
        shutil.copytree(ROOT / name, to / "core" / name)
    project = (ROOT / "port/rust/Cargo.toml").read_text()
    write(to / "Cargo.toml", project.replace('license = "MIT"', f'license = "MIT"\nrepository = "{URL}"'))


class OneFile:
    """One C text: every header in its place, once.  Of `#if` that ask for the arithmetic, one side is left."""

    def __init__(self, folders, known):
        self.folders, self.known, self.done = folders, known, set()

    def found(self, name, beside):
        return next(path for folder in (beside, *self.folders) if (path := (folder / name).resolve()).exists())

    def text(self, path):
        """Lines of a file; sides of a condition that is known are chosen."""
        kept, sides = [], []  # of each #if: None, it stays, or whether its lines are taken
        for line in path.read_text().splitlines():
            word = re.match(r"\s*#\s*(if\w*|else|elif|endif)\b\s*(\w*)\s*$|\s*#\s*(if\w*|elif)\b", line)
            word = word and (word.group(1) or word.group(3), word.group(2))
            is_known = bool(sides) and sides[-1] is not None
            if word and word[0].startswith("if"):
                sides.append(self.known[word[1]] if word[0] == "if" and word[1] in self.known else None)
                if sides[-1] is not None:
                    continue
            elif word and word[0] in ("else", "elif") and is_known:
                assert word[0] == "else", f"{path}: {line}"
                sides[-1] = not sides[-1]
                continue
            elif word and word[0] == "endif":
                if sides.pop() is not None:
                    continue
            if False not in sides:
                kept += self.line(line, path)
        return kept

    def line(self, line, path):
        include = re.match(r'\s*#\s*include "(.*)"', line)
        if not include:
            return [line]
        header = self.found(include.group(1), path.parent)
        if header in self.done:
            return []
        self.done.add(header)
        if (ROOT / "include") in header.parents and "port" not in header.parts[-2:] and self.known:
            public, self.known_header = not hasattr(self, "known_header"), True
            return ['#include "kalmanq.h"'] if public else []
        return self.text(header)


def onefile(to):
    banner = f"/* kalmanq {VERSION}, made of the library's files by port/packages/packages.py.\n\n{LICENSE}*/\n"
    header = OneFile([ROOT / "include"], {})
    write(to / "kalmanq.h", banner + "\n".join(header.text(ROOT / "include/kalmanq/kalmanq.h")))
    write(to / "kalmanq/kalmanq.h", '#include "../kalmanq.h"\n')  # programs find it as the library's, too
    generic = header.text(ROOT / "include/kalmanq/generic.h")
    write(to / "kalmanq/generic.h", banner + '#include "../kalmanq.h"\n' + "\n".join(generic))
    for arithmetic in ARITHMETICS:
        name = f"src/arithmetic/{arithmetic}.h"
        known = {key: value == "1" for key, value in
                 re.findall(r"#define (KQ_FLOATING|KQ_MEAN_IS_PAIR) ([01])", (ROOT / name).read_text())}
        one = OneFile([ROOT / "include", ROOT / "src"], {"KQ_MEAN_IS_PAIR": False, **known})
        lines = []
        for source in SOURCES:
            if arithmetic in source and "prepare" not in source:
                lines += one.text(ROOT / "src" / source)
        status = OneFile([ROOT / "include", ROOT / "src"], known).text(ROOT / "src/kq_status.c")
        lines += ["#ifndef KQ_NO_STATUS_TEXT /* define it for all but one of several such files */", *status, "#endif"]
        write(to / f"kalmanq_{arithmetic}.c", banner + "\n".join(lines))
    archive(to, f"kalmanq-{VERSION}-onefile.zip")


def archive(of, name):
    """What a release has, beside the folder: the same bytes whenever it is made, and their SHA-256"""
    made = of.parent / name
    with zipfile.ZipFile(made, "w", zipfile.ZIP_DEFLATED) as file:
        for path in sorted(path for path in of.rglob("*.[ch]")):
            file.writestr(zipfile.ZipInfo(str(path.relative_to(of))), path.read_bytes(), zipfile.ZIP_DEFLATED)
    (of.parent / f"{name}.sha256").write_text(f"{hashlib.sha256(made.read_bytes()).hexdigest()}  {name}\n")


PACKAGES = {"arduino": arduino, "platformio": platformio, "zephyr": zephyr, "esp-idf": esp_idf, "cmsis-pack": cmsis_pack,
            "conan": conan, "vcpkg": vcpkg, "meson": meson, "onefile": onefile, "python": python,
            "rust": rust}


def main(name, folder):
    if name not in PACKAGES:
        sys.exit(f"packages.py: {name}: there is no such package; there are {', '.join(PACKAGES)}")
    shutil.rmtree(folder, ignore_errors=True)
    PACKAGES[name](Path(folder))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(f"usage: packages.py {'|'.join(PACKAGES)} FOLDER")
    main(*sys.argv[1:])
