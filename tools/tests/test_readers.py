"""Files that are no CSV text: GPX, NMEA, UBX, ULog, CAN logs, Parquet, Feather, Excel.  Each is made here, by its library or by hand."""

from __future__ import annotations

import functools
import json
import operator
import re
import struct
import sys
import warnings
from datetime import datetime, timedelta, timezone

import can
import cantools
import gpxpy
import gpxpy.gpx
import numpy as np
import pandas
import pymap3d
import pytest
import pyubx2
from command import kalmanq, refused, succeeds
from library import saved

from kalmanq import KalmanqWarning, Smoother
from kalmanq.data import joining
from kalmanq.data.layouts import Layout, Source
from kalmanq.data.readers import READERS
from kalmanq.model import model_file

PLACE = 47.5, 11.25, 600.0
BEGUN = datetime(2024, 5, 4, 23, 59, 40, tzinfo=timezone.utc)  # 2 seconds before a week of GPS ends
WALK = """
[model]
F = [[0, 1, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0], [0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 1], [0, 0, 0, 0, 0, 0]]
Qc = [0, 0.1, 0, 0.1, 0, 0.01]
dt = 1.0
H = [[1, 0, 0, 0, 0, 0], [0, 0, 1, 0, 0, 0], [0, 0, 0, 0, 1, 0]]
R = [9, 9, 25]
P0 = [100, 4, 100, 4, 100, 4]

[measurements]
names = ["east", "north", "up"]
units = ["m", "m", "m"]
"""
SIGNAL = '[model]\nF = [[0.0]]\nQc = [0.1]\ndt = 0.1\nH = [1.0]\nR = 0.04\nP0 = [4.0]\n\n[measurements]\nnames = ["{}"]\n'


def walk(seed: int, rows: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Seconds since BEGUN, over midnight, and degrees and height"""
    draw = np.random.default_rng(seed)
    seconds = np.cumsum(draw.integers(1, 4, rows)).astype(float)
    metres = np.cumsum(draw.normal(size=(rows, 3)), axis=0) + np.outer(seconds, [1, 2, 0.1])
    return seconds - seconds[0], np.column_stack(pymap3d.enu2geodetic(*metres.T, *PLACE))


def metres_of(degrees: np.ndarray) -> np.ndarray:
    return np.column_stack(pymap3d.geodetic2enu(*degrees.T, *degrees[0]))


def gpx(path, seconds, degrees):
    made = gpxpy.gpx.GPX()
    made.tracks.append(gpxpy.gpx.GPXTrack())
    made.tracks[0].segments.append(gpxpy.gpx.GPXTrackSegment())
    made.tracks[0].segments[0].points = [gpxpy.gpx.GPXTrackPoint(*map(float, place), time=BEGUN + timedelta(seconds=float(at)))
                                         for at, place in zip(seconds, degrees)]
    return saved(path, made.to_xml())


def sentence(text):
    return f"${text}*{functools.reduce(operator.xor, text.encode()):02X}\r\n"


def nmea(path, seconds, degrees):
    def angle(value, width, ends):
        return f"{int(abs(value)):0{width}}{abs(value) % 1 * 60:09.6f},{ends[int(value < 0)]}"

    lines = []
    for at, (latitude, longitude, height) in zip(seconds, degrees):
        now, place = BEGUN + timedelta(seconds=float(at)), f"{angle(latitude, 2, 'NS')},{angle(longitude, 3, 'EW')}"
        lines += [sentence(f"GPGGA,{now:%H%M%S}.00,{place},1,08,0.9,{height:.6f},M,47.0,M,,"),
                  sentence(f"GPRMC,{now:%H%M%S}.00,A,{place},1.0,90.0,{now:%d%m%y},,,A"), "$GPGSV,junk\r\n"]
    return saved(path, "".join(lines))


def ubx(path, seconds, degrees):
    made = b""
    for at, (latitude, longitude, height) in zip(seconds, degrees):
        now = BEGUN + timedelta(seconds=float(at))
        week = ((now.weekday() + 1) % 7 * 86400 + now.hour * 3600 + now.minute * 60 + now.second + 18) % 604_800 * 1000  # of GPS
        made += pyubx2.UBXMessage("NAV", "NAV-PVT", pyubx2.GET, iTOW=week, year=now.year, month=now.month, day=now.day, hour=now.hour, min=now.minute,
                                  second=now.second, validDate=1, validTime=1, nano=0, fixType=3, lat=latitude, lon=longitude,
                                  height=round(height * 1000), velN=500).serialize()
    return saved(path, made + b"\xb5\x62junk")


def ulog(path, seconds, degrees, form="double latitude_deg;double longitude_deg;double altitude_msl_m;", as_form=tuple, kind="ddd"):
    """Header, formats, subscriptions and data, of the definition of ULog"""
    def message(kind, body):
        return struct.pack("<HB", len(body), ord(kind)) + body

    made = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0) + message("B", bytes(40))
    made += message("F", b"sensor_gps:uint64_t timestamp;" + form.encode())
    made += message("F", b"noise:uint64_t timestamp;float level;")
    made += message("A", struct.pack("<BH", 0, 0) + b"sensor_gps") + message("A", struct.pack("<BH", 0, 1) + b"noise")
    for at, place in zip(seconds, degrees):
        made += message("D", struct.pack("<HQ" + kind, 0, 5_000_000 + round(1e6 * at), *as_form(place)))
        made += message("D", struct.pack("<HQf", 1, 5_100_000 + round(1e6 * at), 0.5))
    return saved(path, made)


def old_ulog(path, seconds, degrees):
    """Whole numbers of 1e-7 degrees and mm"""
    return ulog(path, seconds, degrees, "int32_t lat;int32_t lon;int32_t alt;", lambda place: [round(a * b) for a, b in zip(place, (1e7, 1e7, 1e3))], "iii")


def frame(seconds, degrees):
    at = pandas.to_datetime([BEGUN.replace(tzinfo=None) + timedelta(seconds=float(one)) for one in seconds])
    return pandas.DataFrame(degrees, columns=["Latitude", "Longitude", "Height"]).assign(time=at)


def excel(path, seconds, degrees):
    with pandas.ExcelWriter(path) as book:
        pandas.DataFrame([["A recording"]]).to_excel(book, sheet_name="About", header=False, index=False)
        frame(seconds, degrees).to_excel(book, sheet_name="Data", index=False, startrow=2)
    return path


def raw(path, seconds, degrees):
    """CSV of a receiver's whole numbers"""
    rows = "".join(f"{round(1000 * at)},{round(1e7 * a)},{round(1e7 * b)},{round(1e3 * c)}\n" for at, (a, b, c) in zip(seconds, degrees))
    return saved(path, "iTOW_ms,lat,lon,height [mm]\n" + rows)


MAKE = {"gpx": gpx, "nmea": nmea, "ubx": ubx, "ulg": ulog, "ulog": old_ulog, "xlsx": excel, "csv": raw,
        "parquet": lambda path, *given: (frame(*given).to_parquet(path), path)[1],
        "feather": lambda path, *given: (frame(*given).set_index("time").reset_index().to_feather(path), path)[1]}
WITHIN = {"ubx": 0.012, "ulog": 0.012, "csv": 0.012, "nmea": 0.002}  # metres; others have all digits


@pytest.mark.parametrize("suffix", MAKE)
@pytest.mark.parametrize("seed", [1, 2])
def test_a_track_is_metres_at_their_times(suffix, seed, tmp_path):
    seconds, degrees = walk(seed)
    path = MAKE[suffix](tmp_path / f"track.{suffix}", seconds, degrees)
    z, _, times = joining.record(Source(path), model_file.read(saved(tmp_path / "walk.toml", WALK)))
    assert np.allclose(times, seconds, atol=1e-6)
    assert np.abs(z - metres_of(degrees)).max() < WITHIN.get(suffix, 1e-5)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_smoothed_track_is_written_as_gpx(seed, tmp_path):
    seconds, degrees = walk(seed)
    path, model, out = gpx(tmp_path / "track.gpx", seconds, degrees), saved(tmp_path / "walk.toml", WALK), tmp_path / "smooth.gpx"
    done = kalmanq("run", model, path, "--smooth", "-o", out)
    assert done.returncode == 0 and not done.stderr, done.stderr
    right = Smoother(model_file.read(model)).run(metres_of(degrees), times=seconds).smoothed[:, ::2]
    points = gpxpy.parse(out.read_text()).tracks[0].segments[0].points
    made = np.array([[one.latitude, one.longitude, one.elevation] for one in points])
    assert np.abs(np.column_stack(pymap3d.geodetic2enu(*made.T, *degrees[0])) - right).max() < 1e-4
    assert [one.time for one in points] == [BEGUN + timedelta(seconds=one) for one in seconds]


@pytest.mark.parametrize("spoil, left, wrong", [
    (lambda data, size: data[:-20], 9, 1), (lambda data, size: data[:size - 1] + b"\x00" + data[size:], 9, 1),
    (lambda data, size: b"abc\xb5" + data[:3 * size] + b"\xb5b\x01\x07\xff\xff" + data[3 * size:], 10, 1),
    (lambda data, size: data[:size] + b"\xb5" + data[size:], 10, 0)], ids=["cut", "sum", "length", "sync"])
def test_a_message_that_is_broken_costs_no_other_one(spoil, left, wrong, tmp_path):
    """The next one begins where its signs say, and what is left out is told"""
    seconds, degrees = walk(1)
    data = ubx(tmp_path / "a.ubx", seconds[:10], degrees[:10]).read_bytes()[:-6]  # without the junk
    size = len(data) // 10
    (tmp_path / "b.ubx").write_bytes(spoil(data, size))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        z, _, _ = joining.record(Source(tmp_path / "b.ubx"), model_file.read(saved(tmp_path / "walk.toml", WALK)))
    assert len(z) == left and ("1 UBX messages are cut off" in str([one.message for one in told])) == bool(wrong)


def test_a_leap_second_is_of_the_second_before(tmp_path):
    lines = [sentence(f"GPRMC,{at},A,4730.00,N,01115.00,E,1.0,0.0,311216,,,A") for at in ("235959", "235960", "000000")]
    (tmp_path / "a.nmea").write_text("".join([*lines, " \r\n", "$GPGSV,junk\r\n"]))
    with pytest.warns(KalmanqWarning, match="a.nmea: 1 lines are no NMEA sentences"):
        z, _, times = joining.record(Source(tmp_path / "a.nmea"), model_file.read(saved(tmp_path / "walk.toml", WALK)))
    assert list(times) == [0, 1]


def test_a_track_has_what_is_known(tmp_path):
    """Of a start of which nothing is known: a place without a speed, a place without a height, no place"""
    model, data, out = tmp_path / "m.toml", tmp_path / "d.csv", tmp_path / "o.gpx"
    model.write_text("[model]\nA = [[1, 1, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\nQ = [0, 0.1, 0.1, 0.1]\n"
                     'H = [[1, 0, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\nR = [1, 1, 1]\nP0 = "unknown"\n[measurements]\nnames = ["east", "north", "up"]\n')
    data.write_text("latitude,longitude,height\n,,\n47,11,\n47,11,500\n")
    succeeds("run", model, data, "-o", out)
    points = gpxpy.parse(out.read_text()).tracks[0].segments[0].points
    assert [(round(one.latitude, 6), round(one.longitude, 6), one.elevation and round(one.elevation, 3)) for one in points] == [(47, 11, None), (47, 11, 500)]


def test_without_heights_the_track_stays_on_the_ground(tmp_path):
    """However far it goes: a plane would be 780 m off the ground in 100 km, and its points 12 m off"""
    from kalmanq.data.ground import degrees

    origin = (47.5, 11.25, 0.0)
    place = np.column_stack([np.linspace(46.5, 48.5, 9), np.linspace(10, 12.5, 9)])
    metres = np.column_stack(pymap3d.geodetic2enu(*place.T, 0.0, *origin))[:, :2]
    assert np.abs(degrees(metres, origin) - place).max() * 111e3 < 1e-3


def test_the_origin_may_be_said(tmp_path):
    seconds, degrees = walk(1)
    model = saved(tmp_path / "walk.toml", WALK + "\n[recording]\norigin = [47.5, 11.25, 600.0]\n")
    z, _, _ = joining.record(Source(gpx(tmp_path / "a.gpx", seconds, degrees)), model_file.read(model))
    assert np.abs(z - np.column_stack(pymap3d.geodetic2enu(*degrees.T, *PLACE))).max() < 1e-5
    assert model_file.text_of(model_file.read(model)).count("origin = [47.5, 11.25, 600.0]") == 1


DBC = 'VERSION ""\nNS_ :\nBS_:\nBU_: A\nBO_ 291 Wheel: 8 A\n SG_ Speed : 0|16@1+ (0.01,0) [0|600] "m/s" A\n SG_ Rate : 16|16@1- (0.1,0) [0|0] "" A\n'


def candump(path, times, speeds, database):
    lines = [f"({1.7e9 + at:.6f}) can0 123#{database.encode_message('Wheel', {'Speed': speed, 'Rate': -1.5}).hex().upper()}\n(1700000000.0) can0 7FF#00\n"
             for at, speed in zip(times, speeds)]
    return saved(path, "".join(lines))


def blf(path, times, speeds, database):
    with can.Logger(str(path)) as log:
        for at, speed in zip(times, speeds):
            log(can.Message(timestamp=1.7e9 + at, arbitration_id=291, is_extended_id=False,
                            data=database.encode_message("Wheel", {"Speed": speed, "Rate": -1.5})))
    return path


@pytest.mark.parametrize("suffix, make", [("log", candump), ("blf", blf), ("asc", blf)])
def test_signals_of_a_can_log(suffix, make, tmp_path):
    times, speeds = np.arange(20) * 0.1, np.round(np.random.default_rng(1).uniform(0, 50, 20), 2)
    saved(tmp_path / "car.dbc", DBC)
    path = make(tmp_path / f"drive.{suffix}", times, speeds, cantools.database.load_file(str(tmp_path / "car.dbc")))
    for name, database in (("Speed", "car.dbc"), ("Wheel.Speed", str(tmp_path / "car.dbc"))):
        model = saved(tmp_path / "m.toml", SIGNAL.format(name))
        z, _, at = joining.record(Source(path, Layout(database=database)), model_file.read(model))
        assert np.allclose(z[:, 0], speeds, atol=1e-9) and np.allclose(at, times, atol=1e-5)
    refused(kalmanq("run", model, path), "--database CAR.dbc")
    model = saved(tmp_path / "m.toml", SIGNAL.format("Speed") + '[recording]\ndatabase = "no.dbc"\n')
    assert "there is no database no.dbc here" in kalmanq("run", model, path).stderr


def test_topics_of_a_log_of_px4_keep_their_rows(tmp_path):
    seconds, degrees = walk(1, 10)
    path = ulog(tmp_path / "flight.ulg", seconds, degrees)
    for name in ("level", "noise.level"):
        z, _, times = joining.record(Source(path), model_file.read(saved(tmp_path / "m.toml", SIGNAL.format(name))))
        assert np.all(z == 0.5) and np.allclose(times, seconds - seconds[0])
    refused(kalmanq("run", saved(tmp_path / "m.toml", SIGNAL.format("nothing")), path), "noise.level")


def test_numbers_of_a_sheet_and_their_row(tmp_path):
    path = tmp_path / "a.xlsx"
    pandas.DataFrame({"t": [0, 0.1, 0.2], "y": [1.5, "x", 2]}).to_excel(path, index=False)
    refused(kalmanq("run", saved(tmp_path / "m.toml", SIGNAL.format("y")), path), "row 3, column y: 'x' is not a number")


def test_days_and_clocks_of_a_sheet_are_one_time(tmp_path):
    path, at = tmp_path / "a.xlsx", [datetime(2024, 3, 1, 23, 40), datetime(2024, 3, 1, 23, 50), datetime(2024, 3, 2)]
    pandas.DataFrame({"date": [one.replace(hour=0, minute=0) for one in at], "time": [one.time() for one in at], "y": [1, 2, 3]}).to_excel(path, index=False)
    _, _, times = joining.record(Source(path), model_file.read(saved(tmp_path / "m.toml", SIGNAL.format("y").replace("0.1\nH", "600.0\nH"))))
    assert times.tolist() == [0, 600, 1200]


# ------------------------------------------------------------------------------ files that are none

JUNK = np.random.default_rng(1).integers(0, 256, 20000, dtype=np.uint8).tobytes()
NONE = {  # a file's name, what it has, and what is said
    "bytes": ("a.csv", JUNK, "not text"), "bytes without 0": ("a.dat", JUNK.replace(b"\0", b"")[:4000], "not text"), "empty": ("a.csv", b"", "empty"),
    **{one.suffixes[0]: (f"a{one.suffixes[0]}", JUNK, f"is no {one.what} file|has no |NMEA|is a CAN log") for one in READERS},
    "a part of a book": ("a.xlsx", b"PK\x03\x04" + JUNK, "is no Excel file"), "KML": ("a.csv", b"<?xml version='1.0'?><kml></kml>", "XML"),
    "a part of a track": ("a.gpx", b"<?xml version='1.0'?><gpx><trk><trkseg><trkpt lat='1'", "is no GPX file"),
    "no points": ("a.gpx", b"<gpx></gpx>", "has no points"), "folder": ("folder.gpx", None, "is a folder"), "nothing": ("no.gpx", None, "no such file"),
}


@pytest.mark.parametrize("which", NONE)
def test_a_file_that_is_none_of_these_is_one_line(which, tmp_path):
    name, content, said = NONE[which]
    if content is not None:
        saved(tmp_path / name, content)
    (tmp_path / "folder.gpx").mkdir()
    done = kalmanq("run", saved(tmp_path / "walk.toml", WALK), tmp_path / name, "--out", tmp_path / "o.csv")
    assert done.returncode == 1 and done.stderr.count("\n") == 1 and len(done.stderr) < 600, done.stderr
    assert re.search(said, done.stderr) and name in done.stderr and not (tmp_path / "o.csv").exists(), done.stderr


def test_what_a_file_is_does_not_hang_on_its_name(tmp_path):
    seconds, degrees = walk(1)
    model = model_file.read(saved(tmp_path / "walk.toml", WALK))
    for suffix in ("gpx", "nmea", "ubx", "ulg", "xlsx", "parquet"):
        made = MAKE[suffix](tmp_path / f"a.{suffix}", seconds, degrees).rename(tmp_path / f"{suffix}.csv")
        assert np.abs(joining.record(Source(made), model)[0] - metres_of(degrees)).max() < 0.02


@pytest.mark.parametrize("suffix, library", [("gpx", "gpxpy"), ("ulg", "pyulog"), ("nmea", "pynmea2"), ("ubx", "pyubx2"), ("blf", "can"), ("gpx", "pymap3d"),
                                             ("xlsx", "openpyxl")])
def test_a_missing_library_is_one_line(suffix, library, tmp_path, monkeypatch):
    path = MAKE.get(suffix, lambda path, *_: saved(path, b"x"))(tmp_path / f"a.{suffix}", *walk(1))
    monkeypatch.setitem(sys.modules, library, None)
    for name in [name for name in sys.modules if name.startswith("kalmanq.data.readers.")]:
        monkeypatch.delitem(sys.modules, name)
    refused(kalmanq("run", saved(tmp_path / "walk.toml", WALK), path), (library, "kalmanq[logs]"))


@pytest.mark.parametrize("rows, said", [(["91,11", "92,11"], "row 2, column lat: 91 is no angle"), (["47,11", "x,11"], "row 3, column lat: 'x'"),
                                        (["47,11,", "47.1,11.1,"], "there is no column up")])
def test_what_is_no_place_is_one_line(rows, said, tmp_path):
    path = saved(tmp_path / "a.csv", "t,lat,lon\n" + "".join(f"{k},{row.rstrip(',')}\n" for k, row in enumerate(rows)))
    model = saved(tmp_path / "walk.toml", WALK if "up" in said else WALK.replace('"up"', '"t"'))
    refused(kalmanq("run", model, path, *(("--time", "none") if "up" not in said else ())), said)


def test_a_track_of_what_is_none_is_refused(tmp_path):
    data = saved(tmp_path / "a.csv", "t,east,north,up\n0,1,2,3\n1,2,3,4\n")
    for model, said in ((WALK, "have no latitude"), (WALK.replace('"east"', '"x"'), "named east and north")):
        refused(kalmanq("run", saved(tmp_path / "walk.toml", model), data, "-o", tmp_path / "o.gpx", "--rename", "east=east" if '"x"' not in model else "x=east"),
                said)
        assert not (tmp_path / "o.gpx").exists()


def test_noises_are_fitted_to_a_track(tmp_path):
    seconds, degrees = walk(3, 120)
    done = kalmanq("fit", saved(tmp_path / "walk.toml", WALK), gpx(tmp_path / "a.gpx", seconds, degrees), "--free", "R", "--r-form", "diagonal", "--json")
    assert json.loads(done.stdout)["R"][0][0] > 0
