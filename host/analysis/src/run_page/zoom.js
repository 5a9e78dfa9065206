// Pointers and wheel over the curves.

"use strict";

const offset = (event) => event.clientX - event.currentTarget.getBoundingClientRect().left;

function attachZoom(canvas, panel) {
  const fingers = new Map();
  let drag = null;

  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    canvas.setPointerCapture(event.pointerId);
    const x = offset(event);
    if (event.pointerType === "touch") {
      fingers.set(event.pointerId, x);
      if (fingers.size === 1) seek(panel.time(x));
      return;
    }
    drag = { x, time: panel.time(x), range: [...app.range], isPan: event.shiftKey, isMoved: false };
  });

  canvas.addEventListener("pointermove", (event) => {
    const x = offset(event);
    if (fingers.has(event.pointerId)) {
      moveFinger(event.pointerId, x);
    } else if (drag) {
      drag.isMoved ||= Math.abs(x - drag.x) > 4;
      if (drag.isMoved) moveDrag(x);
    } else if (!app.isPlaying) {
      hover(panel.time(x));
    }
  });

  function moveFinger(id, x) {
    const before = new Map(fingers);
    fingers.set(id, x);
    if (fingers.size === 1) {
      seek(panel.time(x));
    } else if (fingers.size === 2) {
      const [[a, b], [c, d]] = [before, fingers].map((all) => [...all.values()].sort((p, q) => p - q));
      const [first, last] = [panel.time(a), panel.time(b)];
      const scale = (last - first) / Math.max(20, d - c);
      const from = first - (c - MARGIN.left) * scale;
      zoomTo(from, from + panel.inner() * scale);
    }
  }

  function moveDrag(x) {
    if (drag.isPan) {
      const [from, to] = drag.range;
      const by = ((x - drag.x) / panel.inner()) * (to - from);
      zoomTo(from - by, to - by);
    } else {
      app.selection = [drag.time, panel.time(x)];
      redrawCursor();
    }
  }

  canvas.addEventListener("pointerup", (event) => {
    fingers.delete(event.pointerId);
    if (!drag) return;
    const { isMoved, isPan, time } = drag;
    drag = null;
    const selection = app.selection;
    app.selection = null;
    if (!isMoved) seek(time);
    else if (!isPan && selection) zoomTo(Math.min(...selection), Math.max(...selection));
    redrawCursor();
  });

  canvas.addEventListener("pointercancel", (event) => {
    fingers.delete(event.pointerId);
    drag = app.selection = null;
    redrawCursor();
  });

  canvas.addEventListener("pointerleave", () => hover(null));
  canvas.addEventListener("dblclick", () => zoomTo(DATA.from, DATA.to));

  canvas.addEventListener(
    "wheel",
    (event) => {
      const isZoom = event.ctrlKey || document.activeElement === canvas;
      const isPan = event.shiftKey || Math.abs(event.deltaX) > Math.abs(event.deltaY);
      if (!isZoom && !isPan) return;
      const [from, to] = app.range;
      if (isPan) {
        if (to - from >= DATA.to - DATA.from) return;
        const by = ((event.deltaX || event.deltaY) / panel.inner()) * (to - from);
        zoomTo(from + by, to + by);
      } else {
        if (event.deltaY > 0 && to - from >= DATA.to - DATA.from) return;
        zoomAbout(panel.time(offset(event)), Math.exp(event.deltaY * (event.ctrlKey ? 0.008 : 0.0015)));
      }
      event.preventDefault();
    },
    { passive: false },
  );
}
