// State of the page, and its drawing: once a frame at most.

"use strict";

const app = {
  time: 0,
  // Time under the pointer, which goes before `time` while nothing plays.
  hovered: null,
  range: [DATA.from, DATA.to],
  selection: null,
  isPlaying: false,
  isLooping: false,
  rate: 1,
};

// Shortest interval that is shown, in s.
const SPAN_MIN_S = 0.01;

const arm = new ArmView(document.getElementById("arm"));
const panels = PANELS.map((panel) => new Panel(panel, document.getElementById("panels")));
const timeline = new Timeline();
const events = new EventTable();
attachSettings();
attachCopies();

let isCursorDue = false;
let isAllDue = false;

function redrawCursor() {
  if (!isCursorDue) requestAnimationFrame(draw);
  isCursorDue = true;
}

function redraw() {
  isAllDue = true;
  redrawCursor();
}

function draw() {
  isCursorDue = false;
  if (isAllDue) for (const panel of panels) panel.draw();
  isAllDue = false;
  const time = app.hovered ?? app.time;
  for (const panel of panels) panel.drawCursor(time, app.selection);
  arm.draw(time);
  timeline.update(app.time);
  events.update(time);
  showReadout(time);
}

function seek(time) {
  app.time = Math.min(DATA.to, Math.max(DATA.from, time));
  app.hovered = null;
  redrawCursor();
}

function hover(time) {
  app.hovered = time === null ? null : Math.min(app.range[1], Math.max(app.range[0], time));
  redrawCursor();
}

function zoomTo(from, to) {
  const span = Math.min(DATA.to - DATA.from, Math.max(SPAN_MIN_S, to - from));
  const start = Math.min(DATA.to - span, Math.max(DATA.from, from));
  app.range = [start, start + span];
  redraw();
}

function zoomAbout(time, scale) {
  const [from, to] = app.range;
  zoomTo(time - (time - from) * scale, time + (to - time) * scale);
}

function togglePlay() {
  app.isPlaying = !app.isPlaying;
  if (!app.isPlaying) return redrawCursor();
  app.hovered = null;
  if (app.time >= DATA.to) app.time = DATA.from;
  let last = null;
  const step = (now) => {
    if (!app.isPlaying) return;
    const elapsed = last === null ? 0 : Math.min(0.1, (now - last) / 1000);
    last = now;
    advance(elapsed * app.rate);
    requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
}

// Moves on; a zoomed interval moves along.
function advance(by) {
  const [from, to] = app.range;
  const wasShown = app.time >= from && app.time <= to;
  let time = app.time + by;
  if (time >= DATA.to) {
    if (app.isLooping) time = DATA.from;
    else app.isPlaying = false;
  }
  seek(time);
  if (wasShown && time > to) zoomTo(time, time + to - from);
  else if (wasShown && time < from) zoomTo(DATA.from, DATA.from + to - from);
}

function showView(name) {
  for (const button of document.querySelectorAll("[data-view]")) {
    button.setAttribute("aria-pressed", String(button.dataset.view === name));
  }
}

for (const button of document.querySelectorAll("[data-view]")) {
  button.addEventListener("click", () => {
    showView(button.dataset.view);
    arm.show(button.dataset.view);
  });
}

// `#t=4.2&from=3&to=6` opens the page at a moment and an interval.
function openLink() {
  const link = new URLSearchParams(location.hash.slice(1));
  const [time, from, to] = ["t", "from", "to"].map((name) => parseFloat(link.get(name)));
  if (from < to) zoomTo(from, to);
  if (!Number.isNaN(time)) seek(time);
  return !Number.isNaN(time);
}

document.addEventListener("keydown", onKey);
window.addEventListener("hashchange", openLink);
new ResizeObserver(redraw).observe(document.getElementById("panels"));
for (const query of ["(prefers-color-scheme: dark)", "(resolution: 1dppx)"]) {
  matchMedia(query).addEventListener("change", () => {
    COLOURS.clear();
    redraw();
  });
}
window.addEventListener("beforeprint", () => draw());

seek(Math.max(0, DATA.from));
redraw();
// A short run plays when it is opened, unless its reader asked for less motion.
const isStill = matchMedia("(prefers-reduced-motion: reduce)").matches;
if (!openLink() && !isStill && DATA.to - DATA.from <= 60) togglePlay();
