// A hand that turns: the project's own mesh, drawn into a canvas by a small rasteriser, so that no graphics card is needed.
"use strict";

// From the upper left, from behind the camera, in the camera's frame: x right, y down, z forward.
const LIGHT = normalised([-0.3, -0.55, -0.78]);

function normalised(v) {
  const length = Math.hypot(...v) || 1;
  return v.map((x) => x / length);
}

// Row-major rotation matrix of a unit quaternion x, y, z, w.
function matrixOf([x, y, z, w]) {
  return [
    1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
    2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
    2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y),
  ];
}

function times(a, b) {
  const out = [];
  for (let row = 0; row < 3; row++) {
    for (let column = 0; column < 3; column++) {
      out.push(a[3 * row] * b[column] + a[3 * row + 1] * b[3 + column] + a[3 * row + 2] * b[6 + column]);
    }
  }
  return out;
}

// The hands of `hand.mesh`, by grasp; renders/examples/hand_mesh.rs writes the file and says what is in it.
function readHands(buffer) {
  const view = new DataView(buffer);
  const hands = new Map();
  let at = 0;
  const u32 = () => {
    at += 4;
    return view.getUint32(at - 4, true);
  };
  for (let left = u32(); left > 0; left--) {
    const [length, vertices, triangles, ofHand, trianglesOfHand] = [u32(), u32(), u32(), u32(), u32()];
    const name = new TextDecoder().decode(new Uint8Array(buffer, at, length));
    at += length;
    const places = new Float32Array(3 * vertices);
    for (let i = 0; i < places.length; i++, at += 2) places[i] = view.getInt16(at, true) / 1e4;
    const corners = new Uint16Array(3 * triangles);
    for (let i = 0; i < corners.length; i++, at += 2) corners[i] = view.getUint16(at, true);
    hands.set(name, { places, corners, normals: normalsOf(places, corners), ofHand, trianglesOfHand });
  }
  return hands;
}

function normalsOf(places, corners) {
  const normals = new Float32Array(places.length);
  for (let t = 0; t < corners.length; t += 3) {
    const [a, b, c] = [3 * corners[t], 3 * corners[t + 1], 3 * corners[t + 2]];
    const edge = (from, to) => [0, 1, 2].map((i) => places[to + i] - places[from + i]);
    const [u, v] = [edge(a, b), edge(a, c)];
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (const corner of [a, b, c]) for (let i = 0; i < 3; i++) normals[corner + i] += n[i];
  }
  for (let at = 0; at < normals.length; at += 3) {
    const length = Math.hypot(normals[at], normals[at + 1], normals[at + 2]) || 1;
    for (let i = 0; i < 3; i++) normals[at + i] /= length;
  }
  return normals;
}

class HandView {
  constructor(canvas) {
    this.canvas = canvas;
    this.hands = null;
    this.shown = null;
    this.turned = [0, 0];
    this.swaying = false;
    this.still = window.matchMedia("(prefers-reduced-motion: reduce)");
    let held = null;
    canvas.addEventListener("pointerdown", (event) => {
      held = [event.clientX, event.clientY];
      this.swaying = false;
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!held) return;
      this.turn((event.clientX - held[0]) / 90, (held[1] - event.clientY) / 90);
      held = [event.clientX, event.clientY];
    });
    for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => { held = null; });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: [-0.2, 0], ArrowRight: [0.2, 0], ArrowUp: [0, 0.2], ArrowDown: [0, -0.2] }[event.key];
      if (step) this.turn(...step);
      else if (event.key === "Home") this.home();
      else return;
      this.swaying = false;
      event.preventDefault();
    });
  }

  async load() {
    const response = await fetch("hand.mesh");
    this.hands = readHands(await response.arrayBuffer());
  }

  // The hand of a grasp, turned as `quaternion` (camera_from_hand) says; a left hand is the right one's mirror image.
  show(grasp, quaternion, side) {
    const hand = this.hands?.get(grasp) ?? this.hands?.values().next().value;
    if (!hand) return;
    this.shown = { hand, rotation: matrixOf(quaternion), flip: side === "left" ? -1 : 1 };
    this.turned = [0, 0];
    this.swaying = !this.still.matches;
    this.since = performance.now();
    this.redraw();
    if (this.swaying) requestAnimationFrame(() => this.sway());
  }

  home() {
    this.turned = [0, 0];
    this.swaying = false;
    this.redraw();
  }

  turn(right, up) {
    this.turned = [this.turned[0] + right, Math.max(-1.6, Math.min(1.6, this.turned[1] + up))];
    this.redraw();
  }

  // To and fro, so that its depth is seen, and slowly back to how the camera sees it.
  sway() {
    if (!this.swaying || !this.shown) return;
    const seconds = (performance.now() - this.since) / 1000;
    if (seconds > 9) return this.home();
    this.turned = [0.6 * Math.sin((seconds / 4.5) * 2 * Math.PI) * Math.min(1, (9 - seconds) / 2), 0];
    this.redraw();
    requestAnimationFrame(() => this.sway());
  }

  // The same into another canvas, standing still; false where no such hand is known.
  draw(grasp, quaternion, side, canvas) {
    const hand = this.hands?.get(grasp);
    if (hand) drawHand(canvas, hand, matrixOf(quaternion), { flip: side === "left" ? -1 : 1, field: 0.2 });
    return Boolean(hand);
  }

  redraw() {
    if (!this.shown) return;
    const { hand, rotation, flip } = this.shown;
    const [yaw, pitch] = this.turned;
    const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
    // About the picture's vertical, then about its horizontal; what is in front goes the way the pointer does.
    const turn = times([1, 0, 0, 0, cp, -sp, 0, sp, cp], [cy, 0, -sy, 0, 1, 0, sy, 0, cy]);
    drawHand(this.canvas, hand, times(turn, rotation), { flip });
  }
}

// Red, green and blue in full light.
const SKIN = [226, 172, 142];
const THING = [128, 150, 172];

// Draws a hand of `readHands`, turned by a row-major rotation matrix, into a canvas, whose shorter side is `field` metres.
// `flip` of -1 makes a left hand of it; `held` draws what it holds as well.
function drawHand(canvas, hand, m, { flip = 1, held = false, field = 0.24 } = {}) {
  const context = canvas.getContext("2d");
  const { width, height } = canvas;
  const scale = Math.min(width, height) / field;
  const count = held ? hand.places.length / 3 : hand.ofHand;
  const [xs, ys, zs, shades] = [0, 0, 0, 0].map(() => new Float32Array(count));
  for (let v = 0; v < count; v++) {
    const [x, y, z] = [hand.places[3 * v], flip * hand.places[3 * v + 1], hand.places[3 * v + 2]];
    xs[v] = width / 2 + scale * (m[0] * x + m[1] * y + m[2] * z);
    ys[v] = height / 2 + scale * (m[3] * x + m[4] * y + m[5] * z);
    zs[v] = m[6] * x + m[7] * y + m[8] * z;
    const [a, b, c] = [hand.normals[3 * v], flip * hand.normals[3 * v + 1], hand.normals[3 * v + 2]];
    const facing = (m[0] * a + m[1] * b + m[2] * c) * LIGHT[0] + (m[3] * a + m[4] * b + m[5] * c) * LIGHT[1]
      + (m[6] * a + m[7] * b + m[8] * c) * LIGHT[2];
    shades[v] = 0.42 + 0.58 * Math.max(0, facing);
  }
  const picture = context.createImageData(width, height);
  const depth = new Float32Array(width * height).fill(Infinity);
  const end = held ? hand.corners.length : 3 * hand.trianglesOfHand;
  for (let t = 0; t < end; t += 3) {
    const [red, green, blue] = t < 3 * hand.trianglesOfHand ? SKIN : THING;
    const [a, b, c] = [hand.corners[t], hand.corners[t + 1], hand.corners[t + 2]];
    const area = (xs[b] - xs[a]) * (ys[c] - ys[a]) - (xs[c] - xs[a]) * (ys[b] - ys[a]);
    // The picture's y points down: a triangle's front runs clockwise there, and in a mirror image the other way.
    if (area === 0) continue;
    const [left, right] = [Math.min(xs[a], xs[b], xs[c]), Math.max(xs[a], xs[b], xs[c])];
    const [top, bottom] = [Math.min(ys[a], ys[b], ys[c]), Math.max(ys[a], ys[b], ys[c])];
    for (let y = Math.max(0, Math.ceil(top)); y <= Math.min(height - 1, bottom); y++) {
      for (let x = Math.max(0, Math.ceil(left)); x <= Math.min(width - 1, right); x++) {
        const wb = ((x - xs[a]) * (ys[c] - ys[a]) - (xs[c] - xs[a]) * (y - ys[a])) / area;
        const wc = ((xs[b] - xs[a]) * (y - ys[a]) - (x - xs[a]) * (ys[b] - ys[a])) / area;
        const wa = 1 - wb - wc;
        if (wa < -1e-6 || wb < -1e-6 || wc < -1e-6) continue;
        const z = wa * zs[a] + wb * zs[b] + wc * zs[c];
        const at = y * width + x;
        if (z >= depth[at]) continue;
        depth[at] = z;
        const shade = wa * shades[a] + wb * shades[b] + wc * shades[c];
        picture.data.set([red * shade, green * shade, blue * shade, 255], 4 * at);
      }
    }
  }
  context.putImageData(picture, 0, 0);
}
