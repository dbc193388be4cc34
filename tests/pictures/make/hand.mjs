// Loads the WebXR generic hand, bends its joints and skins its mesh, all in the hand frame:
// origin at the wrist's centre, x to the middle knuckle, z out of the back of the hand, y = z cross x (to the thumb). Metres.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { Matrix4, Quaternion, Vector3 } from 'three';

const require = createRequire(import.meta.url);
export const FINGERS = ['index', 'middle', 'ring', 'pinky'];
const SEGMENTS = ['phalanx-proximal', 'phalanx-intermediate', 'phalanx-distal', 'tip'];
export const CHAINS = Object.fromEntries(FINGERS.map(f => [f, SEGMENTS.map(s => `${f}-finger-${s}`)]));
CHAINS.thumb = ['metacarpal', 'phalanx-proximal', 'phalanx-distal', 'tip'].map(s => `thumb-${s}`);

export function loadHand() {
  const data = readFileSync(require.resolve('@webxr-input-profiles/assets/dist/profiles/generic-hand/right.glb'));
  const jsonLength = data.readUInt32LE(12);
  const gltf = JSON.parse(data.subarray(20, 20 + jsonLength).toString());
  const bin = data.subarray(28 + jsonLength);
  const read = (i) => {
    const a = gltf.accessors[i], v = gltf.bufferViews[a.bufferView];
    const start = (v.byteOffset || 0) + (a.byteOffset || 0);
    const n = a.count * { SCALAR: 1, VEC2: 2, VEC3: 3, VEC4: 4, MAT4: 16 }[a.type];
    const size = { 5126: 4, 5123: 2, 5121: 1 }[a.componentType];
    return Array.from({ length: n }, (_, k) => size === 4 ? bin.readFloatLE(start + 4 * k)
      : size === 2 ? bin.readUInt16LE(start + 2 * k) : bin.readUInt8(start + k));
  };
  const primitive = gltf.meshes[0].primitives[0], skin = gltf.skins[0];
  const position = read(primitive.attributes.POSITION);
  const inverse = read(skin.inverseBindMatrices);
  const names = skin.joints.map(j => gltf.nodes[j].name);
  const bindModel = names.map((_, i) => new Matrix4().fromArray(inverse, 16 * i).invert());
  const at = n => new Vector3().setFromMatrixPosition(bindModel[names.indexOf(n)]);
  const origin = at('wrist');
  const x = at('middle-finger-phalanx-proximal').sub(origin).normalize();
  const dorsal = new Vector3().setFromMatrixColumn(bindModel[names.indexOf('wrist')], 1); // WebXR: a joint's y is dorsal
  const z = dorsal.addScaledVector(x, -dorsal.dot(x)).normalize();
  const y = z.clone().cross(x);
  const toHand = new Matrix4().makeBasis(x, y, z).setPosition(origin).invert();

  // Weld the vertices that texture seams split.
  const key = new Map(), remap = [], points = [], joints = [], weights = [];
  const J = read(primitive.attributes.JOINTS_0), W = read(primitive.attributes.WEIGHTS_0);
  for (let i = 0; i < position.length / 3; i++) {
    const p = position.slice(3 * i, 3 * i + 3), k = p.map(v => Math.round(v * 1e5)).join();
    if (!key.has(k)) {
      key.set(k, points.length);
      points.push(new Vector3(...p).applyMatrix4(toHand));
      joints.push(J.slice(4 * i, 4 * i + 4));
      weights.push(W.slice(4 * i, 4 * i + 4));
    }
    remap.push(key.get(k));
  }
  const triangles = [], raw = read(primitive.indices).map(i => remap[i]);
  for (let i = 0; i < raw.length; i += 3) {
    const t = raw.slice(i, i + 3);
    if (new Set(t).size === 3) triangles.push(t);
  }
  const bind = bindModel.map(m => toHand.clone().multiply(m));
  const hand = { names, bind, inverse: bind.map(m => m.clone().invert()), points, joints, weights, triangles };
  hand.normals = normalsOf(points, triangles);
  hand.main = joints.map((j, i) => names[j[weights[i].indexOf(Math.max(...weights[i]))]]);
  return hand;
}

export function normalsOf(points, triangles) {
  const out = points.map(() => new Vector3());
  for (const [a, b, c] of triangles) {
    const n = points[b].clone().sub(points[a]).cross(points[c].clone().sub(points[a]));
    for (const i of [a, b, c]) out[i].add(n);
  }
  return out.map(n => n.normalize());
}

// angles: { index: [spread, mcp, pip, dip], ..., thumb: [flex, spread, twist, mcp, ip] }, radians from the model's own
// (almost flat) pose; flexion is positive, spread is positive toward the thumb's side.
export function poseJoints(hand, angles) {
  const world = hand.bind.map(m => m.clone());
  const local = new Matrix4(), q = new Quaternion(), X = new Vector3(1, 0, 0), Y = new Vector3(0, 1, 0), Z = new Vector3(0, 0, 1);
  for (const [finger, chain] of Object.entries(CHAINS)) {
    const a = angles[finger];
    const turns = finger === 'thumb' ? [[a[1], a[2], a[0]], [0, 0, a[3]], [0, 0, a[4]], [0, 0, 0]]
      : [[a[0], 0, a[1]], [0, 0, a[2]], [0, 0, a[3]], [0, 0, 0]];
    let parentNew = null, parentOld = null;
    chain.forEach((name, k) => {
      const i = hand.names.indexOf(name);
      const here = parentNew ? parentNew.clone().multiply(parentOld.clone().invert()).multiply(hand.bind[i]) : hand.bind[i].clone();
      const [spread, twist, flex] = turns[k];
      q.setFromAxisAngle(Y, spread).multiply(new Quaternion().setFromAxisAngle(Z, twist)).multiply(new Quaternion().setFromAxisAngle(X, -flex));
      here.multiply(local.makeRotationFromQuaternion(q));
      world[i] = here;
      parentNew = here;
      parentOld = hand.bind[i];
    });
  }
  return world;
}

export function skin(hand, world) {
  const m = world.map((w, i) => w.clone().multiply(hand.inverse[i]).elements);
  return hand.points.map((p, v) => {
    let x = 0, y = 0, z = 0;
    for (let k = 0; k < 4; k++) {
      const w = hand.weights[v][k];
      if (!w) continue;
      const e = m[hand.joints[v][k]];
      x += w * (e[0] * p.x + e[4] * p.y + e[8] * p.z + e[12]);
      y += w * (e[1] * p.x + e[5] * p.y + e[9] * p.z + e[13]);
      z += w * (e[2] * p.x + e[6] * p.y + e[10] * p.z + e[14]);
    }
    return new Vector3(x, y, z);
  });
}
