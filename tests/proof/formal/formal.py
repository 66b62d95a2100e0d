#!/usr/bin/env python3
"""formal.py: bounds of the q31 number layer, by Frama-C's EVA and WP, by Z3 (lemmas.py) and by exhaustion (formal.py STRIDE: each STRIDE-th
number); and whole steps of one to three states by EVA (steps.c).

It fails on an alarm or an unproved goal that is not in ARGUED, on a bound in a comment without a row of bounds.txt, on a row without
a comment, and where a false bound that is planted is not found."""

import csv
import re
import shutil
import subprocess
import sys
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import lemmas

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
WORK = ROOT / "build" / "proof" / "formal"
LAYER = [*sorted(ROOT.glob("src/arithmetic/*_q31.h")), ROOT / "src/arithmetic/fixed.h",
         ROOT / "include/kalmanq/port/integer.h", ROOT / "include/kalmanq/port/vectors.h"]
BOUND = re.compile(r"(?:[<>]=?|\bbelow|\bat most|\bwithin|\bbeyond|\bcut at|\bheld at|\bin|norm|words of|part in) (?:\+-|\[|-|at most )?"
                   r"(?:[\d.]+ )?(?:2\^|0x|\d\d)|2\^\d+ \.\. |2\^\d+ at most|at most \d")
CPP = f"-I {WORK / 'src'} -I {WORK / 'include'} -I {HERE}"
FRAMA = ["frama-c", "-c11", "-machdep", "gcc_x86_64", f"-cpp-extra-args={CPP}"]
CONTRACTS = "inverse_root,reciprocal,shift_rounded_long,wide_from,steady_mantissa"
WP = "dot,rotate_words,multiply_add,accumulate"
NORMALISED = "a number is normalised or 0 (primitives.c), which an interval does not say"
ARGUED = {  # function, kind: why EVA need not show it.  It goes on with what holds then: so only what is true may be here.
    ("multiply_add", "postcondition"): "WP",
    ("accumulate", "postcondition"): "WP",
    ("dot", "postcondition"): "WP",
    ("packed_over", "precondition of reciprocal"): NORMALISED,
    ("packed_root", "precondition of inverse_root"): NORMALISED,
    ("inverse_root", "postcondition"): "exhaustive",
    ("reciprocal", "postcondition"): "exhaustive",
    ("shift_rounded_long", "postcondition"): "Z3: SHIFTED",
    ("wide_from", "postcondition"): "no proof: its last line holds it",
    ("steady_mantissa", "postcondition"): "no proof: shifts are leading zeros less 32",
    ("packed_root", "signed_downcast"): "exhaustive: look_at_root",
    ("dot", "precondition"): "WP: its callers' rows are of norm below 2^30.5 (checked)",
    ("dot", "loop invariant"): "WP",
    ("squares", "precondition of dot"): "WP: as dot",
    ("row_product", "precondition of dot"): "WP: as dot",
    ("upper_word_raised", "shift"): "its number is above 0: r and a sum of squares, whose sign EVA does not know",
}
ARGUED_STEPS = {  # of steps.c, beside ARGUED
    ("round_products_to_word", "postcondition"): "what a shift is: primitives.c, where it is the sum of two",
    ("noise_word", "precondition of shift_down_rounded"): "align leaves no exponent below the one it is given: G's, and 1",
    ("fitted_word", "precondition of shift_down_rounded"): "a row's exponent is above those of its entries and its sigma (lemmas.py: renormalised)",
    ("packed_plus", "shift"): "the larger exponent comes first",
    ("packed_dot", "precondition of dot"): "WP: as dot",
    ("add_product", "precondition of accumulate"): "a sum of squares or products of two rows, of norm 2^30; three words of 2^30 would be more",
    ("add_losses", "shift"): "taken is all at most where it is asked",
    ("sum_of", "signed_overflow"): "each call has its precondition, of these:",
    ("likelihood_add_words", "precondition of sum_of"): "a NIS is a square",
    ("likelihood_run_fold", "precondition of sum_of"): "a NIS is a square",
    ("likelihood_run_add", "precondition of sum_of"): "a NIS is a square",
    ("root_take", "precondition of sum_of"): "a weak measurement takes less than 2^-16 of a row's norm from an entry",
    ("root_take", "signed_downcast"): "as its precondition of sum_of",
    ("contract_noise", "user assertion"): "a noise is a variance, or a share of one: its sign is known where it is made",
}
STEPS = {"predict": (1, 2, 3), "update": (1, 2, 3), "care": (1, 2)}  # harnesses of steps.c, and of how many states
# What acsl.txt takes as axioms, the weighted means of squares and a turned pair: Z3 decides them over the reals.
MEANS = """(declare-const x Real)(declare-const y Real)(define-fun xx () Real (* x x))(define-fun yy () Real (* y y))
(assert (not (and (<= (- (+ xx yy)) (* 2 x y) (+ xx yy)) (<= (- (+ xx (* 4 yy))) (* 4 x y) (+ xx (* 4 yy))))))(check-sat)"""
TURNED = f"""(declare-const c Real)(declare-const t Real)(declare-const s Real)(declare-const b Real)(define-fun turned () Real (+ (* c s) (* t b)))
(assert (<= (+ (* c c) (* t t)) {(1 << 62) + (1 << 34)}))(assert (<= (+ (* s s) (* b b)) {(1 << 60) + (1 << 42)}))
(assert (not (<= (- {(1 << 61) + (1 << 43)}) turned {(1 << 61) + (1 << 43)})))(check-sat)"""

# shift_rounded_long is what it is to be, for each shift.
SHIFTED = """(declare-const a (_ BitVec 64))(define-fun low () (_ BitVec 32) ((_ extract 31 0) a))
(define-fun high () (_ BitVec 32) ((_ extract 63 32) a))(define-fun wide () (_ BitVec 65) ((_ sign_extend 1) a))""" + "".join(
    f"(push)(assert (distinct (bvashr (bvadd wide (_ bv{1 << s - 1} 65)) (_ bv{s} 65)) (bvadd ((_ zero_extend 64) ((_ extract {s - 1} {s - 1}) low))"
    f"((_ sign_extend 1) (concat (bvashr high (_ bv{s} 32)) (bvor (bvlshr low (_ bv{s} 32)) (bvshl high (_ bv{32 - s} 32))))))))(check-sat)(pop)"
    for s in range(1, 32))


def run(*words, **more):
    return subprocess.run([str(word) for word in words], capture_output=True, text=True, **more)


def annotations():
    found, file = {}, None
    for line in (HERE / "acsl.txt").read_text().splitlines():
        if line.startswith("@ "):
            file = line[2:]
        elif line[:2] in ("> ", "= "):
            text = found.setdefault((file, line[2:].strip()), [line[0]])
        elif file:
            text.append(line)
    return found


def counted(name, bits):
    """The model of a count of leading zeros that the proofs see, a line for each; exhaust.c compares it with the compiler's."""
    lines = [f"    if (a >= UINT{bits}_C(1) << {bits - 1 - zeros}) return {zeros};\n" for zeros in range(bits)]
    return f"static inline int {name}(uint{bits}_t a)\n{{\n{''.join(lines)}    return {bits};\n}}\n"


def annotate():
    """The sources with acsl.txt in them: each line that it names is there once."""
    shutil.rmtree(WORK, ignore_errors=True)
    for part in ("src", "include"):
        shutil.copytree(ROOT / part, WORK / part)
    for (file, anchor), (kind, *text) in annotations().items():
        lines = (WORK / file).read_text().split("\n")
        at = [k for k, line in enumerate(lines) if line.strip() == anchor]
        if len(at) != 1:
            sys.exit(f"formal.py: {file}: {anchor!r} is there {len(at)} times")
        lines[at[0]] = "\n".join(text + [lines[at[0]]] * (kind == ">"))
        (WORK / file).write_text("\n".join(lines))
    (WORK / "include" / "leading_zeros.h").write_text(counted("leading_zeros", 32) + counted("leading_zeros_wide", 64))


ZEROS = ":".join(str(k) for k in range(64))
PRIMITIVES = ("-eva-precision", 5, "-eva-split-return-function", f"leading_zeros_wide:{ZEROS},leading_zeros:{ZEROS[:86]}")
WHOLE = ("-eva-precision", 2, "-eva-min-loop-unroll", 17, "-eva-split-return-function", f"leading_zeros_wide:{ZEROS},update_root:0:1,weigh_scalar:0:1")


def eva(file, main="main", how=PRIMITIVES, defined="", name=""):
    """(file, line, function, kind, status) of each property that a harness has reached"""
    report = WORK / f"{name or main}.csv"
    done = run(*FRAMA[:-1], f"{FRAMA[-1]} {defined}", "-eva", *how, "-eva-verbose", 0, "-eva-use-spec", CONTRACTS, "-warn-signed-downcast",
               "-main", main, file, "-then", "-no-eva", "-report-csv", report)
    if done.returncode or not report.exists():
        sys.exit(f"formal.py: {(done.stdout + done.stderr)[-3000:]}")
    with report.open() as rows:
        found = [tuple(row.values())[1:6] for row in csv.DictReader(rows, delimiter="\t", quoting=csv.QUOTE_NONE)]
    left = {row[2] for row in found if row[4] == "Dead"} & {main, "predict_from" if main == "predict" else main, *harnesses()}
    if left and Path(file).name != "planted.c" and (main == "main") <= (Path(file).name == "primitives.c"):
        sys.exit(f"formal.py: {main}: EVA leaves {', '.join(sorted(left))} before its end: what comes then is not looked at")
    return [row for row in found if row[4] not in ("Dead", "Considered valid")]


def whole_step(step):
    main, n = step
    return eva(HERE / "steps.c", main, WHOLE, f"-DSTATES={n}", f"{main}{n}")


def of_steps():
    """What EVA does not show of whole steps and is not argued, and a row for each step"""
    steps = [(main, n) for main, sizes in STEPS.items() for n in sizes]
    failed, lines, argued = [], [], Counter()
    with ThreadPoolExecutor(2) as pool:
        for (main, n), seen in zip(steps, pool.map(whole_step, steps)):
            unknown = [row for row in seen if row[4] != "Valid" and not is_of_calls(row)]
            failed += [f"EVA: {main}, {n} states: {file}:{line}: {function}: {kind}: {status}" for file, line, function, kind, status in unknown
                       if (function, kind) not in ARGUED | ARGUED_STEPS]
            argued.update({row[2:4] for row in unknown})
            lines.append(f"- EVA, whole steps: {main}, {n} states: {len({row[2] for row in seen})} functions with something to show, {len(seen)} "
                         f"properties, {sum(row[4] == 'Valid' for row in seen)} valid, {len(unknown)} argued")
    failed += [f"EVA: {function}: {kind}: is argued, and nothing is unknown of it" for function, kind in ARGUED_STEPS if (function, kind) not in argued]
    return failed, lines


def is_of_calls(row):
    """A precondition has a row for each call, too"""
    return row[3] == "precondition" and row[2] in {"round_to_word", "accumulate", "shift_down_rounded", "sum_of", "inverse_root", "reciprocal"}


def harnesses():
    text = (HERE / "primitives.c").read_text()
    return re.findall(r"^    (\w+)\(\);$", text[text.index("int main(void)"):], re.M)


def prove(*options):
    """Goals that WP has not proved, and how many there are"""
    done = run(*FRAMA, "-wp", "-wp-rte", "-wp-model", "Typed+nocast", "-wp-prover", "z3,cvc4", "-wp-timeout", 30, *options, HERE / "primitives.c")
    count = re.search(r"Proved goals: +(\d+) / (\d+)", done.stdout)
    if not count:
        sys.exit(f"formal.py: {(done.stdout + done.stderr)[-3000:]}")
    return re.findall(r"\[(?:Failed|Timeout|Unknown)\] Goal (\w+)", done.stdout), int(count[2])


def exhausted(stride, name="exhaust.c"):
    made = run("gcc", "-std=c11", "-O2", "-fsanitize=undefined", "-fsanitize-undefined-trap-on-error", *CPP.split(), HERE / name, "-lm",
               "-o", WORK / "exhaust")
    if made.returncode:
        sys.exit(f"formal.py: {made.stderr}")
    return run(WORK / "exhaust", 0, 1, stride)


def unlisted(rows):
    """Bounds in comments without a row, and rows without a comment"""
    left, missing = set(rows), []
    for path in LAYER:
        for comment in re.finditer(r"/\*.*?\*/", path.read_text(), re.S):
            text = " ".join(re.sub(r"\n \* ?", " ", comment[0][2:-2]).split())
            named = {row for row in rows if row[0] == path.name and row[1] in text}
            left -= named
            if BOUND.search(text) and not named:
                missing.append(f"{path.name}: {text[:90]}: no row of bounds.txt")
    return missing + [f"{file}: {text}: no comment says so" for file, text, _, _ in left]


def planted():
    """A shift that loses a bit, states beyond what calls leave, a bound of the inverse root that is none: is each found?"""
    bad = WORK / "planted.c"
    bad.write_text('#include "arithmetic/q31.h"\n#include "arithmetic/arithmetic.h"\n#include "__fc_builtin.h"\n'
                   "int main(void) { return (int)shift_up(Frama_C_interval(0, 1 << 30), 1, 31) + (int)sum_of(Frama_C_interval(0, 5), 4, 3); }\n")
    missed = [] if any(kind == "precondition of sum_of" and status != "Valid" for _, _, _, kind, status in eva(bad)) else ["EVA"]
    states = eva(HERE / "steps.c", "predict", WHOLE, "-DSTATES=1 -DPLANTED", "planted")
    missed += [] if any(row[2:5] == ("contract_align", "user assertion", "Unknown") for row in states) else ["EVA of steps"]
    header = WORK / "src/arithmetic/inverse_q31.h"
    text = header.read_text()
    header.write_text(text.replace("KEPT(y <= 504)", "KEPT(y <= 503)"))
    missed += [] if exhausted(100003).returncode == 1 else ["exhaust.c"]
    header.write_text(text)
    return [f"{one} does not find a false bound that is planted" for one in missed]


def main():
    stride = int(sys.argv[1]) if len(sys.argv) > 1 else 1
    rows = [tuple(part.strip() for part in line.split(" | ")) for line in (HERE / "bounds.txt").read_text().splitlines() if line[:1] != "#"]
    annotate()
    failed = unlisted(rows) + planted()
    failed += [f"{by}: no such harness" for _, _, how, by in rows if how == "EVA" and by not in harnesses()]
    failed += [f"{by}: no such lemma" for _, _, how, by in rows if how == "Z3" and by not in lemmas.LEMMAS]
    seen = eva(HERE / "primitives.c")
    open_ones = [row for row in seen if row[4] != "Valid" and not is_of_calls(row)]
    failed += [f"EVA: {file}:{line}: {function}: {kind}: {status}" for file, line, function, kind, status in open_ones
               if (function, kind) not in ARGUED]
    of_whole, lines = of_steps()
    failed += of_whole + [problem for name in lemmas.LEMMAS for problem in lemmas.failures(name)]
    goals, count = prove("-wp-fct", WP)
    failed += [f"WP: {goal}" for goal in goals]
    failed += [f"Z3: {name}" for name, query in (("the means of squares", MEANS), ("a turned pair", TURNED)) if run("z3", "-in", input=query).stdout.strip() != "unsat"]
    failed += [] if set(run("z3", "-in", input=SHIFTED).stdout.split()) == {"unsat"} else ["Z3: shift_rounded_long"]
    numbers = exhausted(stride)
    failed += [f"exhaust.c: {numbers.stdout}"] if numbers.returncode else []
    print(f"- EVA: {len(harnesses())} harnesses, {len({row[2] for row in seen})} functions with something to show, {len(seen)} properties, "
          f"{sum(row[4] == 'Valid' for row in seen)} valid, {len(open_ones)} argued\n" + "\n".join(lines) +
          f"\n- Z3: {len(lemmas.LEMMAS)} lemmas of {sum(len(list(one())) for one in lemmas.LEMMAS.values())} parts\n- WP: {WP}: {count} goals, {len(goals)} not proved"
          f"\n- exhaustive, each {stride}th number: {numbers.stdout.strip()}\n\n| how | bounds |\n|---|---:|")
    for how, number in Counter(row[2] for row in rows).most_common():
        print(f"| {how} | {number} |")
    print("\n| file | bound | how | by |\n|---|---|---|---|")
    for file, text, how, by in rows:
        print("|", " | ".join([file, text.replace("|", "\\|"), how, by]), "|")
    print("\n" + "\n".join(failed))
    return bool(failed)


if __name__ == "__main__":
    sys.exit(main())
