"""The page of findings, in Markdown: every figure on it is put there from the numbers."""

from __future__ import annotations

from textwrap import fill
from typing import Sequence

import numpy as np

from kalmanq_studies.heavy_tails import population, scores
from kalmanq_studies.heavy_tails.claims import (
    EVEN, METRICS, QUIET, ROBUST_ALPHAS, TAILED, Claim, claims, nearest, worst)
from kalmanq_studies.heavy_tails.collected import GAUSSIAN, Collected
from kalmanq_studies.heavy_tails.estimators import FILTERS, ITERATIONS, JUMP, SMOOTHERS, TOLERANCE
from kalmanq_studies.heavy_tails.grid import FINER, Grid
from kalmanq_studies.heavy_tails.scores import Figure
from kalmanq_studies.heavy_tails.settings import SETTINGS

TABLED = (1.0, 1.3, 1.5, 1.7, 2.0)
CAPTIONS = {
    "known": "Known parameters: how the filter's error grows as alpha falls, and what smoothing gains. Bars are two "
             "standard errors; the lines of the population need no runs. The RMSE has no population value below alpha = 2.",
    "runs": "The filter's error over the first so many runs, Q/R = 2. The RMSE goes up with each jump that is larger "
            "than all before; the MAE settles at the population's value.",
    "skewness": "Mean error against the skewness of the jumps: it costs the filter, and hardly the smoother.",
    "fitted": "The filter's mean error with fitted parameters, over the Gaussian case. Left in the units of x, where a "
              "free c leaves the unit open; right in those of the measurement. Curves stand side by side: each point is of "
              "the nearest grid line.",
    "estimates": "What is fitted, Q/R = 2: medians, with the quartiles as bands. Q goes to that of the largest jumps, "
                 "and K to 1.",
    "robust": "Mean error above that of the exact posterior mean, in per cent, on a logarithmic axis; a curve ends "
              "where it is less than 0.05 %.",
}


def page(c: Collected, command: str, versions: dict[str, str]) -> str:
    found = list(claims(c))
    parts = [_head(c, command, versions), _summary(found), _advice(c), _claims(found), _known(c), _estimates(c),
             _robust(c), _grid(c)]
    return "\n\n".join(parts) + "\n"


def table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def picture(name: str) -> str:
    return f"![{name}]({name}.png)\n\n{filled('*' + CAPTIONS[name] + '*')}"


def filled(text: str, indent: str = "") -> str:
    """In lines of the page's width"""
    return fill(" ".join(text.split()), 116, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)


def _head(c: Collected, command: str, versions: dict[str, str]) -> str:
    made_by = ", ".join(f"{name} {version}" for name, version in versions.items())
    settings = " and ".join(f"Q/R = {setting.ratio:g}, {setting.rows} rows" for setting in SETTINGS)
    return "\n\n".join([
        "# Heavy tails: a Kalman filter where the state jumps",
        "    x[t+1] = a x[t] + w        z[t] = c x[t] + v",
        filled(f"""a = c = R = 1; v is Gaussian, w and x[0] are alpha-stable, S(alpha, beta, sigma): Gaussian for
        alpha = 2, with the more and the larger jumps the smaller alpha is. The filter is told the Gaussian of the same
        sigma, Q = 2 sigma^2. After Mozgunov (2014), in two settings ({settings}); noise by Chambers, Mallows and Stuck
        (1976), as corrected by Weron (1996). All filters, smoothers and fits are the C core's, in f64."""),
        filled(f"""Written by `{command}` ({made_by}). FOLDER/heavy_tails.csv then has all errors and estimates.
        For each alpha and beta there are {c.runs('known')} runs with known parameters, {c.runs('skewed')} for the
        skewness, {c.runs('fitted')} with fitted ones (of Q/R = {QUIET:g} with Q, or Q and R, alone) and
        {c.runs('robust')} beside the exact posterior. Different alphas have the same random numbers, so that ratios
        between them are more exact than the errors."""),
        "\n".join(f"- {filled(line, '  ')}" for line in WORDS)])


WORDS = (
    "**RMSE**, **MAE**: root of the mean square, and mean size, of the errors of all rows of all runs.",
    "**Gaussian case**: the filter with known parameters at alpha = 2 and the same Q/R; RMSE is compared with its "
    "RMSE, MAE with its MAE.",
    "**a ± b**: b is one standard error, over runs. That of an RMSE for alpha < 2 is only that of the runs which were "
    "drawn: it understates, as the largest jump is yet to come. So, by less, does that of an MAE of errors that have "
    "such tails: runs that lack the largest jumps are below the population, and say nothing of it.",
    "**of the population**: what infinitely many runs would have, by an integral over the error's characteristic "
    "function.",
    "**error of c x**: of the fitted c times the estimate of x, beside the true c x: free of the unit of x.")


def _summary(found: Sequence[Claim]) -> str:
    rows = [[str(k), claim.said, claim.source, claim.verdict] for k, claim in enumerate(found, 1)]
    whose = filled("""The paper is Mozgunov (2014). Our reference is an earlier calculation of this project, by other
    code: what it says is not in the paper. The last column is this study's.""")
    return "\n\n".join(["## What was said, and what came out", whose,
                        table(["", "said", "who says so", "this study finds"], rows)])


def _claims(found: Sequence[Claim]) -> str:
    pictures = {1: ("known", "runs"), 4: ("fitted",), 6: ("skewness",)}
    made = ["## One by one"]
    for k, claim in enumerate(found, 1):
        made.append(f"### {k}. {claim.said}")
        made.append("\n".join(f"- {filled(line, '  ')}" for line in claim.measured))
        made.append(filled(f"**{claim.verdict[0].upper()}{claim.verdict[1:]}.** {claim.why}"))
        made += [picture(name) for name in pictures.get(k, ())]
    return "\n\n".join(made)


# ------------------------------------------------------------------------------ what to do


def _advice(c: Collected) -> str:
    alpha = nearest(c.alphas("robust"), 1.5)
    plain, gate, huber = (c.beside_exact(EVEN, alpha, name, "MAE", "filter") for name in ("plain", "gate", "Huber"))
    jump = worst(c, EVEN, "jump", "MAE", "filter")
    fitted = c.beside_gaussian("fitted", EVEN, TAILED, "EM of Q", "MAE")
    cost = [c.beside_exact(ratio, GAUSSIAN, "jump", "MAE", "filter") for ratio in (EVEN, QUIET)]
    smoothed = [worst(c, ratio, "reweighted", "MAE", "smoother") for ratio in (EVEN, QUIET)]
    alphas = ", ".join(f"{one:g}" for one in ROBUST_ALPHAS)
    said = (
        f"""**Where the state jumps, say so to the filter**: `kalmanq run --robust jump`, in Python
        `Robust("jump", g)`. For Q/R = {EVEN:g}, g = {JUMP[EVEN]:g}, its MAE is at most {jump} times the exact
        posterior mean's (alpha = {alphas}); the plain filter's is {plain} at alpha = {alpha:g}. Where nothing jumps, it costs {percent(cost[0])}
        (Q/R = {EVEN:g}) or {percent(cost[1])} ({QUIET:g}, g = {JUMP[QUIET]:g}).""",
        f"""**Smooth with** `ReweightedSmoother`: its MAE is at most {percent(smoothed[0])} (Q/R = {EVEN:g}) and
        {percent(smoothed[1])} ({QUIET:g}) above the exact smoother's, for alpha = {ROBUST_ALPHAS[0]:g} to
        {ROBUST_ALPHAS[-1]:g}. Five passes from a weight of 16 are enough; the plain smoother smears every jump.""",
        f"""**No step for measurement outliers there.** At alpha = {alpha:g}, Q/R = {EVEN:g}, a gate has {gate} times
        the exact error, Huber's update {huber}: they take the jump for an outlier.""",
        f"""**Fit Q, or Q and R; hold c** (H). EM of Q bounds the harm of jumps, to {fitted} times the Gaussian case's
        MAE at alpha = {TAILED:g}, by trusting every measurement.""",
        "**Quote the MAE with its standard error**, or medians. An RMSE of such noise says how many runs there were.")
    return "## What to do\n\n" + "\n".join(f"{k}. {filled(one, '   ')}" for k, one in enumerate(said, 1))


def percent(ratio: Figure) -> str:
    return f"{ratio.above()} %"


# ------------------------------------------------------------------------------ tables


def tabled(alphas: np.ndarray) -> np.ndarray:
    """Those of a table: the CSV has all of them"""
    return alphas[np.isclose(alphas[:, None], TABLED).any(axis=1)]


def _known(c: Collected) -> str:
    rows = []
    for alpha in tabled(c.alphas("known")):
        for setting in SETTINGS:
            of = c.of("known", setting.ratio, alpha)
            made = [f"{scores.error_of(of, kind, metric)}" for kind in ("filter", "smoother") for metric in METRICS]
            exact = [f"{population.mean_size(setting, kind, alpha):.4f}" if alpha > 1 else "infinite"
                     for kind in ("filter", "smoother")]
            rows.append([f"{alpha:g}", f"{setting.ratio:g}", *made[:2], exact[0], *made[2:], exact[1]])
    return "## Errors with known parameters\n\n" + table(
        ["alpha", "Q/R", "filter RMSE", "MAE", "of the population", "smoother RMSE", "MAE", "of the population"], rows)


def _estimates(c: Collected) -> str:
    rows = []
    for alpha in tabled(c.alphas("fitted")):
        for name in ("EM of Q", "EM of Q, R"):
            of = c.of("fitted", EVEN, alpha, name)
            rows.append([f"{alpha:g}", name, *(f"{scores.median(of[column])}" for column in "QRPK"),
                         f"{100 * of['converged'].mean():.0f} %"])
    return "\n\n".join([
        "## What is fitted", filled(f"""Medians over the runs, Q/R = {EVEN:g}, after at most {ITERATIONS} iterations;
        converged: no parameter moved by more than {TOLERANCE:g} of itself in the last one."""),
        table(["alpha", "fitted", "Q", "R", "P", "K", "converged"], rows),
        picture("estimates")])


def _robust(c: Collected) -> str:
    rows = []
    for kind, names in (("filter", FILTERS), ("smoother", SMOOTHERS)):
        for name in names:
            made = [worst(c, ratio, name, metric, kind) for ratio in (EVEN, QUIET) for metric in METRICS]
            harm = [c.beside_exact(ratio, GAUSSIAN, name, "MAE", kind) for ratio in (EVEN, QUIET)]
            rows.append([kind, name, *map(str, made), *map(str, harm)])
    alphas = ", ".join(f"{alpha:g}" for alpha in ROBUST_ALPHAS)
    header = ["", "way", *(f"{metric}, Q/R = {ratio:g}" for ratio in (EVEN, QUIET) for metric in METRICS),
              *(f"alpha = 2: MAE, {ratio:g}" for ratio in (EVEN, QUIET))]
    return "\n\n".join([
        "## Robust steps beside the exact posterior mean",
        filled(f"""Errors over those of the exact posterior mean for the noise that was drawn, over the same runs: the
        largest of alpha = {alphas}; and what each way costs where nothing jumps. The reweighted smoothers have nu = 2
        and begin with a weight of 16; five passes where no other number is named."""),
        table(header, rows), picture("robust")])


def _grid(c: Collected) -> str:
    rows = []
    for alpha in tabled(c.alphas("robust")):
        for ratio in (EVEN, QUIET):
            exact = c.of("robust", ratio, alpha, "exact")
            made = [f"{scores.error_of(exact, kind, metric)}" for kind in ("filter", "smoother") for metric in METRICS]
            rows.append([f"{alpha:g}", f"{ratio:g}", *made, f"{exact['refined'].max():.1e}"])
    return "\n\n".join([
        "## The yardstick's own error",
        filled(f"""The exact posterior mean is computed on a grid of steps of {Grid.step:g} sigma, to {Grid.width:g} on
        each side of the measurement, with the true density. The last column is by how much the mean of any row moves at
        most with steps of {FINER['step']:g} sigma and a width of {FINER['width']:g}, in some runs. At alpha = 2 it is
        the Kalman filter's own mean. It minimises the mean square; the posterior's median would have a slightly smaller
        MAE."""),
        table(["alpha", "Q/R", "filter RMSE", "MAE", "smoother RMSE", "MAE", "grid's error"], rows)])
