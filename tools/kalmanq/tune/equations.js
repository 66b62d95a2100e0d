"use strict";
/* A nonlinear model: the C that `kalmanq compile` emits for it, in WebAssembly, over a recording.  It answers as Engine does. */

/* Of a tune_run (c/run.h), in its order: 32 bits each */
const RUN_FIELDS = ("n m c l rows smooth ahead latest late R z u clock step mean sigma expected innovation innovation_sigma nis log_likelihood taken " +
  "smoothed smoothed_sigma smoothed_expected forecast forecast_sigma total events").split(" ");
const RUN_RESULTS = RUN_FIELDS.slice(RUN_FIELDS.indexOf("mean"), RUN_FIELDS.indexOf("total"));
const FUNCTIONS = ["sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp", "expm1", "log", "log1p", "cbrt", "atan2", "pow"];

/* What the emitted C takes of <math.h>, by its names */
function mathematics() {
  const made = { fmod: (a, b) => a % b };
  for (const name of FUNCTIONS) made[name] = Math[name];
  for (const name of Object.keys(made)) made[`${name}f`] = made[name]; // a result becomes a float on its way back
  return made;
}

/* A number of the C: [form, noise, factor, begun]; begun: at the sizes of the model's file, where that is another one */
function literalOf([form, noise, factor, begun], theta, values, parameter) {
  const size = noise < 0 ? 1 : theta[noise];
  if (begun !== null && size === values[noise]) return begun;
  if (form === "size") return factor * size;
  if (form === "root") return factor * Math.sqrt(size);
  if (form === "square") return factor * parameter * parameter;
  if (form === "inverse") return factor * (1 / (parameter + 1));
  return factor * size * (parameter / (parameter + 1));
}

class EquationEngine extends Recording {
  constructor(instance, model) {
    super(instance, model, RUN_FIELDS, RUN_RESULTS);
    this.canFix = false;
    this.hasExpected = true;
    this.fixed = { u: this.put(model.u), clock: this.put(model.clock), step: this.put([model.step]),
                   R: this.take(model.m * model.m), total: this.take(1) };
  }
  limit(dof) { return this.model.limits[dof]; }

  /* The emitted C's numbers and R, at these sizes of the noises */
  choose(name, { theta, arithmetic, parameter }) {
    const { literals } = this.model.filters[name], values = this.model.noises.map((one) => one.value), at = this.core[`${name}_k`].value;
    const Numbers = arithmetic === "f32" ? Float32Array : Float64Array;
    new Numbers(this.core.memory.buffer, at, literals.length).set(literals.map((one) => literalOf(one, theta, values, parameter)));
    const R = this.model.rest.R.slice();
    this.model.noises.forEach((one, k) => { if (one.R) add(R, one.R, theta[k]); });
    this.view(this.fixed.R, R.length).set(this.model.noises.every((one, k) => one.value === theta[k]) ? this.model.R : R);
  }

  /* asked: as Engine's; the loss is none, gate (parameter: sigmas) or student (degrees of freedom) */
  run(asked) {
    const { model } = this, name = `${asked.loss || "none"}_${asked.arithmetic}`, isAll = asked.all !== false;
    this.choose(name, asked);
    this.ahead = isAll && !asked.alone ? Math.min(asked.ahead || 0, this.mostAhead) : 0;
    this.set({ n: model.states_of_filter, m: model.m, c: model.n, l: model.l, rows: model.rows, smooth: asked.smooth && model.smooths ? 1 : 0, ahead: this.ahead,
               latest: isAll && !asked.smooth ? this.latest : 0, z: this.z, late: this.late, ...this.fixed, ...this.out });
    if (!isAll) this.set({ mean: 0, smooth: 0 });
    if (!this.core[`${name}_tune`]()) throw new Refusal("not enough memory for so many rows");
    return { total: this.view(this.fixed.total, 1)[0], events: this.events };
  }

  /* Has it the bits of the host?  Otherwise how far its last mean is from the host's, in sigmas */
  compared() {
    const { digest, mean } = this.model.host, x = this.result("mean"), last = x.length - this.model.n, sigma = this.result("sigma").subarray(last);
    return digestOf(x) === digest ? 0 : Math.max(Number.MIN_VALUE, ...x.subarray(last).map((one, i) => (sigma[i] > 0 ? Math.abs(one - mean[i]) / sigma[i] : 0)));
  }
}

/* FNV-1a of the 32-bit halves of doubles */
function digestOf(values) {
  const halves = new Uint32Array(values.slice().buffer);
  let made = 2166136261;
  for (const half of halves) made = Math.imul(made ^ half, 16777619);
  return made >>> 0;
}

function decodedEquations(given) {
  const made = { ...given };
  for (const name of ["z", "u", "clock", "times", "H", "d", "R"]) made[name] = numbersOf(given[name]);
  made.u = made.u || new Float64Array(0);
  made.rest = { R: numbersOf(given.rest.R) };
  made.noises = given.noises.map((one) => ({ ...one, R: numbersOf(one.R) }));
  made.host = { ...given.host, mean: numbersOf(given.host.mean) };
  return made;
}

/* The C of a filter with the page's noises, as `kalmanq compile` writes it, and its header */
async function codeOf(content, { theta, loss, arithmetic, parameter }) {
  const { pieces, literals, header } = JSON.parse(new TextDecoder().decode(await unpacked(content.filters[`${loss}_${arithmetic}`].code)));
  const values = content.noises.map((one) => one.value), isFloat = arithmetic === "f32";
  const code = pieces.map((piece, k) => (k ? written(literalOf(literals[k - 1], theta, values, parameter), isFloat) : "") + piece).join("");
  return { code, header };
}

/* A number of C with the fewest digits that give it again, as the compiler writes it */
function written(value, isFloat) {
  const given = isFloat ? Math.fround(value) : value, text = isFloat ? shortest(given) : String(given), size = Math.abs(given);
  if (isFloat) return `${inC(text, size !== 0 && (size < 1e-4 || size >= 1e7), 1)}f`;
  return inC(text, size !== 0 && (size < 1e-4 || size >= 1e16), 2);
}

function shortest(value) {
  for (let digits = 1; digits < 10; digits++) {
    const text = value.toPrecision(digits);
    if (Math.fround(Number(text)) === value) return String(Number(text));
  }
  return String(value);
}

/* hasExponent: as C's compiler module writes numbers that are large or small; at least so many digits of it */
function inC(text, hasExponent, least) {
  if (!hasExponent) {
    return text.includes(".") ? text : `${text}.0`;
  }
  const [mantissa, power] = (/e/.test(text) ? text : Number(text).toExponential()).split("e");
  const digits = power.replace(/[+-]/, "").padStart(least, "0");
  return `${least === 1 && !mantissa.includes(".") ? `${mantissa}.0` : mantissa}e${power.startsWith("-") ? "-" : "+"}${digits}`;
}

if (typeof module !== "undefined") Object.assign(module.exports, { EquationEngine, decodedEquations, mathematics, codeOf });
