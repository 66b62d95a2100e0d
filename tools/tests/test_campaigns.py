"""Campaigns: the same bits however they are run, interrupted and resumed; and simulate --runs, their first user."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import joblib
import numpy as np
import pytest
from typer.testing import CliRunner

from kalmanq import KalmanqError, Smoother, command_line
from kalmanq.model import model_file
from kalmanq.run import campaigns
from kalmanq.run.campaigns import CampaignInterrupted, journal_of, run_campaign
from kalmanq.run.diagnostics import nees
from kalmanq.run.monte_carlo import Study, one_run, summary
from kalmanq.run.simulation import simulate
from campaign_tasks import ends_its_process, refuses_five, third
from command import kalmanq, refused, succeeds
from library import EXAMPLES, saved
from models import cart
from test_commands import rows_of
from whole import first

TRACK, NILE = EXAMPLES / "track.toml", EXAMPLES / "nile.toml"
STUDY = ["-n", 200, "--runs", 24, "--seed", 8, "--smooth", "--arith", "q31"]
LONG = ["-n", 1500, "--runs", 40, "--seed", 7]
COMMAND = [sys.executable, "-m", "kalmanq.command_line", "simulate"]


def campaign(journal, function=third, tasks=range(20), **options):
    return list(run_campaign(function, tasks, **{"fingerprint": {"study": "thirds"}, "journal": journal, **options}))


def study(out, *options):
    succeeds("simulate", TRACK, *STUDY, "--out", out, *options)
    assert not journal_of(out).exists()
    return out.read_bytes()


# ------------------------------------------------------------------------------ any campaign


@pytest.mark.parametrize("workers", first(2, (1, 2, 3)))
def test_results_are_in_the_order_of_tasks(workers, tmp_path):
    made = campaign(tmp_path / "journal", workers=workers)
    assert [one["third"] for one in made] == [task / 3 for task in range(20)]
    assert all(np.isnan(one["nothing"]) for one in made)


def test_what_is_in_the_journal_is_not_done_again(tmp_path):
    journal, done = tmp_path / "journal", []
    first = campaign(journal, tasks=range(8), workers=1)
    again = campaign(journal, function=lambda task: done.append(task), tasks=range(10), workers=1)
    assert done == [8, 9] and json.dumps(again[:8]) == json.dumps(first)


def test_a_line_that_was_cut_off_is_done_again(tmp_path):
    journal = tmp_path / "journal"
    whole = campaign(journal, workers=1)
    complete = journal.read_bytes()
    journal.write_bytes(complete[:-9])
    assert json.dumps(campaign(journal, workers=1)) == json.dumps(whole)
    assert journal.read_bytes() == complete


def test_a_damaged_journal_is_refused(tmp_path):
    journal = tmp_path / "journal"
    campaign(journal, workers=1)
    journal.write_text(journal.read_text().replace("[3,", "[3;"))
    with pytest.raises(KalmanqError, match="journal: line 5 "):
        campaign(journal, workers=1)


def test_the_journal_of_another_campaign_is_refused_and_stays(tmp_path):
    journal = tmp_path / "out.csv.journal"
    campaign(journal, workers=1)
    before = journal.read_bytes()
    with pytest.raises(KalmanqError, match=r"out.csv.journal: .*'thirds', not 'other'"):
        campaign(journal, fingerprint={"study": "other"}, workers=1)
    assert journal.read_bytes() == before
    campaign(journal, fingerprint={"study": "other"}, workers=1, fresh=True)
    assert b"other" in journal.read_bytes()


@pytest.mark.parametrize("content", ["a,b\n1,2\n", "{}\n", "[1]\n", "precious"])
def test_a_file_that_is_no_journal_is_never_written(content, tmp_path):
    journal = saved(tmp_path / "journal", content)
    with pytest.raises(KalmanqError, match="journal: .*no journal"):
        campaign(journal, workers=1, fresh=True)
    assert journal.read_text() == content


@pytest.mark.parametrize("workers", [1, 2])
def test_what_a_task_refuses_ends_the_campaign_and_keeps_what_is_done(workers, tmp_path):
    journal = tmp_path / "journal"
    with pytest.raises(KalmanqError, match="task 5"):
        campaign(journal, function=refuses_five, workers=workers)
    kept = [json.loads(line) for line in journal.read_text().splitlines()[1:]]
    assert len(kept) >= 4 and all(task == result for task, result in kept)  # the other worker may have one of 0 .. 4


def test_a_worker_of_another_version_is_refused():
    _, made, refused = campaigns._perform(third, 7, 1, {"kalmanq": "0.0.0", "numpy": np.__version__})
    assert not made and "other versions" in refused
    number, made, refused = campaigns._perform(third, 7, 1, campaigns.versions())
    assert (number, json.loads(made)["task"], refused) == (7, 1, "")


def test_a_process_that_dies_is_told_in_one_line(tmp_path):
    with pytest.raises(KalmanqError, match="worker process"):
        campaign(tmp_path / "journal", function=ends_its_process, workers=2)


def test_an_interrupt_says_how_many_are_done(tmp_path):
    def interrupted_at_four(task):
        if task == 4:
            raise KeyboardInterrupt
        return task

    with pytest.raises(CampaignInterrupted, match="4 of 20"):
        campaign(tmp_path / "journal", function=interrupted_at_four, workers=1)
    assert len(campaign(tmp_path / "journal", workers=1)) == 20


def test_a_journal_is_written_by_one_campaign_at_a_time(tmp_path):
    pytest.importorskip("fcntl")
    first = run_campaign(third, range(3), fingerprint={}, journal=tmp_path / "journal", workers=1)
    next(first)
    with pytest.raises(KalmanqError, match="journal: another"):
        campaign(tmp_path / "journal", fingerprint={}, workers=1)


def test_progress_counts_what_was_done_before(tmp_path):
    told = []
    campaign(tmp_path / "journal", tasks=range(2), workers=1)
    campaign(tmp_path / "journal", tasks=range(4), workers=1, progress=lambda done, total: told.append((done, total)))
    assert told == [(2, 4), (3, 4), (4, 4)]


def test_the_pages_program_runs(tmp_path):
    page = (Path(__file__).parents[2] / "tools/docs/guides/many_runs.md").read_text(encoding="utf-8")
    program = page.split("```python squares.py\n")[1].split("```")[0]
    (tmp_path / "squares.py").write_text(program)
    done = subprocess.run([sys.executable, "squares.py"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0 and done.stderr == ""
    assert (tmp_path / "squares.txt").read_text().split() == [str(k * k) for k in range(1000)]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["squares.py", "squares.txt"]


# ------------------------------------------------------------------------------ simulate --runs


def test_any_number_of_workers_gives_the_same_bytes(tmp_path):
    one = study(tmp_path / "one.csv", "--workers", 1)
    assert one == study(tmp_path / "two.csv", "--workers", 2)
    assert len(one.splitlines()) == 25


def test_a_cluster_gives_the_same_bytes(tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None) as cluster:
        with distributed.Client(cluster), joblib.parallel_config(backend="dask"):
            by_dask = campaign(tmp_path / "dask")
            with pytest.raises(KalmanqError, match="task 5"):
                campaign(tmp_path / "refused", function=refuses_five)
    assert json.dumps(by_dask) == json.dumps(campaign(tmp_path / "one", workers=1))


@pytest.mark.parametrize("workers", ["1", "2"])
def test_interrupted_and_resumed_gives_the_same_bytes(workers, tmp_path):
    out, whole = tmp_path / "out.csv", tmp_path / "whole.csv"
    arguments = [*COMMAND, TRACK, *LONG, "--workers", workers, "--out"]
    running = subprocess.Popen([*map(str, arguments), str(out)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                               text=True, start_new_session=True)
    journal = journal_of(out)
    while running.poll() is None and not (journal.exists() and journal.read_bytes().count(b"\n") > 4):
        time.sleep(0.01)
    os.killpg(running.pid, signal.SIGINT)  # as a terminal does: to the workers, too
    printed, said = running.communicate()
    assert running.returncode == 130 and printed == ""
    done = journal.read_bytes().count(b"\n") - 1
    assert said == f"kalmanq: interrupted: {done} of 40 are done; the same command goes on from there\n"
    assert 4 <= done < 40 and [path.name for path in tmp_path.iterdir()] == ["out.csv.journal"]
    succeeds("simulate", TRACK, *LONG, "--workers", 2, "--out", out)
    succeeds("simulate", TRACK, *LONG, "--workers", 1, "--out", whole)
    assert out.read_bytes() == whole.read_bytes() and not journal.exists()


def test_an_interrupt_right_after_a_line_counts_it(tmp_path, monkeypatch):
    def added_then_interrupted(book, task, result):
        add(book, task, result)
        raise KeyboardInterrupt

    add = campaigns.Journal.add
    monkeypatch.setattr(campaigns.Journal, "add", added_then_interrupted)
    for done in (1, 2):
        with pytest.raises(CampaignInterrupted, match=f"{done} of 20"):
            campaign(tmp_path / "journal", workers=1)


def test_another_campaigns_journal_is_refused_by_name(tmp_path):
    out = tmp_path / "out.csv"
    campaign(journal_of(out), tasks=range(2), workers=1)
    command = ("simulate", NILE, "-n", 20, "--runs", 4, "--workers", 1, "--out", out)
    refused(kalmanq(*command), ("out.csv.journal: is of another campaign", "--fresh"))
    assert not out.exists()
    succeeds(*command, "--fresh")


def test_a_run_is_what_it_is_however_many_there_are(tmp_path):
    few, many = tmp_path / "few.csv", tmp_path / "many.csv"
    for out, runs in ((few, 3), (many, 6)):
        succeeds("simulate", NILE, "-n", 30, "--runs", runs, "--workers", 1, "--out", out)
    assert rows_of(few) == rows_of(many)[:3]
    assert len({row["loglik"] for row in rows_of(many)}) == 6


def test_a_row_is_what_a_smoother_says(tmp_path):
    model, rows = model_file.read(TRACK), 80
    row = one_run(Study(model, rows, 5, "f32", True, (10, 20)), 3)
    x, z = simulate(model, rows, np.random.SeedSequence(5, spawn_key=(3,)))
    z[10:20] = np.nan
    run = Smoother(model, "f32").run(z, covariance=True)
    assert row["vx_rmse"] == pytest.approx(np.sqrt(np.mean((run.mean - x)[:, 1] ** 2)), rel=1e-12)
    assert row["y_smoothed_rmse"] == pytest.approx(np.sqrt(np.mean((run.smoothed - x)[:, 2] ** 2)), rel=1e-12)
    errors = run.mean - x
    each = [e @ np.linalg.solve(P, e) for e, P in zip(errors, run.covariance)]
    assert row["nees"] == pytest.approx(np.mean(each) / 4, rel=1e-4)
    assert row["nis"] == pytest.approx(np.nansum(run.nis) / run.taken.sum(), rel=1e-12)
    assert row["loglik"] == pytest.approx(run.log_likelihood.sum(), rel=1e-12) and row["taken"] == 140


def test_one_run_is_drawn_as_before(tmp_path):
    done = kalmanq("simulate", NILE, "-n", 3, "--seed", 5)
    assert done.stdout.splitlines()[:2] == ["step,flow", "0,139.59511248750903"]


def test_the_right_model_is_within_its_bounds(tmp_path):
    done = kalmanq("simulate", TRACK, *STUDY, "--out", tmp_path / "out.csv", "--json")
    said = json.loads(done.stdout)
    assert said["nees"]["within"] and said["nis"]["within"]
    low, high = said["nis"]["bounds"]
    assert low < 1 < high and low < said["nis"]["mean"] < high
    rows = rows_of(tmp_path / "out.csv")
    values = [float(row["x_rmse"]) for row in rows]
    assert said["columns"]["x_rmse"]["mean"] == pytest.approx(np.mean(values))
    assert said["columns"]["x_rmse"]["standard_error"] == pytest.approx(np.std(values, ddof=1) / len(values) ** 0.5)
    assert list(rows[0])[:3] == ["run", "x_rmse", "x_smoothed_rmse"]
    assert list(rows[0])[-5:] == ["nees", "nis", "taken", "loglik", "events"]
    printed = kalmanq("simulate", TRACK, *STUDY, "--out", tmp_path / "again.csv").stdout
    assert "NEES" in printed and "within" in printed and "wrote" in printed


def test_bounds_hold_as_often_as_they_say():
    model, seeds = model_file.read(TRACK), range(40)
    said = []
    for seed in seeds:
        rows = [one_run(Study(model, 60, seed, "f64", False, None), run) for run in range(8)]
        said.append(summary({name: np.array([row[name] for row in rows], object) for name in rows[0]}))
    for name in ("nees", "nis"):
        assert sum(one[name]["within"] for one in said) >= 34
        assert abs(np.mean([one[name]["mean"] for one in said]) - 1) < 0.03


def test_nees_of_what_is_known_exactly_or_not_at_all():
    errors = np.array([[1.0, 0.0], [2.0, 5.0]])
    covariances = np.array([[[4.0, 0.0], [0.0, 0.0]], [[np.nan, 0.0], [0.0, 1.0]]])
    score, dimensions = nees(errors, covariances, "f64")
    assert score.tolist() == [0.25, 0.0] and dimensions.tolist() == [1, 0]
    scaled = np.diag([1e-9, 1e9])
    P = scaled @ np.array([[2.0, 1], [1, 2]]) @ scaled
    score, dimensions = nees((scaled @ [1.0, -1.0])[None], P[None], "f64")
    assert score[0] == pytest.approx(2.0) and dimensions[0] == 2


def test_odd_models(tmp_path):
    text = ("[model]\nA = [[1.0, 0.5], [0.0, 1.0]]\nB = [0.0, 0.5]\nH = [1.0, 0.0]\nG = [0.1, 0.2]\nR = 4.0\n"
            "P0 = 'unknown'\n[states]\nnames = ['a,b', 'c\"d']\n[controls]\nnames = ['push']\n")
    model, out = tmp_path / "odd.toml", tmp_path / "out.csv"
    model.write_text(text)
    for rows, runs in ((1, 3), (40, 1)):
        done = succeeds("simulate", model, "-n", rows, "--runs", runs, "--smooth", "--workers", 1, "--out", out)
        assert done.stderr == "" and len(rows_of(out)) == runs
    assert cart().l == 1 and one_run(Study(cart(), 50, 1, "q31", False, None), 0)["events"] == ""


@pytest.mark.parametrize("options, said", [
    (["--runs", "3"], "--runs: needs --out"),
    (["--runs", "3", "--truth", "--out", "out.csv"], "--truth: of one run alone"),
    (["--smooth"], "--smooth: goes with --runs"),
    (["--arith", "f64"], "--arith: goes with --runs"),
    (["--json", "--workers", "2"], "--workers, --json: go with --runs"),
    (["--runs", "3", "--dask", "tcp://one:1", "--out", "out.csv"], "--dask is gone"),
    (["--runs", "3", "--out", "none/out.csv"], "no such folder"),
    (["--runs", "3", "--workers", "1", "--out", "out.csv", "--arith", "q31"], "run 0: "),
])
def test_bad_options_are_one_line(options, said, tmp_path, monkeypatch):
    model = saved(tmp_path / "model.toml", NILE.read_text().replace("4000", "100"))
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(command_line.app, ["simulate", str(model), *options])
    assert done.exit_code == 1 and said in done.output and done.output.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["model.toml"]


def test_the_model_is_not_overwritten(tmp_path):
    model = saved(tmp_path / "model.toml", NILE.read_text())
    refused(kalmanq("simulate", model, "--runs", 2, "--out", model), "is an input", tmp_path)
    assert model.read_text() == NILE.read_text()


# ------------------------------------------------------------------------------ what is lost on the way


KILLED = """
import sys
from pathlib import Path
sys.path.insert(0, {here!r})
from campaign_tasks import is_short
from kalmanq.run.campaigns import run_campaign
if __name__ == "__main__":
    list(run_campaign(is_short, range(100000), fingerprint={{}}, journal=Path({journal!r}), workers=2))
"""


@pytest.mark.skipif(not os.path.isdir("/proc"), reason="looks for processes there")
@pytest.mark.parametrize("done", [0, 20])  # 0: a worker has begun, and has no task yet
def test_workers_end_with_a_campaign_that_is_killed(done, tmp_path):
    program, journal = tmp_path / "killed_campaign.py", tmp_path / "journal"
    program.write_text(KILLED.format(here=os.path.dirname(__file__), journal=str(journal)))
    running = subprocess.Popen([sys.executable, str(program)], start_new_session=True)

    def is_due():
        return journal.exists() and journal.read_bytes().count(b"\n") > done if done else len(of_session(running.pid)) > 3
    while running.poll() is None and not is_due():
        time.sleep(0.002)
    assert len(of_session(running.pid)) >= 3
    running.kill()
    running.wait()
    ends = time.monotonic() + 60
    while of_session(running.pid) and time.monotonic() < ends:
        time.sleep(0.05)
    assert of_session(running.pid) == []
    assert not done or len(journal.read_bytes().splitlines()) > done


def of_session(session):
    """Processes that are not over"""
    made = []
    for name in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{name}/stat", encoding="utf-8", errors="replace") as text:
                state, _, _, its_session = text.read().rpartition(")")[2].split()[:4]
        except OSError:
            continue
        if int(its_session) == session and state not in "ZX":
            made.append(int(name))
    return made
