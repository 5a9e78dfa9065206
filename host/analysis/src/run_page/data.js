// Data of the page: the JSON that the program wrote, with its numbers unpacked.
//
// Times are in s after the arm is armed. A series has the lowest and the highest value of each
// row; in a row of one tick they are the same array. A missing value is NaN.

"use strict";

const DATA = JSON.parse(document.getElementById("data").textContent);

function unpackBytes(base64) {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes;
}

function unpackTimes(times) {
  if (times.f32 !== undefined) return new Float32Array(unpackBytes(times.f32).buffer);
  return Float64Array.from({ length: times.count }, (_, row) => times.from + times.step * row);
}

function unpackSeries({ min, step, low, high }) {
  const values = (base64) =>
    Float32Array.from(new Uint16Array(unpackBytes(base64).buffer), (code) =>
      code === 65535 ? NaN : min + step * code,
    );
  const lowest = values(low);
  return { low: lowest, high: high === undefined ? lowest : values(high) };
}

// Quantities over time.
class Table {
  constructor({ times, series }) {
    this.times = unpackTimes(times);
    this.series = Object.fromEntries(
      Object.entries(series).map(([name, packed]) => [name, unpackSeries(packed)]),
    );
  }

  // The last row that begins at or before a time; -1 before the first.
  row(time) {
    let [low, high] = [0, this.times.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= time) low = middle + 1;
      else high = middle;
    }
    return low - 1;
  }

  // A quantity at a time: of a row of several ticks the middle of its range.
  at(name, time) {
    const series = this.series[name];
    const row = this.row(time + 1e-9);
    return series && row >= 0 ? (series.low[row] + series.high[row]) / 2 : NaN;
  }

  // The same, between rows.
  between(name, time) {
    const row = this.row(time);
    const here = this.at(name, time);
    const series = this.series[name];
    if (!series || row < 0 || row + 1 >= this.times.length) return here;
    const next = (series.low[row + 1] + series.high[row + 1]) / 2;
    if (Number.isNaN(here) || Number.isNaN(next)) return here;
    const [begin, end] = [this.times[row], this.times[row + 1]];
    return here + ((next - here) * (time - begin)) / (end - begin);
  }
}

class Run {
  constructor({ name, every, curves, poses }) {
    this.name = name;
    this.every = every;
    this.curves = new Table(curves);
    this.poses = poses ? new Table(poses) : this.curves;
  }

  // Both joint angles, or the reference's, or null.
  pose(time, name = "angle") {
    const angles = [1, 2].map((joint) => this.poses.between(name + joint, time));
    return angles.some(Number.isNaN) ? null : angles;
  }
}

const [RUN, BESIDE] = DATA.runs.map((run) => new Run(run));

// Name of the mode at a time.
function modeAt(time) {
  let mode = "";
  for (const [start, name] of DATA.modes) {
    if (start > time + 1e-9) break;
    mode = name;
  }
  return mode.replaceAll("_", " ");
}

// Intervals in which a fault is latched.
const FAULTS = DATA.modes.flatMap(([start, name], i) =>
  name === "fault" ? [[start, i + 1 < DATA.modes.length ? DATA.modes[i + 1][0] : DATA.to]] : [],
);

// A number with sign and a fixed number of digits, with the true minus sign.
function signed(value, digits) {
  if (Number.isNaN(value)) return "–";
  const text = Math.abs(value).toFixed(digits);
  return (value < 0 && Number(text) !== 0 ? "−" : "+") + text;
}

// Colours of the page's style by name, as text.
const COLOURS = new Map();
function colour(name) {
  if (!COLOURS.has(name)) {
    const style = getComputedStyle(document.documentElement);
    COLOURS.set(name, style.getPropertyValue(name).trim());
  }
  return COLOURS.get(name);
}

// Sizes a canvas to its box in px of the screen; returns its context, in px of the page.
function fit(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w) canvas.width = w;
  if (canvas.height !== h) canvas.height = h;
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}
