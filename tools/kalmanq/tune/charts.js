"use strict";
/* Pictures on a canvas: layers over rows, axes with round numbers. */

const MARGIN = { left: 62, right: 12, top: 8, bottom: 24 };

function colour(name) { return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim(); }

/* A number in few letters, as it may be typed again */
function said(value, digits = 5) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (value !== 0 && (size < 1e-4 || size >= 1e7)) return value.toExponential(Math.max(0, digits - 2)).replace(/\.?0+e/, "e").replace("e+", "e");
  return String(Number(value.toPrecision(digits)));
}

/* Of an axis */
function short(value, digits) {
  const size = Math.abs(value);
  return value !== 0 && (size >= 1e5 || size < 1e-3) ? value.toExponential(2).replace(/\.?0*e/, "e").replace("e+", "e") : value.toFixed(digits);
}

function ticks(low, high, most) {
  const rough = (high - low) / Math.max(1, most), power = 10 ** Math.floor(Math.log10(rough));
  const steps = [0.5, 1, 2, 5, 10].map((one) => one * power), at = steps.findIndex((one, k) => k > 0 && one >= rough * 0.999);
  const isOne = Math.floor(high / steps[at]) - Math.ceil(low / steps[at]) < 1; // one label alone tells no scale
  const step = steps[isOne ? at - 1 : at];
  const made = [];
  for (let k = Math.ceil(low / step); k * step <= high + step * 1e-9; k++) made.push(k * step);
  return { made, digits: Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) };
}

/* Where rows are across: at their numbers, or at their times; dt: of steps before the first row and after the last one */
const ROWS = { to: (row) => row, from: (at) => at, said: (at) => said(at, 7), isWhole: true };
function timesAcross(times, dt) {
  const last = times.length - 1;
  const to = (row) => {
    if (row <= 0 || row >= last) return row <= 0 ? times[0] + row * dt : times[last] + (row - last) * dt;
    const before = Math.floor(row);
    return times[before] + (row - before) * (times[before + 1] - times[before]);
  };
  const from = (time) => {
    if (time <= times[0] || time >= times[last]) return time <= times[0] ? (time - times[0]) / dt : last + (time - times[last]) / dt;
    let low = 0, high = last;
    while (high - low > 1) { const middle = (low + high) >> 1; if (times[middle] <= time) low = middle; else high = middle; }
    return low + (time - times[low]) / (times[high] - times[low]);
  };
  return { to, from, said: (at, digits) => at.toFixed(digits), isWhole: false };
}

class Chart {
  constructor(place, across = ROWS) {
    this.place = place;
    this.across = across;
    this.canvas = place.querySelector("canvas");
    this.pen = this.canvas.getContext("2d");
  }
  get most() { return (this.place.clientWidth - MARGIN.left - MARGIN.right) / 90; } // labels across
  get columns() { return Math.max(50, Math.floor(this.place.clientWidth - MARGIN.left - MARGIN.right)); }
  fit() {
    const scale = window.devicePixelRatio || 1, width = this.place.clientWidth, height = this.place.clientHeight;
    if (this.canvas.width !== Math.round(width * scale) || this.canvas.height !== Math.round(height * scale)) {
      this.canvas.width = Math.round(width * scale);
      this.canvas.height = Math.round(height * scale);
    }
    this.pen.setTransform(scale, 0, 0, scale, 0, 0);
    this.pen.clearRect(0, 0, width, height);
    this.box = { left: MARGIN.left, right: width - MARGIN.right, top: MARGIN.top, bottom: height - MARGIN.bottom };
  }
  x(row) { return this.left(this.across.to(row)); }
  left(at) { return this.box.left + ((at - this.ends[0]) / (this.ends[1] - this.ends[0])) * (this.box.right - this.box.left); }
  y(value) { return this.box.bottom - ((value - this.ys[0]) / (this.ys[1] - this.ys[0])) * (this.box.bottom - this.box.top); }
  row(x) { return this.across.from(this.ends[0] + ((x - this.box.left) / (this.box.right - this.box.left)) * (this.ends[1] - this.ends[0])); }
  value(y) { return this.ys[0] + ((this.box.bottom - y) / (this.box.bottom - this.box.top)) * (this.ys[1] - this.ys[0]); }

  /* spec: xs, from and to which row; ys (or null: by the layers), layers */
  draw(spec) {
    this.fit();
    this.ends = spec.xs.map(this.across.to);
    this.ys = spec.ys || reach(spec.layers);
    this.axes();
    const { pen, box } = this;
    pen.save();
    pen.beginPath();
    pen.rect(box.left, box.top, box.right - box.left, box.bottom - box.top);
    pen.clip();
    for (const layer of spec.layers) this[layer.kind](layer);
    pen.restore();
  }
  axes() {
    const { pen, box } = this, across = ticks(...this.ends, this.most), up = ticks(...this.ys, Math.max(3, (box.bottom - box.top) / 34));
    pen.font = "12px system-ui, sans-serif";
    pen.strokeStyle = colour("grid");
    pen.fillStyle = colour("muted");
    pen.lineWidth = 1;
    pen.textAlign = "right";
    pen.textBaseline = "middle";
    pen.beginPath();
    for (const value of up.made) {
      const y = Math.round(this.y(value)) + 0.5;
      pen.moveTo(box.left, y);
      pen.lineTo(box.right, y);
      pen.fillText(short(value, up.digits), box.left - 6, y);
    }
    pen.stroke();
    pen.textBaseline = "top";
    for (const at of across.made.filter((one) => !this.across.isWhole || one === Math.round(one))) {
      const text = this.across.said(at, across.digits), x = this.left(at), half = pen.measureText(text).width / 2;
      pen.textAlign = "center";
      if (x - half > 0 && x + half < box.right + MARGIN.right) pen.fillText(text, x, box.bottom + 6);
    }
  }
  at(count, k, first, last) { return count === 1 ? this.x(first) : this.x(first + ((k + 0.5) * (last - first)) / count - 0.5); }

  /* Between low and high; pieces where both are numbers */
  band({ low, high, first, last, colour: name, alpha = 0.18 }) {
    const { pen } = this, n = low.length;
    pen.fillStyle = colour(name);
    pen.globalAlpha = alpha;
    for (let a = 0; a < n; a++) {
      if (Number.isNaN(low[a])) continue;
      let b = a;
      while (b + 1 < n && !Number.isNaN(low[b + 1])) b++;
      pen.beginPath();
      for (let k = a; k <= b; k++) pen.lineTo(this.at(n, k, first, last), this.y(high[k]));
      for (let k = b; k >= a; k--) pen.lineTo(this.at(n, k, first, last), this.y(low[k]));
      pen.fill();
      a = b;
    }
    pen.globalAlpha = 1;
  }
  line({ low, high, first, last, colour: name, width = 1.6, dash = [] }) {
    const { pen } = this, n = low.length;
    pen.strokeStyle = colour(name);
    pen.lineWidth = width;
    pen.lineJoin = "round";
    pen.setLineDash(dash);
    pen.beginPath();
    let begins = true;
    for (let k = 0; k < n; k++) {
      if (Number.isNaN(low[k])) { begins = true; continue; }
      const x = this.at(n, k, first, last);
      pen[begins ? "moveTo" : "lineTo"](x, this.y(high[k]));
      if (high[k] !== low[k]) pen.lineTo(x, this.y(low[k]));
      begins = false;
    }
    pen.stroke();
    pen.setLineDash([]);
  }
  points({ low, high, first, last, colour: name }) {
    if (low.length < last - first) return this.spans({ low, high, first, last, colour: name });
    this.dots({ low, high, first, last, colour: name }, low.length > (this.box.right - this.box.left) / 3 ? 1.2 : 2);
  }
  dots({ low, high, first, last, colour: name }, size) {
    const { pen } = this, n = low.length;
    pen.fillStyle = colour(name);
    for (let k = 0; k < n; k++) {
      if (Number.isNaN(low[k])) continue;
      const x = this.at(n, k, first, last);
      for (const value of high[k] === low[k] ? [low[k]] : [low[k], high[k]]) {
        const y = this.y(value), edge = y < this.box.top ? this.box.top : y > this.box.bottom ? this.box.bottom : null;
        pen.beginPath();
        if (edge === null) pen.arc(x, y, size, 0, 7);
        else for (const [dx, dy] of [[0, 0], [-4, 7], [4, 7]]) pen.lineTo(x + dx, edge === this.box.top ? edge + dy : edge - dy); // farther than the picture
        pen.fill();
      }
    }
  }
  /* Of many rows in a column: from the least to the most; where most columns have one value, or none, as dots */
  spans({ low, high, first, last, colour: name }) {
    const { pen } = this, n = low.length;
    const several = low.reduce((count, one, k) => count + (high[k] > one), 0), some = low.reduce((count, one) => count + !Number.isNaN(one), 0);
    if (several < 0.2 * some) return this.dots({ low, high, first, last, colour: name }, 1.8);
    pen.strokeStyle = colour(name);
    pen.lineWidth = 1;
    pen.globalAlpha = 0.55;
    pen.beginPath();
    for (let k = 0; k < n; k++) {
      if (Number.isNaN(low[k])) continue;
      const x = this.at(n, k, first, last);
      pen.moveTo(x, this.y(high[k]) - 0.5);
      pen.lineTo(x, this.y(low[k]) + 0.5);
    }
    pen.stroke();
    pen.globalAlpha = 1;
  }
  bars({ values, colour: name }) {
    const { pen } = this, width = Math.max(2, (0.5 * (this.box.right - this.box.left)) / (values.length + 1));
    pen.fillStyle = colour(name);
    values.forEach((one, k) => pen.fillRect(this.x(k + 1) - width / 2, Math.min(this.y(0), this.y(one)), width, Math.abs(this.y(one) - this.y(0))));
  }
  level({ value, colour: name, dash = [] }) {
    const { pen } = this, y = this.y(value);
    pen.strokeStyle = colour(name);
    pen.lineWidth = 1;
    pen.setLineDash(dash);
    pen.beginPath();
    pen.moveTo(this.box.left, y);
    pen.lineTo(this.box.right, y);
    pen.stroke();
    pen.setLineDash([]);
  }
  marked({ from, to, colour: name }) {
    const { pen } = this, a = this.x(from - 0.5), b = this.x(to - 0.5);
    pen.fillStyle = colour(name);
    pen.globalAlpha = 0.12;
    pen.fillRect(a, this.box.top, b - a, this.box.bottom - this.box.top);
    pen.globalAlpha = 1;
  }
}

/* Of all that is drawn, with a little room; bands that are far wider than the rest are cut off */
function reach(layers) {
  const ends = (kinds) => {
    let low = Infinity, high = -Infinity;
    for (const one of layers) {
      if (!kinds.includes(one.kind)) continue;
      if (one.kind === "level") { low = Math.min(low, one.value); high = Math.max(high, one.value); }
      for (const values of one.low ? [one.low, one.high] : []) for (const v of values) if (Number.isFinite(v)) { if (v < low) low = v; if (v > high) high = v; }
    }
    return [low, high];
  };
  let [low, high] = ends(["line", "points", "level"]);
  const [a, b] = ends(["band"]);
  const room = 0.75 * (high - low);
  if (Number.isFinite(room)) { low = Math.max(Math.min(a, low), low - room); high = Math.min(Math.max(b, high), high + room); }
  if (!(high > low)) [low, high] = Number.isFinite(low) ? [low - 1, low + 1] : [-1, 1];
  return [low - 0.04 * (high - low), high + 0.04 * (high - low)];
}

/* Around 0, of points with few far ones: those are drawn at the edge */
function around({ low, high }) {
  const sizes = [];
  for (let k = 0; k < low.length; k++) if (Number.isFinite(low[k])) sizes.push(Math.max(Math.abs(low[k]), Math.abs(high[k])));
  const most = sizes.sort((a, b) => a - b)[Math.floor(0.98 * (sizes.length - 1))];
  return most > 0 ? [-1.35 * most, 1.35 * most] : [-1, 1];
}
