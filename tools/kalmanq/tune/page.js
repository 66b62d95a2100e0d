"use strict";
/* The page: what is set, what is asked of the library, what is shown. */

const SOURCE = `<!DOCTYPE html>\n${document.documentElement.outerHTML}\n`;
const $ = (id) => document.getElementById(id);
const content = JSON.parse($("content").textContent);
const isNonlinear = content.kind === "equations"; // its filter is the C that `kalmanq compile` emits
const BEGIN = {
  theta: content.noises.map((one) => one.value), dt: content.flow ? content.flow.dt : undefined, free: content.noises.map(() => true), arithmetic: "f64", loss: "none", parameter: null,
  lag: 0, ahead: Math.max(10, Math.min(200, Math.round(content.rows / 10))), cells: {}, late: {},
};
const LOSSES = { none: { title: "as they are", note: "", usual: null }, ...content.losses };
const EVENTS = [[1, "a measurement was redundant"], [2, "overflow: a mean or variance is not representable"], [8, "a state saturated at the end of its range"],
                [128, "precision lost: a sigma may be wrong by more than 5 %"], [512, "a low-noise measurement contradicts what was known"]];

let set = JSON.parse(JSON.stringify(BEGIN)), shows = { state: 0, measurement: 0, first: 0, last: content.rows };
let past = [], future = [], seenBy = { first: [], second: [] };
let drawn = { pictures: null, smoothed: null, total: null, refused: null };
const begunTotal = {};

/* ------------------------------------------------------------------ workers, or the page itself */

class Helper {
  constructor(wasm, code) {
    this.waiting = new Map();
    this.next = 0;
    this.isReady = false;
    try {
      this.worker = new Worker(URL.createObjectURL(new Blob([code], { type: "text/javascript" })));
      this.worker.onmessage = ({ data }) => this.heard(data);
      this.worker.onerror = (event) => { event.preventDefault(); this.lost(event.message); };
    } catch { this.worker = null; }
    this.answer = desk(); // of the page itself, which is slower to touch
    this.ready = this.ask({ kind: "begin", wasm, content }).then((made) => { this.isReady = true; return made; });
  }
  heard(data) {
    const one = this.waiting.get(data.id);
    if (data.told) return one.told(data.told);
    this.waiting.delete(data.id);
    one.done(data);
  }
  /* Without a worker from the beginning the page itself does it. */
  lost(why) {
    if (this.isReady) return [...this.waiting.keys()].forEach((id) => this.heard({ id, refused: why || "the worker has stopped: load the page again" }));
    this.worker = null;
    for (const { message, told } of this.waiting.values()) this.here(message, told);
  }
  here(message, told) { this.answer(message, told).then((data) => this.heard(data)); }
  ask(asked, told = () => {}) {
    const message = { ...asked, id: this.next++ };
    return new Promise((done) => {
      this.waiting.set(message.id, { message, done, told });
      if (this.worker) this.worker.postMessage(message);
      else this.here(message, told);
    });
  }
}

/* The newest request alone is kept while one is at work. */
class Latest {
  constructor(work) { this.work = work; this.busy = false; this.wanted = null; }
  ask(what) {
    this.wanted = what;
    if (!this.busy) this.go();
  }
  async go() {
    this.busy = true;
    while (this.wanted) {
      const what = this.wanted;
      this.wanted = null;
      await this.work(what);
    }
    this.busy = false;
  }
}

/* ------------------------------------------------------------------ asking */

let first, second, resting, smoothRefused = false, isFitting = false;
const filterRuns = new Latest(runFilter), smoothRuns = new Latest(runSmoother);

function asked() {
  return { theta: set.theta, dt: set.dt, arithmetic: set.arithmetic, loss: set.loss, parameter: set.parameter, lag: set.lag, ahead: set.ahead };
}

async function edited(helper, who) {
  const { cells, late } = set;
  if (seenBy[who][0] === cells && seenBy[who][1] === late) return;
  const told = await helper.ask({ kind: "edit", cells: Object.keys(cells).map(Number), values: Object.values(cells).map((one) => (one === null ? NaN : one)),
                                  late: Object.keys(late).map(Number), rows: Object.values(late) });
  if (told.refused) throw new Error(told.refused);
  seenBy[who] = [cells, late];
}

async function runFilter({ kind, begun }) {
  if (kind === "look" && drawn.refused) return show(); // there is no run to look at
  await edited(first, "first");
  const now = JSON.stringify([set.theta, set.dt]), { state } = shows, told = await first.ask({ kind, asked: asked(), shows: shown() });
  if (told.refused) { drawn.refused = told.refused; return drawn.pictures ? show() : refuse(told.refused); }
  drawn = { ...drawn, state, refused: null, pictures: told.pictures, consistency: told.consistency, correlation: told.correlation };
  if (kind === "run") Object.assign(drawn, { total: told.total, events: told.events, headroom: told.headroom });
  if (kind === "run" && now === JSON.stringify([BEGIN.theta, BEGIN.dt]) && set.arithmetic === "f64" && set.loss === "none" && !isPainted()) check(told);
  show(begun);
}

async function runSmoother({ kind, begun }) {
  if (!smooths()) { drawn.smoothed = null; return show(); }
  if (kind === "look_smooth" && smoothRefused) return;
  await edited(second, "second");
  const told = await second.ask({ kind, asked: asked(), shows: shown() });
  smoothRefused = Boolean(told.refused);
  drawn.smoothed = told.pictures || null;
  show(begun);
}

function shown() { return { ...shows, columns: charts.state.columns }; }

/* kind: run, or look where nothing but what is shown has changed */
function redraw(kind = "run") {
  const begun = performance.now();
  filterRuns.ask({ kind: kind === "look" && !filterRuns.wanted ? "look" : "run", begun });
  smoothRuns.ask({ kind: kind === "look" && !smoothRuns.wanted ? "look_smooth" : "smooth", begun });
  if (kind === "look") return;
  clearTimeout(resting);
  resting = setTimeout(measureDistance, 400);
  showSettings();
}

/* From the change to the picture of it, smoothed curve included */
function took(begun) {
  const milliseconds = performance.now() - begun;
  $("took").textContent = `${milliseconds.toFixed(0)} ms`;
  document.body.dataset.took = milliseconds.toFixed(1);
}

async function measureDistance() {
  if (set.loss !== "none" && set.parameter === null) return;
  await edited(second, "second");
  const { far } = await second.ask({ kind: "distance", asked: asked() });
  const told = Object.entries(far).map(([name, one]) => `${name}: ${typeof one === "number" ? `${said(one, 2)} sigma` : "cannot run"}`);
  $("distance").textContent = `Farthest mean from f64. ${told.join("; ")}.`;
}

function isPainted() { return Object.keys(set.cells).length + Object.keys(set.late).length > 0; }
function smooths() { return isNonlinear ? content.smooths : set.loss === "none"; }

function check({ total, apart }) {
  const same = isNonlinear ? apart === 0 : Object.is(total, content.total);
  const other = !isNonlinear ? "not the host's bits" : apart < 1e-15 ? "the host's but for last bits" : `${said(apart, 2)} sigma off the host`;
  $("bits").textContent = `start: ${same ? "the host's bits" : other}`;
  document.body.dataset.bits = same ? "same" : "other";
}

/* ------------------------------------------------------------------ changing */

function change(what, { isDragging = false } = {}) {
  if (!isDragging && JSON.stringify({ ...set, ...what }) === JSON.stringify(set)) return showSettings(); // nothing to take back
  if (!isDragging) remember();
  Object.assign(set, what);
  redraw();
}

let before = null; // of a drag
function remember() {
  past.push(JSON.stringify(before || set));
  if (past.length > 300) past.shift();
  before = null;
  future = [];
}
function beginDrag() { before = before || JSON.parse(JSON.stringify(set)); }
function endDrag() { if (before && JSON.stringify(before) !== JSON.stringify(set)) remember(); before = null; showSettings(); }

function travel(from, to) {
  if (!from.length) return;
  to.push(JSON.stringify(set));
  set = JSON.parse(from.pop());
  redraw();
}

/* ------------------------------------------------------------------ sliders: of the noises, and of dt */

const NOISE_DECADES = 6, DT_DECADES = 1;
const sliders = content.noises.map((one, k) => ({
  key: one.key, unit: one.unit, hint: `${one.kind === "R" ? "measurement noise" : "process noise"}${one.hint ? ` of ${one.hint}` : ""}`, decades: NOISE_DECADES,
  begun: BEGIN.theta[k], value: () => set.theta[k], noise: k, changed: (value) => ({ theta: set.theta.map((old, i) => (i === k ? value : old)) }) }));
if (content.flow) sliders.push({ key: "dt", unit: content.flow.unit, hint: "time from row to row", decades: DT_DECADES, begun: BEGIN.dt, value: () => set.dt, changed: (dt) => ({ dt }) });

function buildSliders() {
  sliders.forEach((one, k) => {
    const row = document.createElement("div"), isNoise = one.noise !== undefined;
    row.className = "noise";
    row.innerHTML = `<label class="what" for="size-${k}"></label><input id="size-${k}" inputmode="decimal" autocomplete="off" spellcheck="false">
      <input type="range" id="noise-${k}" min="${-one.decades}" max="${one.decades}" step="0.01">
      <label class="free">${isNoise ? `<input type="checkbox" id="free-${k}"> fit it` : "&nbsp;"}</label><button type="button" class="was" id="was-${k}" title="Back to what it was"></button>`;
    const what = row.querySelector(".what"), small = document.createElement("small"), [size, slider, free] = row.querySelectorAll("input");
    what.textContent = `${one.key}${one.unit ? ` [${one.unit}]` : ""}`;
    small.textContent = one.hint;
    what.append(small);
    $("noises").append(row);
    slider.setAttribute("aria-label", `${one.key}, ${one.hint}, logarithmic`);
    slider.addEventListener("input", () => { beginDrag(); change(one.changed(Number(slider.value) === 0 ? one.begun : one.begun * 10 ** Number(slider.value)), { isDragging: true }); });
    slider.addEventListener("change", endDrag);
    size.addEventListener("change", () => typed(one, size.value));
    row.querySelector(".was").addEventListener("click", () => change(one.changed(one.begun)));
    if (!isNoise) return;
    free.setAttribute("aria-label", `Fit ${one.key}, ${one.hint}`);
    free.addEventListener("change", () => { remember(); set.free[one.noise] = free.checked; showSettings(); });
  });
}

function typed(one, text) {
  const value = Number(text.replace(",", "."));
  if (value > 0 && Number.isFinite(value)) return change(one.changed(value));
  tell(`${one.key}: ${text} is not a number above 0`, true);
  showSettings();
}

function setNoise(k, value) { change(sliders[k].changed(value)); }

function showSliders() {
  sliders.forEach((one, k) => {
    const value = one.value(), decades = Math.log10(value / one.begun);
    $(`size-${k}`).parentElement.classList.toggle("changed", value !== one.begun);
    if (document.activeElement !== $(`size-${k}`)) $(`size-${k}`).value = said(value, 6);
    $(`noise-${k}`).value = Math.max(-one.decades, Math.min(one.decades, decades));
    $(`noise-${k}`).setAttribute("aria-valuetext", said(value, 4));
    if (one.noise !== undefined) $(`free-${k}`).checked = set.free[one.noise];
    $(`was-${k}`).textContent = `was ${said(one.begun, 4)}`;
  });
}

function showSettings() {
  showSliders();
  for (const one of document.querySelectorAll("[name=arithmetic]")) one.checked = one.value === set.arithmetic;
  $("loss").value = set.loss;
  $("parameter").value = set.parameter === null ? "" : String(set.parameter);
  $("parameter").disabled = set.loss === "none";
  $("loss-note").textContent = LOSSES[set.loss].note + (LOSSES[set.loss].levels ? " The parameter is the share of good rows that pass." : "") + (smooths() ? "" : isNonlinear ? " No smoother: its history holds 32767 rows." : ` No smoother${set.loss === "jump" ? " or fixed lag" : ""} then.`);
  $("lag").value = set.lag;
  $("ahead").value = set.ahead;
  for (const [id, name] of [["arithmetics", "arithmetic"], ["loss", "loss"], ["parameter", "parameter"], ["lag", "lag"], ["ahead", "ahead"]]) {
    $(id).closest("label, fieldset").classList.toggle("changed", set[name] !== BEGIN[name]);
  }
  $("undo").disabled = !past.length;
  $("redo").disabled = !future.length;
  $("fit").disabled = $("em-fit").disabled = isFitting || !set.free.some(Boolean);
  $("painted").textContent = painted();
  $("commands").textContent = commands();
  showSource();
  showCosts();
}

function painted() {
  const count = Object.keys(set.cells).length, late = Object.keys(set.late).length, values = (k) => `${k} ${k === 1 ? "value" : "values"}`;
  const parts = [...(count ? [`${values(count)} changed`] : []), ...(late ? [`${values(late)} late`] : [])];
  if (late && set.loss !== "none" && !isNonlinear) parts.push("with a gate or another loss all count as in time");
  if (late && set.lag > 0) parts.push("no fixed lag with late rows");
  return parts.length ? `${parts.join("; ")}.` : "The recording is as it was.";
}

/* ------------------------------------------------------------------ showing */

const charts = {};
const named = (one) => `${one.name}${one.unit ? ` [${one.unit}]` : ""}`;
let times = null, sizes = null, overlay = null, queued = false, waiting = 0;

function show(begun) {
  if (begun) waiting = begun;
  if (queued) return;
  queued = true;
  requestAnimationFrame(() => {
    queued = false;
    draw();
    if (waiting) took(waiting);
    waiting = 0;
  });
}

function draw() {
  const of = drawn.pictures;
  if (!of) return;
  const { first: a, last: b } = of, ahead = of.forecast && b === content.rows ? set.ahead : 0;
  const one = (kind, curve, colour, more) => (curve ? [{ kind, ...curve, first: a, last: b, colour, ...more }] : []);
  const layers = [...one("band", of.filteredBand, "filtered"), ...one("band", drawn.smoothed?.smoothedBand, "smoothed", { alpha: 0.28 }),
                  ...one("points", of.data, "data"), ...one("line", of.filtered, "filtered"), ...one("line", drawn.smoothed?.smoothed, "smoothed"),
                  ...one("line", of.lagged, "lagged", { dash: [5, 3] })];
  if (ahead) {
    const more = { first: content.rows, last: content.rows + of.forecast.mean.length, colour: "forecast" };
    layers.push({ kind: "band", low: of.forecast.low, high: of.forecast.high, ...more }, { kind: "line", low: of.forecast.mean, high: of.forecast.mean, ...more });
  }
  layers.unshift(...lateSpans().filter(([from, to]) => to > a && from < b).map(([from, to]) => ({ kind: "marked", from: Math.max(from, a), to: Math.min(to, b), colour: "late" })));
  if (overlay) layers.push({ kind: "marked", ...overlay });
  const room = times ? 0 : 0.5, over = { xs: [a - room, b - 1 + room] };
  charts.state.draw({ xs: [a - room, b - 1 + room + ahead], layers });
  charts.innovation.draw({ ...over, ys: around(of.innovation), layers: [...one("band", of.innovationBand, "filtered"), { kind: "level", value: 0, colour: "edge" }, ...one("points", of.innovation, "data"), ...edges(of.innovationBand, a, b)] });
  charts.nis.draw({ ...over, ys: [0, Math.max(1.3, around(of.nis)[1])], layers: [{ kind: "level", value: 0, colour: "edge" }, { kind: "level", value: 1, colour: "smoothed", dash: [5, 3] }, ...one("points", of.nis, "filtered")] });
  const { values, bound } = drawn.correlation, most = Math.min(1, Math.max(3 * bound, 1.2 * Math.max(0, ...values.map(Math.abs))));
  charts.correlation.draw({ xs: [0, values.length + 1], ys: [-most, most], layers: [{ kind: "bars", values, colour: "filtered" }, { kind: "level", value: 0, colour: "edge" },
    { kind: "level", value: bound, colour: "smoothed", dash: [5, 3] }, { kind: "level", value: -bound, colour: "smoothed", dash: [5, 3] }] });
  showNumbers(ahead);
}

/* Rows that follow each other and have something late */
let spansOf = { late: null, made: [] };
function lateSpans() {
  if (spansOf.late === set.late) return spansOf.made;
  const rows = [...new Set(Object.keys(set.late).map((cell) => Math.floor(cell / content.m)))].sort((one, other) => one - other), made = [];
  for (const row of rows) if (made.length && made[made.length - 1][1] === row) made[made.length - 1][1]++; else made.push([row, row + 1]);
  spansOf = { late: set.late, made };
  return made;
}

function edges({ low, high }, first, last) {
  return [low, high].map((one) => ({ kind: "line", low: one, high: one, first, last, colour: "filtered", width: 1 }));
}

function showNumbers(ahead) {
  document.body.classList.toggle("refused", drawn.refused !== null);
  if (drawn.refused !== null) return showRefusal();
  delete document.body.dataset.refused;
  const { consistency: of } = drawn, begun = content.total;
  $("total").textContent = Number.isFinite(drawn.total) ? drawn.total.toFixed(3) : "–";
  const gain = drawn.total - begun;
  const isOther = Object.keys(set.cells).length > 0 || set.loss === "gate"; // not to be compared
  $("gain").textContent = isOther ? "of other rows than at the start" : Math.abs(gain) < 5e-4 ? "as at the start" : `${gain > 0 ? "+" : "−"}${Math.abs(gain).toFixed(3)} since the start`;
  $("nis-mean").textContent = said(of.mean, 4);
  $("nis-bounds").textContent = of.rows ? `95 %: ${of.low.toFixed(3)} to ${of.high.toFixed(3)}` : "no measurement counts";
  $("nis-mean").style.color = of.mean < of.low || of.mean > of.high ? "var(--bad)" : "";
  $("beyond").textContent = of.rows ? `${(100 * of.beyond).toFixed(1)} %` : "–";
  document.querySelector(".legend .late").hidden = !lateSpans().length;
  document.querySelector(".legend .lagged").hidden = !drawn.pictures.lagged;
  document.querySelector(".legend .forecast").hidden = !ahead;
  document.querySelector(".legend .smoothed").hidden = !drawn.smoothed;
  for (const one of document.querySelectorAll(".with-band")) one.hidden = !drawn.pictures.filteredBand;
  document.querySelector(".legend .data").hidden = !drawn.pictures.data;
  const events = isNonlinear ? content.filters[`${set.loss}_${set.arithmetic}`].events : EVENTS, found = events.filter(([bit]) => drawn.events & bit).map(([, text]) => text);
  if (set.arithmetic === "q31") found.push(...(drawn.headroom || []).filter((one) => one.wide).map((one) => `the sigma of ${one.name} is up to ${said(one.wide, 3)}, beyond its range: raise the range in the model file`));
  tell(found.join("; "), found.length > 0);
  $("headroom").hidden = !drawn.headroom || set.arithmetic !== "q31";
  if (drawn.headroom) showHeadroom(drawn.headroom);
}

function showHeadroom(bars) {
  $("bars").replaceChildren(...bars.map((one) => {
    const row = document.createElement("div"), [name, bar, text] = ["span", "i", "span"].map((tag) => document.createElement(tag)), fill = document.createElement("b");
    row.className = `headroom${one.share >= 1 ? " full" : ""}`;
    name.textContent = one.name;
    fill.style.width = `${Math.min(100, 100 * one.share)}%`;
    text.textContent = `${(100 * one.share).toFixed(0)} %`;
    bar.append(fill);
    row.append(name, bar, text);
    return row;
  }));
}

function tell(text, isBad = false) {
  $("message").textContent = text || "\u00a0";
  $("message").classList.toggle("bad", isBad);
}
function refuse(text) { tell(text, true); document.body.dataset.refused = text; }

/* The pictures are of the last run that was possible, and pale: so a value can be dragged back. */
function showRefusal() {
  for (const id of ["total", "nis-mean", "beyond"]) $(id).textContent = "–";
  for (const id of ["gain", "nis-bounds"]) $(id).textContent = "no result with these settings";
  $("nis-mean").style.color = "";
  $("headroom").hidden = true;
  $("chart-state").classList.toggle("other", drawn.state !== shows.state);
  refuse(drawn.refused);
}

function showCosts() {
  const of = (content.costs[$("core").value] || {})[set.arithmetic === "q31" ? "q31" : "f32"] || {};
  const cells = (tag, values) => { const row = document.createElement("tr"); values.forEach((one) => { const cell = document.createElement(tag); cell.textContent = one; row.append(cell); }); return row; };
  $("costs").replaceChildren(cells("th", isNonlinear ? ["f32", "instructions"] : [set.arithmetic === "q31" ? "q31" : "f32", "instr./row", "flash", "RAM", "stack"]),
    ...Object.entries(of).map(([way, values]) => cells("td", [way, ...values.map((one) => one.toLocaleString("en").replaceAll(",", "\u2009"))])),
    ...(Object.keys(of).length ? [] : [cells("td", ["-", content.no_costs || "was not counted on this core"])]));
}

/* ------------------------------------------------------------------ the fit, and what is taken along */

/* kind: fit, the climb, or em */
async function runFit(kind) {
  if (drawn.consistency?.rows === 0) { $("fitted").textContent = "No measurement counts: there is nothing to fit."; return; }
  const free = set.free.slice(), name = kind === "em" ? "EM" : "Climbing";
  isFitting = true;
  showSettings();
  await edited(second, "second");
  $("fitted").textContent = `${name} …`;
  const found = await second.ask({ kind, asked: { ...asked(), loss: "none" }, free },
                                 (now) => { $("fitted").textContent = `${name} … log-likelihood ${now.value.toFixed(6)}${now.steps ? `, ${now.steps} steps` : ""}`; });
  isFitting = false;
  showSettings();
  if (found.refused) { $("fitted").textContent = found.refused; return; }
  if (!Number.isFinite(found.value)) { $("fitted").textContent = "The log-likelihood is not a number with these noises: choose others to begin from."; return; }
  const gone = content.noises.filter((one, k) => free[k] && found.theta[k] < 1e-8 * one.value).map((one) => one.key);
  const more = found.hasEnded === false ? " It still gains: EM is slow here, so climb from this point." : "";
  $("fitted").textContent = `Log-likelihood ${found.value.toFixed(6)} after ${found.steps ? `${found.steps} steps of EM, ` : ""}${found.calls} runs.${gone.length ? ` Nothing is left of ${gone.join(", ")}.` : ""}${more}`;
  document.body.dataset[kind === "em" ? "expected" : "fitted"] = String(found.value);
  change({ theta: found.theta });
}

function quoted(text) { return /^[\w./+=-]+$/.test(text) ? text : `'${text.replaceAll("'", "'\\''")}'`; }
function tuned() { return `${content.name.replace(/[^\w-]+/g, "_") || "model"}_tuned.${isNonlinear ? "py" : "toml"}`; }

function commands() { return [...notIn(), isNonlinear ? commandsOfEquations() : commandsOfMatrices()].join("\n"); }

/* What the page shows and `kalmanq run` does not take, as comments of the shell */
function notIn() {
  return [...(isPainted() ? ["# of the recording as it was: what is painted is in this page alone"] : []),
          ...(isNonlinear && set.loss !== "none" ? [`# kalmanq run has no ${set.loss}`] : [])];
}

/* Of a command; a gate's parameter in sigma */
function robustly() {
  const level = (LOSSES[set.loss].levels || []).find(([share]) => share === set.parameter);
  return set.loss === "none" ? "" : ` --robust ${set.loss}=${level ? level[2] : set.parameter}`;
}

function filesOfData() { const { data, files = [data], options = [] } = content.sources; return data ? ` ${[...files, ...options].map(quoted).join(" ")}` : " DATA.csv"; }

/* Where all of Q and R is free, and nothing else */
function commandsOfEquations() {
  const files = filesOfData(), names = content.noises.map((one) => one.fit);
  const isFit = set.free.every(Boolean) && names.every(Boolean), file = quoted(content.sources.model);
  return [...(isFit ? [`kalmanq fit ${file}${files} --free Q,R --q-form diagonal --r-form diagonal`] : []),
          `kalmanq run ${tuned()}${files} --compiled --arith ${set.arithmetic} --smooth`,
          `kalmanq compile ${tuned()} --arith ${set.arithmetic}${robustly()} -o ${content.c_name}.c`].join("\n");
}

/* The file that `kalmanq fit` begins from: with this dt and these noises, where the fit does not move them */
function fitted() {
  const isOther = set.dt !== BEGIN.dt || set.theta.some((one, k) => !set.free[k] && one !== BEGIN.theta[k]);
  return isOther ? tuned() : quoted(content.sources.model);
}

function commandsOfMatrices() {
  const core = $("core").value || "m4f", chip = set.arithmetic === "q31" ? "q31" : "f32";
  const names = content.noises.filter((one, k) => set.free[k]).map((one) => one.fit), files = filesOfData();
  const isDiscrete = names.every((one) => /^[QR](\[|$)/.test(one));
  const forms = isDiscrete ? " --q-form diagonal --r-form diagonal" : "";
  const fit = names.length && names.every(Boolean) && !names.some((one) => /^(Q|R|Qc)$/.test(one)) ? [`kalmanq fit ${fitted()}${files} --free ${quoted(names.join(","))}${forms}`] : [];
  return [...fit, `kalmanq run ${tuned()}${files} --arith ${set.arithmetic}${robustly() || " --smooth"}`,
          `kalmanq design ${tuned()} --core ${core} --arith ${chip} -o .`, `kalmanq compile ${tuned()} --arith ${chip} -o ${tuned().replace(".toml", ".c")}`].join("\n");
}

function modelText() {
  const { theta } = set, written = (value) => String(value).replace(/^(-?\d+)(e|$)/, "$1.0$2");
  return content.template.map((one) => (typeof one === "string" ? one : Array.isArray(one) ? written(one.reduce((sum, [k, factor]) => sum + factor * theta[k], 0))
    : one.dt ? written(set.dt) : written(one.of * Math.sqrt(theta[one.root] / content.noises[one.root].value)))).join("");
}

/* The model file and the commands, to be pasted into a shell */
function script() {
  const text = modelText(), line = text.endsWith("\n") ? "" : "\n";
  return `cat > ${tuned()} <<'END_OF_MODEL'\n${text}${line}END_OF_MODEL\n${commands()}\n`;
}

async function copyScript() {
  const done = await navigator.clipboard?.writeText(script()).then(() => true, () => false);
  $("script-text").hidden = done === true;
  if (!done) { $("script-text").textContent = script(); getSelection().selectAllChildren($("script-text")); }
  $("copied").textContent = done ? "Copied." : "The browser does not let a page copy: the text below is selected, Ctrl+C copies it.";
}

/* What a user takes along: of a nonlinear model the C of these noises, otherwise the model file */
async function showSource() {
  if (!$("source").open) return;
  const asked = JSON.stringify([set.theta, set.dt, set.loss, set.arithmetic, set.parameter]), text = isNonlinear ? (await codeOf(content, set)).code : script();
  if (asked === JSON.stringify([set.theta, set.dt, set.loss, set.arithmetic, set.parameter])) $("source-text").textContent = text;
}

async function saveCode() {
  const { code, header } = await codeOf(content, set);
  save(`${content.c_name}.h`, header, "text/plain");
  save(`${content.c_name}.c`, code, "text/plain");
}

function pageText() {
  const settings = JSON.stringify({ set, shows }).replaceAll("<", "\\u003c"), mark = '<script type="application/json" id="settings">';
  const at = SOURCE.indexOf(mark) + mark.length, end = SOURCE.indexOf("</" + "script>", at);
  return SOURCE.slice(0, at) + settings + SOURCE.slice(end);
}

function save(name, text, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

/* ------------------------------------------------------------------ dragging in the picture, keys */

function clampRow(row) { return Math.max(0, Math.min(content.rows, Math.round(row))); }

function zoom(a, b) {
  let from = clampRow(a), to = clampRow(b);
  if (to - from < 8) { const middle = Math.round((from + to) / 2); from = Math.max(0, middle - 4); to = Math.min(content.rows, from + 8); }
  shows = { ...shows, first: from, last: to };
  redraw("look");
}

/* kind: gap, late or restore, of the rows and of the measurement that is chosen */
function paint(kind, from, to) {
  const cells = { ...set.cells }, late = { ...set.late }, { m } = content, only = $("of").value, by = rowsLate();
  for (let t = clampRow(from); t < clampRow(to); t++) {
    for (let c = 0; c < m; c++) {
      const cell = t * m + c;
      if (only !== "" && Number(only) !== c) continue;
      if (kind === "restore") { delete cells[cell]; delete late[cell]; }
      else if (kind === "gap") cells[cell] = null;
      else late[cell] = by;
    }
  }
  change({ cells, late });
}

function rowsLate() { return Math.max(1, Math.min(200, Math.round(Number($("late").value) || 1))); }

function moveValue(row, value) {
  const of = seen(sizes, shows.state), t = Math.max(0, Math.min(content.rows - 1, Math.round(row)));
  change({ cells: { ...set.cells, [t * content.m + of.c]: value * of.scale + of.less } }, { isDragging: true });
}

function listenToPicture() {
  const place = $("chart-state");
  let drag = null;
  const where = (event) => { const box = place.getBoundingClientRect(); return { x: event.clientX - box.left, y: event.clientY - box.top }; };
  place.addEventListener("pointerdown", (event) => {
    if (!charts.state.box) return;
    const { x, y } = where(event), tool = document.querySelector("[name=tool]:checked").value;
    if (tool === "outlier" && !seen(sizes, shows.state)) return tell("No measurement sees this state alone: choose another state.", true);
    drag = { tool, row: charts.state.row(x) };
    place.setPointerCapture(event.pointerId);
    if (tool === "outlier") { beginDrag(); moveValue(drag.row, charts.state.value(y)); }
  });
  place.addEventListener("pointermove", (event) => {
    const { x, y } = where(event);
    read(x);
    if (!drag) return;
    if (drag.tool === "outlier") return moveValue(drag.row, charts.state.value(y));
    const [from, to] = [drag.row, charts.state.row(x)].sort((a, b) => a - b);
    overlay = { from: clampRow(from), to: clampRow(to + 1), colour: { gap: "bad", late: "late" }[drag.tool] || "accent" };
    show();
  });
  const end = () => {
    if (!drag) return;
    if (drag.tool === "outlier") endDrag();
    else if (overlay && overlay.to > overlay.from) {
      if (drag.tool === "zoom") { if (overlay.to - overlay.from > 3) zoom(overlay.from, overlay.to); }
      else paint(drag.tool, overlay.from, overlay.to);
    }
    drag = overlay = null;
    show();
  };
  place.addEventListener("pointerup", end);
  place.addEventListener("pointercancel", end);
  place.addEventListener("dblclick", () => zoom(0, content.rows));
  place.addEventListener("wheel", (event) => { event.preventDefault(); scale(event.deltaY > 0 ? 1.25 : 0.8, charts.state.row(where(event).x)); }, { passive: false });
  place.addEventListener("keydown", (event) => {
    const span = shows.last - shows.first, step = Math.max(1, Math.round(span / 10));
    const moves = { ArrowLeft: () => pan(-step), ArrowRight: () => pan(step), "+": () => scale(0.8), "=": () => scale(0.8), "-": () => scale(1.25), 0: () => zoom(0, content.rows), Home: () => zoom(0, content.rows) };
    if (event.ctrlKey || event.metaKey || !moves[event.key]) return;
    event.preventDefault();
    moves[event.key]();
  });
}

function pan(step) {
  const by = Math.max(-shows.first, Math.min(content.rows - shows.last, step));
  if (by) zoom(shows.first + by, shows.last + by);
}
function scale(factor, around = (shows.first + shows.last) / 2) {
  zoom(around - (around - shows.first) * factor, around + (shows.last - around) * factor);
}

function read(x) {
  const of = drawn.pictures;
  if (!of || !charts.state.box) return;
  const row = Math.round(charts.state.row(x)), n = of.filtered.low.length;
  const k = Math.floor(((row - of.first) * n) / (of.last - of.first)), unit = quantity().unit;
  if (row < of.first || row >= of.last) { $("reading").textContent = "\u00a0"; return; }
  const middle = (curve) => (curve.low[k] + curve.high[k]) / 2, half = (curve) => (curve.high[k] - curve.low[k]) / 2;
  const parts = [`${content.times ? `${said(times[row], 7)} ${content.unit}, ` : ""}row ${row}`];
  if (of.data) parts.push(`measured ${said(middle(of.data))}`);
  const both = (name, curve, band) => parts.push(`${name} ${said(middle(curve))}${band ? ` ± ${said(half(band), 3)}` : ""}`);
  both("filtered", of.filtered, of.filteredBand);
  if (drawn.smoothed) both("smoothed", drawn.smoothed.smoothed, drawn.smoothed.smoothedBand);
  $("reading").textContent = parts.join(" · ") + (unit ? ` ${unit}` : "");
}

/* ------------------------------------------------------------------ the beginning */

function options(select, names, chosen = 0) {
  select.replaceChildren(...names.map((one, k) => { const made = document.createElement("option"); made.value = one[0]; made.textContent = one[1]; made.selected = k === chosen; return made; }));
}

function quantity() { return shows.state < content.n ? content.states[shows.state] : content.measurements[shows.state - content.n]; }

function captions() {
  const state = quantity(), over = content.times ? `over time [${content.unit}]` : "over rows", measured = content.measurements[shows.measurement];
  $("state-caption").textContent = `${named(state)}, ${over}`;
  $("innovation-caption").textContent = `Innovations of ${named(measured)}, with the band of 95 %`;
  $("correlation-caption").textContent = `Autocorrelation of the innovations of ${measured.name}, from measurement to measurement, with the bound of 95 %`;
  $("chart-state").setAttribute("aria-label", `Picture of ${named(state)}, ${over}`);
}

/* The lesser row first */
function byKeyboard(act) {
  const last = content.rows - 1, [from, most] = ["from", "to"].map((id) => Math.max(0, Math.round(Number($(id).value) || 0))).sort((a, b) => a - b);
  if (from > last) return tell(`the rows are 0 to ${last}`, true);
  const to = Math.min(last, most);
  $("from").value = from;
  $("to").value = to;
  act(from, to + 1);
}

function listen() {
  const number = (id, most) => Math.max(0, Math.min(most, Math.round(Number($(id).value) || 0)));
  $("undo").onclick = () => travel(past, future);
  $("redo").onclick = () => travel(future, past);
  $("reset").onclick = () => change(JSON.parse(JSON.stringify(BEGIN)));
  document.addEventListener("keydown", (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.target.matches("input:not([type=range],[type=radio],[type=checkbox])")) return;
    if (event.key === "z" && !event.shiftKey) { event.preventDefault(); travel(past, future); }
    if (event.key === "y" || (event.key === "z" && event.shiftKey) || event.key === "Z") { event.preventDefault(); travel(future, past); }
  });
  $("state").onchange = () => { shows.state = Number($("state").value); captions(); redraw("look"); };
  $("measurement").onchange = () => { shows.measurement = Number($("measurement").value); captions(); redraw("look"); };
  for (const one of document.querySelectorAll("[name=arithmetic]")) one.onchange = () => change({ arithmetic: one.value });
  $("loss").onchange = () => change({ loss: $("loss").value, parameter: LOSSES[$("loss").value].usual });
  $("parameter").onchange = () => setParameter(Number($("parameter").value.replace(",", ".")));
  $("lag").onchange = () => change({ lag: number("lag", 200) });
  $("ahead").onchange = () => change({ ahead: number("ahead", 2000) });
  $("fit").onclick = () => runFit("fit");
  $("em-fit").onclick = () => runFit("em");
  for (const [id, kind] of [["make-gap", "gap"], ["make-late", "late"], ["restore", "restore"]]) $(id).onclick = () => byKeyboard((from, to) => paint(kind, from, to));
  $("zoom-to").onclick = () => byKeyboard(zoom);
  $("core").onchange = showSettings;
  $("save-model").onclick = () => save(tuned(), modelText(), "text/plain");
  $("save-c").onclick = saveCode;
  $("copy").onclick = copyScript;
  $("source").ontoggle = showSource;
  $("save-page").onclick = () => save(`${content.name.replace(/[^\w-]+/g, "_") || "tune"}.html`, pageText(), "text/html");
  new ResizeObserver(() => { if ($("chart-state").clientWidth > 0) redraw("look"); }).observe($("chart-state"));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
  for (const one of document.querySelectorAll("[name=tool]")) one.onchange = () => { $("chart-state").style.touchAction = one.value === "outlier" ? "none" : "pan-y"; };
  listenToPicture();
}

function setParameter(value) {
  const { levels, least } = LOSSES[set.loss], shares = (levels || []).map(([share]) => share), floor = set.loss === "gate" ? 1 : 0;
  if (levels ? !shares.includes(value) : !(value >= least && value > floor && Number.isFinite(value))) {
    tell(levels ? `the gate's share is one of ${shares.join(", ")}` : `the parameter is a number ${floor || !least ? `above ${floor}` : `of at least ${least}`}`, true);
    return showSettings();
  }
  change({ parameter: value });
}

function title() {
  document.title = `${content.name}: tune`;
  $("name").textContent = content.name;
  const { model, data } = content.sources, states = content.states_of_filter || content.n;
  $("facts").textContent = [`${model}, ${data || "drawn from the model"}`, `${content.rows} rows`, `${states} ${states === 1 ? "state" : "states"}, ${content.m} ${content.m === 1 ? "measurement" : "measurements"}`].join(" · ");
}

async function begin() {
  if (typeof WebAssembly !== "object" || typeof DecompressionStream !== "function") {
    $("stop").hidden = false;
    $("stop").textContent = "This browser has no WebAssembly, in which the filter runs: open the page in a newer one, or allow it.";
    return;
  }
  times = numbersOf(content.times);
  sizes = { ...content, H: numbersOf(content.H), d: numbersOf(content.d) };
  if (!seen(sizes, 0)) shows.state = content.n; // what is measured, where nothing measures the first state alone
  const kept = JSON.parse($("settings").textContent);
  if (kept) { set = { ...set, ...kept.set }; shows = { ...shows, ...kept.shows }; }
  title();
  options($("state"), [...content.states.map((one, k) => [k, one.name]), ...content.measurements.map((one, c) => [content.n + c, `${one.name} (measured)`])], shows.state);
  options($("measurement"), content.measurements.map((one, k) => [k, one.name]), shows.measurement);
  options($("loss"), Object.entries(LOSSES).map(([name, { title }]) => [name, title]));
  options($("core"), Object.entries(content.cores), Object.keys(content.cores).indexOf("m4f"));
  buildSliders();
  captions();
  const across = times ? timesAcross(times, content.flow?.dt || (times[times.length - 1] - times[0]) / (times.length - 1)) : ROWS;
  for (const [name, id] of [["state", "chart-state"], ["innovation", "chart-innovation"], ["nis", "chart-nis"], ["correlation", "chart-correlation"]]) charts[name] = new Chart($(id), name === "correlation" ? ROWS : across);
  if ([...content.states, ...content.measurements, ...content.controls].some((one) => one.range === null)) {
    const fixed = document.querySelector("[name=arithmetic][value=q31]");
    fixed.disabled = true;
    fixed.parentElement.title = "q31 needs ranges of all states and measurements in the model file";
  }
  const correlated = !isNonlinear && numbersOf(content.R).some((one, k) => one !== 0 && k % content.m !== Math.floor(k / content.m));
  options($("of"), [["", "all measurements"], ...(correlated ? [] : content.measurements.map((one, c) => [c, one.name]))]);
  $("of-label").hidden = content.m === 1;
  if (isNonlinear) {
    $("em-fit").hidden = true;
    $("save-c").hidden = false;
    $("source-name").textContent = `C of this filter, as kalmanq compile writes ${content.c_name}.c`;
    document.querySelector("[name=arithmetic][value=q31]").parentElement.hidden = $("lag").parentElement.hidden = true;
  }
  $("from").value = 0;
  $("to").value = Math.min(content.rows - 1, 9);
  showSettings();
  const wasm = await unpacked($("core-text").textContent), code = ["engine", "em", "equations", "worker"].map((one) => $(one).textContent).join("\n");
  first = new Helper(wasm, code);
  second = new Helper(wasm, code);
  const made = await Promise.all([first.ready, second.ready]);
  const refused = made.find((one) => one.refused);
  if (refused) return refuse(refused.refused);
  listen();
  redraw();
  document.body.dataset.ready = String(Math.round(performance.now()));
}

begin().catch((problem) => { $("stop").hidden = false; $("stop").textContent = `The page has stopped: ${problem.message}`; });
