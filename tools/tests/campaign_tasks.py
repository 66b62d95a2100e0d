"""What campaigns of tests do.  A module of its own: their worker processes import it, and nothing else of the tests."""

from __future__ import annotations

import os
import time

from kalmanq import KalmanqError


def third(task):
    return {"task": task, "third": task / 3, "nothing": float("nan")}


def refuses_five(task):
    if task == 5:
        raise KalmanqError("task 5: is too much")
    return task


def ends_its_process(task):
    os._exit(1) if task == 3 else time.sleep(0.01)


def is_short(task):
    time.sleep(0.004)
    return task
