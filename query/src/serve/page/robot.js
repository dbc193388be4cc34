// The robot's strategy as a picture: the object, the way of the palm to it and the way up, from the side and from above.
"use strict";

const ROBOT_FILES = { object: "bottle.toml", "camera-pose": "camera.toml" };
// Metres that the picture is high and wide.
const FIELD = 0.5;

// The palm's axis of approach, and its side of the thumb, in the world.
function palmAxes(pose) {
  const m = matrixOf(pose.quaternion_xyzw);
  return { z: [m[2], m[5], m[8]], y: [m[1], m[4], m[7]] };
}

// One view; `right` and `up` say which of the world's axes go right and up in it, `sign` whether right is reversed.
function strategyView(strategy, title, left, [right, up]) {
  const palm = strategy.palm_in_world;
  const { z, y } = palmAxes(palm);
  const middle = palm.position;
  const at = (p) => [150 + (300 / FIELD) * (p[right] - middle[right]), 130 - (300 / FIELD) * (p[up] - middle[up])];
  const line = (from, to, name) => {
    const [a, b] = [at(from), at(to)];
    return drawn("line", { x1: a[0], y1: a[1], x2: b[0], y2: b[1], class: name });
  };
  const plus = (p, d, length) => p.map((x, i) => x + length * d[i]);
  const parts = [];
  const approach = strategy.steps.find((step) => step.step === "approach");
  const retreat = strategy.steps.find((step) => step.step === "retreat");
  // Where the palm comes from: the wrist's way, moved to the palm.
  const back = approach.from.position.map((x, i) => x - approach.to.position[i]);
  const start = middle.map((x, i) => x + back[i]);
  parts.push(line(start, middle, "way"));
  if (retreat.direction.frame === "world") parts.push(line(middle, plus(middle, retreat.direction.vector, retreat.distance), "way up"));
  // The object lies in front of the palm, as wide across the fingers as the strategy says.
  const width = strategy.object_width;
  const [cx, cy] = at(plus(middle, z, width / 2));
  parts.unshift(drawn("circle", { cx, cy, r: (150 / FIELD) * width, class: "thing" }));
  // The palm, its fingers on one side of the object and its thumb on the other.
  const half = Math.max(width / 2 + 0.02, 0.04);
  const [one, other] = [plus(middle, y, half), plus(middle, y, -half)];
  parts.push(line(one, other, "palm"), line(one, plus(one, z, 0.09), "palm"), line(other, plus(other, z, 0.09), "palm"));
  const group = drawn("g", { transform: `translate(${left} 0)` }, ...parts);
  const text = drawn("text", { x: 12, y: 22 });
  text.textContent = title;
  group.append(text);
  return group;
}

const stepInWords = {
  preshape: () => "Open the fingers, away from the object.",
  approach: (step) => `Move straight to it, ${Math.round(100 * step.distance)} cm.`,
  grasp: (step) => `Close the fingers until they meet it; press with at most ${step.max_contact_force} N.`,
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
  const svg = drawn("svg", { viewBox: "0 0 600 260", role: "img" },
    strategyView(strategy, "from the side", 0, [0, 2]), strategyView(strategy, "from above", 300, [0, 1]));
  svg.setAttribute("aria-label", summary);
  $("strategy-picture").append(svg, element("p", {}, `A ${summary}.`));
  $("steps").append(...strategy.steps.map((step) => element("li", {}, stepInWords[step.step]?.(step) ?? step.step)));
  for (const warning of strategy.warnings) $("steps").append(element("li", { className: "warning" }, `Beware: ${warning}.`));
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
