"""q31 in generated headers: a value in its unit as a raw value."""

from __future__ import annotations

TO_RAW = """\
/* A value in its unit as a raw value: rounded to the nearest one, saturated at +-(2^31 - 1).  NaN becomes
   {missing}: an update refuses it, as it does what is beyond the declared range; a predict
   {control}. */
static inline int32_t {name}_to_raw(double value, double scale)
{{
    const double raw = value * scale;
    if (raw >= 2147483647.0) return INT32_MAX;
    if (raw > -2147483647.0) {{
        const int32_t whole = (int32_t)raw;
        const double rest = raw - (double)whole;
        return rest >= 0.5 ? whole + 1 : rest <= -0.5 ? whole - 1 : whole;
    }}
    return raw <= -2147483647.0 ? -INT32_MAX : {missing};
}}"""


def to_raw(name: str, missing: str, control: str) -> list[str]:
    """NAME_to_raw(value, scale); missing: the raw value of what is not there; control: what a predict does with such a control"""
    return TO_RAW.format(name=name, missing=missing, control=control).split("\n")
