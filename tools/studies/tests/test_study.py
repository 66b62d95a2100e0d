"""The study of heavy tails: its noise, its yardsticks, its arithmetic of errors, its figures, its command."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
import tempfile
import time
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image
from scipy.integrate import quad
from scipy.stats import norm

import study
from kalmanq.pages.pictures import save
from kalmanq.run.campaigns import journal_of, run_campaign
from kalmanq_studies.commands.study import shrink
from kalmanq_studies.heavy_tails import claims, estimators, population, scores, stable
from kalmanq_studies.heavy_tails.collected import Collected
from kalmanq_studies.heavy_tails.figures import figures
from kalmanq_studies.heavy_tails.grid import Grid, posterior_means
from kalmanq_studies.heavy_tails.perform import perform
from kalmanq_studies.heavy_tails.settings import SETTINGS, Part, Plan, Task, tasks_of
from command import kalmanq, refused
from whole import WHOLE, first

EVEN, QUIET = SETTINGS
SEEDS = [1, 2, 3]
TINY = Plan(known=Part(2, 5, (1.5, 2.0)), skewed=Part(1, 4, (1.5,), (-1.0, 0.0, 1.0)), fitted=Part(1, 2, (1.3, 2.0)),
            robust=Part(1, 3, (1.5,)))
FEW = Plan(known=Part(2, 500, (1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 2.0)), skewed=Part(1, 500, (1.5,), (-1.0, 0.0, 1.0)),
           fitted=Part(1, 12, (1.3, 2.0)), robust=Part(1, 30, (1.3, 1.5, 1.7, 2.0)))

# ------------------------------------------------------------------------------ the noise

LAWS = [(2.0, 0.0, 1.0), (2.0, 0.7, 2.0), (1.0, 0.0, 1.0), (1.0, 0.5, 1.0), (1.0, -1.0, 0.3), (1.001, 0.0, 1.0),
        (1.001, 0.5, 1.0), (1.01, -0.7, 2.0), (0.999, 0.3, 1.0), (1.3, 1.0, 1.0), (1.5, -0.5, 0.1), (1.9, 1.0, 1.0),
        (0.7, 0.5, 1.0)]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("alpha, beta, sigma", LAWS)
def test_the_noise_has_its_characteristic_function(alpha, beta, sigma, seed):
    x = stable.draw(np.random.default_rng(seed), 100_000, alpha, beta, sigma)
    for k in np.array([0.1, 0.3, 0.7, 1.5, 3.0]) / sigma:
        exact = complex(stable.characteristic(k, alpha, beta, sigma))
        for drawn, value in ((np.cos(k * x), exact.real), (np.sin(k * x), exact.imag)):
            made = scores.mean(drawn)
            assert abs(made.value - value) < 4.5 * made.error, (k, made)


@pytest.mark.parametrize("seed", SEEDS)
def test_alpha_2_is_gaussian_with_variance_2_sigma_squared(seed):
    x = stable.draw(np.random.default_rng(seed), 200_000, 2.0, 0.0, 0.5)
    square, fourth = scores.mean(x**2), scores.mean(x**4)
    assert abs(square.value - 0.5) < 4 * square.error and abs(fourth.value - 3 * 0.25) < 4 * fourth.error
    assert np.allclose(stable.density([0, 1.3], 2.0, 0.5), norm.pdf([0, 1.3], scale=np.sqrt(0.5)), rtol=1e-12)


@pytest.mark.parametrize("alpha", [1.0, 1.1, 1.3, 1.5, 1.7, 1.9, 1.99])
def test_the_density_is_that_of_the_characteristic_function(alpha):
    sigma = 0.4
    for x in (0.0, 0.3, 2.0, 7.9, 8.1, 20.0):  # 8 is where the series of the tail begins
        whole = quad(lambda k: np.exp(-((sigma * k) ** alpha)), 0, np.inf, weight="cos", wvar=x, limlst=200,
                     epsabs=1e-12)[0] if x else quad(lambda k: np.exp(-((sigma * k) ** alpha)), 0, np.inf)[0]
        assert np.isclose(float(stable.density(x, alpha, sigma)), whole / np.pi, rtol=1e-5, atol=1e-9)
    if alpha == 1:
        assert np.allclose(stable.density([0.0, 3.0, 500.0], 1.0, 2.0), 2 / np.pi / (4 + np.array([0, 9, 25e4])))


def test_what_is_no_stable_law():
    for law in ((2.1, 0, 1), (0, 0, 1), (1.5, 1.1, 1), (1.5, 0, 0)):
        with pytest.raises(ValueError, match="is no stable law"):
            stable.draw(np.random.default_rng(1), 3, *law)


# ------------------------------------------------------------------------------ the yardsticks


@pytest.mark.parametrize("setting", SETTINGS)
def test_at_alpha_2_the_grid_has_kalmans_means(setting):
    _, z = setting.draw(np.random.default_rng(4), 10, 2.0, 0.0)
    for exact, kalman in zip(posterior_means(Grid(2.0, setting.sigma), z), estimators.known(setting, z)):
        assert np.abs(exact - kalman).max() < 1e-10


@pytest.mark.parametrize("alpha", [1.0, 1.3, 1.7])
def test_the_grid_is_the_plain_sum_over_all_paths(alpha):
    """Three rows, one fine fixed lattice wide enough for all of them, no transforms"""
    sigma, z = 0.5, np.array([[0.3, 4.1, 3.0]])
    at = np.arange(-14, 18, 0.2)
    by_distance = stable.density(np.arange(len(at)) * 0.2, alpha, sigma)
    step = by_distance[np.abs(np.subtract.outer(np.arange(len(at)), np.arange(len(at))))]
    seen = np.exp(-0.5 * (z.T - at) ** 2)
    first = stable.density(at, alpha, sigma) * seen[0]
    paths = first[:, None, None] * (step * seen[1])[:, :, None] * (step * seen[2])[None]
    smoothed = [np.einsum(paths, [0, 1, 2], [k]) @ at / paths.sum() for k in range(3)]
    exact, by_grid = posterior_means(Grid(alpha, sigma), z)
    assert np.allclose(by_grid[0], smoothed, atol=1e-6)
    two = first[:, None] * (step * seen[1])
    assert np.allclose(exact[0], [first @ at / first.sum(), two.sum(0) @ at / two.sum(), smoothed[2]], atol=1e-6)


@pytest.mark.parametrize("setting, alpha", [(EVEN, 1.1), (EVEN, 1.5), (QUIET, 1.3), (QUIET, 1.9)])
def test_a_finer_and_wider_grid_says_the_same(setting, alpha):
    _, z = setting.draw(np.random.default_rng(5), 4, alpha, 0.0)
    for coarse, fine in zip(posterior_means(Grid(alpha, setting.sigma), z),
                            posterior_means(Grid(alpha, setting.sigma, 0.25, 11), z)):
        assert np.abs(coarse - fine).max() < 1e-5


@pytest.mark.parametrize("setting", SETTINGS)
def test_the_populations_error_of_gaussian_noise_is_that_of_the_covariance(setting):
    runs = [estimators.Smoother(setting.model()).run(np.zeros(setting.rows))]
    for kind, sigma in (("filter", runs[0].sigma), ("smoother", runs[0].smoothed_sigma)):
        assert np.isclose(population.mean_size(setting, kind, 2.0), np.sqrt(2 / np.pi) * sigma.mean(), rtol=1e-6)


@pytest.mark.parametrize("seed", first(1, SEEDS))
@pytest.mark.parametrize("setting, alpha, beta", [(EVEN, 1.5, 0.0), (EVEN, 1.3, 1.0), (QUIET, 1.3, 1.0)])
def test_errors_that_are_drawn_have_the_populations_law(setting, alpha, beta, seed):
    """Their characteristic function, in some rows: unlike their mean size it has no tail that few runs miss."""
    x, z = setting.draw(np.random.default_rng(seed), 1000, alpha, beta)
    for kind, states in zip(population.KINDS, estimators.known(setting, z)):
        of_steps, of_noise = population.weights(setting, kind)
        for row in (0, setting.rows // 2, setting.rows - 1):
            for k in (0.3, 1.0, 3.0):
                parts = [stable.characteristic(k * weight, alpha, beta, setting.sigma) for weight in of_steps[row]]
                exact = np.prod(parts) * np.exp(-0.5 * k**2 * np.sum(of_noise[row] ** 2))
                error = k * (states - x)[:, row]
                for drawn, value in ((np.cos(error), exact.real), (np.sin(error), exact.imag)):
                    made = scores.mean(drawn)
                    assert abs(made.value - value) < 4 * made.error, (kind, row, k, made, value)


def test_the_populations_error_of_jumps_alone():
    """E|S(alpha, beta, 1)| in closed form (Nikias and Shao 1995, for beta = 0)"""
    from scipy.special import gamma

    for alpha in (1.2, 1.5, 1.8):
        exact = 2 / np.pi * gamma(1 - 1 / alpha)
        assert np.isclose(population._mean_size(1.0, 0.0, alpha, 0.0), exact, rtol=1e-4)
        lean = np.tan(np.pi * alpha / 2)
        skewed = exact * (1 + lean**2) ** (0.5 / alpha) * np.cos(np.arctan(lean) / alpha)
        assert np.isclose(population._mean_size(1.0, 0.0, alpha, lean), skewed, rtol=1e-4)


@pytest.mark.parametrize("ratio", [0.02, 2.0, 2 * population.even_ratio()])
def test_what_one_large_jump_makes_of_smoother_and_filter(ratio):
    """By the C core: a jump in the middle of a long record without noise"""
    model = EVEN.model().changed(Q=[[ratio]], P0=[[ratio]])
    x = 1e6 * (np.arange(2001) > 1000)
    run = estimators.Smoother(model).run(x)
    made = np.sqrt(np.sum((run.smoothed[:, 0] - x) ** 2) / np.sum((run.mean[:, 0] - x) ** 2))
    weight = float(population.steady_state(model).gain[0, 0])
    assert np.isclose(made, population.jump_ratio(weight), rtol=1e-6)
    assert (made < 1) == (ratio < population.even_ratio())


# ------------------------------------------------------------------------------ errors


@pytest.mark.parametrize("seed", SEEDS)
def test_standard_errors_are_the_spread_of_repetitions(seed):
    random = np.random.default_rng(seed)
    over, under = random.exponential(2, (4000, 100)), random.exponential(1, (4000, 100))
    over += under
    for make in (scores.mean, lambda a: scores.root(scores.mean(a)), scores.median):
        made = [make(row) for row in over]
        assert np.isclose(np.std([one.value for one in made]), np.mean([one.error for one in made]), rtol=0.1)
    made = [scores.ratio_of(*pair) for pair in zip(over, under)]
    assert np.isclose(np.std([one.value for one in made]), np.mean([one.error for one in made]), rtol=0.05)


def test_figures_show_two_digits_of_their_error():
    shown = {(1.13312, 0.0123): "1.133 ± 0.012", (15.3, 2.4): "15.3 ± 2.4", (1200.4, 300.0): "1200 ± 300",
             (1.0, 0.0): "1", (0.5, 1e-12): "0.5000 ± 0.0000", (1.5, float("nan")): "1.5"}
    assert [str(scores.Figure(*of)) for of in shown] == list(shown.values())


def test_where_ratios_cross_1():
    alphas = np.array([1.0, 1.2, 1.4, 1.6])
    assert np.isclose(scores.crossing(alphas, np.array([1.4, 1.1, 0.9, 0.8])), 1.3)
    assert np.isclose(scores.crossing(alphas, np.array([0.9, 1.1, 1.3, 0.9])), 1.55)  # the last one counts
    assert np.isnan(scores.crossing(alphas, np.array([0.9, 0.8, 0.9, 0.8])))


# ------------------------------------------------------------------------------ what is drawn and estimated


def test_a_known_state_one_row_before_is_the_same_prior():
    _, z = EVEN.draw(np.random.default_rng(6), 5, 1.5, 0.0)
    filtered, smoothed = estimators.known(EVEN, z)
    assert np.allclose(estimators.robust_filters(EVEN, z)["plain"], filtered, atol=1e-9)
    assert np.allclose(estimators.robust_smoothers(EVEN, z)["plain"], smoothed, atol=1e-9)


def test_blocks_differ_and_alphas_have_the_same_numbers():
    draws = {(block, alpha): Task("known", EVEN, alpha, 0.0, block, 3, 1).draw() for block in (0, 1)
             for alpha in (1.999, 2.0)}
    noise = {key: z - x for key, (x, z) in draws.items()}
    assert np.allclose(noise[0, 1.999], noise[0, 2.0]) and np.abs(noise[0, 2.0] - noise[1, 2.0]).max() > 0.1
    assert np.abs(draws[0, 1.999][0] - draws[0, 2.0][0]).max() < 1


@lru_cache(None)
def tiny():
    """The tasks of a tiny study and their results, by one process"""
    tasks = tasks_of(TINY, 7)
    with tempfile.TemporaryDirectory() as folder:
        return tasks, list(run_campaign(perform, tasks, fingerprint={}, journal=Path(folder) / "journal", workers=1))


def assert_the_same(results, tasks, journal, **options):
    made = list(run_campaign(perform, tasks, fingerprint={}, journal=journal, **options))
    assert json.dumps(made) == json.dumps(results)


@pytest.mark.parametrize("every", [2, pytest.param(1, marks=WHOLE)])
def test_any_number_of_workers_draws_the_same(every, tmp_path):
    tasks, results = tiny()
    assert len(tasks) == 2 * (4 + 3 + 2 + 1)
    assert_the_same(results[::every], tasks[::every], tmp_path / "two", workers=2)


# ------------------------------------------------------------------------------ what it has to show


@lru_cache(None)
def few(seed):
    return study.collected(FEW, seed)


def test_every_claim_says_whose_it_is():
    """The paper says the first three; of beta the opposite.  All others are of this project."""
    found = list(claims.claims(few(1)))
    assert [claim.source for claim in found[:5]] == [claims.PAPER] * 3 + [claims.REFERENCE] * 2
    assert "the paper says the opposite" in found[5].source and found[6].source == claims.REFERENCE


@pytest.mark.parametrize("seed", first(1, SEEDS))
def test_what_the_study_has_to_show_with_few_runs(seed):
    c = few(seed)
    for check in study.CHECKS:
        check(c)


# ------------------------------------------------------------------------------ the figures


def curves(axis):
    """Lines that are no frames, bars or guides"""
    return [line for line in axis.get_lines() if line.get_linestyle() not in ("None", "") and line.get_linewidth() > 0.7
            and len(line.get_xdata()) > 1]


@pytest.mark.parametrize("every", [2, pytest.param(1, marks=WHOLE)])
def test_curves_can_be_told_apart(every, tmp_path):
    """Each has a colour of its own, in its panel and in the file with its palette."""
    c = Collected(*tiny())
    for name, draw in list(figures().items())[::every]:
        picture = draw(c)
        colours = [[np.array(to_rgb(line.get_color())) for line in curves(axis)] for axis in picture.axes]
        for panel in colours:
            for k, one in enumerate(panel):
                assert all(255 * np.linalg.norm(one - other) > 50 for other in panel[:k]), name
        save(picture, tmp_path / f"{name}.png")
        shrink(tmp_path / f"{name}.png")
        pixels = np.unique(np.asarray(Image.open(tmp_path / f"{name}.png").convert("RGB")).reshape(-1, 3), axis=0)
        for one in {tuple(one) for panel in colours for one in panel}:
            assert np.linalg.norm(pixels - 255 * np.array(one), axis=1).min() < 30, (name, one)


# ------------------------------------------------------------------------------ the command

STUDY = ("study", "heavy-tails", "--quick", "--seed", 3)


@WHOLE
def test_the_quick_study_goes_on_where_it_was_interrupted(tmp_path):
    journal = journal_of(tmp_path / "heavy-tails")
    command = [sys.executable, "-m", "kalmanq.command_line", *map(str, STUDY), "--out", str(tmp_path)]
    begun = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    until = time.monotonic() + 60
    while time.monotonic() < until and not (journal.exists() and journal.read_bytes().count(b"\n") > 5):
        time.sleep(0.05)
    begun.send_signal(signal.SIGINT)
    _, said = begun.communicate(timeout=60)
    assert begun.returncode == 130 and "the same command goes on from there" in said
    assert [path.name for path in tmp_path.iterdir()] == [journal.name]

    kept = journal.read_bytes()
    done = kalmanq(*STUDY, "--out", tmp_path, "--json")
    assert done.returncode == 0 and done.stderr == ""
    said = json.loads(done.stdout)
    assert len(kept.splitlines()) > 5 and not journal.exists()
    assert sorted(said["files"]) == sorted(path.name for path in tmp_path.iterdir())
    check_page(tmp_path, said)


def check_page(folder, said):
    pictures = {path.stem: path.stat().st_size for path in folder.glob("*.png")}
    assert sorted(pictures) == sorted(figures()) and len(pictures) == 6 and max(pictures.values()) < 60_000
    page = (folder / "README.md").read_text(encoding="utf-8")
    assert all(f"]({name}.png)" in page for name in pictures) and "FOLDER/heavy_tails.csv" in page
    assert all(claim["said"] in page and claim["verdict"] in page for claim in said["claims"])
    assert "groups of 1000" not in page and "one group of 800 runs" in page
    assert "| who says so |" in page and all(f"| {claim['source']} |" in page for claim in said["claims"])
    assert "nan" not in page and " inf " not in page
    rows = (folder / "heavy_tails.csv").read_text().splitlines()
    assert len(rows) > 100 and len({row.count(",") for row in rows}) <= 3  # estimators' names have commas, quoted


def test_what_cannot_be_done_is_one_line(tmp_path):
    refused(kalmanq("study", "heavy-tails", "--out", tmp_path / "none"), "there is no such folder", tmp_path)
    refused(kalmanq(*STUDY, "--out", tmp_path, "--dask", "tcp://a:1"), "--dask is gone", tmp_path)
    assert kalmanq("study", "thin-tails", "--out", tmp_path).returncode == 2
    journal_of(tmp_path / "heavy-tails").write_text("precious")
    done = kalmanq(*STUDY, "--out", tmp_path)
    assert done.returncode == 1 and "is no journal of a campaign" in done.stderr
    assert [path.read_text() for path in tmp_path.iterdir()] == ["precious"]
