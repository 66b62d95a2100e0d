#!/usr/bin/env python3
"""Draws the recordings of the examples, all of them simulated, from their seeds: data.py [NAME...]

A recording is NAME/data.csv: what the sensors say in each row, and what is true as NAME_true.  attitude's is drawn by
`kalmanq simulate`, --kalmanq COMMAND says how to call it; battery's is tools/kalmanq/examples/battery.csv.
"""
from __future__ import annotations

import argparse
import shlex
import tempfile
from pathlib import Path
from typing import Callable, Sequence

import numpy as np

from texts import BoardError, run, table

HERE = Path(__file__).resolve().parent
Columns = dict[str, np.ndarray]


def adc(draws: np.random.Generator) -> Columns:
    """A light sensor under clouds: a level that wanders, 60 mV of noise, as an ADC of 10 bits and 5 V reads it"""
    true = 2500 + np.cumsum(12 * draws.standard_normal(200))
    millivolts = np.round(true + 60 * draws.standard_normal(len(true))).astype(int)
    return {"millivolts": millivolts, "count": millivolts * 1023 // 5000, "level_true": true * 1023 / 5000 - 0.5}


def altitude(draws: np.random.Generator) -> Columns:
    """A drone climbs, waits and comes down; every 12th barometer value or so is off by some metres (a gust, the sun)"""
    dt, count = 0.02, 800
    climb = np.interp(np.arange(count) * dt, [0, 2, 4, 7, 9, 11, 13, 15, 16], [0, 0, 4, 4, 0, 0, -5, -5, 0])
    acceleration = np.append(np.diff(climb), 0) / dt
    height = np.concatenate([[0], np.cumsum((climb[1:] + climb[:-1]) / 2 * dt)])
    barometer = height + 0.5 * draws.standard_normal(count)
    wild = draws.random(count) < 0.08
    barometer += wild * draws.choice([-1, 1], count) * draws.uniform(6, 15, count)
    barometer[np.arange(count) % 5 != 0] = np.nan
    sensed = acceleration + 0.3 + 0.15 * draws.standard_normal(count)
    return {"barometer": barometer, "acceleration": sensed, "altitude_true": height, "climb_true": climb}


def wheel(draws: np.random.Generator) -> Columns:
    """A start, a stop and a start; the sensor loses its signal for 4 to 25 rows, and single rows"""
    dt, count = 0.02, 400
    true = np.interp(np.arange(count) * dt, [0, 1, 3, 4, 5.2, 6, 8], [0, 0, 14, 15, 5, 5, 12])
    seen = true + 0.2 * draws.standard_normal(count)
    seen[draws.random(count) < 0.05] = np.nan
    for first in (70, 130, 215, 245, 330):
        seen[first:first + int(draws.integers(4, 26))] = np.nan
    return {"wheel": seen, "speed_true": true}


def rocket(draws: np.random.Generator) -> Columns:
    """2 s of motor, air, a parachute from a second after the highest point on, up to the ground; 10 rows a second"""
    dt, fine, count = 0.1, 100, 348
    height, speed, falls, rows = 0.0, 0.0, 0.0, []
    for k in range(count * fine):
        t = k * dt / fine
        thrust = np.interp(t, [1.0, 1.2, 2.7, 3.0], [0, 90, 70, 0])
        a = thrust - 9.81 - (0.02 if falls > 1 else 0.0012) * speed * abs(speed)
        if height <= 0 and a <= 0:
            a = speed = height = 0.0
        if k % fine == 0:
            rows.append((height, speed, a))
        speed += a * dt / fine
        height += speed * dt / fine
        falls += dt / fine if speed < 0 else 0
    height, speed, a = np.array(rows).T
    return {"barometer": height + 3 * draws.standard_normal(count), "accelerometer": a + draws.standard_normal(count),
            "altitude_true": height, "speed_true": speed}


def room(draws: np.random.Generator) -> Columns:
    """Four days and the one that is forecast: a wave of a day, heating from 6 to 21 h, a slow change of the weather"""
    hours = np.arange(5 * 96) / 4
    weather = np.cumsum(0.02 * draws.standard_normal(len(hours)))
    heating = np.where((hours % 24 > 6) & (hours % 24 < 21), 1.0, 0.0)
    warm = np.convolve(np.concatenate([np.full(96, heating[:96].mean()), heating]), np.exp(-np.arange(96) / 12), "full")[96:96 + len(hours)] / 12
    true = 18.5 + weather + 2.0 * warm + 1.2 * np.sin(2 * np.pi * (hours - 9) / 24)
    seen = true + 0.1 * draws.standard_normal(len(hours))
    seen[4 * 96:] = np.nan
    return {"thermometer": np.round(seen, 2), "temperature_true": true}


def gps(draws: np.random.Generator) -> Columns:
    """15 s of driving with braking; a GPS of 1 m once a second, whose row is the one that it comes in: 15 rows late"""
    dt, count, late = 0.02, 750, 15
    speed = np.interp(np.arange(count) * dt, [0, 3, 6, 8, 10, 15], [10, 20, 20, 6, 6, 22])
    position = 2 + np.concatenate([[0], np.cumsum((speed[1:] + speed[:-1]) / 2 * dt)])
    measured = np.full(count, np.nan)
    for row in range(late, count, 50):
        measured[row] = position[row - late] + draws.standard_normal()
    return {"wheel": speed + 0.3 * draws.standard_normal(count), "gps": measured, "position_true": position, "speed_true": speed}


def attitude(kalmanq: Sequence[str]) -> Columns:
    """A body that turns, by its model; the accelerometer and the magnetometer say something in each tenth row"""
    with tempfile.TemporaryDirectory(prefix="kalmanq-boards-") as folder:
        out = Path(folder) / "simulated.csv"
        model = HERE.parents[1] / "kalmanq/examples/attitude.py"
        run([*kalmanq, "simulate", str(model), "-n", "300", "--seed", "1", "--truth", "--out", str(out)])
        columns = {name: values[:250] for name, values in table(out).items() if name != "step" and not name.startswith("bias")}
    for name in columns:
        if name.startswith(("up", "north")):
            columns[name][np.arange(250) % 10 != 0] = np.nan
    return columns


ALL: dict[str, tuple[Callable[[np.random.Generator], Columns], int]] = {
    "adc": (adc, 29), "altitude": (altitude, 2), "wheel": (wheel, 3), "rocket": (rocket, 4), "room": (room, 5), "gps": (gps, 6)}
NAMES = (*ALL, "attitude")


def text_of(columns: Columns) -> str:
    rows = [",".join("" if np.isnan(one) else f"{one:.5g}" for one in row) for row in zip(*columns.values())]
    return "\n".join([",".join(columns), *rows, ""])


def drawn(name: str, kalmanq: Sequence[str]) -> str:
    """data.csv"""
    if name not in NAMES:
        raise BoardError(f"{name}: has no recording to draw; there are {', '.join(NAMES)}")
    if name == "attitude":
        return text_of(attitude(kalmanq))
    make, seed = ALL[name]
    return text_of(make(np.random.default_rng(seed)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", metavar="NAME")
    parser.add_argument("--kalmanq", default="kalmanq")
    given = parser.parse_args()
    try:
        for name in given.names or NAMES:
            (HERE / name / "data.csv").write_text(drawn(name, shlex.split(given.kalmanq)), encoding="utf-8")
    except BoardError as problem:
        raise SystemExit(f"data: {problem}") from None


if __name__ == "__main__":
    main()
