"""The C core, all of it: `lib` has every public function, `ffi` makes its structs.

An Arithmetic has the names of one of f32, f64 and q31, and turns its numbers into float64 and back.
"""

from __future__ import annotations

import warnings
from typing import Any, Optional, Sequence

import numpy as np
from numpy.typing import ArrayLike

from kalmanq._core import ffi, lib
from kalmanq.errors import KalmanqError, KalmanqWarning


EVENTS = {
    lib.KQ_EVENT_REDUNDANT: ("redundant", "a measurement was not taken: its innovation variance is rounding"),
    lib.KQ_EVENT_OVERFLOW: ("overflow", "a variance or a mean has grown not representable"),
    lib.KQ_EVENT_HISTORY_FULL: ("history_full", "a recording ended before its run did"),
    lib.KQ_EVENT_SATURATED: ("saturated", "a state saturated"),
    lib.KQ_EVENT_GATED: ("gated", "a measurement was rejected by the gate"),
    lib.KQ_EVENT_REJECTIONS: ("rejections", "so many measurements in a row were rejected that one was taken"),
    lib.KQ_EVENT_JUMP: ("jump", "the state was taken to have jumped"),
    lib.KQ_EVENT_PRECISION: ("precision", "precision lost: a sigma may be wrong by more than 5 %"),
    lib.KQ_EVENT_LOW_NOISE: ("low noise", "a lean sensor took a measurement in part: R is 0, or the rest was rounding"),
    lib.KQ_EVENT_CONTRADICTION: ("contradiction", "a low-noise measurement contradicts what was known"),
}
NOT_A_VALUE = np.iinfo(np.int32).min  # KQ_NOT_A_VALUE_Q31
# what the user asked for is no surprise
ASKED_FOR = lib.KQ_EVENT_GATED | lib.KQ_EVENT_REJECTIONS | lib.KQ_EVENT_JUMP


# A host's histories have room for all rows, so one that ends does so for another cause
OF_THE_HOST = {lib.KQ_ERR_HISTORY_FULL: "a mean or a variance has grown not representable, and what came before cannot be smoothed: look at A "
               "over long gaps, or leave out the rows from there on"}


def pointer_of(array: np.ndarray) -> Any:
    """Of whole numbers, or of numbers of f64, that C reads or writes during a call"""
    return ffi.cast("int64_t *" if array.dtype == np.int64 else "double *", array.ctypes.data)


def words_of(status: int) -> str:
    """What a status says here"""
    return OF_THE_HOST.get(status) or ffi.string(lib.kq_status_text(status)).decode()


def require(status: int, what: str, row: Optional[int] = None) -> None:
    """Raises what the C core says of a status that is an error."""
    if status < lib.KQ_OK:
        raise KalmanqError(f"{what}: {words_of(status)}", status, row)


def warn_of(events: int, what: str) -> None:
    for bit, (_, meaning) in EVENTS.items():
        if events & bit & ~ASKED_FOR:
            warnings.warn(f"{what}: {meaning}", KalmanqWarning, stacklevel=3)


def names_of(events: int) -> list[str]:
    return [name for bit, (name, _) in EVENTS.items() if events & bit]


_LENGTH_OF = {"sensor": "m", "diffuse": "nk", "consistency": "mk", "continuous": "nk"}  # arguments of kq_length; others: n, m, k, l


class Arithmetic:
    """f32, f64 or q31.

    `call.update_subset` is kq_update_subset_<T>; `struct("filter")` a new kq_filter_<T>.
    """

    def __init__(self, name: str, number: Any):
        self.name = name
        self.number = np.dtype(number)  # of memory: float, double, int32_t
        self.is_fixed = name == "q31"

    def __repr__(self) -> str:
        return self.name

    def function(self, stem: str) -> Any:
        return getattr(lib, f"kq_{stem}_{self.name}")

    def length(self, stem: str, *sizes: int) -> int:
        """Numbers of memory of an object: sizes in the order in which the macro KQ_..._LEN has them."""
        given = dict(zip(_LENGTH_OF.get(stem, "nmkl"), sizes))
        return int(self.function("length")(getattr(lib, f"KQ_OBJECT_{stem.upper()}"), *(given.get(p, 0) for p in "nmkl")))

    def struct(self, stem: str) -> Any:
        return ffi.new(f"kq_{stem}_{self.name} *")

    def losses(self, name: str, count: int) -> Any:
        """So many of a loss of robust.h: "gate", "huber", ..."""
        made = ffi.new(f"kq_loss_{self.name}[]", count)
        for one in made:
            one.kind = getattr(lib, f"kq_loss_{name}_{self.name}_address")()
        return made

    def empty(self, *shape: int) -> np.ndarray:
        return np.zeros(shape, self.number)

    def pointer(self, array: Optional[np.ndarray], kind: str = "") -> Any:
        """Of an array of memory, or of what `kind` names; NULL of None."""
        if array is None:
            return ffi.NULL
        named = kind or {"f32": "float", "f64": "double", "q31": "int32_t"}[self.name]
        return ffi.cast(f"{named} *", array.ctypes.data)

    # ---------------------------------------------------- values: words, numbers of any size, scores

    def values(self, words: np.ndarray, fractions: Sequence[int], low: Optional[np.ndarray] = None) -> np.ndarray:
        """float64 of means, sigmas, innovations, a column a component; fractions are q31's."""
        if not self.is_fixed:
            made = words.astype(np.float64, copy=False)
            return made if low is None else made + low
        made = words.astype(np.float64)
        if low is not None:
            made += low * 2.0**-24
        made = np.ldexp(made, -np.asarray(fractions, int))
        made[words == NOT_A_VALUE] = np.nan
        return made

    def numbers(self, given: np.ndarray, scale: Any = 0) -> np.ndarray:
        """float64 of covariances, gains and scales; scale: 2^-scale is q31's unit."""
        if not self.is_fixed:
            return given.astype(np.float64, copy=False)
        mantissa, exponent = given["mantissa"], given["exponent"]
        made = np.ldexp(mantissa.astype(np.float64), exponent - np.asarray(scale))
        made[mantissa == NOT_A_VALUE] = np.nan
        return made

    def scores(self, given: np.ndarray) -> np.ndarray:
        if not self.is_fixed:
            return given.astype(np.float64, copy=False)
        made = given * 2.0**-24
        made[given == np.iinfo(np.int64).min] = np.nan
        return made

    @property
    def has_low_words(self) -> bool:
        """Is there more of a mean behind its number?"""
        return self.name != "f64"

    @property
    def number_of_any_size(self) -> np.dtype:
        """What covariances are made of."""
        if self.is_fixed:
            return np.dtype([("mantissa", np.int32), ("exponent", np.int32)])
        return self.number

    @property
    def score(self) -> np.dtype:
        return np.dtype(np.int64) if self.is_fixed else self.number

    def made_of(self, values: ArrayLike, scale: Any = 0) -> np.ndarray:
        """The other way round: numbers of any size of float64, to the nearest, as prepare.h makes them."""
        given = np.asarray(values, np.float64)
        if not self.is_fixed:
            with np.errstate(over="ignore"):
                return np.ascontiguousarray(given, self.number)
        part, exponent = np.frexp(np.where(np.isfinite(given), given, 0.0))
        mantissa = nearest(part * 2.0**31)
        carried = np.abs(mantissa) == 2.0**31
        made = np.zeros(given.shape, self.number_of_any_size)
        made["mantissa"] = np.where(carried, mantissa / 2, mantissa)
        made["exponent"] = np.where(mantissa != 0, exponent - 31 + carried + np.asarray(scale), 0)
        return made

    def parameter(self, value: float) -> Any:
        """A number of any size that stands by itself."""
        made = self.made_of(value)
        if not self.is_fixed:
            return float(value)
        return {"mantissa": int(made["mantissa"]), "exponent": int(made["exponent"])}

    # ---------------------------------------------------- words of measurements and controls

    def words(self, given: np.ndarray, quantities: Sequence[Any], formats: Any, what: str, less: ArrayLike = 0.0) -> np.ndarray:
        """Rows of values as the arithmetic has them, less offsets; what is NaN stays NaN, in q31 it is no word."""
        if not self.is_fixed:
            with np.errstate(over="ignore"):
                made = given.astype(self.number, copy=False)
            _refuse_rows(np.isinf(made), given, quantities, f"{what}: beyond {self.name}")
            return np.ascontiguousarray(made if np.isscalar(less) and less == 0 else made - np.asarray(less, self.number))
        fractions = np.array([formats[k].fraction for k in range(len(quantities))])
        ranges = np.array([formats[k].range for k in range(len(quantities))], float)
        rounded = nearest(np.ldexp(given, fractions)) - nearest(np.ldexp(less, fractions))
        _refuse_rows(np.abs(rounded) > ranges, given, quantities, f"{what}: beyond the declared range")
        return np.where(np.isnan(rounded), NOT_A_VALUE, rounded).astype(np.int32)


def nearest(values: np.ndarray) -> np.ndarray:
    """The nearest integers, halves away from 0: so does C, in kq_vector_prepare_q31."""
    whole = np.trunc(values)
    with np.errstate(invalid="ignore"):  # what is infinite stays so
        rest = values - whole  # exact, which values + 1/2 is not
    return whole + (rest >= 0.5) - (rest <= -0.5)


def _refuse_rows(wrong: np.ndarray, given: np.ndarray, quantities: Sequence[Any], reason: str) -> None:
    if np.any(wrong):
        row, column = map(int, np.argwhere(wrong)[0])
        raise KalmanqError(
            f"{quantities[column].name} = {given[row, column]:g}: {reason}", lib.KQ_ERR_RANGE, row)


ARITHMETICS = {
    "f32": Arithmetic("f32", np.float32),
    "f64": Arithmetic("f64", np.float64),
    "q31": Arithmetic("q31", np.int32),
}


def arithmetic_of(name: str) -> Arithmetic:
    try:
        return ARITHMETICS[name]
    except (KeyError, TypeError):
        said = repr(name) if isinstance(name, str) else f"of {type(name).__name__}"
        raise KalmanqError(f"there is no arithmetic {said}: f32, f64 or q31") from None
