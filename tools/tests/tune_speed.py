"""tune_speed.py [MODEL]: what a page of `kalmanq tune` takes in this machine's Chromium, at 1e3, 1e4 and 1e5 rows; of a nonlinear
model (MODEL.py) at most at as many as its smoother takes.

A redraw: from the change of a noise to the picture of it: filter, smoother and statistics of all rows, in f64."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import numpy as np
from browser import Browser

from kalmanq.commands.options import read_any
from kalmanq.firmware.steps_kept import MOST_STEPS
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.simulation import simulate
from kalmanq.run.simulation import drawn
from kalmanq.tune import page

REDRAWS = 25
MEASURE = """(async () => {
  const made = [];
  for (let k = 0; k < %d; k++) {
    delete document.body.dataset.took;
    setNoise(0, BEGIN.theta[0] * (1 + 0.01 * (k + 1)));
    while (filterRuns.busy || smoothRuns.busy || queued) await new Promise((done) => setTimeout(done, 2));
    made.push(Number(document.body.dataset.took));
  }
  return made;
})()"""


def main() -> None:
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else page.HERE.parent / "examples" / "track.toml"
    model = read_any(path)
    is_nonlinear = isinstance(model, NonlinearModel)
    print(f"{path.name}, n = {model.n}, m = {model.m}, f64; of {REDRAWS} redraws the least, the median and the most")
    with tempfile.TemporaryDirectory() as folder, Browser() as browser:
        for rows in (1000, 10_000, MOST_STEPS if is_nonlinear else 100_000):
            file = Path(folder) / "tune.html"
            z, u = simulate(model, rows, 1)[1:] if is_nonlinear else (drawn(model, rows, 1, None)[1], None)
            file.write_text(page.page(model, z, u, None, {"model": path.name, "data": ""}), encoding="utf-8")
            browser.open(file)
            browser.wait("document.body.dataset.took !== undefined")
            first = browser.run("document.body.dataset.took")
            ready = int(browser.run("document.body.dataset.ready")) + float(first)
            browser.wait("!filterRuns.busy && !smoothRuns.busy && !second.waiting.size")
            took = np.array(browser.run(MEASURE % REDRAWS))
            print(f"{rows:7d} rows: {file.stat().st_size / 1e6:.2f} MB, first picture after {ready:.0f} ms, "
                  f"redraw {took.min():.0f}, {np.median(took):.0f}, {took.max():.0f} ms")
            if browser.errors:
                sys.exit(str(browser.errors))


main()
