// The pictures: which grasp, how the hand is held (`up`, `toward`: directions in the hand frame that come to world z and x),
// and from where the camera looks: azimuth (from world x toward y), elevation, roll, degrees.
export const OBJECTS = {
  'large-diameter': c => [
    { shape: 'cylinder', r: 0.035, h: 0.19, colour: c.a || '#2f6fb0', stripe: c.b || '#e9edf0', rough: 0.35 },
    { shape: 'cylinder', r: 0.035, r2: 0.018, h: 0.025, at: [0, 0, 0.1075], colour: c.a || '#2f6fb0', rough: 0.35 },
    { shape: 'cylinder', r: 0.017, h: 0.025, at: [0, 0, 0.13], colour: '#e9edf0', rough: 0.5 },
  ],
  'small-diameter': c => [{ shape: 'cylinder', r: 0.012, h: 0.30, colour: c.a || '#3b7d4f', rough: 0.4 }],
  'abducted-thumb': c => [
    { shape: 'cylinder', r: 0.010, h: 0.20, colour: c.a || '#2455a8', rough: 0.4 },
    { shape: 'cylinder', r: 0.0035, h: 0.12, at: [0, 0, 0.16], colour: '#9aa2aa', metal: 0.6, rough: 0.3 },
  ],
  pinch: c => [{ shape: 'sphere', r: 0.012, colour: c.a || '#2a62c4', rough: 0.25 }],
  'power-sphere': c => [{ shape: 'sphere', r: 0.040, colour: c.a || '#2f9e5a', rough: 0.6 }],
  'precision-disc': c => [
    { shape: 'cylinder', r: 0.045, h: 0.018, colour: c.a || '#3d4f9e', rough: 0.4 },
    { shape: 'cylinder', r: 0.040, h: 0.060, at: [0, 0, -0.038], colour: c.b || '#c9d6de', rough: 0.15 },
  ],
};
const grey = { kind: 'speckle', a: '#8f9aa3', b: '#dfe5ea', seed: 3 }, blue = { kind: 'cloth', a: '#5f7894', b: '#e8eef5', seed: 5 };
const green = { kind: 'speckle', a: '#6d8578', b: '#24382c', seed: 9 }, white = { kind: 'boards', a: '#d5d9dc', b: '#8d949b', seed: 11 };
const bottle = { grasp: 'large-diameter', up: 'axis' }, stick = { grasp: 'small-diameter', up: [0, 0, 1] }, tool = { grasp: 'abducted-thumb', up: [0, 0, 1] };
const ball = { grasp: 'pinch', up: [-0.4, 0.3, 1] }, sphere = { grasp: 'power-sphere', up: [0, 0, 1] }, lid = { grasp: 'precision-disc', up: 'axis' };
const segmented = { segmented: true, distance: 0.34, lean: 0.2 };
export const PICTURES = [
  { ...bottle, name: '01-large-diameter', view: [-72, 18, 0], arm: '#5a6068', table: grey, light: [-0.5, -0.6, 1], distance: 0.52, group: 'back' },
  { ...stick, name: '02-small-diameter', view: [70, 42, 0], arm: '#2c4a7c', table: white, lift: 0.05, distance: 0.42, group: 'back' },
  { ...tool, name: '04-abducted-thumb', view: [112, 30, 0], arm: '#3a5f4a', table: blue, lift: 0.05, distance: 0.42, group: 'thumb' },
  { ...ball, name: '09-pinch', view: [80, 12, 0], arm: 'bare', skin: 'tan', table: green, lift: 0.03, distance: 0.42, group: 'thumb' },
  { ...sphere, name: '10-power-sphere', view: [50, 30, 0], arm: '#31343c', table: white, distance: 0.42, group: 'back' },
  { ...lid, name: '12-precision-disc', view: [40, 35, 0], arm: '#7a7f88', table: blue, distance: 0.45, group: 'back' },
  { ...sphere, name: '10-power-sphere-left', hand: 'left', view: [105, 22, 0], arm: '#2d6b66', skin: 'brown', table: grey, paint: { a: '#d9dde2' }, distance: 0.42, group: 'back' },
  { ...bottle, name: 'no-hand', noHand: true, view: [-40, 25, 0], table: green, distance: 0.55, lean: 1 },
  { ...bottle, ...segmented, name: '01-large-diameter', view: [-115, 25, 0], group: 'back' },
  { ...stick, ...segmented, name: '02-small-diameter', view: [50, 30, 0], group: 'back' },
  { ...tool, ...segmented, name: '04-abducted-thumb', view: [65, 35, 0], group: 'thumb' },
  { ...ball, ...segmented, name: '09-pinch', view: [110, 5, 0], group: 'thumb' },
  { ...sphere, ...segmented, name: '10-power-sphere', view: [85, 15, 0], group: 'thumb' },
  { ...lid, ...segmented, name: '12-precision-disc', view: [75, 15, 0], group: 'thumb' },
];

// `n` segmented views of each grasp, even over the sphere from 25 degrees below to 70 above (a spiral of golden angles).
export const around = n => [[bottle, '01'], [stick, '02'], [tool, '04'], [ball, '09'], [sphere, '10'], [lid, '12']].flatMap(([held, number]) =>
  Array.from({ length: n }, (_, i) => {
    const sine = d => Math.sin(d * Math.PI / 180), height = sine(-25) + (sine(70) - sine(-25)) * (i + 0.5) / n;
    const view = [i * 137.508 % 360, Math.asin(height) * 180 / Math.PI, 0].map(d => Math.round(10 * d) / 10);
    return { ...held, ...segmented, name: `${number}-${held.grasp}-${String(i).padStart(3, '0')}`, view, group: 'around' };
  }));
