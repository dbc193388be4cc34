// The robot's strategy as a picture. What is drawn, and where, the strategy's `layout` says, in metres; here it gets pixels.
"use strict";

const ROBOT_FILES = { object: "bottle.toml", "camera-pose": "camera.toml" };
// Each view's size in pixels, and the room around what is drawn.
const VIEW = { width: 300, height: 260, margin: 30 };
// No object fills the picture: pixels a metre, at most.
const LARGEST_SCALE = 900;

// All that a view shows, which has to fit.
const shown = (view) => [view.object, view.palm, view.palm_at_start, ...view.fingers, view.approach, view.retreat].flat();

function extent(points, axis) {
  const values = points.map((point) => point[axis]);
  return [Math.min(...values), Math.max(...values)];
}

// Both views have one scale, so that they can be compared.
function scaleOf(views) {
  const fits = views.flatMap((view) => [VIEW.width, VIEW.height].map((size, axis) => {
    const [least, most] = extent(shown(view), axis);
    return (size - 2 * VIEW.margin) / Math.max(most - least, 1e-6);
  }));
  return Math.min(LARGEST_SCALE, ...fits);
}

function strategyView(view, scale, summary) {
  const [middle, level] = [0, 1].map((axis) => extent(shown(view), axis).reduce((a, b) => a + b) / 2);
  const at = ([x, y]) => [VIEW.width / 2 + scale * (x - middle), VIEW.height / 2 - scale * (y - level)];
  const points = (list) => list.map((point) => at(point).map((pixels) => pixels.toFixed(2)).join(",")).join(" ");
  const area = (list, name) => drawn("polygon", { points: points(list), class: name });
  const way = (list, name) => drawn("polyline", { points: points(list), class: name });
  const label = (x, y, words) => {
    const text = drawn("text", { x, y });
    text.textContent = words;
    return text;
  };
  const parts = [];
  if (view.table !== null) {
    const [, y] = at([0, view.table]);
    parts.push(drawn("rect", { x: 0, y, width: VIEW.width, height: Math.max(0, VIEW.height - y), class: "table" }));
  }
  parts.push(area(view.object, "thing"), area(view.palm_at_start, "start"), area(view.palm, "palm"));
  parts.push(...view.fingers.map((finger) => way(finger, "finger")));
  parts.push(way(view.approach, "way"), way(view.retreat, "way up"), label(12, 22, view.name));
  // A bar as long as it says, in the largest round length that has room.
  const bar = [1, 0.1, 0.01].find((metres) => scale * metres < VIEW.width / 2) ?? 0.01;
  const foot = VIEW.height - 10;
  parts.push(drawn("line", { x1: 12, y1: foot, x2: 12 + scale * bar, y2: foot, class: "ruler" }));
  parts.push(label(12, foot - 7, bar < 1 ? `${100 * bar} cm` : `${bar} m`));
  const svg = drawn("svg", { viewBox: `0 0 ${VIEW.width} ${VIEW.height}`, role: "img" }, ...parts);
  svg.setAttribute("aria-label", `${summary}, ${view.name}`);
  return svg;
}

const forceInWords = (step) => (step.simulated_force === null
  ? "How hard they press was not simulated"
  : `In the simulation of such an object one link pressed with up to ${Math.round(step.simulated_force)} N`)
  + `; the hand's description says ${step.max_contact_force} N, which nothing here keeps to.`;

const stepInWords = {
  preshape: () => "Open the fingers, away from the object.",
  approach: (step) => `Move straight to it, ${Math.round(100 * step.distance)} cm.`,
  grasp: (step) => `Close the fingers until they meet it. ${forceInWords(step)}`,
  retreat: (step) => `Lift it by ${Math.round(100 * step.distance)} cm.`,
};

function drawStrategy(strategy, error) {
  $("strategy").hidden = !strategy && !error;
  $("strategy-picture").replaceChildren();
  $("steps").replaceChildren();
  if (!strategy) {
    if (error) $("steps").append(element("li", {}, error.message));
    return;
  }
  const summary = `${inWords(strategy.grasp)} of the ${strategy.robot}, as ${inWords(strategy.human_grasp)}, on the ${strategy.object}`;
  const { views } = strategy.layout;
  const scale = scaleOf(views);
  $("strategy-picture").append(...views.map((view) => strategyView(view, scale, summary)));
  $("strategy-picture").append(element("p", {}, `A ${summary}. Dashed: the way to it; solid: the way up.`));
  // What cannot be right comes before what would be done.
  const problems = strategy.problems.map(({ message }) => element("p", { className: "warning" }, `This cannot be carried out: ${message}.`));
  $("strategy-picture").append(...problems);
  $("steps").append(...strategy.steps.map((step) => element("li", {}, stepInWords[step.step]?.(step) ?? step.step)));
  // The first warnings are the problems.
  for (const doubt of strategy.warnings.slice(problems.length)) $("steps").append(element("li", { className: "warning" }, `Beware: ${doubt}.`));
}

// The descriptions to begin with are those that the program brings along.
document.addEventListener("DOMContentLoaded", () => {
  $("robot-choice").addEventListener("toggle", async () => {
    for (const [id, file] of Object.entries(ROBOT_FILES)) {
      if ($(id).value) continue;
      const response = await fetch(file);
      if (response.ok && !$(id).value) $(id).value = await response.text();
    }
  });
});
