"""compiled_random.py COUNT: random models, each compiled and within its promise, or refused with a reason.

What is compiled has been run beside an exact filter over 2000 rows with gaps; its own test passes.
"""

from __future__ import annotations

import collections
import re
import sys
import tempfile
from pathlib import Path

from compiled import Compiled
from compiled_models import random_model

from kalmanq.errors import KalmanqError

PROMISED = 1e-3  # sigma, of a mean
REASONS = ("not observable", "not stabilisable", "to settle", "covariances", "sigma_i sigma_j", "positive definite",
           "a mean is", "words of 32 bits", "worth in the word", "too far for")


def reason_of(said: str) -> str:
    found = [reason for reason in REASONS if reason in said]
    if not found:
        raise SystemExit(f"refused without a reason: {said}")
    return found[0]


def main() -> None:
    count = int(sys.argv[1])
    for arithmetic in ("f32", "q31"):
        refused: collections.Counter[str] = collections.Counter()
        forms: collections.Counter[str] = collections.Counter()
        worst = 0.0
        for seed in range(count):
            model = random_model(seed, arithmetic == "q31")
            with tempfile.TemporaryDirectory() as folder:
                try:
                    made = Compiled(model, Path(folder), arithmetic)
                except KalmanqError as problem:
                    refused[reason_of(re.sub(r"\s+", " ", str(problem)))] += 1
                    continue
                forms[made.product.plan.form.name] += 1
                if made.program().returncode:
                    raise SystemExit(f"seed {seed} in {arithmetic}: its own test fails")
                worst = max(worst, made.product.proof.track.worst)
        print(f"{arithmetic}: {sum(forms.values())} compiled {dict(forms)}, means within {worst:.1e} sigma; "
              f"{sum(refused.values())} refused: {dict(refused)}", flush=True)
        if worst > PROMISED:
            raise SystemExit("a mean is beyond what is promised")


if __name__ == "__main__":
    main()
