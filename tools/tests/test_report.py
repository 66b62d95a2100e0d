"""The report: one page that stands by itself, of any model and data, and what it says of them."""

from __future__ import annotations

import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from kalmanq import Filter, Model, Quantity
from kalmanq import command_line
from kalmanq.model import model_file
from kalmanq.pages.across import Across, spoken
from kalmanq.pages.charts import envelope
from kalmanq.pages.verdict import findings, headline, whiteness
from kalmanq.run.diagnostics import autocorrelation, ljung_box, mean_bounds, share_bounds
from kalmanq.run.simulation import simulate
from command import kalmanq, succeeds
from library import EXAMPLES, saved
from whole import MEASURED, WHOLE

NILE, MODEL, TRACK = EXAMPLES / "nile.csv", EXAMPLES / "nile.toml", EXAMPLES / "track.toml"
VOID = {"meta", "br", "hr", "link", "img", "input"}
ODD = "<script>alert('1')</script> & \"quotes\""


class Page(HTMLParser):
    """Balanced elements, their attributes, and what is to be read."""

    def __init__(self, path: Path):
        super().__init__()
        self.raw = path.read_text(encoding="utf-8")
        self.open: list[str] = []
        self.elements: list[tuple[str, dict]] = []
        self.words: list[str] = []
        self.feed(self.raw)
        self.close()
        assert self.open == [], "left open"

    def handle_starttag(self, tag, attributes):
        names = [name for name, _ in attributes]
        assert len(names) == len(set(names)), f"<{tag}> has an attribute twice"
        self.elements.append((tag, dict(attributes)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))

    def handle_endtag(self, tag):
        assert self.open and self.open[-1] == tag, f"</{tag}> in {self.open[-3:]}"
        self.open.pop()

    def handle_data(self, data):
        if "style" not in self.open:
            self.words.append(data)

    @property
    def text(self) -> str:
        return re.sub(r"\s+", " ", " ".join(self.words))

    def all(self, tag: str) -> list[dict]:
        return [attributes for name, attributes in self.elements if name == tag]


def reported(model, data, folder, *options) -> Page:
    """In this process: a report is a second of drawing, and starting Python is another one."""
    out = folder / "report.html"
    done = CliRunner().invoke(command_line.app, ["report", str(model), str(data), "-o", str(out), *options])
    assert done.exit_code == 0, done.output
    assert [path.name for path in folder.iterdir() if path.name.startswith(".")] == []
    page = Page(out)
    stands_by_itself(page)
    can_be_used_by_all(page)
    return page


def stands_by_itself(page: Page) -> None:
    assert not re.search(r"https?:|//[a-z]|@import|<script|<link|<iframe|javascript:", page.raw)
    for tag, attributes in page.elements:
        for name in ("src", "href", "xlink:href", "data", "action"):
            assert attributes.get(name, "#").startswith("#"), (tag, attributes)
        assert not any(name.startswith("on") for name in attributes), (tag, attributes)
    for target in re.findall(r"url\(([^)]*)\)", page.raw):
        assert target.startswith("#")
    identities = [of["id"] for _, of in page.elements if "id" in of]
    assert len(identities) == len(set(identities))
    wanted = {of["href"][1:] for _, of in page.elements if "href" in of} | set(re.findall(r"url\(#([^)]*)\)", page.raw))
    assert wanted <= set(identities)


def can_be_used_by_all(page: Page) -> None:
    assert page.all("html")[0]["lang"] == "en" and len(page.all("h1")) == 1 and len(page.all("title")) == 1
    assert "width=device-width" in page.all("meta")[1]["content"]
    for picture in page.all("svg"):
        assert picture["role"] == "img" and len(picture["aria-label"]) > 20
        assert "width" not in picture and picture["viewbox"]
    assert len(page.all("caption")) == len(page.all("table"))
    assert all(cell.get("scope") in ("col", "row") for cell in page.all("th"))
    assert "prefers-color-scheme: dark" in page.raw and "@media print" in page.raw


def written(folder: Path, model: Model, z: np.ndarray) -> tuple[Path, Path]:
    """Files of a model and its measurements."""
    paths = folder / "model.toml", folder / "data.csv"
    paths[0].write_text(model_file.text_of(model), encoding="utf-8")
    names = ",".join('"' + one.name.replace('"', '""') + '"' for one in model.measurements)
    lines = [",".join("" if np.isnan(cell) else repr(float(cell)) for cell in row) + f",{k}" for k, row in enumerate(z)]
    paths[1].write_text("\n".join([f"{names},row", *lines]) + "\n", encoding="utf-8")
    return paths


def level(name="level", drift=0.5, noise=2.0, **options) -> Model:
    return Model([[1.0]], H=[1.0], R=noise, Q=[[drift]], name=name, **options)


# ------------------------------------------------------------------------------ the page


@pytest.mark.usefixtures("no_offers")
@pytest.mark.parametrize("arithmetic", ["f32", "f64", "q31"])
def test_the_nile(arithmetic, tmp_path):
    page = reported(MODEL, NILE, tmp_path, "--arith", arithmetic)
    assert "nile" in page.text and "100 rows" in page.text and arithmetic in page.text
    for heading in ("Does the data fit the model?", "Data and bands", "Residuals", "NIS", "Autocorrelation",
                    "Sigma", "The arithmetics", "The model"):
        assert heading in page.text, heading
    assert "log-likelihood" in page.text and "level [1e8 m3]" in page.text
    assert str(tmp_path) not in page.raw and "nan" not in re.sub(r"<svg.*?</svg>", "", page.raw).lower()


def test_the_same_page_for_the_same_files(tmp_path):
    assert reported(MODEL, NILE, tmp_path).raw == reported(MODEL, NILE, tmp_path).raw


def test_the_colours_of_pictures_are_those_of_the_page(tmp_path):
    page = reported(MODEL, NILE, tmp_path)
    pictures = "".join(re.findall(r"<svg.*?</svg>", page.raw, re.S))
    assert "var(--filtered)" in pictures and "var(--smoothed)" in pictures
    assert not re.search(r"(fill|stroke): ?#[0-9a-f]{3,6}", pictures)
    for variable in set(re.findall(r"var\((--[a-z-]+)\)", page.raw)):
        assert page.raw.count(f"{variable}:") == 2, variable  # once for light, once for dark


def test_names_are_escaped(tmp_path):
    model = level(ODD, states=[Quantity(ODD, "<b>", 100)], measurements=[Quantity("a&<i>", "\"'", 100)])
    page = reported(*written(tmp_path, model, simulate(model, 30, 1)[1]), tmp_path)
    assert "<script" not in page.raw and "<b>" not in page.raw and "<i>" not in page.raw
    assert ODD in page.text and "a&<i>" in page.text


CASES = {
    "one row": (level(P0=[[1.0]]), np.array([[1.5]])),
    "one row, unknown start": (level(), np.array([[1.5]])),
    "two rows": (level(), np.array([[1.5], [2.0]])),
    "all missing": (level(P0=[[1.0]]), np.full((20, 1), np.nan)),
    "all missing, unknown start": (level(), np.full((20, 1), np.nan)),
    "one missing row": (level(P0=[[0.0]]), np.array([[np.nan]])),
    "no noise at all": (level(drift=0.0, noise=1e-30, P0=[[0.0]]), np.zeros((40, 1))),
    "constant": (level(), np.full((40, 1), 3.0)),
    "large": (level(P0=[[1e30]]), np.linspace(1e30, 2e30, 40)[:, None]),
    "never known": (Model([[1.0, 1], [0, 1]], H=[1.0, 0], R=1.0, Q=[0.1, 0.1]), np.array([[1.0], [np.nan], [np.nan]])),
}


@pytest.mark.parametrize("case", CASES)
def test_edges(case, tmp_path):
    page = reported(*written(tmp_path, *CASES[case]), tmp_path)
    assert f"{len(CASES[case][1])} row" in page.text
    assert "nan" not in re.sub(r"<svg.*?</svg>", "", page.raw, flags=re.S).lower()
    if "missing" in case or "row" in case:
        assert "Too few measurements" in page.text


@WHOLE
def test_sixteen_states_stay_small(tmp_path):
    model = Model(0.9 * np.eye(16), H=np.eye(16), R=np.ones(16), Q=np.full(16, 0.1), P0=np.ones(16),
                  states=[Quantity(f"s{k}", "m", 100) for k in range(16)])
    page = reported(*written(tmp_path, model, simulate(model, 600, 1)[1]), tmp_path)
    assert len(page.raw) < 3e6 and "lowest and highest" in page.text
    assert len(page.all("svg")) == 2 * (16 + 16 + 1 + 16) + 16  # autocorrelations are narrow alone


@pytest.mark.usefixtures("no_offers")
def test_a_hundred_thousand_rows_stay_small(tmp_path):
    page = reported(*written(tmp_path, level(), simulate(level(), 100_000, 1)[1]), tmp_path)
    assert len(page.raw) < 1e6 and "100000 rows" in page.text and "lowest and highest" in page.text


def track(folder: Path) -> Path:
    """Rows that the track's model has drawn"""
    data = folder / "track.csv"
    succeeds("simulate", EXAMPLES / "track.toml", "-n", 40, "--out", data)
    return data


@MEASURED
def test_what_each_core_pays_is_told(tmp_path):
    text = reported(MODEL, NILE, tmp_path).text
    assert "kalmanq design" in text and "Compiled for this model alone" in text and "Cortex-M4F" in text and "arm-none-eabi-gcc" in text


CHROMIUM = next(filter(None, map(shutil.which, ("chromium-headless-shell", "chromium", "google-chrome"))), None)


def printed_style(raw: str) -> str:
    return raw[raw.index("@media print"):raw.index("</style>")]


@MEASURED
def test_a_number_is_printed_in_one_line(tmp_path):
    """No cell of a table holds a sentence, which would leave no room for the others, and no number is broken."""
    page = reported(EXAMPLES / "track.toml", track(tmp_path), tmp_path)
    style = printed_style(page.raw)
    assert "anywhere" not in style and not re.search(r"\btd\b[^{]*{[^}]*white-space: normal", style)
    cells = re.findall(r"<td[^>]*>([^<]*)</td>", page.raw)
    assert cells and max(map(len, cells)) < 30
    assert "Compiled for this model alone" in page.text and re.search(r"Cortex-M4F f32 \d+ \d+ \d+ ", " ".join(page.text.split()))


@MEASURED
@pytest.mark.skipif(not (CHROMIUM and shutil.which("pdftotext")), reason="needs Chromium and pdftotext")
@pytest.mark.parametrize("states", [4, 16])
def test_the_print_has_all_of_its_tables(states, tmp_path):
    """Every cell of every table is within the page, in one line."""
    if states == 4:
        model, data = EXAMPLES / "track.toml", track(tmp_path)
    else:
        model, data = tmp_path / "wide.toml", tmp_path / "wide.csv"
        rows = ", ".join(f"[{', '.join(f'{0.0123456 * (i + j + 1):.6g}' if i != j else '0.5' for j in range(16))}]"
                         for i in range(16))
        first = [float(i == 0) for i in range(16)]
        model.write_text(f"[model]\nA = [{rows.replace('0.5', '0.123456')}]\nH = [{first}]\nR = 1.0\nG = {[[1.0]] * 16}\nP0 = {[1.0] * 16}\n")
        data.write_text("z1\n" + "0.5\n" * 20)
    page = reported(model, data, tmp_path)
    cells = [cell.replace("&#x27;", "'") for cell in re.findall(r"<td>([^<]+)</td>", page.raw)]  # no words
    assert len(cells) > 50
    subprocess.run([CHROMIUM, "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'browser'}",
                    f"--print-to-pdf={tmp_path / 'out.pdf'}", (tmp_path / "report.html").as_uri()], check=True,
                   capture_output=True, timeout=120)
    text = subprocess.run(["pdftotext", "-layout", str(tmp_path / "out.pdf"), "-"], check=True, capture_output=True,
                          text=True).stdout
    lines = [" ".join(line.split()) for line in text.splitlines()]
    there = "\n".join(lines)
    missing = [cell for cell in cells if cell not in there]
    assert not missing, missing[:5]
    whole_rows = [" ".join(one) for one in (re.findall(r"<t[dh][^>]*>([^<]*)</t[dh]>", row)
                                            for row in re.findall(r"<tr>(.*?)</tr>", page.raw, re.S)) if "±" in "".join(one)]
    assert all(" ".join(row.split()) in there for row in whole_rows)


# ------------------------------------------------------------------------------ what is refused


def test_bad_options_are_refused_before_anything_is_done(tmp_path):
    run = CliRunner()
    for options, said in ((["-o", str(tmp_path / "none" / "out.html")], "no such folder"),
                          (["-o", str(NILE)], "is an input"), (["-o", str(MODEL)], "is an input")):
        done = run.invoke(command_line.app, ["report", str(MODEL), str(NILE), *options])
        assert done.exit_code == 1 and said in done.output and done.output.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


# ------------------------------------------------------------------------------ the verdict


def judged(model: Model, z: np.ndarray) -> tuple[str, dict]:
    found = findings(Filter(model).run(z), z)
    return headline(found), {one.subject: one for one in found}


def test_data_of_the_model_fit_it():
    said = [judged(level(), simulate(level(), 300, seed)[1])[0] for seed in range(200)]
    assert sum("do not fit" in one for one in said) <= 3
    assert sum(one == "The data fit the model." for one in said) > 140


@pytest.mark.parametrize("truth, said", [
    (level(noise=8.0), "R"), (level(drift=8.0), "Q"), (level(noise=0.4, drift=0.1), "too large"),
])
def test_a_wrong_size_of_noise_is_found(truth, said):
    verdict, of = judged(level(), simulate(truth, 400, 3)[1])
    assert verdict.startswith("The data do not fit the model")
    assert of["NIS"].state == "bad" and said in of["NIS"].advice


def test_an_offset_a_gap_and_a_lag_are_found():
    z = simulate(level(), 400, 3)[1]
    _, of = judged(level(drift=0.001), z)
    assert of["Autocorrelation"].state == "bad" and "Q" in of["Autocorrelation"].advice
    drifting = z + 5.0 * np.arange(400)[:, None]
    assert judged(level(), drifting)[1]["Mean innovation"].state == "bad"
    z[100:300] = np.nan
    assert "50" in judged(level(), z)[1]["Missing"].said


IRREGULAR = np.array([0.0, 0.1, 0.2, 5.2, 5.3, 5.5])


@pytest.mark.parametrize("there, along, count, usual, longest", [
    ([1, 1, 1, 1, 1, 1], Across(IRREGULAR, "s", 0.1), 6, 0.1, 5.0),
    ([0, 1, 0, 1, 0, 0], Across(IRREGULAR, "s", 0.1), 2, 5.1, 5.1),
    ([0, 0, 0, 0, 1, 0], Across(IRREGULAR, "s", 0.1), 1, np.nan, 5.3),
    ([0, 0, 0, 0, 0, 0], Across(IRREGULAR, "s", 0.1), 0, np.nan, 5.5),
    ([1, 0, 0, 1, 0, 1], Across(np.arange(6.0)), 3, 2.5, 3.0)])
def test_how_often_a_sensor_spoke(there, along, count, usual, longest):
    made = spoken(np.array(there, bool), along)
    assert made.count == count and np.allclose([made.usual, made.longest], [usual, longest], equal_nan=True)


def test_a_slow_sensor_is_judged_from_measurement_to_measurement():
    """Its rows are never neighbours"""
    series = np.full(3000, np.nan)
    series[::30] = np.random.default_rng(3).standard_normal(100).cumsum()
    made = whiteness(series)
    assert made.count == 100 and made.correlation[0] > 0.8 and made.chance < 1e-6
    assert np.array_equal(made.correlation, whiteness(series[::30]).correlation)


@pytest.mark.parametrize("seed", range(3))
def test_buckets_are_as_wide_in_time(seed):
    at = np.cumsum(np.random.default_rng(seed).exponential(1.0, 5000))
    at[2000:] += 4000  # a pause
    values = np.sin(at)
    where, low, high, middle = envelope(values, Across(at, "s"), 100)
    assert not np.any((where > at[1999] + 100) & (where < at[2000] - 100)) and len(where) <= 100
    assert np.min(low) == np.min(values) and np.max(high) == np.max(values) and np.all((low <= values[middle]) & (values[middle] <= high))


def test_a_report_of_times_has_them_across(tmp_path):
    """Two sensors, one seldom; a gap of 60 s with no empty cell"""
    rows = [f"{t:.1f},{'' if k % 20 else 0.1},{0.01 * (k % 7)}" for k, t in enumerate([*np.arange(0, 40, 0.1), *np.arange(100, 140, 0.1)])]
    model, data, page = tmp_path / "two.toml", tmp_path / "two.csv", tmp_path / "page.html"
    data.write_text("time,slow,fast\n" + "\n".join(rows) + "\n")
    model.write_text("""[model]\nF = [[0.0]]\nQc = [0.01]\ndt = 0.1\nP0 = [1.0]\n[[sensors]]\nname = "slow"\nH = [1.0]\nR = 1.0
[[sensors]]\nname = "fast"\nH = [1.0]\nR = 0.01\n""")
    succeeds("report", model, data, "-o", page)
    text = page.read_text()
    assert ">time [s]<" in text and ">row<" not in text and ">140<" in text
    cells = [re.findall(r"<t[hd][^>]*>([^<]*)</t[hd]>", row) for row in re.findall(r"<tr>.*?</tr>", text, re.S)]
    assert ["slow", "40", "2 s", "62 s"] in cells and ["fast", "800", "0.1 s", "60.1 s"] in cells


def test_outliers_are_found():
    z = simulate(level(), 400, 3)[1]
    z[::40] += 30.0
    of = judged(level(), z)[1]
    assert "robust" in of["NIS"].advice


def test_figures_are_those_of_the_books():
    draw = np.random.default_rng(2)
    series = draw.normal(size=200)
    correlation, pairs = autocorrelation(series, 10)
    centred, T = series - series.mean(), 200
    wanted = np.array([centred[k:] @ centred[:-k] / (centred @ centred) for k in range(1, 11)])
    assert np.allclose(correlation * pairs / T, wanted, rtol=1e-12)
    from scipy.stats import binom, chi2

    statistic = T * (T + 2) * np.sum(wanted**2 / (T - np.arange(1, 11)))
    assert ljung_box(correlation, pairs, T) == pytest.approx(chi2.sf(statistic, 10), rel=1e-9)
    assert mean_bounds(50) == pytest.approx(tuple(chi2.ppf([0.025, 0.975], 50) / 50))
    assert share_bounds(100) == pytest.approx(tuple(binom.ppf([0.025, 0.975], 100, 0.05) / 100))


# ------------------------------------------------------------------------------ ranges that are too narrow


def narrow(tmp_path):
    """A track whose velocity goes beyond its range, and nothing else is wrong."""
    model = saved(tmp_path / "m.toml", "[model]\nA = [[1.0, 1.0], [0.0, 1.0]]\nH = [[1.0, 0.0]]\nG = [0.5, 1.0]\nR = [[1.0]]\nP0 = [100.0, 4.0]\n"
                                       '[states]\nnames = ["position", "velocity"]\nranges = [1e5, 6]\n[measurements]\nranges = [1e5]\n')
    x, z = simulate(model_file.read(model), 400, 3)
    data = saved(tmp_path / "z.csv", "z1\n" + "".join(f"{value}\n" for value in z[:, 0]))
    return model, data, float(np.abs(x[:, 1]).max())


@pytest.mark.usefixtures("no_offers")
def test_saturation_comes_first_with_the_range_that_would_do(tmp_path):
    model, data, most = narrow(tmp_path)
    out = tmp_path / "r.html"
    done = kalmanq("report", model, data, "-o", out, "--arith", "q31")
    assert done.returncode == 0 and done.stdout.startswith("A state saturated"), done.stdout
    page = out.read_text()
    assert not re.search("outliers|larger Q|larger R|an offset", page)
    found = re.search(r"give it a range of (\d+) for velocity, which reaches ([\d.]+) and declares 6\.", page)
    assert found and page.index(found.group()) < page.index("Autocorrelation"), page[:3000]
    model.write_text(model.read_text().replace("1e5, 6]", f"1e5, {found.group(1)}]"))
    done = kalmanq("report", model, data, "-o", out, "--arith", "q31")
    assert done.stdout.startswith("The data fit the model")
    assert 1.2 * most < float(found.group(1)) < 3 * most


def test_a_design_says_which_range_would_do(tmp_path):
    model, data, _ = narrow(tmp_path)
    done = kalmanq("design", model, "--core", "m3", "--data", data)
    found = re.search(r"q31 would do with a range of (\d+) for velocity, which reaches", " ".join(done.stdout.split()))
    assert done.returncode == 0 and found, done.stdout
    model.write_text(model.read_text().replace("1e5, 6]", f"1e5, {found.group(1)}]"))
    done = kalmanq("design", model, "--core", "m3", "--arith", "q31", "--data", data)
    assert "would do" not in done.stdout and "recommended: q31" in done.stdout
