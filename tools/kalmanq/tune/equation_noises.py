"""Noises of a nonlinear model: what of Q, G and R has a size, and its file with other sizes."""

from __future__ import annotations

import inspect
from typing import Any, Callable, Iterator, Sequence

import numpy as np

from kalmanq.errors import KalmanqError
from kalmanq.nonlinear import NonlinearModel
from kalmanq.nonlinear.calls import Given
from kalmanq.nonlinear.model import Sensor
from kalmanq.tune.noises import Noise, blocks, squared

HEAD = "\n\n# Noises, as kalmanq tune has set them\n"
Number = Callable[[int, float], float]  # of a noise and a factor: what is written


def noises_of(model: NonlinearModel) -> list[Noise]:
    made = [*_of_step(model), *(one for sensor in model.sensors for one in _of_sensor(model, sensor))]
    if not made:
        raise KalmanqError("all noises are 0: there is nothing to tune; give a Q, G or R that is not 0")
    return made


def _of_step(model: NonlinearModel) -> Iterator[Noise]:
    which = next((key for key in ("Q", "G") if key in model.given), "")
    if which:
        yield Noise(f"{which} x", 1.0, {}, "Q", hint="all states")
        return
    for key, value, part in blocks("Q", model.frame.Q):
        at = np.flatnonzero(np.diag(part))
        yield Noise(key, value, {"Q": part}, "Q", _unit([model.states[i] for i in at], key), ", ".join(model.states[i].name for i in at),
                    fit=key if model.G is None and " x" not in key else "")


def _of_sensor(model: NonlinearModel, sensor: Sensor) -> Iterator[Noise]:
    label, whole = f"R of {sensor.name}" if sensor.name else "R", np.zeros((model.m, model.m))
    names = model.measurements[sensor.rows] if isinstance(model.measurements, list) else list(model.measurements)[sensor.rows]
    if isinstance(model.noises.parts[sensor.name], Given):
        whole[sensor.rows, sensor.rows] = 1.0
        yield Noise(f"{label} x", 1.0, {"R": whole}, "R", hint=", ".join(one.name for one in names))
        return
    for key, value, part in blocks(label, np.asarray(model.noises.parts[sensor.name])):
        whole, at = np.zeros((model.m, model.m)), np.flatnonzero(np.diag(part))
        whole[sensor.rows, sensor.rows] = part
        yield Noise(key, value, {"R": whole}, "R", _unit([names[i] for i in at], key), ", ".join(names[i].name for i in at),
                    fit=key if len(model.sensors) == 1 and " x" not in key else "")


def _unit(whose: Sequence[Any], key: str) -> str:
    if len(whose) != 1 or " x" in key or not whose[0].unit:
        return ""
    return squared(whose[0].unit)


# ------------------------------------------------------------------------------ the file with other sizes


def text_of(source: str, model: NonlinearModel, noises: Sequence[Noise], number: Number, root: Number) -> str:
    """The file, and after it its noises.  number: factor times size; root: factor times the root of a size"""
    return source.rstrip("\n") + HEAD + "\n".join([*_step_lines(model, noises, number, root), *(
        line for sensor in model.sensors for line in _sensor_lines(model, sensor, noises, number))]) + "\n"


def _step_lines(model: NonlinearModel, noises: Sequence[Noise], number: Number, root: Number) -> list[str]:
    for key, factor in (("Q", number(0, 1.0)), ("G", root(0, 1.0))):
        if key in model.given:
            return _scaled(key, key, model.given[key].function, factor)
    if model.G is None:
        return [f"Q = {_matrix(model.frame.Q, noises, number)}"]
    G = np.array(model.G, float)
    for k, one in enumerate(noises):
        for i in np.flatnonzero(np.diag(one.parts["Q"])) if "Q" in one.parts else ():
            G[i] = [root(k, value) if value else 0.0 for value in model.G[i]]
    return [f"G = {G.tolist()}"]


def _sensor_lines(model: NonlinearModel, sensor: Sensor, noises: Sequence[Noise], number: Number) -> list[str]:
    given, name = model.noises.parts[sensor.name], sensor.name
    own = [(k, one.parts["R"][sensor.rows, sensor.rows]) for k, one in enumerate(noises) if "R" in one.parts and np.any(one.parts["R"][sensor.rows, sensor.rows])]
    put = f'sensors["{name}"] = (sensors["{name}"][0], {{}}, *sensors["{name}"][2:])'
    if isinstance(given, Given):
        made = _scaled(f"_R_{name}" if name else "R", f'sensors["{name}"][1]' if name else "R", given.function, number(own[0][0], 1.0))
        return [*made, *([put.format(f"_R_{name}")] if name else [])]
    text = _entries(np.asarray(given), own, number)
    return [put.format(text) if name else f"R = {text}"]


def _matrix(given: np.ndarray, noises: Sequence[Noise], number: Number) -> str:
    return _entries(given, [(k, one.parts["Q"]) for k, one in enumerate(noises) if "Q" in one.parts], number)


def _entries(given: np.ndarray, parts: Sequence[tuple[int, np.ndarray]], number: Number) -> str:
    made = np.array(given, float)
    for k, part in parts:
        for at in np.argwhere(part):
            made[tuple(at)] = number(k, float(part[tuple(at)]))
    return repr(made.tolist() if np.any(given != np.diag(np.diag(given))) else np.diag(made).tolist())


def _scaled(name: str, of: str, function: Any, factor: float) -> list[str]:
    """A function of that name that answers `factor` times what another one does"""
    arguments = ", ".join(inspect.signature(function).parameters)
    kept = f"_given_{name.lstrip('_')}"
    return ["import numpy as _numpy", f"{kept} = {of}", "", "", f"def {name}({arguments}):",
            f"    return {factor!r} * _numpy.asarray({kept}({arguments}))", "", ""]
