"""Tables as others write them: separators, decimals, letters, missing cells, units, pipes, and times."""

from __future__ import annotations

import os
import threading
import warnings

import numpy as np
import pytest

from kalmanq import KalmanqError, KalmanqWarning, Quantity
from kalmanq.data import tables
from command import kalmanq, refused, succeeds
from library import EXAMPLES, text_in
from test_commands import MODEL, NILE
from whole import first

FLOW = [1.5, np.nan, -2.25, 1000.0]
WANTED = [Quantity("pos", "m"), Quantity("speed")]


def columns(path, wanted=("flow",), **said):
    from kalmanq.data.layouts import Layout, Source

    made = tables.joined(list(tables.read(Source(path, Layout(**said)), wanted, 2)))
    return [made.columns[one if isinstance(one, str) else one.name].tolist() for one in wanted]


def same(made, wanted):
    return np.array_equal(np.array(made), np.array(wanted), equal_nan=True)


# ------------------------------------------------------------------------------ what a table tells by itself

WRITTEN = {
    "semicolons": "a;flow\nx;1.5\nx;\nx;-2.25\nx;1e3\n",
    "decimal commas": "a;flow\nx;1,5\nx;\nx;-2,25\nx;1e3\n",
    "tabs and decimal commas": "a\tflow\nx\t1,5\nx\t\nx\t-2,25\nx\t1,0e3\n",
    "quoted decimal commas": 'a,flow\nx,"1,5"\nx,\nx,"-2,25"\nx,1000\n',
    "words for nothing": "a,flow\nx,1.5\nx,NA\nx,-2.25\nx,1000\n",
    "other words": "flow\n1.5\n#N/A\n-2.25\n1000\n",
    "a unit": "a,flow [m3/s]\nx,1.5\nx,null\nx,-2.25\nx,1000\n",
    "a unit in parentheses": "a;flow (m3/s)\nx;1.5\nx;NaN\nx;-2.25\nx;1000\n",
    "a spreadsheet's line": "sep=;\na;flow\nx;1.5\nx;\nx;-2.25\nx;1000\n",
    "a comma in another name": "pos, raw;flow\nx;1.5\nx;\nx;-2.25\nx;1000\n",
    "a quoted name with a semicolon": '"a;b",flow\nx,1.5\nx,\nx,-2.25\nx,1000\n',
    "comments": "# a; b\n# c\na;flow\nx;1.5\nx;\nx;-2.25\nx;1000\n",
}


@pytest.mark.parametrize("which", WRITTEN)
def test_what_is_certain_is_found(which, tmp_path):
    assert same(columns(text_in(tmp_path, WRITTEN[which])), [FLOW])


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16", "utf-32"])
def test_letters_are_found(encoding, tmp_path):
    text = "# Abfluß der Würm\nFläche;Durchfluß [m³/s]\nä;1,5\nö;NA\nü;-2,25\nß;1000\n"
    assert same(columns(text_in(tmp_path, text.encode(encoding)), ["Durchfluß"]), [FLOW])


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
def test_letters_without_their_mark_are_refused(encoding, tmp_path):
    with pytest.raises(KalmanqError, match="UTF-8"):
        columns(text_in(tmp_path, "flow\n1.5\n".encode(encoding)))


def test_a_quoted_name_with_a_semicolon_is_a_name(tmp_path):
    assert columns(text_in(tmp_path, '"flow;1"\n2\n3\n'), ["flow;1"]) == [[2, 3]]
    with pytest.raises(KalmanqError, match="flow; .*flow;1"):
        columns(text_in(tmp_path, '"flow;1"\n2\n'))


UNCERTAIN = {  # and what is said
    "a;flow\nx;1,234\nx;2,345\n": "row 2, column flow: '1,234' .*--decimal ,",
    "a;flow\nx;1,5\nx;2.5\n": "row 2, column flow: '1,5' ",
    "a;flow\nx;1\nx;2\nx;1,5\n": "row 4, column flow: '1,5' .*--decimal ,",  # after the first block
    "a;flow\nx;1.234,5\nx;2.000,5\n": "'1.234,5' .*grouped",
    "flow\n1_000\n": "row 2, column flow: '1_000' ",
    "flow\n1\n2,5\n": "row 3: 2 .*--decimal ,",
    "flow\n1\n?\n": "row 3, column flow: '\\?' .*--missing",
    "1,2\n3,4\n": "row 1: .*header: 1, 2 .*flow",
    "time,x,1\n0,2,3\n": "flow; .*time, x, 1",
    "a,flow\n1,2\n3\n": "row 3: 1 .*2: fill",
    "a,flow\n1,2\n\n3,4\n": "row 3: an empty row: leave it out",
    "flow [m],flow [ft]\n1,2\n": "flow .*twice",
    "a,b;c\n1,2;3\n": "',' or ';' .*--separator",
    "\0\1\2\3": "text",
    '"a\nb",c\n1,2\n': "row 1: .*flow; .*a b, c",
    '# c\na,flow\n"x\ny",1\n"z,2\nw,3\n': "row 4: .*quote",
    '# c\n"a,flow\n1,2\n': "row 2: .*quote",
    '# c\nflow\n"1\n"\n\n"2' + "," * 131072: "row 5: .*131072.*quote",
}


@pytest.mark.parametrize("text", UNCERTAIN, ids=[text[:24] for text in UNCERTAIN])
def test_what_is_not_certain_is_refused_with_what_to_say(text, tmp_path):
    with pytest.raises(KalmanqError, match=UNCERTAIN[text]):
        columns(text_in(tmp_path, text))


def test_what_is_said_is_taken(tmp_path):
    assert columns(text_in(tmp_path, "a;flow\nx;1,234\nx;2,345\n"), decimal=",") == [[1.234, 2.345]]
    assert same(columns(text_in(tmp_path, "a|flow\nx|1.5\nx|?\nx|-9999.0\n"), separator="|", missing=("?", "-9999")),
                [[1.5, np.nan, np.nan]])
    assert columns(text_in(tmp_path, "flow\n1,5\n2\n"), decimal=",") == [[1.5, 2]]
    assert columns(text_in(tmp_path, "POS,v\n1,2\n"), ["x"], rename={"x": "POS"}) == [[1]]


def test_a_unit_that_is_another_one_is_refused(tmp_path):
    path = text_in(tmp_path, "pos [cm],speed [m/s]\n1,2\n")
    with pytest.raises(KalmanqError, match=r"row 1: pos \[cm\] .*cm, .*pos in m: convert"):
        columns(path, WANTED)
    assert columns(path, WANTED, rename={"pos": "pos [cm]"}) == [[1], [2]]
    assert columns(text_in(tmp_path, "pos [m],speed [m/s]\n1,2\n"), WANTED) == [[1], [2]]


@pytest.mark.parametrize("options, said", [
    (["--decimal", "x"], "--decimal: 'x' is neither"), (["--separator", "::"], "--separator: '::'"),
    (["--separator", ",", "--decimal", ","], "--decimal: ',' is --separator, too"),
    (["--rename", "flow"], "--rename: is not NAME=COLUMN"), (["--rename", "no=flow"], "--rename: there is no no"),
    (["--rename", "flow=a", "--rename", "flow=b"], "--rename: flow is there twice"),
])
def test_options_that_say_nothing_are_one_line(options, said, tmp_path):
    refused(kalmanq("run", MODEL, NILE, *options, "--out", tmp_path / "out.csv"), said, tmp_path)


@pytest.mark.usefixtures("no_offers")
def test_every_command_reads_alike(tmp_path):
    rows = NILE.read_text().splitlines()[5:]
    text = "Jahr;Q\n" + "".join(f"{row.split(',')[0]};{row.split(',')[1].replace('.', ',')}\n" for row in rows)
    data = text_in(tmp_path, text.replace(";1120", ";-9999"), "utf-16")
    out = tmp_path / "out"
    for command in (("run", MODEL, data), ("compare", MODEL, data), ("report", MODEL, data, "-o", f"{out}.html"),
                    ("fit", EXAMPLES / "nile_guess.toml", data, "--method", "em", "--iterations", 3),
                    ("design", MODEL, "--core", "m3", "--data", data)):
        done = kalmanq(*command, "--missing=-9999", "--rename", "flow=Q")
        assert done.returncode in (0, 3), done.stderr
    refused(kalmanq("check", EXAMPLES / "range_bearing.py", EXAMPLES / "range_bearing.csv", "--rename", "range=far"), "there is no column far")


# ------------------------------------------------------------------------------ ranges


@pytest.mark.usefixtures("no_offers")
@pytest.mark.parametrize("arithmetic", first(2, ["f32", "q31", "f64"]))
def test_a_value_beyond_its_range_is_told_in_every_arithmetic(arithmetic, tmp_path):
    """Fixed point has no word for it; floating point takes it, as the chip does, and says the same."""
    data = text_in(tmp_path, "flow\n1000\n-9999\n1000\n-9999\n")
    said = "data.csv: row 3: flow = -9999 is beyond its declared range of 4000: --missing -9999 if"
    for command in (("run", MODEL, data, "--out", tmp_path / "out.csv"), ("report", MODEL, data, "-o", tmp_path / "out.html")):
        done = kalmanq(*command, "--arith", arithmetic)
        if arithmetic == "q31":
            refused(done, said, tmp_path)
        else:
            assert done.returncode == 0 and said in done.stderr and "(and 1 more)" in done.stderr
        cured = kalmanq(*command, "--arith", arithmetic, "--missing", "-9999")
        assert cured.returncode == 0 and not cured.stderr
        for path in tmp_path.glob("out*"):
            path.unlink()


# ------------------------------------------------------------------------------ pipes


@pytest.mark.usefixtures("no_offers")
def test_the_standard_input_and_a_named_pipe_are_data(tmp_path):
    wanted, text = kalmanq("run", MODEL, NILE, "--json").stdout, NILE.read_text()
    assert kalmanq("run", MODEL, "-", "--json", input=text).stdout == wanted
    assert kalmanq("run", MODEL, "-", "--smooth", "--json", input=text).stdout == wanted
    pipe = tmp_path / "pipe"
    for command in (("run", MODEL, pipe, "--json"), ("compare", MODEL, pipe, "--json"),
                    ("report", MODEL, pipe, "-o", tmp_path / "r.html")):
        os.mkfifo(pipe)
        writer = threading.Thread(target=pipe.write_text, args=(text,))
        writer.start()
        done = succeeds(*command)
        writer.join()
        pipe.unlink()
        assert command[0] != "run" or done.stdout == wanted
    done = kalmanq("run", MODEL, "-", input="flow\n1\nx\n")
    assert done.returncode == 1 and done.stderr.startswith("kalmanq: standard input: row 3, column flow")
    model, data = EXAMPLES / "range_bearing.py", EXAMPLES / "range_bearing.csv"
    assert kalmanq("compare", model, "-", "--json", input=data.read_text()).stdout == kalmanq(
        "compare", model, data, "--json").stdout


# ------------------------------------------------------------------------------ times


def timed(tmp_path, times, name="time [s]", blocks=65536):
    text = f"{name},flow\n" + "".join(f"{time},{k}\n" for k, time in enumerate(times))
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        list(tables.read(text_in(tmp_path, text), ["flow"], blocks))
    assert all(one.category is KalmanqWarning for one in told)
    return [str(one.message) for one in told]


def months(count):
    return [f"{1990 + k // 12}-{k % 12 + 1:02}-01" for k in range(count)]


REGULAR = {
    "numbers": np.arange(50) * 0.1, "rounded": np.round(np.arange(50) * 0.033, 2), "years": range(1900, 1950),
    "months": months(60), "months alone": [day[:7] for day in months(60)], "with a gap in the column": [0, 1, "", 3, 4, "NA", 6],
    "clocks that begin anew": ["23:59:58", "23:59:59", "00:00:00", "00:00:01"] + [f"00:00:{k:02}" for k in range(2, 58)] * 2,
    "no times": ["a", "b", "c"], "one day": ["2020-01-01"] * 20, "a temperature": [20.1, 20.0, 19.9, 20.3, 20.2],
    "instants": [f"2020-01-01T00:{k:02}:00Z" for k in range(50)], "one row": [3.0], "none": [""] * 5,
}


@pytest.mark.parametrize("blocks", [7, 65536])
@pytest.mark.parametrize("which", REGULAR)
def test_regular_times_are_not_warned_of(which, blocks, tmp_path):
    assert timed(tmp_path, REGULAR[which], blocks=blocks) == []


IRREGULAR = {
    "a row left out": [0, 1, 2, 3, 4, 5, 6, 8, 9], "instants": ["2020-01-01", "2020-01-02", "2020-01-03", "2020-01-04",
                                                               "2020-01-05", "2020-01-06", "2020-01-07", "2020-01-20"],
    "twice": [0, 1, 2, 3, 4, 5, 6, 6, 7], "clocks": [f"10:00:{k:02}" for k in (0, 1, 2, 3, 4, 5, 6, 9)],
}


@pytest.mark.parametrize("blocks", [3, 65536])
@pytest.mark.parametrize("which", IRREGULAR)
def test_irregular_times_are_warned_of(which, blocks, tmp_path):
    for name in ("time", "t [s]", "timestamp", "Date", "utc time"):
        said = timed(tmp_path, IRREGULAR[which], name, blocks)
        assert len(said) == 1 and ": row 9: the times of column" in said[0] and "are irregular, steps are" in said[0]
    assert timed(tmp_path, IRREGULAR[which], "speed") == []


@pytest.mark.usefixtures("no_offers")
def test_irregular_times_are_one_line_of_every_command(tmp_path):
    draw = np.random.default_rng(1)
    text = "time,flow\n" + "".join(f"{time},{1000 + k}\n" for k, time in enumerate(np.cumsum(draw.exponential(1.0, 40))))
    data = text_in(tmp_path, text)
    for command in (("run", MODEL, data), ("compare", MODEL, data), ("report", MODEL, data, "-o", tmp_path / "r.html")):
        done = kalmanq(*command)
        assert done.returncode == 0 and done.stderr.count("times of column") == 1 == done.stderr.count("\n"), done.stderr


def test_a_model_that_takes_the_steps_knows_of_them(tmp_path):
    path = text_in(tmp_path, "time,dt,flow\n0,1,1\n1,7,1\n8,1,1\n9,1,1\n")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        list(tables.read(path, ["flow", "dt"]))
