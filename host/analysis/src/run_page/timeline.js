// Timeline at the bottom of the window: the whole run with marks of its events, playback,
// and keys.
//
// The slider is a range input over the drawing, which shows its thumb: so keyboard and
// screen readers have a slider, and the drawing has its marks.

"use strict";

// Half the width of the slider's thumb in px, as in the style.
const THUMB = 8;

const MARK_COLOURS = {
  command: "--link",
  push: "--bad",
  fault: "--bad",
  mode: "--muted",
  board: "--muted",
  link: "--fair",
};

class Timeline {
  constructor() {
    this.canvas = document.getElementById("overview");
    this.slider = document.getElementById("slider");
    this.hint = document.getElementById("hint");
    this.clock = document.getElementById("clock");
    this.button = document.getElementById("play");
    const { slider } = this;
    slider.min = DATA.from;
    slider.max = DATA.to;
    slider.step = "any";
    slider.addEventListener("input", () => seek(Number(slider.value)));
    slider.addEventListener("pointermove", (event) => this.showHint(offset(event)));
    slider.addEventListener("pointerleave", () => (this.hint.hidden = true));
    this.button.addEventListener("click", togglePlay);
    document.getElementById("rate").addEventListener("change", (event) => {
      app.rate = Number(event.target.value);
    });
    document.getElementById("loop").addEventListener("click", ({ currentTarget }) => {
      app.isLooping = !app.isLooping;
      currentTarget.setAttribute("aria-pressed", String(app.isLooping));
    });
    document.getElementById("before").addEventListener("click", () => jump(-1));
    document.getElementById("after").addEventListener("click", () => jump(1));
    document.getElementById("reset").addEventListener("click", () => zoomTo(DATA.from, DATA.to));
  }

  x(time) {
    const inner = this.canvas.clientWidth - 2 * THUMB;
    return THUMB + ((time - DATA.from) / (DATA.to - DATA.from)) * inner;
  }

  // The event whose mark is at x, in words.
  showHint(x) {
    const near = DATA.events
      .map((event) => [Math.abs(this.x(event.time) - x), event])
      .reduce((a, b) => (b[0] < a[0] ? b : a), [8, null])[1];
    this.hint.hidden = !near;
    if (!near) return;
    this.hint.textContent = `${near.time.toFixed(2)} s · ${near.text}`;
    const width = this.canvas.clientWidth;
    this.hint.style.left = `${Math.max(0, Math.min(width - this.hint.offsetWidth, this.x(near.time) - 20))}px`;
  }

  draw(time) {
    const { context, width, height } = fit(this.canvas);
    const area = (from, to, fill, opacity) => {
      context.globalAlpha = opacity;
      context.fillStyle = colour(fill);
      context.fillRect(this.x(from), 0, Math.max(1.5, this.x(to) - this.x(from)), height);
      context.globalAlpha = 1;
    };
    context.fillStyle = colour("--soft");
    context.fillRect(THUMB, 0, width - 2 * THUMB, height);
    for (const [from, to] of FAULTS) area(from, to, "--bad", 0.2);
    for (const [from, to] of DATA.gaps) area(from, to, "--gap", 1);
    this.drawCurves(context, height);
    for (const event of DATA.events) {
      const isLoud = event.level !== "info" || event.kind === "push";
      context.fillStyle = colour(event.level === "error" ? "--bad" : MARK_COLOURS[event.kind]);
      const mark = isLoud ? [2, height] : event.kind === "command" ? [2, 12] : [1, 6];
      context.fillRect(this.x(event.time) - mark[0] / 2, 0, ...mark);
    }
    const [from, to] = app.range;
    if (from > DATA.from || to < DATA.to) {
      context.globalAlpha = 0.6;
      context.fillStyle = colour("--paper");
      context.fillRect(0, 0, this.x(from), height);
      context.fillRect(this.x(to), 0, width, height);
      context.globalAlpha = 1;
      context.strokeStyle = colour("--link");
      context.strokeRect(this.x(from), 0.5, this.x(to) - this.x(from), height - 1);
    }
    const x = this.x(time);
    context.strokeStyle = context.fillStyle = colour("--cursor");
    context.lineWidth = 2;
    line(context, [x, 0], [x, height]);
    context.beginPath();
    context.arc(x, height / 2, THUMB - 1, 0, 2 * Math.PI);
    context.fill();
  }

  // The angles, in one scale.
  drawCurves(context, height) {
    const { times, series } = RUN.curves;
    const shown = ["angle1", "angle2"].slice(0, DATA.torque_limits.length).filter((name) => series[name]);
    let most = 0.05;
    for (const name of shown) {
      for (let row = 0; row < times.length; row += 7) {
        const value = Math.abs(series[name].high[row]);
        if (value > most) most = value;
      }
    }
    const every = Math.max(1, Math.floor(times.length / 2000));
    context.lineWidth = 1;
    shown.forEach((name, joint) => {
      context.strokeStyle = colour(`--j${joint + 1}`);
      context.globalAlpha = 0.7;
      context.beginPath();
      let isDown = false;
      for (let row = 0; row < times.length; row += every) {
        const value = series[name].high[row];
        const [x, y] = [this.x(times[row]), height / 2 - (value / most) * (height / 2 - 4)];
        if (Number.isNaN(value)) isDown = false;
        else if (isDown) context.lineTo(x, y);
        else {
          context.moveTo(x, y);
          isDown = true;
        }
      }
      context.stroke();
      context.globalAlpha = 1;
    });
  }

  update(time) {
    this.draw(time);
    this.slider.value = time;
    const mode = modeAt(time);
    this.slider.setAttribute("aria-valuetext", `${time.toFixed(2)} seconds, ${mode}`);
    this.clock.textContent = `${time.toFixed(2).replace("-", "−")} s`;
    this.button.setAttribute("aria-label", app.isPlaying ? "Pause" : "Play");
    this.button.classList.toggle("playing", app.isPlaying);
    const isZoomed = app.range[0] > DATA.from || app.range[1] < DATA.to;
    document.getElementById("reset").disabled = !isZoomed;
  }
}

// Jumps to the next event, or to the one before.
function jump(direction) {
  const times = DATA.events.map((event) => event.time);
  const found =
    direction > 0
      ? times.find((time) => time > app.time + 1e-3)
      : times.findLast((time) => time < app.time - 1e-3);
  if (found !== undefined) seek(found);
}

function onKey(event) {
  const { key, target } = event;
  const isTyping = target.matches("input[type=search], select, textarea");
  if (isTyping || event.ctrlKey || event.metaKey || event.altKey) return;
  // A button or a link does its own thing on space.
  if (key === " " && target.matches("button, a, summary")) return;
  const span = app.range[1] - app.range[0];
  const step = event.shiftKey ? span / 10 : span / 100;
  const actions = {
    " ": togglePlay,
    ArrowLeft: () => seek(app.time - step),
    ArrowRight: () => seek(app.time + step),
    Home: () => seek(DATA.from),
    End: () => seek(DATA.to),
    "[": () => jump(-1),
    "]": () => jump(1),
    "+": () => zoomAbout(app.time, 0.5),
    "=": () => zoomAbout(app.time, 0.5),
    "-": () => zoomAbout(app.time, 2),
    0: () => zoomTo(DATA.from, DATA.to),
  };
  const action = actions[key];
  if (!action) return;
  // The canvas of the arm and lists scroll by these keys otherwise.
  event.preventDefault();
  action();
}
