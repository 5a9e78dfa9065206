// Curves over time, panel below panel, with one time axis and one cursor.
//
// Drag zooms to an interval, with shift it moves the interval; two fingers zoom. The wheel
// zooms with Ctrl, or after a click into a panel: otherwise it scrolls the page.

"use strict";

const MARGIN = { left: 54, right: 24, top: 6, bottom: 22 };

// A curve: name of its series, label, and the colour's name in the style.
const curve = (name, label, colour, more = {}) => ({ name, label, colour, run: RUN, ...more });

function jointCurves(joint) {
  return [
    curve(`encoder${joint}`, "encoder", `--j${joint}-tint`, { isDots: true }),
    curve(`true_angle${joint}`, "true angle", "--true", { width: 1.2 }),
    curve(`angle${joint}`, "estimate", `--j${joint}`, { width: 1.8 }),
    curve(`reference${joint}`, "setpoint", "--ink", { dash: [5, 4], width: 1.2 }),
  ];
}

// Numbers of the joints.
const JOINTS = DATA.torque_limits.map((_, index) => index + 1);
const eachJoint = (name, more = {}) =>
  JOINTS.map((joint) => curve(name + joint, `joint ${joint}`, `--j${joint}`, { width: 1.5, ...more }));

// The same curves of the second run, below the others.
function besides(names) {
  if (!BESIDE) return [];
  const isPair = names.length > 1;
  return names.map((name) => {
    const joint = name.slice(-1);
    const dash = isPair && joint === "2" ? [2, 2] : [];
    return curve(name, isPair ? `grey ${joint}` : BESIDE.name, "--grey", { run: BESIDE, width: 1.5, dash });
  });
}

const besidesEach = (name) => besides(JOINTS.map((joint) => name + joint));

const PANELS = [
  ...JOINTS.map((joint) => ({
    title: `Joint ${joint}`,
    unit: "rad",
    digits: 3,
    curves: [...besides([`angle${joint}`]), ...jointCurves(joint)],
  })),
  {
    title: "Error",
    unit: "mrad",
    digits: 1,
    factor: 1000,
    band: DATA.settled * 1000,
    curves: [...besidesEach("error"), ...eachJoint("error")],
  },
  {
    title: "Speed",
    unit: "rad/s",
    digits: 2,
    curves: [...besidesEach("speed").map(hidden), ...eachJoint("speed"), ...JOINTS.map((joint) =>
      curve(`reference_speed${joint}`, `reference ${joint}`, "--ink", { dash: [5, 4], width: 1, isHidden: true }),
    )],
  },
  {
    title: "Torque",
    unit: "N m",
    digits: 3,
    limits: DATA.torque_limits,
    curves: [...besidesEach("torque").map(hidden), ...eachJoint("torque"), ...JOINTS.map((joint) =>
      curve(`disturbance${joint}`, `disturbance ${joint}`, `--j${joint}`, { dash: [2, 3], width: 1, isHidden: true }),
    )],
  },
];

function hidden(curve) {
  return { ...curve, isHidden: true };
}

// Round values of an axis, at most `count`.
function ticks(low, high, count) {
  const rough = (high - low) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5].find((k) => k * power >= rough) ?? 10);
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const first = Math.ceil(low / step - 1e-9);
  const values = [];
  for (let i = first; i * step <= high + step * 1e-9; i++) {
    values.push([i * step, (i * step).toFixed(digits).replace(/^-0(\.0*)?$/, "0").replace("-", "−")]);
  }
  return values;
}

class Panel {
  constructor({ title, unit, digits, factor = 1, band, limits, curves }, parent) {
    Object.assign(this, { unit, digits, factor, band, limits });
    this.curves = curves.filter(({ name, run }) => run && run.curves.series[name]);
    this.box = document.createElement("figure");
    this.box.className = "panel";
    const head = this.box.appendChild(document.createElement("figcaption"));
    const name = head.appendChild(document.createElement("strong"));
    name.textContent = `${title} (${unit})`;
    const isOther = ({ run }) => run === BESIDE;
    const keys = [...this.curves.filter((shown) => !isOther(shown)), ...this.curves.filter(isOther)];
    for (const shown of keys) head.appendChild(this.key(shown));
    const stack = this.box.appendChild(document.createElement("div"));
    stack.className = "stack";
    this.base = stack.appendChild(document.createElement("canvas"));
    this.overlay = stack.appendChild(document.createElement("canvas"));
    this.overlay.tabIndex = 0;
    this.overlay.setAttribute("role", "img");
    this.overlay.setAttribute("aria-label", `${title} in ${unit} over time. Plus and minus zoom, 0 shows all.`);
    parent.appendChild(this.box);
    attachZoom(this.overlay, this);
  }

  // Entry of the legend, which hides its curve and has its value at the cursor.
  key(shown) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "key";
    const swatch = button.appendChild(document.createElement("i"));
    swatch.style.borderTopColor = `var(${shown.colour})`;
    swatch.style.borderTopStyle = shown.dash?.length ? "dashed" : shown.isDots ? "dotted" : "solid";
    button.append(shown.label);
    shown.value = button.appendChild(document.createElement("b"));
    const press = () => button.setAttribute("aria-pressed", String(!shown.isHidden));
    press();
    button.addEventListener("click", () => {
      shown.isHidden = !shown.isHidden;
      press();
      redraw();
    });
    return button;
  }

  // Time at a distance from the canvas's left edge, and back.
  time(x) {
    const [from, to] = app.range;
    return from + ((x - MARGIN.left) / this.inner()) * (to - from);
  }

  x(time) {
    const [from, to] = app.range;
    return MARGIN.left + ((time - from) / (to - from)) * this.inner();
  }

  inner() {
    return Math.max(1, this.overlay.clientWidth - MARGIN.left - MARGIN.right);
  }

  y(value) {
    const [low, high] = this.axis;
    const height = this.height - MARGIN.top - MARGIN.bottom;
    return MARGIN.top + ((high - value) / (high - low)) * height;
  }

  // Rows of a curve that are shown, and one more at each end.
  rows(curves) {
    const [from, to] = app.range;
    return [Math.max(0, curves.row(from)), Math.min(curves.times.length - 1, curves.row(to) + 1)];
  }

  // Range of the values that are shown.
  fitAxis() {
    let [low, high] = [Infinity, -Infinity];
    for (const { name, run, isHidden } of this.curves) {
      if (isHidden) continue;
      const series = run.curves.series[name];
      const [first, last] = this.rows(run.curves);
      for (let row = first; row <= last; row++) {
        if (series.low[row] < low) low = series.low[row];
        if (series.high[row] > high) high = series.high[row];
      }
    }
    if (low > high) [low, high] = [-1, 1];
    [low, high] = [low * this.factor, high * this.factor];
    const least = 4 * 10 ** -this.digits;
    const margin = Math.max(0.07 * (high - low), (least - (high - low)) / 2, 0);
    this.axis = [low - margin, high + margin];
  }

  draw() {
    this.fitAxis();
    const { context, width, height } = fit(this.base);
    Object.assign(this, { width, height });
    const [right, bottom] = [width - MARGIN.right, height - MARGIN.bottom];
    context.fillStyle = colour("--paper");
    context.fillRect(MARGIN.left, MARGIN.top, right - MARGIN.left, bottom - MARGIN.top);
    this.shade(context, bottom);
    context.font = "11px system-ui, sans-serif";
    context.strokeStyle = colour("--grid");
    context.fillStyle = colour("--muted");
    context.lineWidth = 1;
    context.textAlign = "center";
    for (const [value, label] of ticks(...app.range, this.inner() / 80)) {
      const x = Math.round(this.x(value)) + 0.5;
      line(context, [x, MARGIN.top], [x, bottom]);
      context.fillText(`${label} s`, x, bottom + 14);
    }
    context.textAlign = "right";
    for (const [value, label] of ticks(...this.axis, height / 34)) {
      const y = Math.round(this.y(value)) + 0.5;
      line(context, [MARGIN.left, y], [right, y]);
      context.fillText(label, MARGIN.left - 6, y + 4);
    }
    context.save();
    context.beginPath();
    context.rect(MARGIN.left, MARGIN.top, right - MARGIN.left, bottom - MARGIN.top);
    context.clip();
    this.drawLimits(context, right);
    for (const shown of this.curves) if (!shown.isHidden) this.drawCurve(context, shown);
    this.cover(context, bottom);
    context.restore();
    context.strokeStyle = colour("--frame");
    context.strokeRect(MARGIN.left + 0.5, MARGIN.top + 0.5, right - MARGIN.left - 1, bottom - MARGIN.top - 1);
  }

  // Faults and pushes, behind the curves.
  shade(context, bottom) {
    const area = ([from, to], fill, opacity) => {
      const [left, right] = [from, to].map((time) =>
        Math.min(this.width - MARGIN.right, Math.max(MARGIN.left, this.x(time))),
      );
      if (to < app.range[0] || from > app.range[1]) return;
      context.globalAlpha = opacity;
      context.fillStyle = colour(fill);
      context.fillRect(left, MARGIN.top, Math.max(1.5, right - left), bottom - MARGIN.top);
      context.globalAlpha = 1;
    };
    for (const interval of FAULTS) area(interval, "--bad", 0.12);
    for (const [start, duration] of DATA.pushes) area([start, start + duration], "--bad", 0.35);
    if (this.band) {
      const [top, low] = [this.band, -this.band].map((value) =>
        Math.min(bottom, Math.max(MARGIN.top, this.y(value))),
      );
      context.globalAlpha = 0.13;
      context.fillStyle = colour("--good");
      context.fillRect(MARGIN.left, top, this.inner(), low - top);
      context.globalAlpha = 1;
    }
  }

  // Time without records, over the curves, which would cross it.
  cover(context, bottom) {
    context.fillStyle = colour("--gap");
    for (const [from, to] of DATA.gaps) {
      const x = this.x(from);
      context.fillRect(x, MARGIN.top, Math.max(1.5, this.x(to) - x), bottom - MARGIN.top);
    }
  }

  drawLimits(context, right) {
    if (!this.limits) return;
    context.setLineDash([3, 3]);
    context.strokeStyle = colour("--bad");
    for (const value of new Set(this.limits.flat())) {
      const y = this.y(value);
      line(context, [MARGIN.left, y], [right, y]);
    }
    context.setLineDash([]);
  }

  drawCurve(context, { name, run, colour: ink, width = 1.5, dash = [], isDots }) {
    const { times } = run.curves;
    let { low, high } = run.curves.series[name];
    const [first, last] = this.rows(run.curves);
    context.fillStyle = context.strokeStyle = colour(ink);
    context.lineWidth = width;
    context.setLineDash(dash);
    if (isDots) {
      const size = last - first > this.inner() ? 2 : 3;
      for (let row = first; row <= last; row++) {
        if (Number.isNaN(low[row])) continue;
        const [top, bottom] = [high[row], low[row]].map((value) => this.y(value * this.factor));
        context.fillRect(this.x(times[row]) - size / 2, top - size / 2, size, bottom - top + size);
      }
      return;
    }
    context.lineJoin = "round";
    if (high !== low && last - first < this.inner()) {
      this.fillEnvelope(context, times, low, high, first, last);
      const middle = low.map((value, row) => (value + high[row]) / 2);
      [low, high] = [middle, middle];
    }
    context.beginPath();
    let isDown = false;
    const to = (x, value) => {
      const y = this.y(value * this.factor);
      if (isDown) context.lineTo(x, y);
      else context.moveTo(x, y);
      isDown = true;
    };
    // Of all rows in one column of pixels, the first, lowest, highest and last are visible.
    let column = null;
    const endColumn = () => {
      if (!column) return;
      const { x, values } = column;
      to(x, values[0]);
      if (column.low < column.high) {
        to(x, column.low);
        to(x, column.high);
      }
      to(x, values[1]);
      column = null;
    };
    for (let row = first; row <= last; row++) {
      if (Number.isNaN(low[row])) {
        endColumn();
        isDown = false;
        continue;
      }
      const x = this.x(times[row]);
      if (column && x - column.x >= 0.5) endColumn();
      column ??= { x, low: Infinity, high: -Infinity, values: [low[row], low[row]] };
      column.low = Math.min(column.low, low[row]);
      column.high = Math.max(column.high, high[row]);
      column.values[1] = low[row];
    }
    endColumn();
    context.stroke();
    context.setLineDash([]);
  }

  // Area from the lowest to the highest values, where rows are wider than pixels.
  fillEnvelope(context, times, low, high, first, last) {
    context.globalAlpha = 0.35;
    for (let row = first; row < last; row++) {
      if (Number.isNaN(low[row])) continue;
      const [left, right] = [times[row], times[row + 1]].map((time) => this.x(time));
      const [top, bottom] = [high[row], low[row]].map((value) => this.y(value * this.factor));
      context.fillRect(left, top, right - left, bottom - top);
    }
    context.globalAlpha = 1;
  }

  drawCursor(time, selection) {
    const { context, width, height } = fit(this.overlay);
    const bottom = height - MARGIN.bottom;
    for (const shown of this.curves) {
      const value = shown.run.curves.at(shown.name, time);
      shown.value.textContent = signed(value * this.factor, this.digits);
    }
    if (selection) {
      const [from, to] = selection.map((at) => this.x(at)).sort((a, b) => a - b);
      context.fillStyle = colour("--link");
      context.globalAlpha = 0.2;
      context.fillRect(from, MARGIN.top, to - from, bottom - MARGIN.top);
      context.globalAlpha = 1;
    }
    const x = this.x(time);
    if (x < MARGIN.left - 0.5 || x > width - MARGIN.right + 0.5) return;
    context.strokeStyle = colour("--cursor");
    context.lineWidth = 1.2;
    line(context, [x, MARGIN.top], [x, bottom]);
    for (const { name, run, colour: ink, isHidden, isDots } of this.curves) {
      const value = run.curves.at(name, time) * this.factor;
      if (isHidden || isDots || Number.isNaN(value)) continue;
      context.fillStyle = colour(ink);
      context.beginPath();
      context.arc(x, this.y(value), 3.5, 0, 2 * Math.PI);
      context.fill();
    }
  }
}

function line(context, [x0, y0], [x1, y1]) {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}
