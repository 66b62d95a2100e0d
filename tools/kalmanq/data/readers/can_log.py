"""CAN logs (candump, ASC, BLF, TRC): a row for each frame that a database (DBC, KCD, ARXML) decodes; columns MESSAGE.SIGNAL [UNIT]."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Collection, Iterator

import can
import cantools
from can.io.canutils import CanutilsLogReader

from kalmanq.data.layouts import Source, TableError
from kalmanq.data.readers import Cells, Recorded, number

SUFFIXES = (".asc", ".blf", ".trc")


def opened(source: Source) -> Recorded:
    database = _database(source)
    columns = [(message, signal) for message in database.messages for signal in message.signals]
    header = ["time [s]", *(f"{message.name}.{signal.name}{f' [{signal.unit}]' if signal.unit else ''}" for message, signal in columns)]

    def rows(places: Collection[int]) -> Iterator[Cells]:
        wanted: dict[int, dict[str, int]] = {}
        for place in filter(None, places):
            message, signal = columns[place - 1]
            wanted.setdefault(message.frame_id, {})[signal.name] = place
        known = {message.frame_id: message for message, _ in columns}
        with _frames(source.path) as frames:
            for frame in frames:
                if frame.arbitration_id in wanted and not frame.is_error_frame and not frame.is_remote_frame:
                    row = Cells({0: f"{frame.timestamp:.6f}"})
                    said = known[frame.arbitration_id].decode(frame.data, decode_choices=False, allow_truncated=True)
                    for name, place in wanted[frame.arbitration_id].items():
                        row[place] = number(said.get(name))
                    yield row

    return Recorded(source, header, rows)


def _frames(path: Path) -> Any:
    return can.LogReader(str(path)) if path.suffix.lower() in SUFFIXES else CanutilsLogReader(str(path))


def _database(source: Source) -> Any:
    given = source.layout.database
    if not given:
        raise TableError(source, "is a CAN log: --database CAR.dbc, or database in [recording] of the model file, has its signals")
    path = next((one for one in (Path(given), source.path.parent / given) if one.is_file()), None)
    if path is None:
        raise TableError(source, f"there is no database {given} here, nor beside the log")
    return cantools.database.load_file(str(path))
