// What the page shows before it is given a picture: the grasps that it knows, and pictures to try.
"use strict";

const HELD = {
  "large-diameter": "a bottle or a can in the whole hand",
  "small-diameter": "a thin handle in the fist",
  "abducted-thumb": "a tool's handle, the thumb stretched along it",
  pinch: "a small thing between two fingertips",
  "power-sphere": "a ball in the whole hand",
  "precision-disc": "a lid from above, at its rim",
};
// How each hand is shown, as rows of the rotation from its frame: lying, as the thumb's side sees it, or upright, palm or back
// toward the camera; then turned about the picture's vertical and its horizontal, in radians.
const LYING = [-1, 0, 0, 0, 0, -1, 0, -1, 0];
const PALM = [-1, 0, 0, 0, -1, 0, 0, 0, 1];
const BACK = [1, 0, 0, 0, -1, 0, 0, 0, -1];
const SHOWN = {
  "large-diameter": [BACK, -0.9, 0.3],
  "small-diameter": [PALM, 0, 0.3],
  "abducted-thumb": [PALM, -0.3, 0.3],
};

function shownAs(grasp) {
  const [base, yaw, pitch] = SHOWN[grasp] ?? [LYING, 0.5, 0.45];
  const [cy, sy, cp, sp] = [Math.cos(yaw), Math.sin(yaw), Math.cos(pitch), Math.sin(pitch)];
  return times(times([1, 0, 0, 0, cp, -sp, 0, sp, cp], [cy, 0, -sy, 0, 1, 0, sy, 0, cy]), base);
}

// Those of the classes that there is a picture of.
function drawKnown(classes) {
  const known = classes.filter(({ grasp }) => hand.hands?.has(grasp));
  $("known").hidden = known.length === 0;
  $("known-title").textContent = known.length === classes.length
    ? "The grasps that it knows" : `${known.length} of the ${classes.length} grasps that it knows`;
  $("grasps").replaceChildren(...known.map(({ grasp, cutkosky }) => {
    const canvas = element("canvas", { width: 400, height: 300 });
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `${inWords(grasp)}: ${HELD[grasp] ?? "a hand"}`);
    drawHand(canvas, hand.hands.get(grasp), shownAs(grasp), { held: true, field: 0.21 });
    return element("li", {}, canvas, element("strong", { title: `Cutkosky ${cutkosky}` }, inWords(grasp)), HELD[grasp] ?? "");
  }));
}

for (const button of document.querySelectorAll("button.sample")) {
  const name = button.dataset.picture;
  button.addEventListener("click", async () => {
    try {
      const response = await ask(`samples/${name}`);
      recognise(new File([await response.blob()], name, { type: "image/jpeg" }));
    } catch (problem) {
      tell(problem.message);
    }
  });
}
