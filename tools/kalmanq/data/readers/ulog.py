"""ULog of PX4: a row for each message of the topics that are wanted, in the order of time; columns TOPIC.FIELD, of further instances TOPIC_1.FIELD."""

from __future__ import annotations

from typing import Collection, Iterator

import numpy as np
import pyulog

from kalmanq.data.layouts import Source
from kalmanq.data.readers import Cells, Recorded, number

FIRST = ("vehicle_gps_position", "sensor_gps", "vehicle_gnss")  # whose latitude is a measurement, not an estimate
CLOCK = "timestamp"
WHOLE = {"lat": 1e-7, "lon": 1e-7, "alt": 1e-3, "alt_ellipsoid": 1e-3}  # degrees and metres, where they are whole numbers


def opened(source: Source) -> Recorded:
    topics = sorted(pyulog.ULog(str(source.path)).data_list, key=lambda one: (one.name not in FIRST, one.name, one.multi_id))
    columns = [(topic, field) for topic in topics for field in sorted(topic.data) if field != CLOCK]
    header = ["time [us]", *(f"{topic.name}{f'_{topic.multi_id}' if topic.multi_id else ''}.{field}" for topic, field in columns)]

    def rows(places: Collection[int]) -> Iterator[Cells]:
        wanted = [place for place in sorted(places) if place]
        there = [topic for topic in topics if any(columns[place - 1][0] is topic for place in wanted)]
        times = np.concatenate([topic.data[CLOCK].astype(np.int64) for topic in there] or [np.zeros(0, np.int64)])
        of = np.repeat(np.arange(len(there)), [len(topic.data[CLOCK]) for topic in there])
        within = np.concatenate([np.arange(len(topic.data[CLOCK])) for topic in there] or [np.zeros(0, int)])
        for k in np.argsort(times, kind="stable"):
            row = Cells({0: str(times[k])})
            for place in wanted:
                topic, field = columns[place - 1]
                if topic is there[of[k]]:
                    value = topic.data[field][within[k]]
                    row[place] = number(value * WHOLE.get(field, 1.0) if topic.data[field].dtype.kind == "i" else value)
            yield row

    return Recorded(source, header, rows)
