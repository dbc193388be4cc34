// Runs in the browser: draws one described picture and hands back its pixels. World: z up, metres.
import * as THREE from 'three';

const SCALE = 2; // supersampling
const colour = c => new THREE.Color(c);
let renderer;

function random(seed) {
  return () => ((seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0) / 4294967296);
}

function canvasTexture(w, h, draw) {
  const c = document.createElement('canvas');
  c.width = w; c.height = h;
  draw(c.getContext('2d'), w, h);
  const t = new THREE.CanvasTexture(c);
  t.colorSpace = THREE.SRGBColorSpace;
  t.wrapS = t.wrapT = THREE.RepeatWrapping;
  t.anisotropy = 4;
  return t;
}

function tableTexture(kind, a, b, seed) {
  const rnd = random(seed);
  return canvasTexture(512, 512, (g, w, h) => {
    g.fillStyle = a;
    g.fillRect(0, 0, w, h);
    g.globalAlpha = 0.10;
    if (kind === 'cloth') {
      g.fillStyle = b;
      for (let i = 0; i < w; i += 8) { g.fillRect(i, 0, 4, h); g.fillRect(0, i, w, 4); }
    } else if (kind === 'boards') {
      g.strokeStyle = b;
      for (let i = 0; i < 260; i++) {
        const y = rnd() * h, s = 3 + rnd() * 6;
        g.lineWidth = 0.5 + rnd() * 2;
        g.beginPath();
        g.moveTo(0, y);
        for (let x = 0; x <= w; x += 32) g.lineTo(x, y + Math.sin(x * 2 * Math.PI / w + i) * s);
        g.stroke();
      }
      g.globalAlpha = 0.5;
      for (let i = 0; i < 4; i++) g.fillRect(0, i * 128, w, 2);
    } else {
      g.fillStyle = b;
      for (let i = 0; i < 2500; i++) g.fillRect(rnd() * w, rnd() * h, 1 + rnd() * 3, 1 + rnd() * 3);
    }
  });
}

function mesh(m, material) {
  const g = new THREE.BufferGeometry();
  g.setAttribute('position', new THREE.Float32BufferAttribute(m.positions, 3));
  if (m.colours) g.setAttribute('color', new THREE.Float32BufferAttribute(m.colours, 3));
  g.setIndex(m.index);
  g.computeVertexNormals();
  return new THREE.Mesh(g, material);
}

function objectMesh(o, black) {
  const group = new THREE.Group();
  for (const part of o.parts) {
    const g = part.shape === 'sphere' ? new THREE.SphereGeometry(part.r, 48, 32)
      : part.shape === 'box' ? new THREE.BoxGeometry(...part.size)
        : part.shape === 'lathe' ? new THREE.LatheGeometry(part.points.map(p => new THREE.Vector2(...p)), 64)
          : new THREE.CylinderGeometry(part.r2 ?? part.r, part.r, part.h, 64);
    if (part.shape !== 'box') g.rotateX(Math.PI / 2); // axis to z
    const map = part.stripe && canvasTexture(256, 256, (c, w, h) => {
      c.fillStyle = part.colour;
      c.fillRect(0, 0, w, h);
      c.fillStyle = part.stripe;
      c.fillRect(0, h * 0.30, w, h * 0.42);
      c.fillStyle = part.colour;
      for (let i = 0; i < 4; i++) c.fillRect(w * (0.06 + i * 0.25), h * 0.42, w * 0.13, h * 0.05), c.fillRect(w * (0.06 + i * 0.25), h * 0.52, w * 0.09, h * 0.03);
    });
    const surface = { roughness: part.rough ?? 0.45, metalness: part.metal ?? 0 };
    const plain = new THREE.MeshStandardMaterial({ ...surface, color: colour(part.colour) });
    const m = new THREE.Mesh(g, black ? new THREE.MeshBasicMaterial({ color: 0 })
      : map ? [new THREE.MeshStandardMaterial({ ...surface, map }), plain, plain] : plain);
    m.position.set(...(part.at || [0, 0, 0]));
    m.castShadow = m.receiveShadow = true;
    group.add(m);
  }
  group.matrixAutoUpdate = false;
  group.matrix.fromArray(o.matrix);
  return group;
}

window.draw = (s) => {
  const [w, h] = s.size;
  if (!renderer) {
    renderer = new THREE.WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
    renderer.shadowMap.enabled = true;
    renderer.shadowMap.type = THREE.PCFShadowMap;
    renderer.setPixelRatio(1);
  }
  renderer.setSize(w * SCALE, h * SCALE, false);
  renderer.toneMapping = s.plain ? THREE.NoToneMapping : THREE.NeutralToneMapping;
  renderer.toneMappingExposure = 1.0;
  const scene = new THREE.Scene();
  scene.background = colour(s.plain ? '#000000' : s.wall || '#c8ccd0');
  const camera = new THREE.PerspectiveCamera(s.fov, w / h, 0.02, 10);
  camera.matrixAutoUpdate = false;
  camera.matrixWorldAutoUpdate = true;
  camera.matrix.fromArray(s.camera);
  camera.matrix.decompose(camera.position, camera.quaternion, camera.scale);
  camera.updateMatrixWorld(true);

  const hemi = new THREE.HemisphereLight('#f4f7ff', s.plain ? '#b0a8a0' : s.bounce || '#8a8580', s.plain ? 1.5 : 1.35);
  hemi.position.set(0, 0, 1);
  scene.add(hemi);
  const sun = new THREE.DirectionalLight('#fff4e6', 2.1);
  sun.position.set(...s.light).multiplyScalar(1.2).add(new THREE.Vector3(...s.target));
  sun.target.position.set(...s.target);
  if (!s.plain) {
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    Object.assign(sun.shadow.camera, { left: -0.45, right: 0.45, top: 0.45, bottom: -0.45, near: 0.1, far: 3 });
    sun.shadow.radius = 5;
    sun.shadow.normalBias = 0.002;
    sun.shadow.bias = -0.0005;
  }
  scene.add(sun, sun.target);

  if (s.hand) {
    const material = s.mask ? new THREE.MeshBasicMaterial({ color: 0xffffff })
      : new THREE.MeshPhysicalMaterial({ color: 0xffffff, vertexColors: true, roughness: 0.55, sheen: 0.25, sheenColor: colour('#d08a70'), sheenRoughness: 0.5 });
    const m = mesh(s.hand, material);
    m.castShadow = m.receiveShadow = !s.plain;
    scene.add(m);
  }
  if (s.sleeve) {
    const map = canvasTexture(64, 64, (g) => {
      g.fillStyle = '#fff';
      g.fillRect(0, 0, 64, 64);
      g.fillStyle = 'rgba(0,0,0,0.12)';
      for (let i = 0; i < 64; i += 4) g.fillRect(0, i, 64, 2);
    });
    const m = mesh(s.sleeve, new THREE.MeshStandardMaterial({ color: colour(s.sleeve.colour), roughness: 0.95, side: THREE.DoubleSide, map }));
    m.castShadow = m.receiveShadow = true;
    scene.add(m);
  }
  if (s.object) scene.add(objectMesh(s.object, s.plain));
  if (s.table && !s.plain) {
    const map = tableTexture(s.table.kind, s.table.a, s.table.b, s.table.seed);
    map.repeat.set(6, 6);
    const t = new THREE.Mesh(new THREE.PlaneGeometry(2.4, 2.4), new THREE.MeshStandardMaterial({ map, roughness: 0.8 }));
    t.position.set(s.target[0], s.target[1], s.table.z);
    t.rotation.z = s.table.turn || 0.4;
    t.receiveShadow = true;
    scene.add(t);
  }
  renderer.render(scene, camera);

  const out = document.createElement('canvas');
  out.width = w; out.height = h;
  const g = out.getContext('2d', { willReadFrequently: true });
  g.imageSmoothingEnabled = !s.mask;
  g.imageSmoothingQuality = 'high';
  if (s.flip) { g.translate(w, 0); g.scale(-1, 1); }
  g.drawImage(renderer.domElement, 0, 0, w, h);
  if (!s.plain) { // a little sensor noise
    const d = g.getImageData(0, 0, w, h), rnd = random(s.seed || 7);
    for (let i = 0; i < d.data.length; i += 4) {
      const n = (rnd() + rnd() + rnd() - 1.5) * 5;
      for (let k = 0; k < 3; k++) d.data[i + k] += n;
    }
    g.putImageData(d, 0, 0);
  }
  if (s.mask) {
    const d = g.getImageData(0, 0, w, h);
    for (let i = 0; i < d.data.length; i += 4) d.data[i] = d.data[i + 1] = d.data[i + 2] = d.data[i] > 127 ? 255 : 0;
    g.putImageData(d, 0, 0);
  }
  scene.traverse(o => { o.geometry?.dispose(); [o.material].flat().forEach(m => { m?.map?.dispose(); m?.dispose(); }); });
  return out.toDataURL(s.jpeg ? 'image/jpeg' : 'image/png', s.jpeg);
};
window.ready = true;
