"""kalmanq in the place of statsmodels' Kalman filter and smoother, in all results that it has a counterpart of."""

from __future__ import annotations

from typing import Any

import numpy as np
from statsmodels.tsa.statespace.kalman_filter import FilterResults
from statsmodels.tsa.statespace.kalman_smoother import SmootherResults

import kalmanq

TESTS = ["statsmodels.tsa.statespace.tests.test_exact_diffuse_filtering", "statsmodels.tsa.statespace.tests.test_smoothing"]
LEFT_OUT = {
    "*disturbance*": "kalmanq has no disturbance smoother",
    "*scaled_smoothed*": "kalmanq does not show the smoother's recursion",
    "*gain": "a run has no gains",
    "*autocov": "a run has no covariances of two rows",
    "*diffuse_cov": "of an unknown state kalmanq says NaN, not the parts of a limit",
    "*_method": "an option of statsmodels",
    "*_invalid*": "errors that statsmodels raises",
    "*_KFAS::test_forecasts_error_cov": "of one component at a time, each given those before it",
    "*VARUnivariate*::test_forecasts_error*": "of one component at a time, each given those before it",
    "*VARUnivariate*::test_smoothed_states_cov": "the expected determinant is 6e-6 off the exact one, kalmanq 1e-15",
    "*-True-*": "the same models by another method of statsmodels",
}


class Matrices:
    """A matrix at each instant, as statsmodels has them: one, or one for each row along the last axis"""

    def __init__(self, of: FilterResults):
        self.of, self.rows = of, of.nobs

    def __call__(self, name: str) -> np.ndarray:
        given = np.moveaxis(getattr(self.of, name), -1, 0)
        return np.broadcast_to(given, (self.rows, *given.shape[1:]))


def interleaved(still: np.ndarray, moves: np.ndarray) -> np.ndarray:
    """What stands still from before a measurement to behind it, then moves to the next row; and a last row"""
    made = np.repeat(still[None], 2 * len(moves) + 1, axis=0)
    made[1::2] = moves
    return made


def run_of(of: FilterResults) -> kalmanq.Run:
    """Two rows for each of the data: before its measurement, and with it; a row more has the last prediction.  Every matrix
    varies: A, Q, B of the step, H, R of the measurement."""
    at, n, m = Matrices(of), of.k_states, of.k_endog
    noise = at("selection") @ at("state_cov") @ at("selection").swapaxes(1, 2)
    B = interleaved(np.zeros((n, 1)), at("state_intercept")[:, :, None])
    z = np.full((2 * of.nobs + 1, m), np.nan)
    z[1::2] = of.endog.T - at("obs_intercept")
    varying = kalmanq.Varying(A=interleaved(np.eye(n), at("transition")), B=B,
                              Q=interleaved(np.zeros((n, n)), (noise + noise.swapaxes(1, 2)) / 2),
                              H=interleaved(np.zeros((m, n)), at("design")), R=interleaved(np.eye(m), at("obs_cov")))
    unknown = [] if of.initial_diffuse_state_cov is None else np.flatnonzero(np.diag(of.initial_diffuse_state_cov))
    model = kalmanq.Model(np.eye(n), H=np.zeros((m, n)), R=np.eye(m), Q=np.eye(n), B=np.zeros((n, 1)), x0=of.initial_state,
                          P0=of.initial_state_cov, unknown=unknown)
    return kalmanq.Smoother(model).run(z, np.ones((len(z), 1)), varying=varying, covariance=True)


def kept_of_limits(theirs: np.ndarray, ours: np.ndarray, diffuse: Any) -> np.ndarray:
    """While a state is unknown, kalmanq says NaN, and statsmodels the finite part of a limit: that stays, in those rows only"""
    rows = np.isnan(ours).reshape(-1, ours.shape[-1]).any(axis=0)
    expected = np.zeros(len(rows), bool) if diffuse is None else np.abs(diffuse).max(axis=(0, 1))[:len(rows)] > 1e-10
    np.testing.assert_array_equal(rows, np.pad(expected, (0, len(rows) - len(expected))), "rows with unknown states")
    return np.where(rows, theirs, ours)


def put_into(spoil: Any) -> Any:
    """Replaces the results of every filter and smoother from now on; spoil: what is done to each array.  Returns how to stop."""
    filtering, smoothing = FilterResults.update_filter, SmootherResults.update_smoother

    def put(of: FilterResults, name: str, ours: np.ndarray, diffuse: Any = None) -> None:
        theirs = getattr(of, name)
        assert theirs.shape == ours.shape, (name, theirs.shape, ours.shape)
        setattr(of, name, kept_of_limits(theirs, spoil(ours), diffuse))

    def update_filter(of: FilterResults, kalman_filter: Any) -> None:
        filtering(of, kalman_filter)
        of.run, diffuse, at = run_of(of), of.predicted_diffuse_state_cov, Matrices(of)
        mean, P = np.moveaxis(of.run.mean, 0, -1), np.moveaxis(of.run.covariance, 0, -1)
        put(of, "predicted_state", mean[:, ::2], diffuse)
        put(of, "predicted_state_cov", P[:, :, ::2], diffuse)
        after = None if diffuse is None else diffuse[:, :, 1:]
        put(of, "filtered_state", mean[:, 1::2], after)
        put(of, "filtered_state_cov", P[:, :, 1::2], after)
        put(of, "llf_obs", of.run.log_likelihood[1::2])
        design = at("design")
        put(of, "forecasts", (np.einsum("tmn,nt->tm", design, mean[:, :-1:2]) + at("obs_intercept")).T, diffuse)
        S = np.einsum("tmn,nkt,tlk->mlt", design, P[:, :, :-1:2], design) + np.moveaxis(at("obs_cov"), 0, -1)
        put(of, "forecasts_error_cov", S, diffuse)

    def update_smoother(of: SmootherResults, smoother: Any) -> None:
        smoothing(of, smoother)
        put(of, "smoothed_state", of.run.smoothed[1::2].T)
        put(of, "smoothed_state_cov", np.moveaxis(of.run.smoothed_covariance[1::2], 0, -1))

    def stop() -> None:
        FilterResults.update_filter, SmootherResults.update_smoother = filtering, smoothing

    FilterResults.update_filter, SmootherResults.update_smoother = update_filter, update_smoother
    return stop
