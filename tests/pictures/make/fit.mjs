// Closes the hand on each object: damped least squares over the joint angles and the object's place, and writes poses.json.
// Skin must not enter the object, the parts named in `touch` must meet it, fingers must not enter each other.
import { writeFileSync } from 'node:fs';
import { Quaternion, Vector3, Matrix4 } from 'three';
import { CHAINS, FINGERS, loadHand, poseJoints, skin } from './hand.mjs';
import { GRASPS } from './grasps.mjs';

const hand = loadHand();
const only = process.argv.slice(2);
const palmar = hand.points.map((_, v) => {
  const axis = new Vector3().setFromMatrixColumn(hand.bind[hand.names.indexOf(hand.main[v])], 1);
  return -hand.normals[v].dot(axis);
});
const pick = (names, least) => hand.points.flatMap((_, v) => names.includes(hand.main[v]) && palmar[v] > least ? [v] : []);
const PADS = { palm: pick(hand.names.filter(n => n.includes('finger-metacarpal')), 0.6) };
for (const [f, [prox, mid, distal, tip]] of Object.entries(CHAINS)) {
  PADS[f + '-tip'] = pick([distal, tip], 0.7);
  PADS[f + '-distal'] = pick([distal, tip], 0.6);
  PADS[f + '-mid'] = pick([mid], 0.6);
  PADS[f + '-prox'] = pick([prox], 0.6);
}
const soft = hand.main.map(n => /metacarpal|proximal/.test(n) ? 0.0025 : 0.0008); // flesh gives way
const RADIUS = { thumb: 0.0100, index: 0.0082, middle: 0.0085, ring: 0.0080, pinky: 0.0070 };

const sdf = (o, p) => {
  if (o.shape === 'sphere') return p.length() - o.r;
  const a = Math.hypot(p.x, p.y) - o.r, b = Math.abs(p.z) - o.h / 2;
  return Math.min(Math.max(a, b), 0) + Math.hypot(Math.max(a, 0), Math.max(b, 0));
};
const PAIRS = [['index', 'middle'], ['middle', 'ring'], ['ring', 'pinky'], ['thumb', 'index'], ['thumb', 'middle'], ['thumb', 'ring']];

function unpack(g, x) {
  const angles = {};
  let k = 0;
  for (const f of FINGERS) angles[f] = g.fingers[f].map(a => a + x[k++]);
  angles.thumb = g.thumb.map(a => a + x[k++]);
  const q = new Quaternion().setFromUnitVectors(new Vector3(0, 0, 1), new Vector3(...g.axis).normalize());
  q.premultiply(new Quaternion().setFromAxisAngle(new Vector3(1, 0, 0), x[k]))
    .premultiply(new Quaternion().setFromAxisAngle(new Vector3(0, 1, 0), x[k + 1]))
    .premultiply(new Quaternion().setFromAxisAngle(new Vector3(0, 0, 1), x[k + 2]));
  const at = new Vector3(...g.at).add(new Vector3(x[k + 3], x[k + 4], x[k + 5]));
  return { angles, object: new Matrix4().compose(at, q, new Vector3(1, 1, 1)) };
}
const SIZE = 27;

function residuals(g, x, report) {
  const { angles, object } = unpack(g, x);
  const world = poseJoints(hand, angles), points = skin(hand, world);
  const inverse = object.clone().invert(), r = [];
  const inObject = points.map(p => p.clone().applyMatrix4(inverse));
  const d = inObject.map(p => sdf(g.object, p));
  let worst = 0;
  d.forEach((v, i) => { r.push(Math.min(0, v + soft[i]) / 0.0012); worst = Math.min(worst, v); });
  const gaps = {};
  const nearest = (pad, n) => PADS[pad].map(v => [d[v], v]).sort((a, b) => a[0] - b[0]).slice(0, n);
  const centre = pad => nearest(pad, 6).reduce((s, [, v]) => s.add(inObject[v]), new Vector3()).divideScalar(6);
  for (const t of g.touch) {
    const pads = FINGERS.includes(t) ? [`${t}-distal`, `${t}-mid`] : [t];
    for (const pad of pads) {
      const m = nearest(pad, 5).reduce((s, [v]) => s + v, 0) / 5;
      gaps[pad] = m;
      r.push(m / (pad === 'palm' ? 0.002 : pad.endsWith('mid') ? 0.0012 : 0.0007));
    }
  }
  if (g.rim) for (const t of g.touch) {
    const c = centre(t);
    r.push(c.z / 0.003);
  }
  if (g.opposed) {
    const s = centre('thumb-tip').normalize().add(centre('index-tip').normalize());
    r.push(s.x / 0.15, s.y / 0.15, s.z / 0.15);
    for (const t of ['thumb', 'index']) { // with the pad, not the side or the very tip
      const tip = world[hand.names.indexOf(CHAINS[t][3])];
      const out = new Vector3().setFromMatrixColumn(tip, 1).negate();
      const to = new Vector3().setFromMatrixPosition(object).sub(new Vector3().setFromMatrixPosition(tip)).normalize();
      r.push((1 - out.dot(to)) / 0.1);
    }
  }
  const joint = n => new Vector3().setFromMatrixPosition(world[hand.names.indexOf(n)]);
  if (g.thumbOver) { // the thumb's pad lies on the back of the index finger's middle part
    const i = CHAINS.index.map(joint), tip = joint('thumb-tip');
    const goal = i[1].clone().lerp(i[2], 0.75);
    const gap = goal.distanceTo(tip);
    r.push(Math.max(0, gap - 0.019) / 0.003);
    const out = new Vector3().setFromMatrixColumn(world[hand.names.indexOf('thumb-tip')], 1).negate();
    r.push((1 - out.dot(goal.sub(tip).normalize())) / 0.15);
    gaps.thumbOver = gap;
  }
  if (g.thumbAlong) { // the thumb lies straight along the handle
    const along = joint('thumb-tip').sub(joint('thumb-phalanx-proximal')).normalize();
    const axis = new Vector3().setFromMatrixColumn(object, 2);
    const s = along.sub(axis.multiplyScalar(Math.sign(axis.y)));
    r.push(s.x / 0.08, s.y / 0.08, s.z / 0.08);
    const m = nearest('thumb-mid', 5).reduce((a, [v]) => a + v, 0) / 5;
    r.push(m / 0.003);
  }
  // fingers stay out of each other
  const chain = f => {
    const j = CHAINS[f].map(joint), out = [];
    j.push(j[3].clone().add(j[3].clone().sub(j[2]).setLength(0.004)));
    for (let k = 0; k < 4; k++) for (let s = k || f === 'thumb' ? 0 : 1; s < 4; s++) if (f !== 'thumb' || k) out.push(j[k].clone().lerp(j[k + 1], s / 4));
    return out;
  };
  const chains = Object.fromEntries(Object.keys(CHAINS).map(f => [f, chain(f)]));
  let cross = 0;
  for (const [a, b] of PAIRS) {
    let deep = 0;
    for (const p of chains[a]) for (const q of chains[b]) deep = Math.min(deep, p.distanceTo(q) - RADIUS[a] - RADIUS[b] + 0.0005);
    r.push(deep / 0.0007);
    cross = Math.min(cross, deep);
  }
  // lean to the starting angles, natural coupling of the last two joints, limits
  FINGERS.forEach((f, i) => {
    const dx = x.slice(4 * i, 4 * i + 4), a = angles[f];
    r.push(dx[0] / 0.07, dx[1] / 0.3, dx[2] / 0.3, dx[3] / 0.3, (a[3] - 0.55 * a[2]) / 0.4);
    r.push(Math.min(0, a[1] + 0.2) / 0.03, Math.min(0, a[2] - 0.05) / 0.03, Math.min(0, a[3]) / 0.03, Math.max(0, a[3] - 1.25) / 0.03, Math.max(0, a[1] - 1.55) / 0.03, Math.max(0, a[2] - 1.8) / 0.03);
  });
  for (let i = 0; i < 3; i++) { // neighbours bend alike
    const a = angles[FINGERS[i]], b = angles[FINGERS[i + 1]];
    for (const k of [1, 2]) r.push((a[k] - b[k]) / (g.alike || 0.4));
  }
  const t = angles.thumb;
  r.push(x[16] / 0.3, x[17] / 0.25, x[18] / 0.25, x[19] / 0.3, x[20] / 0.3);
  r.push(Math.min(0, t[3] + 0.15) / 0.03, Math.min(0, t[4] + 0.25) / 0.03, Math.max(0, t[4] - 1.3) / 0.03, Math.max(0, t[3] - 1.0) / 0.03);
  for (let k = 21; k < 24; k++) r.push(x[k] / (g.stiff || 0.15));
  for (let k = 24; k < 27; k++) r.push(x[k] / 0.012);
  if (report) return { worst, cross, gaps };
  return r;
}

function solve(A, b) { // Gaussian elimination
  const n = b.length, m = A.map((row, i) => [...row, b[i]]);
  for (let c = 0; c < n; c++) {
    let p = c;
    for (let i = c + 1; i < n; i++) if (Math.abs(m[i][c]) > Math.abs(m[p][c])) p = i;
    [m[c], m[p]] = [m[p], m[c]];
    for (let i = c + 1; i < n; i++) {
      const f = m[i][c] / m[c][c];
      for (let k = c; k <= n; k++) m[i][k] -= f * m[c][k];
    }
  }
  for (let i = n - 1; i >= 0; i--) {
    for (let k = i + 1; k < n; k++) m[i][n] -= m[i][k] * m[k][n];
    m[i][n] /= m[i][i];
  }
  return m.map(row => row[n]);
}

function fit(g) {
  let x = new Array(SIZE).fill(0), r = residuals(g, x), lambda = 1;
  const cost = v => v.reduce((s, a) => s + a * a, 0);
  for (let step = 0; step < 80; step++) {
    const J = x.map((_, k) => {
      const y = [...x], h = k >= 24 ? 1e-5 : 1e-4;
      y[k] += h;
      return residuals(g, y).map((v, i) => (v - r[i]) / h);
    });
    const A = J.map(a => J.map(b => a.reduce((s, v, i) => s + v * b[i], 0))), g0 = J.map(a => -a.reduce((s, v, i) => s + v * r[i], 0));
    let better = false;
    for (let tries = 0; tries < 8 && !better; tries++) {
      const dx = solve(A.map((row, i) => row.map((v, k) => i === k ? v * (1 + lambda) + 1e-6 : v)), g0);
      const y = x.map((v, i) => v + dx[i]), s = residuals(g, y);
      if (cost(s) < cost(r)) {
        better = cost(r) - cost(s) > 1e-3 * cost(r) || tries < 2;
        x = y; r = s; lambda = Math.max(lambda / 4, 1e-6);
        break;
      }
      lambda *= 4;
    }
    if (lambda > 1e8) break;
  }
  return { x, cost: cost(r) };
}

const poses = {};
for (const [name, g] of Object.entries(GRASPS)) {
  if (only.length && !only.includes(name)) continue;
  const { x, cost } = fit(g), { angles, object } = unpack(g, x), told = residuals(g, x, true);
  const round = a => a.map(v => +v.toFixed(4));
  poses[name] = { angles: Object.fromEntries(Object.entries(angles).map(([f, a]) => [f, round(a)])), hand_from_object: round(object.elements) };
  const mm = v => (v * 1000).toFixed(1);
  console.error(name, 'cost', cost.toFixed(1), 'deepest', mm(told.worst), 'mm, fingers in each other', mm(told.cross), 'mm, gaps', Object.entries(told.gaps).map(([k, v]) => `${k} ${mm(v)}`).join(', '));
  for (const [f, a] of Object.entries(angles)) console.error('   ', f, a.map(v => (v * 57.3).toFixed(0)).join(' '));
}
if (!only.length) writeFileSync(new URL('poses.json', import.meta.url), JSON.stringify(poses, null, 1) + '\n');
