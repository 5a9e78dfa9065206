// The arm in three dimensions: two links on a table, joint 1 about x, joint 2 about y of
// link 1. In colour the run, in grey the second one, dashed the setpoint.

"use strict";

const VIEWS = {
  three: { azimuth: 0.72, elevation: 0.3, perspective: true },
  front: { azimuth: Math.PI / 2, elevation: 0, perspective: false },
  side: { azimuth: 0, elevation: 0, perspective: false },
};

const add = (a, b, k = 1) => [a[0] + k * b[0], a[1] + k * b[1], a[2] + k * b[2]];

// Positions of elbow and tip, and the axes of both links, at joint angles.
function links([q1, q2]) {
  const { l1, l2, is_hanging: isHanging } = DATA.arm;
  const [s1, c1] = [Math.sin, Math.cos].map((f) => f(q1 + (isHanging ? Math.PI : 0)));
  const [s2, c2] = [Math.sin(q2), Math.cos(q2)];
  const turned = ([x, y, z]) => [x, y * c1 - z * s1, y * s1 + z * c1];
  const first = [[1, 0, 0], turned([0, 1, 0]), turned([0, 0, 1])];
  const second = [turned([c2, 0, -s2]), first[1], turned([s2, 0, c2])];
  const elbow = add([0, 0, 0], first[2], l1);
  return { first, second, elbow, tip: add(elbow, second[2], l2) };
}

class ArmView {
  constructor(canvas) {
    this.canvas = canvas;
    this.camera = { ...VIEWS.three };
    this.reach = DATA.arm.l1 + DATA.arm.l2;
    let last = null;
    canvas.addEventListener("pointerdown", (event) => {
      last = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!last) return;
      this.turn((event.clientX - last[0]) * 0.01, (event.clientY - last[1]) * 0.01);
      last = [event.clientX, event.clientY];
    });
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, () => (last = null));
    }
  }

  turn(azimuth, elevation) {
    const camera = this.camera;
    camera.perspective = true;
    camera.azimuth -= azimuth;
    camera.elevation = Math.min(1.4, Math.max(0, camera.elevation + elevation));
    showView(null);
    redraw();
  }

  show(name) {
    this.camera = { ...VIEWS[name] };
    redraw();
  }

  // Point of the canvas, and depth, of a point in m.
  project([x, y, z]) {
    const { azimuth, elevation, perspective } = this.camera;
    const [sa, ca] = [Math.sin(azimuth), Math.cos(azimuth)];
    const [se, ce] = [Math.sin(elevation), Math.cos(elevation)];
    const up = z - this.centre;
    const away = x * sa + y * ca;
    const depth = away * ce - up * se;
    const distance = 5 * this.reach;
    const k = this.scale * (perspective ? distance / (distance + depth) : 1);
    return [
      this.width / 2 + k * (x * ca - y * sa),
      this.height / 2 - k * (up * ce + away * se),
      depth,
    ];
  }

  draw(time) {
    const { context, width, height } = fit(this.canvas);
    Object.assign(this, { context, width, height });
    const upwards = DATA.arm.is_hanging ? -1 : 1;
    this.centre = upwards * 0.5 * this.reach;
    this.scale = Math.min(width / 1.75, height / 1.7) / this.reach;
    const shapes = [];
    this.drawTable();
    const pose = RUN.pose(time);
    const grey = BESIDE && BESIDE.pose(time);
    if (grey) this.drawShadow(grey, 0.06);
    if (pose) {
      this.drawShadow(pose, 0.16);
      this.drawTrail(time);
    }
    if (grey) shapes.push(...this.armShapes(grey, [colour("--grey"), colour("--grey")], 0.55));
    if (pose) shapes.push(...this.armShapes(pose, [colour("--j1"), colour("--j2")], 1));
    shapes.push(...this.foot());
    shapes.sort((a, b) => b.depth - a.depth);
    for (const shape of shapes) shape.draw();
    const setpoint = RUN.pose(time, "reference");
    if (setpoint) this.drawSetpoint(setpoint);
    if (pose) this.drawPush(pose, time);
  }

  // A line through points in m.
  path(points, isClosed = false) {
    this.context.beginPath();
    points.forEach((point, i) => {
      const [x, y] = this.project(point);
      if (i) this.context.lineTo(x, y);
      else this.context.moveTo(x, y);
    });
    if (isClosed) this.context.closePath();
  }

  circle(radius, z = 0) {
    const turn = (i) => (i / 48) * 2 * Math.PI;
    return Array.from({ length: 48 }, (_, i) => [
      radius * Math.cos(turn(i)),
      radius * Math.sin(turn(i)),
      z,
    ]);
  }

  drawTable() {
    const { context, reach } = this;
    this.path(this.circle(0.75 * reach), true);
    context.fillStyle = colour("--soft");
    context.fill();
    context.lineWidth = 1;
    context.strokeStyle = colour("--line");
    context.stroke();
    for (const radius of [0.25, 0.5]) {
      this.path(this.circle(radius * reach), true);
      context.stroke();
    }
    const end = 0.75 * reach;
    for (const axis of [[1, 0, 0], [0, 1, 0]]) {
      this.path([add([0, 0, 0], axis, -end), add([0, 0, 0], axis, end)]);
      context.stroke();
    }
  }

  drawShadow(pose, opacity) {
    const { context } = this;
    const { elbow, tip } = links(pose);
    this.path([[0, 0, 0], [elbow[0], elbow[1], 0], [tip[0], tip[1], 0]]);
    context.globalAlpha = opacity;
    context.strokeStyle = colour("--ink");
    context.lineWidth = 0.075 * this.reach * this.scale;
    context.lineCap = context.lineJoin = "round";
    context.stroke();
    context.globalAlpha = 1;
  }

  // Way of the tip in the last second.
  drawTrail(time) {
    const { context } = this;
    context.strokeStyle = colour("--j2");
    context.lineWidth = 2;
    let before = null;
    for (let i = 0; i <= 40; i++) {
      const pose = RUN.pose(time - 1 + i / 40);
      const tip = pose && links(pose).tip;
      if (tip && before) {
        this.path([before, tip]);
        context.globalAlpha = (0.5 * i) / 40;
        context.stroke();
      }
      before = tip;
    }
    context.globalAlpha = 1;
  }

  // A box along a link, from one distance of its origin to another.
  box(origin, axes, [from, to], [wide, deep], fill, opacity) {
    const corner = (x, y, z) =>
      add(add(add(origin, axes[0], x * wide), axes[1], y * deep), axes[2], z ? to : from);
    const faces = [
      [[1, -1, 0], [1, 1, 0], [1, 1, 1], [1, -1, 1]],
      [[-1, 1, 0], [-1, -1, 0], [-1, -1, 1], [-1, 1, 1]],
      [[1, 1, 0], [-1, 1, 0], [-1, 1, 1], [1, 1, 1]],
      [[-1, -1, 0], [1, -1, 0], [1, -1, 1], [-1, -1, 1]],
      [[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]],
      [[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]],
    ];
    const normals = [axes[0], axes[0], axes[1], axes[1], axes[2], axes[2]];
    const rgb = [1, 3, 5].map((i) => parseInt(fill.slice(i, i + 2), 16));
    const draw = () => {
      const { context } = this;
      context.globalAlpha = opacity;
      faces.forEach((face, i) => {
        const points = face.map((at) => this.project(corner(...at)));
        const [a, b, c] = points;
        // A face that is seen from outside turns left on the canvas, whose y points down.
        if ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0) return;
        const sign = i % 2 ? -1 : 1;
        const [x, y, z] = normals[i].map((value) => value * sign);
        const light = Math.min(1.18, 0.86 + 0.2 * z - 0.14 * y + 0.1 * x);
        const shade = (value) => Math.min(255, Math.round(value * light));
        context.fillStyle = `rgb(${rgb.map(shade).join(",")})`;
        context.strokeStyle = context.fillStyle;
        context.lineWidth = 0.7;
        context.beginPath();
        points.forEach(([px, py], k) => (k ? context.lineTo(px, py) : context.moveTo(px, py)));
        context.closePath();
        context.fill();
        context.stroke();
      });
      context.globalAlpha = 1;
    };
    const middle = add(origin, axes[2], (from + to) / 2);
    return { depth: this.project(middle)[2], draw };
  }

  armShapes(pose, [first, second], opacity) {
    const { l1, l2 } = DATA.arm;
    const unit = this.reach;
    const at = links(pose);
    const servo = colour("--servo");
    return [
      this.box([0, 0, 0], at.first, [0.06 * unit, l1 - 0.07 * unit], [0.042 * unit, 0.03 * unit], first, opacity),
      this.box(at.elbow, at.first, [-0.075 * unit, 0.07 * unit], [0.075 * unit, 0.055 * unit], servo, opacity),
      this.box(at.elbow, at.second, [0.05 * unit, l2], [0.03 * unit, 0.042 * unit], second, opacity),
      this.box(at.elbow, at.second, [l2 - 0.012 * unit, l2 + 0.05 * unit], [0.045 * unit, 0.055 * unit], second, opacity),
    ];
  }

  // Servo of joint 1, on the table.
  foot() {
    const axes = [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    const unit = this.reach;
    const servo = colour("--servo");
    return [this.box([0, 0, 0], axes, [-0.075 * unit, 0.07 * unit], [0.11 * unit, 0.085 * unit], servo, 1)];
  }

  drawSetpoint(pose) {
    const { context } = this;
    const { elbow, tip } = links(pose);
    context.strokeStyle = colour("--ink");
    context.lineWidth = 1.6;
    context.setLineDash([6, 4]);
    this.path([[0, 0, 0], elbow, tip]);
    context.stroke();
    context.setLineDash([]);
    const [x, y] = this.project(tip);
    context.beginPath();
    context.arc(x, y, 0.055 * this.reach * this.scale, 0, 2 * Math.PI);
    context.stroke();
  }

  // An arrow at the tip in the direction in which the push turns the joint. It stays for a
  // moment, so that a short push is seen.
  drawPush(pose, time) {
    const STAYS_S = 0.3;
    for (const [start, duration, joint, torque] of DATA.pushes) {
      if (time < start || time > start + duration + STAYS_S) continue;
      const fade = Math.max(0, time - start - duration) / STAYS_S;
      const moved = pose.map((angle, i) => angle + (i + 1 === joint ? 1e-3 : 0));
      const [from, to] = [pose, moved].map((angles) => links(angles).tip);
      const way = add(to, from, -1);
      const length = Math.hypot(...way) / Math.sign(torque);
      const size = this.reach * Math.min(0.6, 0.25 + 0.4 * Math.abs(torque));
      const tail = add(from, way, -(size + 0.06 * this.reach) / length);
      const head = add(from, way, (-0.06 * this.reach) / length);
      this.drawArrow(tail, head, 1 - fade, `${signed(torque, 2)} N m`);
    }
  }

  drawArrow(tail, head, opacity, text) {
    const { context } = this;
    const [[x0, y0], [x1, y1]] = [tail, head].map((point) => this.project(point));
    const angle = Math.atan2(y1 - y0, x1 - x0);
    context.globalAlpha = opacity;
    context.strokeStyle = context.fillStyle = colour("--bad");
    context.lineWidth = 4;
    context.lineCap = "round";
    context.beginPath();
    context.moveTo(x0, y0);
    context.lineTo(x1 - 8 * Math.cos(angle), y1 - 8 * Math.sin(angle));
    context.stroke();
    context.beginPath();
    context.moveTo(x1, y1);
    for (const side of [2.6, -2.6]) {
      context.lineTo(x1 + 15 * Math.cos(angle + side), y1 + 15 * Math.sin(angle + side));
    }
    context.fill();
    context.font = "600 13px system-ui, sans-serif";
    context.textAlign = x0 < this.width / 2 ? "left" : "right";
    context.fillText(text, x0, y0 - 10);
    context.globalAlpha = 1;
  }
}
