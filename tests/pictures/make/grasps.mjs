// The six grasps: the object, where it starts in the hand frame, and the angles (degrees) the fit leans to.
// Angles: fingers [spread, mcp, pip, dip], thumb [flex, spread, twist, mcp, ip]. `touch`: the skin that must meet the object.
const rad = d => d * Math.PI / 180;
export const GRASPS = {
  'large-diameter': {
    cutkosky: 1, object: { shape: 'cylinder', r: 0.035, h: 0.19 }, at: [0.091, -0.003, -0.060], axis: [0.22, 1, 0.08], stiff: 0.05, alike: 0.15,
    fingers: { index: [0, 45, 45, 25], middle: [0, 50, 50, 30], ring: [0, 50, 42, 20], pinky: [0, 48, 38, 15] },
    thumb: [10, 38, 10, 15, 25], touch: ['palm', 'thumb-distal', 'index', 'middle', 'ring', 'pinky'],
  },
  'small-diameter': {
    cutkosky: 2, object: { shape: 'cylinder', r: 0.012, h: 0.26 }, at: [0.084, -0.005, -0.038], axis: [0.26, 1, 0.10],
    fingers: { index: [0, 72, 90, 50], middle: [0, 74, 92, 50], ring: [0, 75, 90, 50], pinky: [0, 75, 85, 45] },
    thumb: [10, 25, 25, 35, 30], touch: ['palm', 'index-distal', 'middle-distal', 'ring-distal', 'pinky-distal', 'index-mid', 'middle-mid'], thumbOver: true,
  },
  'abducted-thumb': {
    cutkosky: 4, object: { shape: 'cylinder', r: 0.010, h: 0.24 }, at: [0.086, -0.003, -0.036], axis: [0.58, 1, 0.05],
    fingers: { index: [0, 60, 85, 40], middle: [0, 70, 92, 50], ring: [0, 75, 92, 50], pinky: [0, 80, 85, 50] },
    thumb: [5, 0, 10, 0, 0], touch: ['palm', 'thumb-distal', 'index-distal', 'middle-distal', 'ring-distal', 'pinky-distal', 'index-prox'], thumbAlong: true,
  },
  pinch: {
    cutkosky: 9, object: { shape: 'sphere', r: 0.012 }, at: [0.118, 0.035, -0.060], axis: [0, 0, 1],
    fingers: { index: [0, 50, 45, 20], middle: [-4, 38, 42, 22], ring: [-6, 28, 38, 20], pinky: [-8, 18, 32, 18] },
    thumb: [30, 10, 20, 15, 15], touch: ['thumb-tip', 'index-tip'], opposed: true,
  },
  'power-sphere': {
    cutkosky: 10, object: { shape: 'sphere', r: 0.040 }, at: [0.088, 0.005, -0.063], axis: [0, 0, 1],
    fingers: { index: [14, 40, 42, 25], middle: [3, 45, 45, 25], ring: [-8, 45, 45, 25], pinky: [-18, 45, 42, 25] },
    thumb: [20, 10, 25, 20, 30], touch: ['palm', 'thumb-distal', 'index', 'middle', 'ring', 'pinky'],
  },
  'precision-disc': {
    cutkosky: 12, object: { shape: 'cylinder', r: 0.045, h: 0.018 }, at: [0.108, 0.005, -0.072], axis: [0, 0, 1],
    fingers: { index: [16, 30, 42, 15], middle: [4, 34, 40, 15], ring: [-10, 34, 42, 15], pinky: [-24, 32, 40, 15] },
    thumb: [15, 15, 25, 10, 25], touch: ['thumb-tip', 'index-tip', 'middle-tip', 'ring-tip', 'pinky-tip'], rim: true,
  },
};
for (const g of Object.values(GRASPS)) {
  for (const f in g.fingers) g.fingers[f] = g.fingers[f].map(rad);
  g.thumb = g.thumb.map(rad);
}
