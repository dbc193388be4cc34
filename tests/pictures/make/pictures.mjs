// Makes the sample pictures and labels.csv from poses.json: places hand, object, sleeve and camera, and lets headless
// Chromium draw them. Usage: node pictures.mjs [OUT_DIR]. CHROMIUM names the browser if it is not /usr/bin/chromium.
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { Matrix3, Matrix4, Quaternion, Vector3 } from 'three';
import { chromium } from 'playwright-core';
import { loadHand, normalsOf, poseJoints, skin } from './hand.mjs';
import { GRASPS } from './grasps.mjs';
import { PICTURES, OBJECTS, around } from './views.mjs';

const here = fileURLToPath(new URL('.', import.meta.url));
const out = process.argv[2] || join(here, '..');
const poses = JSON.parse(readFileSync(join(here, 'poses.json')));
const hand = loadHand();
const rad = d => d * Math.PI / 180;

const SKIN = {
  light: ['#d3a288', '#c07a66'], tan: ['#b58468', '#a0644e'], brown: ['#84594a', '#744638'],
};

// The world is z up: the hand is turned so that `up` and `toward` (hand frame) come to lie along world z and near world x.
function worldFromHand(up, toward) {
  const z = new Vector3(...up).normalize(), x = new Vector3(...toward);
  x.addScaledVector(z, -x.dot(z)).normalize();
  return new Matrix4().makeBasis(x, z.clone().cross(x), z).transpose();
}

// One step of Loop subdivision, so that outlines are round.
function subdivide({ points, triangles, tint }) {
  const n = points.length, edges = new Map(), sum = points.map(() => [new Vector3(), 0]), P = [...points], T = [], C = [...tint];
  const key = (a, b) => a < b ? a * 65536 + b : b * 65536 + a;
  for (const t of triangles) for (let k = 0; k < 3; k++) {
    const [a, b, c] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]], e = edges.get(key(a, b)) || { a, b, far: [] };
    e.far.push(c);
    edges.set(key(a, b), e);
  }
  const border = new Set();
  for (const e of edges.values()) {
    if (e.far.length !== 2) { border.add(e.a); border.add(e.b); }
    sum[e.a][0].add(points[e.b]); sum[e.a][1]++;
    sum[e.b][0].add(points[e.a]); sum[e.b][1]++;
    e.id = P.length;
    const mid = points[e.a].clone().add(points[e.b]);
    P.push(e.far.length === 2 ? mid.multiplyScalar(3 / 8).addScaledVector(points[e.far[0]].clone().add(points[e.far[1]]), 1 / 8) : mid.multiplyScalar(0.5));
    C.push((tint[e.a] + tint[e.b]) / 2);
  }
  for (let i = 0; i < n; i++) {
    if (border.has(i)) continue;
    const [s, k] = sum[i], beta = k > 3 ? 3 / (8 * k) : 3 / 16;
    P[i] = points[i].clone().multiplyScalar(1 - k * beta).addScaledVector(s, beta);
  }
  for (const t of triangles) {
    const m = [0, 1, 2].map(k => edges.get(key(t[k], t[(k + 1) % 3])).id);
    T.push([t[0], m[0], m[2]], [t[1], m[1], m[0]], [t[2], m[2], m[1]], m);
  }
  return { points: P, triangles: T, tint: C };
}

// A tube of elliptical rings behind the wrist: [x, half width (y), half depth (z), dy, dz] each, in the hand frame.
function tube(rings, close) {
  const N = 48, points = [], triangles = [];
  for (const [x, w, d, dy, dz] of rings) for (let i = 0; i < N; i++) {
    const a = 2 * Math.PI * i / N, c = Math.cos(a), s = Math.sin(a), f = v => Math.sign(v) * Math.abs(v) ** 0.9;
    points.push(new Vector3(x, dy + w * f(c), dz + d * f(s)));
  }
  for (let r = 0; r + 1 < rings.length; r++) for (let i = 0; i < N; i++) {
    const a = r * N + i, b = r * N + (i + 1) % N;
    triangles.push([a, a + N, b], [b, a + N, b + N]);
  }
  if (close) for (const r of [0, rings.length - 1]) for (let i = 1; i + 1 < N; i++) triangles.push(r ? [r * N, r * N + i + 1, r * N + i] : [0, i, i + 1]);
  return { points, triangles };
}

const wrist = (() => { // the mesh's girth near its end
  const s = hand.points.filter(p => p.x < -0.010);
  const range = k => [Math.min(...s.map(p => p[k])), Math.max(...s.map(p => p[k]))];
  const [y0, y1] = range('y'), [z0, z1] = range('z');
  return { w: (y1 - y0) / 2, d: (z1 - z0) / 2, y: (y0 + y1) / 2, z: (z0 + z1) / 2 };
})();

function sleeve(length = 0.42) {
  const { w, d, y, z } = wrist, R = [];
  R.push([-0.012, w * 1.02, d * 1.04, y, z], [0.001, w * 1.13, d * 1.16, y, z], [0.002, w * 1.2, d * 1.24, y, z]);
  for (let i = 0; i <= 40; i++) {
    const t = i / 40, wave = 1 + 0.018 * Math.sin(t * 34) + 0.012 * Math.sin(t * 71 + 1);
    R.push([-t * length - 0.002, w * (1.2 + 0.35 * t) * wave, d * (1.26 + 0.75 * t) * wave, y, z - 0.004 * Math.sin(t * 17)]);
  }
  return tube(R);
}

function forearm(length = 0.42) { // starts inside the hand mesh and takes over from its end
  const { w, d, y, z } = wrist, R = [];
  for (let i = 0; i <= 6; i++) R.push([0.010 - i * 0.006, w * (0.93 + 0.1 * i / 6), d * (0.93 + 0.1 * i / 6), y, z]);
  for (let i = 1; i <= 40; i++) {
    const t = i / 40, grow = t * t * (3 - 2 * t);
    R.push([-0.026 - t * length, w * (1.03 + 0.40 * grow), d * (1.03 + 0.75 * grow), y, z - 0.010 * grow]);
  }
  return tube(R, true);
}

const flat = v => v.flatMap(p => [p.x, p.y, p.z]);
function describe(p) {
  const g = GRASPS[p.grasp], pose = poses[p.grasp];
  const objectInHand = new Matrix4().fromArray(pose.hand_from_object);
  const axis = new Vector3().setFromMatrixColumn(objectInHand, 2);
  if (p.flipObject) objectInHand.multiply(new Matrix4().makeRotationX(Math.PI));
  const up = p.up === 'axis' ? axis.toArray() : p.up === '-axis' ? axis.negate().toArray() : p.up;
  const turn = worldFromHand(up, p.toward || [1, 0, 0]);
  const world = v => v.clone().applyMatrix4(turn);
  const joints = poseJoints(hand, pose.angles);
  const raw = { points: skin(hand, joints), triangles: hand.triangles };
  // redder fingertips and knuckles
  const tips = hand.names.flatMap((n, i) => /tip$/.test(n) ? [[hand.bind[i], 0.016, 0.9]] : /intermediate$|proximal$/.test(n) ? [[hand.bind[i], 0.012, 0.5]] : []);
  raw.tint = hand.points.map(v => Math.max(...tips.map(([m, r, k]) => k * Math.exp(-(v.distanceTo(new Vector3().setFromMatrixPosition(m)) ** 2) / (r * r)))));
  let body = subdivide(raw);
  if (p.arm === 'bare' && !p.segmented) {
    const a = forearm(), n = body.points.length;
    body = { points: [...body.points, ...a.points], triangles: [...body.triangles, ...a.triangles.map(t => t.map(i => i + n))], tint: [...body.tint, ...a.points.map(() => 0)] };
  }
  const [c0, c1] = (SKIN[p.skin || 'light']).map(h => [1, 3, 5].map(i => (parseInt(h.slice(i, i + 2), 16) / 255) ** 2.2));
  const colours = body.tint.flatMap((t, i) => {
    const q = body.points[i], m = 0.5 + 0.25 * Math.sin(q.x * 160) * Math.sin(q.y * 190 + 1) + 0.25 * Math.sin(q.z * 210 + q.x * 90); // mottling
    return c0.map((a, k) => a + (c1[k] - a) * Math.min(1, t * 0.7 + 0.18 * m));
  });
  const s = { size: p.segmented ? [256, 192] : [640, 480], plain: !!p.segmented, fov: p.fov || 38, seed: p.seed, wall: p.wall, light: p.light || [-0.5, 0.4, 1.0], jpeg: p.segmented ? undefined : 0.85, flip: p.hand === 'left' };
  const handPoints = raw.points.map(world);
  if (!p.noHand) s.hand = { positions: flat(body.points.map(world)), index: body.triangles.flat(), colours };
  if (p.arm && p.arm !== 'bare' && !p.segmented && !p.noHand) {
    const m = sleeve();
    s.sleeve = { positions: flat(m.points.map(world)), index: m.triangles.flat(), colour: p.arm };
  }
  const objectInWorld = turn.clone().multiply(objectInHand);
  const parts = OBJECTS[p.object || p.grasp](p.paint || {});
  s.object = { matrix: objectInWorld.elements, parts };
  // camera
  const [az, el, roll] = p.view.map(rad);
  const toCamera = new Vector3(Math.cos(el) * Math.cos(az), Math.cos(el) * Math.sin(az), Math.sin(el));
  const centre = handPoints.reduce((a, v) => a.add(v), new Vector3()).divideScalar(handPoints.length);
  const target = centre.lerp(new Vector3().setFromMatrixPosition(objectInWorld), p.lean ?? 0.35).add(new Vector3(...(p.shift || [0, 0, 0])));
  const forward = toCamera.clone().negate();
  let right = forward.clone().cross(new Vector3(0, 0, 1)).normalize(), down = forward.clone().cross(right);
  const r0 = right.clone();
  right = r0.clone().multiplyScalar(Math.cos(roll)).addScaledVector(down, Math.sin(roll));
  down = down.clone().multiplyScalar(Math.cos(roll)).addScaledVector(r0, -Math.sin(roll));
  const at = target.clone().addScaledVector(toCamera, p.distance || 0.55);
  s.camera = new Matrix4().makeBasis(right, down.clone().negate(), toCamera).setPosition(at).elements;
  s.target = target.toArray();
  if (p.table) s.table = { ...p.table, z: p.table.z ?? lowest(parts, objectInWorld, handPoints) - (p.lift || 0) };
  // camera_from_hand: rows are the optical frame's axes (x right, y down, z forward) in the world
  const R = new Matrix4().makeBasis(right, down, forward).transpose().multiply(turn);
  if (p.hand === 'left') R.premultiply(new Matrix4().makeScale(-1, 1, 1)).multiply(new Matrix4().makeScale(1, -1, 1));
  const q = new Quaternion().setFromRotationMatrix(R);
  if (q.w < 0) q.set(-q.x, -q.y, -q.z, -q.w);
  return { s, q };
}

function lowest(parts, m, points) {
  let z = Math.min(...points.map(p => p.z));
  for (const o of parts) {
    const r = o.r || 0.01, h = o.shape === 'cylinder' ? o.h / 2 : 0;
    for (let i = 0; i < 32; i++) for (const e of [-h, h]) {
      const a = i * Math.PI / 16, p = new Vector3(r * Math.cos(a), r * Math.sin(a), e).add(new Vector3(...(o.at || [0, 0, 0]))).applyMatrix4(m);
      z = Math.min(z, o.shape === 'sphere' ? new Vector3().setFromMatrixPosition(m).z - o.r : p.z);
    }
  }
  return z;
}

const profile = mkdtempSync(join(tmpdir(), 'pictures-'));
const browser = await chromium.launchPersistentContext(profile, {
  executablePath: process.env.CHROMIUM || '/usr/bin/chromium', headless: true,
  args: ['--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
    '--disable-component-update', '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
try {
  const page = await browser.newPage();
  page.on('pageerror', e => console.error('page:', e.message));
  page.on('console', m => m.type() === 'error' && console.error('page:', m.text()));
  await page.route('**/*', route => { // everything comes from this folder, nothing from a network
    const path = new URL(route.request().url()).pathname;
    if (path === '/favicon.ico') return route.fulfill({ status: 204 });
    return route.fulfill({ path: join(here, path), contentType: path.endsWith('.html') ? 'text/html' : 'text/javascript' });
  });
  await page.goto('http://pictures.invalid/page.html');
  await page.waitForFunction(() => window.ready);
  const rows = ['file,mask,kind,grasp,cutkosky,confidence,stage,hand,azimuth,elevation,roll,qx,qy,qz,qw,group'];
  const only = process.env.ONLY && new RegExp(process.env.ONLY);
  for (const p of process.env.AROUND ? around(Number(process.env.AROUND)) : PICTURES) {
    if (only && !only.test(p.name)) continue;
    const { s, q } = describe(p);
    const folder = p.segmented ? 'segmented' : 'camera', file = `${folder}/${p.name}.${p.segmented ? 'png' : 'jpg'}`;
    const mask = p.segmented ? `mask/${p.name}.png` : '';
    const save = async (name, scene) => {
      mkdirSync(join(out, name, '..'), { recursive: true });
      writeFileSync(join(out, name), Buffer.from((await page.evaluate(x => window.draw(x), scene)).split(',')[1], 'base64'));
    };
    await save(file, s);
    if (mask) await save(mask, { ...s, mask: true });
    if (!p.noHand) rows.push([file, mask, p.segmented ? 'segmented' : 'camera', p.grasp, GRASPS[p.grasp].cutkosky, 'sure', 'grasp', p.hand || 'right',
      ...p.view.map(v => v.toFixed(4)), ...q.toArray().map(v => v.toFixed(6)), p.group].join());
    console.error(file);
  }
  if (!only) writeFileSync(join(out, 'labels.csv'), rows.join('\n') + '\n');
} finally {
  await browser.close();
  rmSync(profile, { recursive: true, force: true });
}
