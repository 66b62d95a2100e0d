"use strict";
/* EM of the sizes of noises.  A size theta whose noise has N degrees of freedom in all rows is, given the states, at its best at
   S / N, S being the expected sum of squares for a size of 1.  The slope of the log-likelihood has S in it (Fisher's identity):
   d logL / d log theta = (S / theta - N) / 2.  So the step is theta (1 + 2 / N  d logL / d log theta), with any gaps and steps. */

const SLOPE = 1e-4, LEAST = 1e-3, CYCLES = 300, ENDED = 1e-9, OFTEN = 10, FAR_DOWN = 14; // e^-14: a millionth

/* Diagonal entries that a part of a matrix has */
function support(part, size, first = 0) {
  return Array.from({ length: size }, (_, i) => i).filter((i) => part[first + i * size + i] !== 0);
}

/* Of a positive semi-definite matrix, by elimination.  What is left of a variance is compared with that variance: they are of different units */
function rankOf(part, size, first = 0) {
  const a = part.slice(first, first + size * size);
  let rank = 0;
  for (let i = 0; i < size; i++) {
    const pivot = a[i * size + i];
    if (!(pivot > 1e-12 * part[first + i * size + i])) continue;
    rank++;
    for (let r = i + 1; r < size; r++) for (let c = i + 1; c < size; c++) a[r * size + c] -= (a[r * size + i] * a[i * size + c]) / pivot;
  }
  return rank;
}

/* N of each noise: of all steps, of all that was measured, and of the prior where that has it, too */
function degrees(engine) {
  const { n, m, rows, noises, which } = engine.model, z = engine.measurements(), square = n * n, present = new Array(m).fill(0);
  for (let k = 0; k < rows * m; k++) present[k % m] += !Number.isNaN(z[k]);
  return noises.map(({ Q, R, P0 }) => {
    let made = P0 ? rankOf(P0, n) : 0;
    if (Q && !which) made += (rows - 1) * rankOf(Q, n);
    if (Q && which) {
      const ranks = Array.from({ length: Q.length / square }, (_, k) => rankOf(Q, n, k * square));
      for (let t = 1; t < rows; t++) made += ranks[which[t]];
    }
    if (R) {
      const some = support(R, m), share = rankOf(R, m) / some.length;
      for (const c of some) made += share * present[c];
    }
    return made;
  });
}

/* Why there is no EM; "" where there is */
function noExpectation(model) {
  for (const [name, size] of [["Q", model.n], ["R", model.m]]) {
    const seen = new Map();
    for (const one of model.noises) {
      for (const i of one[name] ? support(one[name], size) : []) {
        if (seen.has(i)) return `EM has no best size of ${one.key}, given the states: ${seen.get(i)} is in the same entries of ${name}. Climb in its place.`;
        seen.set(i, one.key);
      }
    }
  }
  return "";
}

/* One step of EM, of logarithms of sizes */
function expectationStep(f, x, N, powers) {
  return slopes(f, x, SLOPE).map((slope, k) => x[k] + Math.log(Math.max(LEAST, 1 + (2 * slope) / (powers[k] * N[k]))) / powers[k]);
}

/* Two steps, extrapolated (SQUAREM, Varadhan and Roland 2008), and one more; the better of that and of the two steps */
function expectationCycle(f, x, step) {
  const one = step(x), two = step(one), r = one.map((v, k) => v - x[k]), v = two.map((w, k) => w - one[k] - r[k]);
  const length = (a) => Math.sqrt(a.reduce((sum, w) => sum + w * w, 0)), plain = { x: two, value: f(two) };
  if (!(length(v) > 0)) return plain;
  const alpha = Math.min(-1, -length(r) / length(v)), far = step(x.map((w, k) => w - 2 * alpha * r[k] + alpha * alpha * v[k]));
  const value = f(far);
  return value > plain.value ? { x: far, value } : plain;
}

/* A variance falls to 0 as one over the number of steps: it goes there at once where that is likelier. */
function withoutTheLeast(f, now) {
  return now.x.reduce((best, _, k) => {
    const x = best.x.map((v, i) => (i === k ? v - FAR_DOWN : v)), value = f(x);
    return value >= best.value ? { x, value } : best;
  }, now);
}

/* The sizes of the free noises by EM, in f64; hasEnded: nothing is gained any more */
function expectation(engine, asked, isFree, told = () => {}) {
  const why = noExpectation(engine.model);
  if (why) throw new Refusal(why);
  const at = asked.theta.map((_, k) => k).filter((k) => isFree[k]), counted = { calls: 0 };
  const f = logLikelihoodOf(engine, asked, at, counted), all = degrees(engine), N = at.map((k) => all[k]), powers = at.map((k) => engine.model.noises[k].power);
  const step = (x) => expectationStep(f, x, N, powers);
  let now = { x: at.map((k) => Math.log(asked.theta[k])), value: -Infinity }, small = 0, cycles = 0;
  now.value = f(now.x);
  for (; cycles < CYCLES && small < 3; cycles++) {
    const next = expectationCycle(f, now.x, step);
    if (!(next.value > -Infinity) || next.x.some((v) => !Number.isFinite(v))) break;
    small = next.value - now.value < ENDED ? small + 1 : 0;
    if (next.value >= now.value) now = next;
    if (cycles % OFTEN === OFTEN - 1) now = withoutTheLeast(f, now);
    told({ value: now.value, steps: 3 * (cycles + 1) });
  }
  return { theta: sizesOf(asked, at, now.x), value: now.value, calls: counted.calls, steps: 3 * cycles, hasEnded: small >= 3 };
}

if (typeof module !== "undefined") Object.assign(module.exports, { expectation, expectationStep, degrees, logLikelihoodOf });
