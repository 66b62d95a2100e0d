"""C of a filter over the library that works out its last steps again, where a measurement comes late."""

from __future__ import annotations

from dataclasses import dataclass
from string import Template

from kalmanq.core import arithmetic_of, ffi


@dataclass(frozen=True)
class Replay:
    """moves: arguments of a predict, as a function declares them (", const float u[1]"); counts: of these how many controls;
    has_steps: and a number of steps"""

    name: str
    T: str
    n: int
    m: int
    counts: int
    has_steps: bool
    kept: int

    @property
    def word(self) -> str:
        return {"f32": "float", "f64": "double", "q31": "int32_t"}[self.T]

    @property
    def ram(self) -> int:
        """Bytes, at most: the filter and the steps"""
        size = 8 if self.T == "f64" else 4
        step = size * (self.counts + self.m + 1) + 4 * self.has_steps
        return size * arithmetic_of(self.T).length("filter", self.n) + ffi.sizeof(f"kq_filter_{self.T}") + self.kept * step + 8

    def objects(self) -> list[str]:
        return self._filled(OBJECTS)

    def start(self) -> list[str]:
        """Calls of an init, each a status; the last one begins the steps"""
        return [f"kq_filter_copy_{self.T}(&model_before, &model_filter)"]

    def functions(self) -> list[str]:
        return self._filled(FUNCTIONS)

    def predict(self) -> list[str]:
        """The body of NAME_predict"""
        return self._filled(PREDICT)

    def _filled(self, text: Template) -> list[str]:
        given = [*(["u"] if self.counts else []), *(["steps"] if self.has_steps else [])]
        keeps = [*(f"    model_steps[k].u[{i}] = u[{i}];\n" for i in range(self.counts)),
                 *(["    model_steps[k].steps = steps;\n"] if self.has_steps else [])]
        return text.substitute(
            T=self.T, upper_T=self.T.upper(), n=self.n, m=self.m, word=self.word, kept=self.kept, bit=1 << self.m, all=(1 << self.m) - 1,
            controls=f"    {self.word} u[{self.counts}];\n" if self.counts else "", steps="    uint32_t steps;\n" if self.has_steps else "",
            given="".join(f", {one}" for one in given), again="".join(f", model_steps[k].{one}" for one in given),
            keeps="".join(keeps)).split("\n")


OBJECTS = Template("""\
/* The last $kept steps, and the filter before them: a measurement that comes late is worked out with them again */
KQ_FILTER_$upper_T(model_before, $n);
static struct {
$controls$steps    $word z[$m];
    uint32_t present; /* bits of z; $bit: it began with a predict */
} model_steps[$kept];
static unsigned model_count, model_newest;""")

FUNCTIONS = Template("""\
/* Step k again */
static kq_status again(kq_filter_$T *f, unsigned k)
{
    const uint32_t present = model_steps[k].present & UINT32_C($all);
    kq_status status = KQ_OK;
    if (model_steps[k].present & UINT32_C($bit)) status = predict(f$again);
    return status || !present ? status : update(f, model_steps[k].z, present);
}

/* All steps again, from the filter before them; its events are those that it had, and theirs */
static kq_status all_again(void)
{
    const uint16_t events = model_filter.events;
    unsigned k = model_newest + 1u >= model_count ? model_newest + 1u - model_count : model_newest + 1u + ${kept}u - model_count;
    kq_status status = kq_filter_copy_$T(&model_filter, &model_before);
    for (unsigned step = 0; step < model_count && !status; step++) {
        status = again(&model_filter, k);
        k = k + 1u < ${kept}u ? k + 1u : 0;
    }
    model_filter.events |= events;
    return status;
}

/* Into the step that was so many predicts ago; where it is refused nothing has changed */
static kq_status take(const $word z[$m], uint32_t present, size_t ago)
{
    if (ago >= model_count || present > UINT32_C($all)) return KQ_ERR_SIZE;
    const unsigned k = model_newest >= ago ? model_newest - (unsigned)ago : model_newest + ${kept}u - (unsigned)ago;
    if (model_steps[k].present & present) return KQ_ERR_HISTORY_FULL;
    for (unsigned j = 0; j < ${m}u; j++)
        if (present >> j & 1u) model_steps[k].z[j] = z[j];
    model_steps[k].present |= present;
    const kq_status status = ago ? all_again() : update(&model_filter, z, present);
    if (!status) return KQ_OK;
    model_steps[k].present &= ~present;
    if (ago && all_again()) return KQ_ERR_TABLE; /* cannot be: it went before */
    return status;
}
""")

PREDICT = Template("""\
    const kq_status status = predict(&model_filter$given);
    if (status) return status;
    const unsigned k = model_newest + 1u < ${kept}u ? model_newest + 1u : 0;
    if (model_count < ${kept}u) model_count++;
    else {
        if (again(&model_before, k)) return KQ_ERR_TABLE; /* cannot be: it went before */
        model_before.events = 0;
    }
    model_newest = k;
$keeps    model_steps[k].present = UINT32_C($bit);
    return KQ_OK;""")
