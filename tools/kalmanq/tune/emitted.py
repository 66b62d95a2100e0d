"""The C of a nonlinear model in WebAssembly: as `kalmanq compile` writes it, but with its noises in an array that the page fills."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Callable, Iterator, Optional, Sequence

from kalmanq.compiler.given.request import Options
from kalmanq.compiler.text.emit import PREDICTS, UPDATES, Row
from kalmanq.compiler.text.equation_product import compiled_equations
from kalmanq.compiler.text.product import Product
from kalmanq.data.files import own_folder, telling_where
from kalmanq.errors import KalmanqError
from kalmanq.firmware.steps_kept import MOST_STEPS
from kalmanq.formulas.graph import using
from kalmanq.formulas.printing import Body, Floats, indented
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.calls import Given
from kalmanq.run.robust import ALONE
from kalmanq.tune.literals import Template, in_double, template, with_loads

C = Path(__file__).resolve().parent / "c"
LOSSES = ("none", *ALONE)
FLOATS = ("f32", "f64")
CLANG = ("clang", *(f"clang-{k}" for k in range(21, 13, -1)))
LINKER = ("wasm-ld", *(f"wasm-ld-{k}" for k in range(21, 13, -1)))
FLAGS = ("--target=wasm32", "-std=c11", "-O2", "-ffreestanding", "-ffp-contract=off", "-fno-math-errno", "-mbulk-memory", "-w")
NO_TOOLS = "tune: {} not found; it compiles the page of a nonlinear model: apt install clang lld"
ModelOf = Callable[[Sequence[float]], NonlinearModel]  # with these sizes of its noises


@dataclass(frozen=True)
class Variant:
    """A filter of the page: its C with open noises; and what a user gets, without the smoother"""

    name: str
    product: Product
    header: str
    run: Template
    written: Template

    @property
    def events(self) -> list[tuple[int, str]]:
        """Bits that tell of a fault"""
        return [(1 << k, meaning) for k, (name, meaning) in enumerate(self.product.events.items()) if name != "GATED"]


def tools() -> tuple[str, str]:
    found = [next((path for path in map(shutil.which, names) if path), None) for names in (CLANG, LINKER)]
    if None in found:
        raise KalmanqError(NO_TOOLS.format("clang" if found[0] is None else "wasm-ld"))
    return found[0], found[1]  # type: ignore[return-value]


def variants(of_sizes: ModelOf, begun: Sequence[float], rows: int, name: str) -> Iterator[Variant]:
    """By loss and arithmetic, f64 first.  name: of the C that a user gets"""
    for loss in LOSSES:
        double: Optional[Variant] = None
        for arithmetic in reversed(FLOATS):
            own = f"{loss}_{arithmetic}"
            plain = Options(arithmetic)
            run = partial(_product, of_sizes, own, replace(plain, nis=True, smooth=max(1, min(rows, MOST_STEPS))), loss)
            written = partial(_product, of_sizes, name, plain, loss)
            products = run(begun, None), written(begun, None)
            made = Variant(own, products[0], products[1].header, *(
                template(lambda *given, of=of, like=product: _code(of(*given, like=like)), len(begun), loss, None if loss == "student" else (begun, _code(product)))
                for of, product in zip((run, written), products)))
            if double is not None:
                made = replace(made, run=in_double(made.run, double.run), written=in_double(made.written, double.written))
            double = double or made
            yield made


def _product(of_sizes: ModelOf, name: str, options: Options, loss: str, sizes: Sequence[float], parameter: Optional[float], like: Optional[Product] = None) -> Product:
    """like: at the sizes of the file, where it is decided which rounding the C looks at"""
    given = {} if loss == "none" else {loss: 3.0 if parameter is None else parameter}
    return compiled_equations(of_sizes(sizes), name, replace(options, **given), looked_at=like.arithmetic.looked_at if like else None)


def _code(product: Product) -> str:
    return product.sources()[f"{product.given.name}.c"]


# ------------------------------------------------------------------------------ WebAssembly


def module(model: NonlinearModel, made: Sequence[Variant]) -> bytes:
    clang, linker = tools()
    names = ["tune_request", "tune_take", "tune_mark", "tune_release", *(f"{one.name}_tune" for one in made), *(f"{one.name}_k" for one in made)]
    with own_folder("kalmanq-tune-") as folder, telling_where(folder):
        texts = {"explain.c": explained(model)}
        for one in made:
            texts.update({f"{one.name}.h": one.product.header, f"{one.name}.c": _filter(one), f"{one.name}_run.c": driver(one.product)})
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
        sources = [C / "memory.c", C / "run.c", folder / "explain.c", *(folder / f"{one.name}_run.c" for one in made)]
        objects = [folder / f"{one.stem}.o" for one in sources]
        for source, target in zip(sources, objects):
            _told([clang, *FLAGS, f"-I{C}", f"-I{folder}", "-c", str(source), "-o", str(target)])
        _told([linker, "--no-entry", "--gc-sections", "--strip-all", "--allow-undefined", "-z", "stack-size=262144",
               *(f"--export={one}" for one in names), *map(str, objects), "-o", str(folder / "model.wasm")])
        return (folder / "model.wasm").read_bytes()


def _told(command: Sequence[str]) -> None:
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        lines = done.stderr.strip().splitlines() or ["no reason given"]
        said = next((line for line in lines if "error" in line), lines[0])
        raise KalmanqError(f"tune: clang made no WebAssembly of the model: {said}; apt install clang lld, 14 or newer")


def _filter(one: Variant) -> str:
    type_ = one.product.arithmetic.type
    return f"{type_} {one.name}_k[{max(1, len(one.run.literals))}];\n{with_loads(one.run, f'{one.name}_k')}"


def explained(model: NonlinearModel) -> str:
    """Innovations, H and R of all measurements, and nominal numbers by their errors, in double"""
    f, noisy = model.formulas, {k for one in model.sensors if isinstance(model.noises.parts[one.name], Given) for k in range(model.m)[one.rows]}
    lines = [f"const double {stem}{k} = {stem}[{k}];" for stem, count in (("x", len(model.carried)), ("z", model.m), ("u", model.l)) for k in range(count)]
    with using(f.graph):
        body = Body(Floats("double"), lines=lines)
        targets = [*((f"e[{j}]", one) for j, one in enumerate(f.innovation)),
                   *((f"H[{j * model.n + i}]", one) for j, row in enumerate(f.measurement) for i, one in enumerate(row))]
        spread = f.noise_of_sensors or []
        targets += [(f"R[{i * model.m + j}]", spread[i][j]) for i in sorted(noisy) for j in sorted(noisy)]
        body.assign(targets)
    rest = [f"R[{i * model.m + j}] {'*' if {i, j} <= noisy else ''}= scale[{i * model.m + j}];" for i in range(model.m) for j in range(model.m)]
    arguments = "const double *x, const double *z, const double *u, double t, const double *scale, double *e, double *H, double *R"
    return "\n".join(['#include "run.h"', "", "#include <math.h>", "", f"void tune_explain({arguments})", "{",
                      *indented([*body.lines, *rest]), "}", "", *_by_errors(model), ""])


def _by_errors(model: NonlinearModel) -> list[str]:
    f = model.formulas
    lines = [f"const double x{k} = x[{k}];" for k in range(len(model.carried))] if model.has_errors else []
    if model.has_errors:
        J = f.by_errors(f.corrected)
        with using(f.graph):
            Body(Floats("double"), lines=lines).assign([(f"J[{i * model.n + k}]", one) for i, row in enumerate(J) for k, one in enumerate(row)])
    return ["int tune_by_errors(const double *x, double *J)", "{", *indented([*lines, f"return {int(model.has_errors)};"]), "}"]


RUN = """#include "{name}.c" /* one file: it is compiled once */

#include "memory.h"
#include "run.h"

static {name}_filter f;

static tune_state tune_now(void)
{{
    tune_state made;
{read}
    for (int i = 0; i < {n}; i++)
        for (int j = 0; j < {n}; j++) made.P[i * {n} + j] = {entry};
    return made;
}}

/* Row t with what has come by another one */
static void tune_row(const tune_run *of, {name}_history *history, int t, int by)
{{
    const double *z = of->z + t * {m}, *u = of->u, *clock = of->clock + 3 * t;
    const unsigned present = tune_present(of, t, by);
    const int what = (t ? {predicts} : 0) | (present ? {updates} : 0);
    {type} v[{m}], w[{l} + 1], at[{l} + 1];
    unsigned taken = 0;
    (void)u, (void)w, (void)at, (void)history;
{given}
{predict}
    const tune_state before = tune_now();
    tune_expect(of, &before, t);
{update}
    tune_judge(of, t, present, taken);
}}

/* kept: filters before the last rows, from which those are taken again once something of them comes */
static void tune_filter(const tune_run *of, {name}_history *history, {name}_filter *kept)
{{
    const int most = of->latest + 1;
    for (int t = 0; t < of->rows; t++) {{
        const int first = tune_first(of, t);
        kept[t % most] = f;
        if (first < t) f = kept[first % most];
        for (int s = first; s <= t; s++) {{
            kept[s % most] = f;
            tune_row(of, history, s, t);
        }}
        if (!of->mean) continue;
        const tune_state made = tune_now();
        tune_tell(of, &made, of->u + t * {l}, of->clock[3 * t + 2], t, of->mean, of->sigma, of->expected);
    }}
    tune_total(of);
}}

static void tune_smooth(const tune_run *of, const {name}_history *history)
{{
    const double *clock = of->clock;
    for (int t = of->rows - 1, back = 0; t >= 0; t--) {{
        const tune_state made = tune_now();
        tune_tell(of, &made, of->u + t * {l}, clock[3 * t + 2], t, of->smoothed, of->smoothed_sigma, of->smoothed_expected);
        if (t && !{name}_smooth(&f, history, ++back)) break;
    }}
}}

/* Rows after the last one, with its controls */
static void tune_look_ahead(const tune_run *of, {name}_history *history)
{{
    const int last = of->rows - 1, what = {predicts};
    double clock[3] = {{of->clock[3 * last + 2], *of->step, 0}};
    {type} w[{l} + 1];
    (void)w, (void)what, (void)history;
{last}
    for (int k = 0; k < of->ahead; k++, clock[0] += clock[1]) {{
{predict}
        const tune_state made = tune_now();
        tune_tell(of, &made, of->u, 0, k, of->forecast, of->forecast_sigma, 0);
    }}
}}

int {name}_tune(void)
{{
    tune_run *of = tune_request();
    void *mark = tune_mark();
    {name}_history *history = tune_take(sizeof *history);
    {name}_filter *kept = tune_take(((size_t)of->latest + 1) * sizeof *kept);
    if (!history || !kept) {{
        tune_release(mark);
        return 0;
    }}
    {name}_start(&f);
    {name}_history_start(history);
    tune_filter(of, history, kept);
    of->events = f.events;
    const {name}_filter reached = f;
    if (of->smooth) tune_smooth(of, history);
    f = reached;
    tune_look_ahead(of, history);
    tune_release(mark);
    return 1;
}}
"""


def driver(product: Product) -> str:
    given, a = product.given, product.arithmetic
    of, name = given.of, given.name
    rows = [line.replace("&history", "history") for line in
            product.text.row(Row("what", "present", "v", "w", "at", "clock[0]", "clock[1]", "clock[2]", "taken"))]
    convert = [f"v[{j}] = {a.from_double('measurements', j, f'z[{j}]')};" for j in range(of.m)]
    convert += [f"w[{k}] = {a.from_double('controls', k, f'u[{of.l} * (t ? t - 1 : 0) + {k}]')};" for k in range(of.l)]
    convert += [f"at[{k}] = {a.from_double('controls', k, f'u[{of.l} * t + {k}]')};" for k in range(of.l)]
    last = [f"w[{k}] = {a.from_double('controls', k, f'of->u[{of.l} * last + {k}]')};" for k in range(of.l)]
    read = [f"made.x[{i}] = {a.mean_double(i)};" for i in range(len(given.carried))]
    return RUN.format(name=name, type=a.type, n=of.n, m=of.m, l=of.l, predicts=PREDICTS, updates=UPDATES, entry=a.covariance_double("i", "j"),
                      read=_inside(read, 1), given=_inside(convert, 1), predict=_inside(rows[:1], 1), update=_inside(rows[1:], 1), last=_inside(last, 1))


def _inside(lines: Sequence[str], depth: int) -> str:
    return "\n".join(f"{'    ' * depth}{line}" for line in lines)
