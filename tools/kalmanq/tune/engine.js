"use strict";
/* The library in WebAssembly over a recording: runs, what the pictures show of them, the fit.  No document is here: a
   worker, the page itself and Node use it alike. */

/* Of a kq_tune (native/tune.h), in its order: 32 bits each */
const FIELDS = ("arithmetic n m l rows processes factor unknown loss level run losses smooth only lag ahead latest A B Q G H R x0 P0 d parameter " +
  "measured range fraction which late z u mean sigma innovation innovation_sigma nis log_likelihood taken smoothed smoothed_sigma lagged " +
  "lagged_sigma forecast forecast_sigma total events part row quantity component bits").split(" ");
const RESULTS = ("mean sigma innovation innovation_sigma nis log_likelihood taken smoothed smoothed_sigma lagged lagged_sigma " +
  "forecast forecast_sigma").split(" ");
const ARITHMETICS = ["f32", "f64", "q31"];
const SATURATED = 8, LAGS = 20, BAND = 1.959963984540054, FARTHEST = 35;
const PARTS = ["", "memory", "formats", "A, B, Q", "H, R", "P0", "measurements", "controls", "the run", "the smoother", "the lag", "what comes late"];

function numbersOf(text) {
  if (!text) return null;
  return new Float64Array(bytesOf(text).buffer);
}

function bytesOf(text) {
  const letters = atob(text), made = new Uint8Array(letters.length);
  for (let k = 0; k < made.length; k++) made[k] = letters.charCodeAt(k);
  return made;
}

/* What Python wrote, its arrays as Float64Array */
function decoded(given) {
  const made = { ...given };
  for (const name of ["A", "B", "Q", "G", "H", "R", "x0", "P0", "d", "z", "u", "times", "which"]) made[name] = numbersOf(given[name]);
  made.rest = Object.fromEntries(["Q", "R", "P0"].map((name) => [name, numbersOf(given.rest[name])]));
  made.noises = given.noises.map((one) => ({ ...one, Q: numbersOf(one.Q), R: numbersOf(one.R), P0: numbersOf(one.P0), Qc: numbersOf(one.Qc) }));
  made.flow = given.flow && { ...given.flow, F: numbersOf(given.flow.F), B: numbersOf(given.flow.B), rest: numbersOf(given.flow.rest) };
  return made;
}

async function unpacked(text) {
  const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

function add(sum, part, size) {
  for (let e = 0; e < sum.length; e++) sum[e] += size * part[e];
}

function product(a, b, rows, inner, columns, isTransposed = false) {
  const made = new Float64Array(rows * columns);
  for (let i = 0; i < rows; i++) for (let j = 0; j < columns; j++) for (let k = 0; k < inner; k++) made[i * columns + j] += a[i * inner + k] * (isTransposed ? b[j * inner + k] : b[k * columns + j]);
  return made;
}

/* A, Q and B of x' = F x + B u + noise over dt, by a series and doublings: model/continuous.py has it, too */
function stepOver(n, l, F, Qc, B, dt) {
  const times = (a, b, isTransposed) => product(a, b, n, n, n, isTransposed), unit = Float64Array.from({ length: n * n }, (_, k) => (k % (n + 1) ? 0 : 1));
  let pattern = F.map((one) => (one ? 1 : 0)), norm = 0;
  for (let k = 1; k < n; k++) pattern = times(pattern, F.map((one) => (one ? 1 : 0)));
  if (pattern.some((one) => one)) for (let i = 0; i < n; i++) norm = Math.max(norm, F.subarray(i * n, i * n + n).reduce((sum, one) => sum + Math.abs(one), 0));
  const doublings = Math.max(0, Math.ceil(Math.log2(Math.max((norm * dt) / 0.5, 1)))), h = dt / 2 ** doublings;
  let power = unit, noise = Qc.map((one) => one * h), A = unit.slice(), Q = noise.slice(), S = unit.map((one) => one * h);
  for (let k = 1; k < 20 + n; k++) {
    power = times(F, power).map((one) => (one * h) / k);
    const left = times(F, noise), right = times(noise, F, true);
    noise = left.map((one, e) => ((one + right[e]) * h) / (k + 1));
    add(A, power, 1);
    add(Q, noise, 1);
    add(S, power, h / (k + 1));
  }
  for (let k = 0; k < doublings; k++) {
    const more = times(times(A, Q), A, true), moved = times(A, S);
    add(Q, more, 1);
    add(S, moved, 1);
    A = times(A, A);
  }
  return { A, Q: Q.map((one, e) => (one + Q[(e % n) * n + Math.floor(e / n)]) / 2), B: B && product(S, B, n, n, l) };
}

class Refusal extends Error {}

/* A recording in the memory of a WebAssembly module, what is asked of it and what comes out.  fields: of the request; results: those
   that it has */
class Recording {
  constructor(instance, model, fields, results) {
    this.core = instance.exports;
    this.model = model;
    this.latest = 0;
    this.mostAhead = 2000;
    const request = this.core.tune_request() >> 2;
    this.at = Object.fromEntries(fields.map((name, k) => [name, request + k]));
    this.z = this.put(model.z);
    this.late = this.putWhole(new Int32Array(model.rows * model.m));
    this.out = Object.fromEntries(results.map((name) => [name, this.take((name.startsWith("forecast") ? this.mostAhead : model.rows) * this.width(name))]));
  }
  /* Of a row of a result */
  width(name) {
    const { n, m } = this.model;
    return name.endsWith("expected") || name.startsWith("innovation") ? m : ["nis", "log_likelihood", "taken"].includes(name) ? 1 : n;
  }
  result(name) { return this.view(this.out[name], (name.startsWith("forecast") ? this.ahead : this.model.rows) * this.width(name)); }
  set(given) {
    const request = new Int32Array(this.core.memory.buffer);
    for (const [name, value] of Object.entries(given)) request[this.at[name]] = value;
  }
  get events() { return new Int32Array(this.core.memory.buffer)[this.at.events]; }
  take(count) {
    const at = this.core.tune_take(8 * count);
    if (!at) throw new Refusal("not enough memory for so many rows");
    return at;
  }
  view(at, count) { return new Float64Array(this.core.memory.buffer, at, count); }
  write(at, values) { this.view(at, values.length).set(values); }
  put(values) { const at = this.take(values.length); this.write(at, values); return at; }
  putWhole(values) {
    const at = this.take(Math.ceil(values.length / 2));
    new Int32Array(this.core.memory.buffer, at, values.length).set(values);
    return at;
  }
  measurements() { return this.view(this.z, this.model.rows * this.model.m); }
  /* Cells that come so many rows late; all others in time */
  setLate(cells, rows) {
    const late = new Int32Array(this.core.memory.buffer, this.late, this.model.rows * this.model.m).fill(0);
    cells.forEach((cell, k) => { late[cell] = rows[k]; });
    this.latest = rows.reduce((most, one) => Math.max(most, one), 0);
  }
}

class Engine extends Recording {
  constructor(instance, model) {
    super(instance, model, FIELDS, RESULTS);
    const { n, m } = model;
    this.u = model.u ? this.put(model.u) : 0;
    this.which = model.which ? this.putWhole(model.which) : 0;
    this.gated = this.putWhole(model.sensors);
    this.all = this.putWhole([2 ** model.m - 1]);
    const quantities = [...model.states, ...model.measurements, ...model.controls];
    this.canFix = quantities.every((one) => one.range !== null);
    this.range = this.put(quantities.map((one) => one.range || 1));
    this.fraction = this.putWhole(quantities.map((one) => (one.fraction === null ? 1000 : one.fraction)));
    this.fixed = ["A", "B", "H", "x0", "d"].reduce((made, name) => ({ ...made, [name]: model[name] ? this.put(model[name]) : 0 }), {});
    this.free = { Q: this.take(model.Q.length), G: model.G ? this.take(model.G.length) : 0, R: this.take(m * m), P0: this.take(n * n),
                  parameter: this.take(1), total: this.take(1) };
  }

  /* A, B and Q of the step of another dt.  As it was given: those very bits. */
  step(theta, dt, made) {
    const { flow, noises, n, l } = this.model, isGiven = !flow || dt === undefined || dt === flow.dt;
    if (isGiven) { this.moveBy(this.model); return; }
    const Qc = flow.rest.slice();
    noises.forEach((one, k) => { if (one.Qc) add(Qc, one.Qc, theta[k] ** one.power); });
    const of = stepOver(n, l, flow.F, Qc, flow.B, dt);
    this.moveBy(of);
    made.Q = of.Q;
  }
  moveBy({ A, B }) {
    this.write(this.fixed.A, A);
    if (B) this.write(this.fixed.B, B);
  }
  /* Q, R, P0 and G at these sizes of the noises.  As they were given: those very bits. */
  matrices(theta) {
    const { noises } = this.model, made = {};
    const isGiven = noises.every((one, k) => one.value === theta[k]);
    for (const name of ["Q", "R", "P0"]) {
      made[name] = isGiven ? this.model[name] : this.model.rest[name].slice();
      if (!isGiven) noises.forEach((one, k) => { if (one[name]) add(made[name], one[name], one.power === 1 ? theta[k] : theta[k] ** one.power); });
    }
    if (!this.model.G) return made;
    made.G = this.model.G.slice();
    const r = this.model.factor;
    if (!isGiven) noises.forEach((one, k) => { for (const c of one.columns) for (let i = 0; i < this.model.n; i++) made.G[i * r + c] *= Math.sqrt((theta[k] / one.value) ** one.power); });
    return made;
  }

  /* asked: theta, dt, arithmetic, loss, parameter, lag, ahead, smooth; all, false: the log-likelihood alone; alone: the smoother alone;
     only: a state to be smoothed */
  run(asked) {
    const model = this.model, made = this.matrices(asked.theta);
    this.step(asked.theta, asked.dt, made);
    if (asked.arithmetic === "q31" && !this.canFix) throw new Refusal("q31 needs a range of each state, measurement and control: `ranges` in the model file");
    for (const name of ["Q", "R", "P0"]) this.write(this.free[name], made[name]);
    if (made.G) this.write(this.free.G, made.G);
    const isGate = asked.loss === "gate", loss = asked.loss && asked.loss !== "none" ? this.core[`kq_loss_${asked.loss}_${asked.arithmetic}`].value : 0;
    this.ahead = asked.all === false ? 0 : Math.min(asked.ahead || 0, this.mostAhead);
    this.write(this.free.parameter, [loss && !isGate ? asked.parameter : 0]);
    this.set({ arithmetic: ARITHMETICS.indexOf(asked.arithmetic), n: model.n, m: model.m, l: model.l, rows: model.rows,
               processes: model.processes, factor: model.factor, unknown: model.unknown, loss, level: isGate ? this.level(asked.parameter) : -1, run: 8,
               losses: isGate ? model.sensors.length : 1, measured: isGate ? this.gated : this.all,
               smooth: asked.smooth && !loss ? 1 : 0, only: asked.only ?? -1, lag: asked.lag > 0 ? asked.lag : -1, ahead: this.ahead, ...this.fixed, ...this.free,
               range: this.range, fraction: this.fraction, which: this.which, late: this.late, latest: loss ? 0 : this.latest, z: this.z, u: this.u, ...this.out });
    if (asked.all === false) this.set({ mean: 0, smooth: 0 });
    if (asked.alone) this.set({ total: 0 });
    this.hasLag = asked.lag > 0 && !this.latest && asked.loss !== "jump" && asked.all !== false && !asked.alone;
    if (!this.hasLag) this.set({ lag: -1 });
    const status = this.core.tune_run();
    if (status < 0) throw new Refusal(this.refusal(status));
    return { total: this.view(this.free.total, 1)[0], events: this.events };
  }

  /* In words, with the row and the cure */
  refusal(status) {
    const said = new Int32Array(this.core.memory.buffer), get = (name) => said[this.at[name]], { n, m } = this.model;
    const part = get("part"), component = get("component"), row = get("row");
    const quantities = [...this.model.states, ...this.model.measurements, ...this.model.controls];
    const offset = PARTS[part] === "measurements" ? n : PARTS[part] === "controls" ? n + m : 0;
    const whose = component >= 0 && quantities[offset + component];
    const where = row >= 0 ? `row ${row}: ` : "";
    if (whose && offset) return `${where}${whose.name} is beyond its range of ${whose.range}: raise the range in the model file, or take another arithmetic`;
    if (whose) return `${PARTS[part]}: ${whose.name} needs ${get("bits") || "more"} more integer bits: lower its fraction, or raise its range, in the model file`;
    if (PARTS[part] === "what comes late" && status === -2) return `${where}cannot be late: nothing is known of the start yet; restore this row`;
    return `${where}${PARTS[part]}: ${this.text(this.core.kq_status_text(status))}`;
  }
  text(at) {
    const bytes = new Uint8Array(this.core.memory.buffer);
    let made = "";
    for (; bytes[at]; at++) made += String.fromCharCode(bytes[at]);
    return made;
  }
  /* The kq_level of a probability */
  level(share) { return this.model.losses.gate.levels.find(([one]) => one === share)[1]; }
  limit(dof, share) { return this.core.tune_limit(dof, this.level(share)); }
}

/* ------------------------------------------------------------------ what is told of a run */

/* Degrees of freedom of the NIS of each row; 0 while something of the start is unknown */
function freedoms(engine) {
  const taken = engine.result("taken"), s = engine.result("innovation_sigma"), { m } = engine.model;
  return taken.map((one, t) => (s[t * m] >= 0 ? one : 0));
}

/* NIS over its degrees of freedom, with the bounds of 95 % for so many of them (by Wilson and Hilferty); rows beyond the limit */
function consistency(engine) {
  const nis = engine.result("nis"), taken = freedoms(engine), limits = {};
  let sum = 0, freedom = 0, beyond = 0, rows = 0;
  for (let t = 0; t < nis.length; t++) {
    if (!(taken[t] > 0) || Number.isNaN(nis[t])) continue;
    limits[taken[t]] ??= engine.limit(taken[t], 0.95);
    sum += nis[t];
    freedom += taken[t];
    beyond += nis[t] > limits[taken[t]];
    rows++;
  }
  const part = 2 / (9 * freedom), bound = (sign) => Math.max(0, 1 - part + sign * BAND * Math.sqrt(part)) ** 3;
  return { mean: sum / freedom, low: bound(-1), high: bound(1), beyond: beyond / rows, rows };
}

/* Of the innovations of one measurement, in their sigmas, from one of them to the next: a slow sensor's rows between are left out */
function autocorrelation(engine, c) {
  const { m, rows } = engine.model, e = engine.result("innovation"), s = engine.result("innovation_sigma");
  const nu = [];
  for (let t = 0; t < rows; t++) {
    const one = e[t * m + c] / s[t * m + c];
    if (Number.isFinite(one)) nu.push(one);
  }
  const power = nu.reduce((sum, one) => sum + one * one, 0), made = [];
  for (let k = 1; k <= Math.min(LAGS, nu.length - 1); k++) {
    let sum = 0;
    for (let t = k; t < nu.length; t++) sum += nu[t] * nu[t - k];
    made.push(sum / power);
  }
  return { values: made, bound: BAND / Math.sqrt(nu.length) };
}

/* Largest |mean| and |measurement| over their ranges, of q31; wide: the largest sigma, where that is beyond the range */
function headroom(engine) {
  const { n, m, rows, states, measurements } = engine.model, x = engine.result("mean"), s = engine.result("sigma"), z = engine.measurements();
  const largest = (values, width, i) => { let most = 0; for (let t = 0; t < rows; t++) { const one = Math.abs(values[t * width + i]); if (one > most && one < Infinity) most = one; } return most; };
  const wide = (one, i) => { const sigma = largest(s, n, i); return sigma > one.range ? sigma : 0; };
  return [...states.map((one, i) => ({ name: one.name, share: largest(x, n, i) / one.range, wide: wide(one, i), fraction: one.fraction })),
          ...measurements.map((one, c) => ({ name: one.name, share: largest(z, m, c) / one.range, fraction: one.fraction }))];
}

/* The farthest means of this arithmetic from those of f64, in f64's sigmas; the run that was shown stays. */
function distance(engine, asked, arithmetic) {
  const plain = { ...asked, smooth: false, lag: 0, ahead: 0 };
  engine.run({ ...plain, arithmetic: "f64" });
  const x = engine.result("mean").slice(), s = engine.result("sigma").slice();
  engine.run({ ...plain, arithmetic });
  const y = engine.result("mean");
  let most = 0;
  for (let k = 0; k < x.length; k++) {
    if (Number.isFinite(x[k]) && !Number.isFinite(y[k])) throw new Refusal("overflow");
    const off = Math.abs(x[k] - y[k]) / s[k];
    if (off > most && Number.isFinite(off)) most = off;
  }
  return most;
}

/* NIS of each row over the limit that 95 % of rows with so many measurements stay below */
function shares(engine) {
  const nis = engine.result("nis"), taken = freedoms(engine), limits = Array.from({ length: engine.model.m + 1 }, (_, k) => (k ? engine.limit(k, 0.95) : NaN));
  return nis.map((one, t) => one / limits[taken[t]]);
}

/* ------------------------------------------------------------------ pictures */

/* Rows first ... last in at most so many columns: least and most of a curve in each; `spread` more on both sides */
function envelope(values, width, i, first, last, columns, sigma, times) {
  const count = last - first, made = Math.min(columns, count), low = new Float64Array(made).fill(NaN), high = new Float64Array(made).fill(NaN);
  for (let k = 0; k < made; k++) {
    const a = first + Math.floor((k * count) / made), b = first + Math.floor(((k + 1) * count) / made);
    let least = Infinity, most = -Infinity;
    for (let t = a; t < b; t++) {
      const x = values ? values[t * width + i] : 0, s = sigma ? times * sigma[t * width + i] : 0;
      if (x - s < least) least = x - s;
      if (x + s > most) most = x + s;
    }
    if (least <= most) { low[k] = least; high[k] = most; }
  }
  return { low, high };
}

/* The measurement that says something of what is shown, state i or, from n on, a measurement itself: z = scale x + less.  null: none sees this state alone */
function seen({ n, m, H, d }, i) {
  if (i >= n) return { c: i - n, scale: 1, less: 0 };
  for (let c = 0; c < m; c++) {
    const row = H.subarray(c * n, c * n + n);
    if (row[i] !== 0 && row.every((one, j) => j === i || one === 0)) return { c, scale: row[i], less: d ? d[c] : 0 };
  }
  return null;
}

/* What is shown of mean, smoothed or lagged rows x: column i of so many, or H x + d; of a nonlinear model its h */
function chosen(engine, name, x, i) {
  const { n, m, H, d, rows } = engine.model;
  if (i < n) return { x, width: n, i };
  if (engine.hasExpected) return { x: engine.result(name === "mean" ? "expected" : `${name}_expected`), width: m, i: i - n };
  const c = i - n, made = new Float64Array(rows);
  for (let t = 0; t < rows; t++) {
    let sum = d ? d[c] : 0;
    for (let j = 0; j < n; j++) sum += H[c * n + j] * x[t * n + j];
    made[t] = sum;
  }
  return { x: made, width: 1, i: 0 };
}

/* shows: state (or from n on a measurement), measurement, first, last (rows), columns */
function pictures(engine, shows, lag) {
  const { model } = engine, { n, m } = model, { state: i, measurement: c, first, last, columns } = shows;
  const curve = (name, width, k, sigma) => envelope(name && engine.result(name), width, k, first, last, columns, sigma && engine.result(sigma), BAND);
  const drawn = (name, x = engine.result(name)) => { const of = chosen(engine, name, x, i); return envelope(of.x, of.width, of.i, first, last, columns); };
  const made = { first, last, filtered: drawn("mean"), filteredBand: i < n ? curve("mean", n, i, "sigma") : null,
                 innovation: curve("innovation", m, c), innovationBand: curve(null, m, c, "innovation_sigma"), nis: envelope(shares(engine), 1, 0, first, last, columns) };
  const of = seen(model, i);
  if (of) {
    const z = envelope(engine.measurements(), m, of.c, first, last, columns), scaled = (from) => from.map((one) => (one - of.less) / of.scale);
    made.data = of.scale > 0 ? { low: scaled(z.low), high: scaled(z.high) } : { low: scaled(z.high), high: scaled(z.low) };
  }
  if (engine.hasLag) made.lagged = drawn("lagged", shifted(engine.result("lagged"), n, lag));
  if (engine.ahead && i < n) {
    const x = engine.result("forecast"), s = engine.result("forecast_sigma");
    const one = (f) => Float64Array.from({ length: engine.ahead }, (_, t) => f(x[t * n + i], BAND * s[t * n + i]));
    made.forecast = { mean: one((a) => a), low: one((a, b) => a - b), high: one((a, b) => a + b) };
  }
  return made;
}

function smoothed(engine, { state: i, first, last, columns }) {
  const x = engine.result("smoothed"), n = engine.model.n, of = chosen(engine, "smoothed", x, i);
  return { smoothed: envelope(of.x, of.width, of.i, first, last, columns),
           smoothedBand: i < n ? envelope(x, n, i, first, last, columns, engine.result("smoothed_sigma"), BAND) : null };
}

/* What is told `lag` rows late, at its own row */
function shifted(values, n, lag) {
  const made = new Float64Array(values.length).fill(NaN);
  made.set(values.subarray(Math.min(lag * n, values.length)));
  return made;
}

/* ------------------------------------------------------------------ the fit */

/* The largest of f over x, by BFGS with differences; `told` after each step.  Begins again nearby until that gains nothing. */
function climb(f, x0, told, tolerance = 1e-9) {
  let best = ascend(f, x0, told, tolerance);
  for (let round = 0; round < 6; round++) {
    let better = best;
    for (let k = 0; k < x0.length; k++) {
      for (const step of [-1.5, 1.5]) {
        const x = best.x.slice();
        x[k] += step;
        const value = f(x);
        if (value > better.value + 1e-7) better = { x, value };
      }
    }
    if (better === best) return best;
    best = ascend(f, better.x, told, tolerance);
  }
  return best;
}

function slopes(f, x, h = 1e-4) {
  return x.map((_, k) => {
    const up = x.slice(), down = x.slice();
    up[k] += h;
    down[k] -= h;
    return (f(up) - f(down)) / (2 * h);
  });
}

function ascend(f, x0, told, tolerance) {
  const n = x0.length, unit = () => x0.map((_, i) => x0.map((__, j) => (i === j ? 1 : 0)));
  const dot = (a, b) => a.reduce((sum, one, k) => sum + one * b[k], 0);
  let x = x0.slice(), value = f(x), g = slopes(f, x), B = unit(), small = 0;
  for (let k = 0; k < 200 && small < 2; k++) {
    let step = B.map((row) => dot(row, g));
    if (!(dot(step, g) > 0)) { B = unit(); step = g.slice(); }
    const size = Math.max(...step.map(Math.abs));
    if (size > 2) step = step.map((one) => (2 * one) / size); // at most e^2 at once
    let length = 1, next, y;
    for (; length > 1e-10; length /= 2) {
      y = x.map((one, i) => one + length * step[i]);
      next = f(y);
      if (next >= value + 1e-4 * length * dot(step, g)) break;
    }
    if (!(length > 1e-10)) { if (small) break; B = unit(); small++; continue; }
    const gain = next - value, h = slopes(f, y), s = y.map((one, i) => one - x[i]), d = g.map((one, i) => one - h[i]), sd = dot(s, d);
    if (sd > 1e-14) {
      const Bd = B.map((row) => dot(row, d)), c = (1 + dot(d, Bd) / sd) / sd;
      B = B.map((row, i) => row.map((one, j) => one + c * s[i] * s[j] - (s[i] * Bd[j] + Bd[i] * s[j]) / sd));
    }
    [x, value, g] = [y, next, h];
    small = gain < tolerance ? small + 1 : 0;
    told({ x, value });
  }
  return { x, value };
}

/* All sizes, of which those at these places have the logarithms x */
function sizesOf(asked, at, x) {
  return asked.theta.map((one, k) => (at.includes(k) ? Math.exp(x[at.indexOf(k)]) : one));
}

/* The log-likelihood in f64 by these logarithms; farthest: how far they may go from where the model has them */
function logLikelihoodOf(engine, asked, at, counted, farthest = Infinity) {
  return (x) => {
    counted.calls++;
    if (x.some((one, k) => Math.abs(one - Math.log(engine.model.noises[at[k]].value)) > farthest)) return -Infinity;
    try {
      const { total } = engine.run({ ...asked, theta: sizesOf(asked, at, x), arithmetic: "f64", all: false });
      return Number.isFinite(total) ? total : -Infinity;
    } catch { return -Infinity; }
  };
}

/* The sizes of the noises that are free at the largest log-likelihood, in f64 */
function fit(engine, asked, isFree, told = () => {}) {
  const at = asked.theta.map((_, k) => k).filter((k) => isFree[k]), counted = { calls: 0 };
  const value = logLikelihoodOf(engine, asked, at, counted, FARTHEST);
  const found = climb(value, at.map((k) => Math.log(asked.theta[k])), (one) => told({ theta: sizesOf(asked, at, one.x), value: one.value }));
  return { theta: sizesOf(asked, at, found.x), value: found.value, calls: counted.calls };
}

async function made(wasm, model) {
  const isLinear = model.kind !== "equations", { instance } = await WebAssembly.instantiate(wasm, isLinear ? {} : { env: mathematics() });
  return isLinear ? new Engine(instance, decoded(model)) : new EquationEngine(instance, decodedEquations(model));
}

if (typeof module !== "undefined") module.exports = { made, decoded, consistency, autocorrelation, pictures, fit, distance, headroom, unpacked, smoothed };
