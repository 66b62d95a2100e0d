"""Numbers of the functions in fixed point (templates/fixed.c.j2), and the C of those that a text calls."""

from __future__ import annotations

import math
from functools import lru_cache

from kalmanq.compiler.algorithm.fixed import routines as word_routines
from kalmanq.compiler.templates.engine import rendered

SATURATED, NO_VALUE = 1, 2  # bits of `far`
WORD = 1 << 30  # words are below
# Coefficients of 1, x, x^2, ...: of 2^x, |x| <= 1/2; of the next three by the square of what they are odd or even in; of
# log(x + 3/2), |x| <= 1/2
EXP = (1073741824, 744261118, 257941253, 59597083, 10327276, 1431671, 166105, 16432)  # 2^-30
SIN = (1686629713, -693598667, 85569259, -5026471, 169873)  # 2^-30, sin(pi/2 y) / y, |y| <= 1/2
COS = (1073741824, -1324675869, 272375233, -22398329, 970263)  # 2^-30, cos(pi/2 y)
ATAN = (1073741824, -357913941, 214748290, -153388158, 119222248, -96554821, 74875806,
        -40415630)  # 2^-30, atan(q) / q, |q| <= 0.415
LOG = (870729689, 1431655764, -477218588, 212097252, -106048638, 56556013, -31419796, 17998857, -10500967, 5925019, -3549187,
       3103530, -1904386)  # 2^-31
TURN, LOG2_E = 1 / (2 * math.pi), 1 / math.log(2)
LN_2, TANGENT = 1488522236, 0x6A09E668  # log(2) 2^31, tan(pi/8) 2^32
QUARTER, HALF = 843314857, 1686629713  # pi/2 and pi, 2^-29


INVERTED = "typedef struct { int32_t over; int by; } inverted;\n"


@lru_cache(maxsize=None)
def _all() -> dict[str, str]:
    numbers = {"EXP": EXP, "SIN": SIN, "COS": COS, "ATAN": ATAN, "LOG": LOG, "LN_2": LN_2, "TANGENT": TANGENT, "QUARTER": QUARTER, "HALF": HALF}
    return word_routines.parted(rendered("fixed.c.j2", numbers))


def routines(text: str) -> str:
    """C of the functions that a text calls, and of those that they call"""
    own = word_routines.called(text, _all())
    own = f"{INVERTED}\n{own}" if "inverted" in text + own else own
    return "\n".join(one for one in (word_routines.routines(text + own), own.removesuffix("\n")) if one)
