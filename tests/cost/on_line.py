"""What a sample costs with a fixed lag on a Cortex-M3 in q31, by the counter of tools/cost.py.

    on_line.py [WORKDIR [CORE ARITHMETIC N M LAG]]

Every phase of the lag's work in turn, at steady operation: the mean and the most, means alone and with
covariance.  At the default size the most is to be 3 times kq_step (tools/cost.csv) at most.
"""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tools" / "cost"))

import build  # noqa: E402
import table  # noqa: E402
from build import TARGET, Place  # noqa: E402
from commands import run  # noqa: E402
from cores import BY_NAME  # noqa: E402
from counted import Counted  # noqa: E402
from emulator import Emulator  # noqa: E402

LIMIT = 3.0
WARM = 30  # samples more than the lag

PROGRAM = """
#define KQ_COST_{t}
#include "library.h"
#define N {n}
#define M {m}
{model}
#include "library.inc"
KQ_LAG_{T}(past, N, M, {lag});
KQ_POINT_{T}(start, N, M);

static void sample(int t)
{{
    if (t >= 0) cost_region(4 * (unsigned)t, 0);
    need_ok(kq_lag_predict_{t}(&past, &SIZED(process), NULL));
    if (t >= 0) cost_region(4 * (unsigned)t + 1, 0);
    need_ok(SIZED(update)());
    if (t >= 0 && t < {phases}) cost_region(4 * (unsigned)t + 2, 0);
    if (t < {phases}) need_ok(kq_lag_smooth_{t}(&past, {lag}));
    else {{
        cost_region(4 * (unsigned)t + 3, 0);
        need_ok(kq_lag_smooth_states_{t}(&past, {lag}));
    }}
}}

int main(void)
{{
    need_ok(SIZED(begin)());
    need_ok(SIZED(update)());
    need_ok(kq_lag_attach_{t}(&past, &SIZED(filter)));
    for (int t = 0; t < {lag}; t++) need_ok(kq_lag_predict_{t}(&past, &SIZED(process), NULL));
    for (int t = 0; t < {warm}; t++) sample(-1);
    for (int t = 0; t < 2 * {phases}; t++) sample(t);
    need_ok(kq_point_attach_{t}(&start, &SIZED(filter)));
    need_ok(kq_point_predict_{t}(&start, &SIZED(process), NULL));
    need_ok(SIZED(update)());
    cost_region(10000, 0);
    need_ok(kq_point_predict_{t}(&start, &SIZED(process), NULL));
    need_ok(SIZED(update)());
    cost_region(10001, 0);
    need_ok(kq_point_smooth_{t}(&start));
    cost_end();
    return 0;
}}
"""


def phases(lag: int) -> int:
    """Samples until the lag's work begins anew, or twice as many."""
    return 2 * ((lag + 1) // 2)


def counted(work: Path, core: str, t: str, n: int, m: int, lag: int) -> dict[int, Counted]:
    place = Place(ROOT, work)
    folder = work / "program"
    folder.mkdir(parents=True)
    build.model_printer(place)
    build.library(place, (core, t, "O2"))
    model = run([str(place.model), t, str(n), str(m)])
    text = PROGRAM.format(
        t=t, T=t.upper(), n=n, m=m, lag=lag, model=model, warm=WARM, phases=phases(lag)
    )
    (folder / "program.c").write_text(text, encoding="utf-8")
    sources = (folder / "program.c", TARGET / "marks.c")
    own = [build.compiled(place, BY_NAME[core], "O2", s, folder / f"{s.stem}.o") for s in sources]
    library = sorted(build.library_folder(place, (core, t, "O2")).glob("*.o"))
    program = build.linked(BY_NAME[core], [*own, *library], folder / "program.elf")
    names = {10000: f"kq_point_predict_{t}", 10001: f"kq_point_smooth_{t}"}
    for sample in range(2 * phases(lag)):
        last = (2, "lag_smooth") if sample < phases(lag) else (3, "lag_smooth_states")
        for kind, name in ((0, "lag_predict"), (1, "update"), last):
            names[4 * sample + kind] = f"kq_{name}_{t}"
    return Emulator(BY_NAME[core], program).count(names)


def step_of(core: str, t: str, n: int, m: int) -> int:
    rows = table.read(ROOT / "tools" / "cost.csv").rows
    wanted = (core, t, n, m, "runtime", "O2", "step")
    return next(row.instructions for row in rows if row.key == wanted)


def main() -> int:
    core, t, n, m, lag = (*sys.argv[2:], *("m3", "q31", "2", "1", "10")[len(sys.argv[2:]) :])
    size = int(n), int(m), int(lag)
    work = Path(sys.argv[1] if len(sys.argv) > 1 else "build/on_line").resolve()
    if work.exists():
        run(["rm", "-r", str(work)])
    calls = counted(work, core, t, *size)
    step = step_of(core, t, size[0], size[1])
    print(f"{core} {t} n {n} m {m}, lag {lag}: kq_step {step}")
    worst = 0.0
    for title, kind, first in (("means", 3, phases(size[2])), ("covariance, too", 2, 0)):
        samples = [
            [calls[4 * s + k].instructions for k in (0, 1, kind)]
            for s in range(first, first + phases(size[2]))
        ]
        whole = [sum(sample) for sample in samples]
        mean, most = sum(whole) / len(whole), max(whole)
        print(
            f"  {title}: a sample {mean:.0f} ({mean / step:.2f}), most {most} ({most / step:.2f});"
            f" without kq_step {mean - step:.0f} ({mean / step - 1:.2f}),"
            f" most {most - step} ({most / step - 1:.2f})"
        )
        worst = max(worst, most / step)
    print(f"  fixed point: predict {calls[10000].instructions}, smooth {calls[10001].instructions}")
    stack = max(call.stack for call in calls.values())
    print(f"  stack {stack}")
    is_default = (core, t, n, m, lag) == ("m3", "q31", "2", "1", "10")
    return 1 if is_default and worst > LIMIT else 0


if __name__ == "__main__":
    sys.exit(main())
