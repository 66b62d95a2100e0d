"""Does the data fit the model?  What the innovations of a run say, in plain language, and what to try."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Optional, Sequence

import numpy as np
from scipy import special

from kalmanq.model import Model
from kalmanq.pages.across import Across, across, spoken
from kalmanq.run.diagnostics import autocorrelation, chi_square_limit, is_scored, ljung_box, mean_bounds, share_bounds
from kalmanq.run.resolution import told_of
from kalmanq.run.results import Run

UNUSUAL, STRANGE = 0.05, 0.001  # chances, of a right model, below which a figure is at the edge, and bad
TOO_FEW = "too few innovations that differ"
RESOLUTION = "Resolution"  # a subject
ENOUGH = 20  # measurements, below which nothing is said of the fit


@dataclass(frozen=True)
class Finding:
    """state: "good"; "edge": it may be chance, or is too small to matter; "bad"; "note": nothing to judge."""

    state: str
    subject: str
    said: str
    advice: str = ""


@dataclass(frozen=True)
class Whiteness:
    """The autocorrelation of one component's standardised innovations."""

    correlation: np.ndarray
    pairs: np.ndarray
    count: int
    chance: float  # of such correlations where there are none; NaN: too few rows

    @property
    def is_judged(self) -> bool:
        return self.chance == self.chance

    @property
    def bounds(self) -> np.ndarray:
        """+- of each lag: 95 %."""
        return 1.96 / np.sqrt(np.maximum(self.pairs, 1))

    @property
    def significant(self) -> np.ndarray:
        return np.flatnonzero(np.abs(np.nan_to_num(self.correlation)) > self.bounds) + 1


def standardised(run: Run) -> np.ndarray:
    """T x m: innovations over their sigmas; NaN where there is none."""
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        made = run.innovation / run.innovation_sigma
    return np.where(np.isfinite(made), made, np.nan)


def whiteness(series: np.ndarray) -> Whiteness:
    """From measurement to measurement, however many rows are between them"""
    series = series[~np.isnan(series)]
    count = len(series)
    lags = max(1, min(40, int(10 * np.log10(max(count, 1))), count // 4))
    correlation, pairs = autocorrelation(series, min(lags, max(len(series) - 1, 1)))
    is_judged = count >= ENOUGH and bool(np.any(np.isfinite(correlation)))
    return Whiteness(correlation, pairs, count, ljung_box(correlation, pairs, count) if is_judged else float("nan"))


def findings(run: Run, z: np.ndarray, wider: Sequence[str] = (), times: Optional[np.ndarray] = None) -> list[Finding]:
    """NIS, rows outside, autocorrelation, mean innovation, events, missing.  Of a run that saturated
    that comes first, and nothing else is judged; so it is of measurements that are coarse in the arithmetic.
    wider: the ranges that would do."""
    found = _findings(run, z, across(run.model, len(z), times))
    if run.is_held:
        return [_held(run, wider), *(replace(one, state="note", advice="Not judged: the ranges first.")
                                     for one in found if one.subject != "Events")]
    coarse = told_of(run.model, run.arithmetic, z) if isinstance(run.model, Model) else ""
    if coarse:
        return [Finding("bad", RESOLUTION, f"{run.arithmetic}: {coarse}", "Or judge the model in f64."),
                *(replace(one, state="note", advice="Not judged: the arithmetic first.") for one in found)]
    return found


def _held(run: Run, wider: Sequence[str]) -> Finding:
    told = sorted(run.faults, key=lambda one: "saturated" not in one[0])
    return Finding("bad", "Events", "; ".join(f"{name}: {meaning}" for name, meaning in told),
                   f"The ranges of the model are too narrow, whatever the data are: give it {', '.join(wider)}." if wider else
                   "The ranges of the model are too narrow, or P0 too wide for them.")


def _findings(run: Run, z: np.ndarray, along: Across) -> list[Finding]:
    scored = is_scored(run, z)
    nis, taken, series = run.nis[scored], run.taken[scored], standardised(run)
    white = [whiteness(column) for column in series.T]
    names = [one.name for one in run.model.measurements]
    return [_nis(nis, taken, white), _outside(nis, taken), _autocorrelation(white, names),
            _mean_innovation(series, names), _events(run), _missing(z, names, along)]


def headline(found: list[Finding]) -> str:
    states = {state: [_within(one.subject) for one in found if one.state == state]
              for state in ("bad", "edge", "note")}
    if found[0].subject == "Events":
        return "A state saturated: the ranges are too narrow, and the fit cannot be judged."
    if found[0].subject == RESOLUTION:
        return "The arithmetic is too coarse for these measurements, and the fit cannot be judged."
    if "NIS" in states["note"]:
        return "Too few measurements to judge the fit."
    if states["bad"]:
        return f"The data do not fit the model: {', '.join(states['bad'])}."
    if states["edge"]:
        return f"The data fit the model; by chance or by little, not quite: {', '.join(states['edge'])}."
    return "The data fit the model."


def _within(subject: str) -> str:
    return subject if subject.isupper() else subject[0].lower() + subject[1:]


def _state(chance: float, is_small: bool) -> str:
    return "good" if chance >= UNUSUAL else "edge" if chance >= STRANGE or is_small else "bad"


# ------------------------------------------------------------------------------ the figures


def _nis(nis: np.ndarray, taken: np.ndarray, white: list[Whiteness]) -> Finding:
    freedom, total = int(taken.sum()), float(nis.sum())
    if freedom < ENOUGH:
        return Finding("note", "NIS", f"{freedom} scored measurements; {ENOUGH} are the least that say something")
    mean, (low, high) = total / freedom, mean_bounds(freedom)
    chance = 2 * min(special.chdtr(freedom, total), special.chdtrc(freedom, total))
    shown = f"{mean:.3f}" if mean < 1000 else f"{mean:.3g}"
    said = (f"{shown} a measurement on average; a right model has 1, and is within {low:.3f} to {high:.3f} in 95 % of "
            "all cases")
    state = _state(chance, 0.9 < mean < 1.1)
    if state == "good":
        return Finding(state, "NIS", said)
    return Finding(state, "NIS", said, _advice_above(nis, taken, white) if mean > 1 else _advice_below(white))


def _advice_above(nis: np.ndarray, taken: np.ndarray, white: list[Whiteness]) -> str:
    usual = float(np.median(nis / chi_square_limit(0.5, taken)))
    if usual < 0.6 * np.sum(nis) / np.sum(taken):
        return ("A few rows are far off, most are not: outliers. Try `kalmanq run --robust huber`, or "
                "`gate`; for steps of the state, `jump`.")
    slow = _lag_one(white)
    if slow > 0:
        return ("Innovations are larger than the model expects and follow one another: Q is too small, or a state is "
                "missing, such as a velocity. Try a larger Q, or `kalmanq fit --free Q,R`.")
    if slow < 0:
        return ("Innovations are larger than the model expects and alternate: R is too small, so that the filter "
                "follows the noise. Try a larger R, or `kalmanq fit --free Q,R`.")
    return ("Innovations are larger than the model expects: R or Q, or both by one factor, are too small. Try "
            "`kalmanq fit --free Q,R`.")


def _advice_below(white: list[Whiteness]) -> str:
    slow = _lag_one(white)
    which = "R is too large" if slow > 0 else "Q is too large" if slow < 0 else "R and Q, by one factor, are too large"
    return f"Innovations are smaller than the model expects: {which}, and the bands are too wide. Try " \
           "`kalmanq fit --free Q,R`."


def _lag_one(white: list[Whiteness]) -> int:
    """The sign of the first lag's correlation, where most components' is significant; else 0."""
    signs = [int(np.sign(one.correlation[0])) for one in white if len(one.significant) and one.significant[0] == 1]
    return 0 if 2 * len(signs) <= len(white) - 1 or not signs else int(np.sign(sum(signs)))


def _outside(nis: np.ndarray, taken: np.ndarray) -> Finding:
    count = len(nis)
    if count < ENOUGH:
        return Finding("note", "Rows outside 95 %", f"{count} scored rows; {ENOUGH} are the least that say something")
    outside = int(np.sum(nis > chi_square_limit(0.95, taken)))
    share, (low, high) = outside / count, share_bounds(count)
    chance = min(1.0, 2 * min(special.bdtr(outside, count, 0.05),
                              special.bdtrc(outside - 1, count, 0.05) if outside else 1.0))
    said = f"{100 * share:.3g} % of {count} rows; 5 % are expected, {100 * low:.3g} to {100 * high:.3g} % are usual"
    state = _state(chance, 0.03 < share < 0.07)
    if state == "good":
        return Finding(state, "Rows outside 95 %", said)
    return Finding(state, "Rows outside 95 %", said,
                   "More rows are surprising than should be: see NIS. Where its mean is right, the noise has heavier "
                   "tails than a Gaussian: `--robust`." if share > 0.05 else
                   "Fewer rows are surprising than should be: noise is taken to be larger than it is.")


def _autocorrelation(white: list[Whiteness], names: list[str]) -> Finding:
    subject = "Autocorrelation"
    judged = [k for k, one in enumerate(white) if one.is_judged]
    if not judged:
        return Finding("note", subject, TOO_FEW)
    worst = min(judged, key=lambda k: white[k].chance)
    one = white[worst]
    lags, largest = one.significant, int(np.nanargmax(np.abs(one.correlation)))
    shown = ", ".join(map(str, lags[:8])) + (", ..." if len(lags) > 8 else "")
    said = (f"of {names[worst]}: {len(lags)} of {len(one.correlation)} lags are outside of 95 %"
            f"{f' ({shown})' if len(lags) else ''}, the largest is {one.correlation[largest]:.2g} at lag "
            f"{largest + 1}; the chance of that is {_percent(one.chance)} (Ljung-Box)")
    state = _state(min(1.0, one.chance * len(judged)), abs(one.correlation[largest]) < 0.05)
    return Finding(state, subject, said, "" if state == "good" else _advice_correlated(one))


def _advice_correlated(one: Whiteness) -> str:
    later = [int(lag) for lag in one.significant if lag > 2]
    if len(one.significant) and one.significant[0] == 1:
        if one.correlation[0] > 0:
            return ("Innovations follow one another: the filter lags behind. Try a larger Q, a state more (a velocity, "
                    "a bias), or noise that is correlated, as a separate state.")
        return "Innovations alternate: the filter follows the noise. Try a larger R or a smaller Q."
    return f"The data repeat themselves{f' after {later[0]} measurements' if later else ''}: a season or an oscillation that " \
           "the model does not have?"


def _mean_innovation(series: np.ndarray, names: list[str]) -> Finding:
    subject, counts = "Mean innovation", np.sum(~np.isnan(series), axis=0)
    judged = [k for k in range(len(names)) if counts[k] >= ENOUGH]
    if not judged:
        return Finding("note", subject, "too few measurements")
    means = {k: float(np.nanmean(series[:, k])) for k in judged}
    worst = max(judged, key=lambda k: abs(means[k]) * counts[k] ** 0.5)
    far = abs(means[worst]) * counts[worst] ** 0.5
    said = (f"of {names[worst]}: {means[worst]:.2g} sigma; a right model has 0, and is within "
            f"{1.96 / counts[worst] ** 0.5:.2g} in 95 % of all cases")
    state = _state(min(1.0, special.erfc(far / 2**0.5) * len(judged)), abs(means[worst]) < 0.05)
    return Finding(state, subject, said, "" if state == "good" else
                   "The measurements are off to one side: an offset of the sensor, a trend that the model does not "
                   "have, or a control that is missing.")


def _events(run: Run) -> Finding:
    told = run.faults
    if not told:
        return Finding("good", "Events", "none: no overflow, no loss of precision")
    return Finding("bad", "Events", "; ".join(f"{name}: {meaning}" for name, meaning in told),
                   "See the ranges and fractions of the model, and the arithmetics below.")


def _missing(z: np.ndarray, names: list[str], along: Across) -> Finding:
    missing = np.isnan(z)
    share = float(np.mean(missing))
    if share == 0 and not along.unit:
        return Finding("good", "Missing", "nothing")
    if share == 1:
        return Finding("note", "Missing", "all measurements: what is shown is the model alone")
    gaps = [spoken(~column, along).longest if along.unit else _longest(column) for column in missing.T]
    longest = int(np.argmax(gaps))
    gap = f"the longest gap is {along.lasts(gaps[longest])}, of {names[longest]}"
    if share == 0:
        return Finding("good", "Missing", f"nothing; {gap}")
    return Finding("note", "Missing", f"{_percent(share)} of the measurements; {gap}")


def _longest(missing: np.ndarray) -> int:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], missing.astype(int), [0]])))
    return int(np.max(edges[1::2] - edges[::2], initial=0))


def _percent(share: float) -> str:
    return f"{100 * share:.3g} %" if share >= 1e-4 else "below 0.01 %"
