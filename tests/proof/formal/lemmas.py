"""What Z3 decides of formulas as they stand in the q31 number layer: sizes of words, normalised numbers, sums of rows, rotations.

Of each lemma the claim follows from the premises, and a claim that is a little stronger does not: so no premise is empty, and each
can fail.  A lemma that is made for each count of zeros or each shift is one for all of them, and need be tight for one alone."""

import subprocess

E30 = "(/ 1.0 1073741824.0)"  # 2^-30


def power(k):
    return str(1 << k)


def over_reals(names, premises, claim, stronger):
    declared = "".join(f"(declare-const {name} Real)" for name in names.split())
    return declared, premises, claim, stronger


def over_integers(names, premises, claim, stronger):
    declared = "".join(f"(declare-const {name} Int)" for name in names.split())
    return declared, premises, claim, stronger


def over_words(names, premises, claim, stronger):
    declared = "".join(f"(declare-const {name} (_ BitVec 32))" for name in names.split())
    return declared, premises, claim, stronger


# ---- sums of coefficients (align) ------------------------------------------------------------


def aligned():
    """sum |c_k| <= 2^30.  `exact` is the sum of |row_k| 2^(E_k - top - 4), `total` what align adds up of it: it never lacks more than
    one for each of the k entries so far."""
    known = "(<= 0 total)(< total 4294967296)(<= total exact)(<= exact (+ total k))(<= 1 k 15)(<= 0 m 2147483647)"
    names = "(declare-const total Int)(declare-const exact Real)(declare-const k Int)(declare-const m Int)"
    for delta in range(1, 32):  # a larger exponent
        now, sized = f"(+ (div total {1 << delta}) (div m 16))", f"(+ (/ exact {1 << delta}.0) (/ m 16.0))"
        yield names, known, f"(and (<= {now} {sized}) (<= {sized} (+ {now} k 1)))", f"(<= {sized} (+ {now} k 0.9))"
    for down in range(28):  # no larger one
        now, sized = f"(+ total (div m {16 << down}))", f"(+ exact (/ m {16 << down}.0))"
        yield names, known, f"(and (<= {now} {sized}) (<= {sized} (+ {now} k 1)))", f"(<= {sized} (+ {now} k 0.5))"
    yield names, known, "(<= (+ (/ exact 4294967296.0) (/ m 16.0)) (+ (div m 16) k 1))", "(<= (+ (/ exact 4294967296.0) (/ m 16.0)) (+ (div m 16) k))"
    yield names, known, "(<= (+ exact (/ m 4294967296.0)) (+ total k 1))", "(<= (+ exact (/ m 4294967296.0)) (+ total k))"
    for bits in range(2, 33):  # `total` with 2 for each entry has so many bits; the scale is top + 4 + bits - 30
        fit = f"(<= 1 k 16)(<= 0 exact 2147483648)(<= exact (- total k))(< total {1 << bits})(>= total {1 << bits - 1})(<= total 2147483680)"
        scaled = f"(+ (* exact {1 << 30}.0 (/ 1.0 {1 << bits}.0)) (/ k 2.0))"
        yield names, fit, f"(<= {scaled} {power(30)})", f"(<= {scaled} {power(28)})"


# ---- leading zeros ---------------------------------------------------------------------------


def normalised():
    """close_reflector: a square of z or z + 1 leading zeros, z even, is raised to [2^62, 2^64), and a word whose square it holds,
    raised by z / 2 - 1, is below 2^31"""
    for z in range(2, 63, 2):
        known = f"(<= {1 << max(62 - z, 0)} q)(< q {1 << 64 - z})(<= 0 w)(<= (* w w) q)"
        raised = f"(* q {1 << z})"
        yield over_reals("q w", known, f"(and (<= {power(62)} {raised}) (< {raised} {power(64)}) (< (* w {1 << z // 2 - 1}) {power(31)}))",
                            f"(< {raised} {power(63)})")


def renormalised():
    """renormalise, fitted_exponent: a row of norm^2 q of z leading zeros, up = (z - 4) >> 1, gets a norm in [2^29, 2^30), and no word
    of it is 2^30"""
    for z in range(4, 64):
        up = (z - 4) >> 1
        known = f"(<= {1 << 63 - z} q)(< q {1 << 64 - z})(<= 0 w)(<= (* w w) q)"
        moved = f"(* q {1 << 2 * up})"
        yield over_reals("q w", known, f"(and (<= {power(58)} {moved}) (< {moved} {power(60)}) (< (* w {1 << up}) {power(30)}))",
                            f"(< {moved} {power(58)})")
    known = f"(<= {power(60)} q)(< q {power(61)})"  # up = -1
    yield over_integers("q", known, f"(and (<= {power(58)} (/ q 4.0)) (< (/ q 4.0) {power(60)}))", f"(< (/ q 4.0) {power(58)})")


def turned():
    """packed_turn: f^2 <= a of z or z + 1 leading zeros, z even: |f| < 2^(32 - z / 2)"""
    for z in range(2, 63, 2):
        known = f"(<= 0 f)(<= (* f f) a)(< a {1 << 64 - z})"
        yield over_reals("a f", known, f"(and (< f {1 << 32 - z // 2}) (< (* f {1 << z // 2 - 1}) {power(31)}))", f"(< f {1 << 31 - z // 2})")


def units():
    """units_raise, turn_row: words of which the union of all bits has z zeros on top, raised by z - 6 or z - 4"""
    for z in range(4, 32):
        known = f"(= (bvand u (bvnot bits)) (_ bv0 32))(bvult bits (_ bv{1 << 32 - z} 32))"
        yield over_words("u bits", known, f"(bvult (bvshl u (_ bv{z - 4} 32)) (_ bv{1 << 28} 32))", f"(bvult (bvshl u (_ bv{z - 4} 32)) (_ bv{1 << 27} 32))")
        if z >= 6:
            yield over_words("u bits", known, f"(bvult (bvshl u (_ bv{z - 6} 32)) (_ bv{1 << 26} 32))",
                             f"(bvult (bvshl u (_ bv{z - 6} 32)) (_ bv{1 << 25} 32))")


# ---- remainders and shares -------------------------------------------------------------------


def remainders():
    """project_exactly: what a coefficient, shifted down and rounded, lacks, in units of 2^-27: 2^26 at most"""
    def rounded(down):
        if down <= 0:
            return f"(bvshl a (_ bv{-down} 32))"
        return f"(bvadd (bvashr a (_ bv{down} 32)) (bvand (bvashr a (_ bv{down - 1} 32)) (_ bv1 32)))"
    for down in range(1, 32):
        low = f"(bvsub {rounded(down - 27)} (bvshl {rounded(down)} (_ bv27 32)))"
        def within(most):
            return f"(and (bvsle {low} (_ bv{most} 32)) (bvsle (bvneg {low}) (_ bv{most} 32)))"
        yield over_words("a", "(distinct a #x80000000)", within(1 << 26), within((1 << 26) - 1))


def shares():
    """mending_rounds: r < 2^31 2^p, and s = sigma^2 >= 2^60 2^(2 q): with p < 2 q - 66 r is below 2^-96 s"""
    yield over_integers("p q", "(< p (- (* 2 q) 66))", "(<= (+ 31 p) (- (+ 60 (* 2 q)) 96))", "(<= (+ 31 p) (- (+ 60 (* 2 q)) 97))")


# ---- Carlson's sums --------------------------------------------------------------------------

NUMBERS = f"(<= {power(30)} rm)(< rm {power(31)})(<= {power(30)} sm)(< sm {power(31)})(or (< p q) (and (= p q) (<= rm sm)))"
UNIT = "(div (- q 29) 2)"  # rotor_begin's exponent


def begun():
    """rotor_begin: s is in [2^59, 2^61) in its units, and r <= s is shifted up by 31 at most"""
    up = f"(- q (* 2 {UNIT}))"
    yield over_integers("rm p sm q", NUMBERS, f"(or (= {up} 29) (= {up} 30))", f"(= {up} 29)")
    yield over_integers("rm p sm q", NUMBERS, f"(<= (- p (* 2 {UNIT})) 31)", f"(<= (- p (* 2 {UNIT})) 29)")
    for shift in (29, 30):
        s = f"(* sm {1 << shift})"
        yield over_integers("sm", f"(<= {power(30)} sm)(< sm {power(31)})", f"(and (<= {power(59)} {s}) (< {s} {power(61)}))", f"(< {s} {power(59)})")


def added():
    """A square of f in units of which it is below 2^30.5, rounded, is larger by 2^31 at most: 16 of them leave a below 2^62"""
    known = f"(<= 0 f)(<= f {power(31)})(<= 0 w)(<= w (+ f 0.5))"
    yield over_reals("f w", known, f"(<= (* w w) (+ (* f f) {power(31)} 1))", f"(<= (* w w) (+ (* f f) {power(30)}))")
    known = f"(< s {power(61)})(<= a (+ (* s (+ 1 {E30})) 1 (* 16 (+ {power(31)} 1))))"
    yield over_reals("s a", known, f"(< a (+ {power(61)} {power(36)}))", f"(< a {power(61)})")


# ---- a rotation: c^2 + t^2 <= 1 + 2^-28 ------------------------------------------------------

ROOT = f"(+ 1 (* 0.54 {E30}))"  # an inverse root is off by 2^-31 of itself (exhaust.c: less than 0.53 2^-30)


def rotations():
    """packed_turn, with A = a_before and B = a, each raised to [1, 4), and A by B's power in the sums: the root's v is up to 2^-30 below,
    d^2 v <= ROOT^2, and C^2 = A / B.  Then the sum of the squares of what c and t are at most, their last halves being 2^-32."""
    known = f"(<= 1 b)(< b 4)(<= v b)(< b (+ v {E30}))(<= 1 v)(<= 0 d)(<= (* d d v) (* {ROOT} {ROOT}))"
    yield over_reals("b v d", known, f"(<= (* d d b) (+ 1 (* 2.09 {E30})))", "(<= (* d d b) 1)")
    known = f"(<= 0 x)(<= x b)(<= 1 b)(< b 4)(<= 0 g)(<= (* g g) (* x {ROOT} {ROOT}))(<= 0 d)(<= (* d d b) (+ 1 (* 2.09 {E30})))(<= 0 c)(= (* c c b) x)"
    yield over_reals("x b g d c", known, f"(<= (* g g d d) (* c c (+ 1 (* 3.18 {E30}))))", "(<= (* g g d d) (* c c))")
    known = f"(<= 0 c)(<= 0 t)(= (+ (* c c) (* t t)) 1)(<= 0 p)(<= p (+ (* c (+ 1 (* 1.6 {E30}))) (* 0.25 {E30})))" \
            f"(<= 0 q)(<= q (+ (* t (+ 1 (* 1.05 {E30}))) (* 0.25 {E30})))"
    yield over_reals("c t p q", known, f"(<= (+ (* p p) (* q q)) (+ 1 (* 4 {E30})))", f"(<= (+ (* p p) (* q q)) (+ 1 (* 3 {E30})))")


def turn_words():
    """cosine_of, sine_of: what the guards let through is a word"""
    def of(p, high_first, high_last):
        return f"((_ extract {high_first} {high_last}) {p})"
    names, word = "(declare-const p (_ BitVec 64))", "(_ bv2147483647 64)"
    high, sine = of("p", 63, 32), "(bvashr (bvadd p (_ bv536870912 64)) (_ bv30 64))"
    most = "(_ bv536870910 32)"
    known = f"(bvult (bvadd {high} {most}) (bvadd {most} {most}))"
    yield names, known, f"(and (bvsle {sine} {word}) (bvsle (bvneg {sine}) {word}))", f"(bvsle {sine} (_ bv2147483630 64))"
    raised = "(bvadd p (_ bv1073741824 64))"
    cosine = f"(bvor (bvshl {of(raised, 63, 32)} (_ bv1 32)) (bvlshr {of(raised, 31, 0)} (_ bv31 32)))"
    known = f"(bvult p (_ bv{1 << 63} 64))(bvult {of(raised, 63, 32)} (_ bv{1 << 30} 32))"
    yield names, known, f"(bvsge {cosine} (_ bv0 32))", f"(bvult {cosine} (_ bv{(1 << 31) - 1} 32))"


# ---- reflectors ------------------------------------------------------------------------------


def reflectors():
    """close_reflector: an entry W raised (W^2 <= q / 4 in units of 2^60) times the inverse root is 1 + 2^-29 at most, and with
    rounding 2^30 + 2 words"""
    known = f"(<= 1 v)(< v 4)(<= 0 w)(<= (* w w) (+ v {E30}))(<= 0 d)(<= (* d d v) (* {ROOT} {ROOT}))"
    yield over_reals("v w d", known, f"(<= (* w d) (+ 1 (* 1.1 {E30})))", "(<= (* w d) 1)")
    # reflect, in units of 2^30: V of norm sqrt(1 - p^2), a row (w, g) of norm 2^0.2 at most; d (1 + p) = entry + g
    known = "(<= 0 p 1)(<= 0 V)(= (+ (* V V) (* p p)) 1)(<= 0 w)(<= 0 g 0.5)(<= (+ (* w w) (* g g)) 1.3196)"
    sum_of = "(+ (* V w) (* (+ 1 p) g))"
    yield over_reals("p V w g", known, f"(< {sum_of} 1.75)", f"(< {sum_of} 1.5)")
    yield over_reals("p V w g", known, f"(< {sum_of} (* 2 (+ 1 p)))", f"(< {sum_of} (* 1.5 (+ 1 p)))")
    yield over_reals("p V w g", known, f"(< (* V {sum_of}) (* 2 (+ 1 p)))", f"(< (* V {sum_of}) (* 1.25 (+ 1 p)))")


# ---- sums of rows ----------------------------------------------------------------------------


def products():
    """c a of a row of norm 2^30 and 16 words below 2^31 is (64 c^2 + a^2) / 16 at most: no sum of them is beyond 2^63"""
    yield over_integers("c a", "", "(<= (* 16 c a) (+ (* 64 c c) (* a a)))", "(<= (* 16 c a) (+ (* 63 c c) (* a a)))")
    known = f"(<= 0 cc {power(60)})(<= 0 aa {power(66)})"
    yield over_integers("cc aa", known, f"(<= (+ (* 64 cc) aa) (* 16 {power(63)}))", f"(< (+ (* 64 cc) aa) (* 16 {power(63)}))")


LEMMAS = {lemma.__name__: lemma for lemma in (
    aligned, normalised, renormalised, turned, units, remainders, shares, begun, added, rotations, turn_words, reflectors, products)}


def script(lemma):
    """For each part: the claim, then the stronger one"""
    parts = []
    for declared, premises, claim, stronger in LEMMAS[lemma]():
        known = f"(assert (and true {premises}))"
        parts += [f"(reset){declared}{known}(assert (not {one}))(check-sat)" for one in (claim, stronger)]
    return "(set-option :timeout 60000)" + "\n".join(parts)


def failures(lemma):
    """Parts of a lemma that Z3 does not prove, or whose stronger claim it does not refute"""
    said = subprocess.run(["z3", "-in"], input=script(lemma), capture_output=True, text=True).stdout.split()
    wanted = len(list(LEMMAS[lemma]()))
    if len(said) != 2 * wanted:
        return [f"Z3: {lemma}: {' '.join(said)[:200]}"]
    found = [f"Z3: {lemma}, part {k}: {said[2 * k]}, {said[2 * k + 1]}" for k in range(wanted) if said[2 * k:2 * k + 2] != ["unsat", "sat"]]
    return found


if __name__ == "__main__":
    import time
    for name in LEMMAS:
        began = time.time()
        print(name, len(list(LEMMAS[name]())), failures(name) or "holds", f"{time.time() - began:.1f} s")
