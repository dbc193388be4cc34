// An answer, drawn: the hand in the picture, the vote, the neighbours and the descriptor.
"use strict";

function show(blob, record) {
  const { explained, orientation } = record;
  $("answer").hidden = false;
  $("verdict").textContent = record.reason ? "unknown" : `${inWords(record.grasp)}, ${percent(record.probability)}`;
  $("words").textContent = `A ${record.hand} hand. The camera sees ${orientation.camera_sees}, the fingers point ${orientation.fingers_point}, give or take ${Math.round(orientation.spread_deg)}°.`
    + (record.reason ? ` Unknown: ${onPage(record.reason)}.` : "");
  const warnings = record.warnings ?? [];
  $("warnings").hidden = warnings.length === 0;
  $("warnings").replaceChildren(...warnings.map(({ message }) => element("li", {}, onPage(message))));
  $("picture").hidden = false;
  // A format that no browser knows shows as its mask alone.
  showBlob($("picture"), blob, () => { $("picture").hidden = true; });
  $("seen").style.aspectRatio = `${explained.width} / ${explained.height}`;
  $("mask").src = explained.mask;
  $("hand-image").src = explained.hand_image;
  const flipped = record.hand === "left" ? ", flipped as it is looked up" : "";
  const clockwise = ((record.roll_deg + 180) % 360 + 360) % 360 - 180;
  const rolled = Math.round(clockwise) ? `, turned ${Math.round(Math.abs(clockwise))}° to the ${clockwise > 0 ? "right" : "left"}` : "";
  $("hand-caption").textContent = `The hand alone, as it is compared${flipped}${rolled}`;
  drawDescriptor(explained);
  drawClasses(record);
  drawNeighbours(record);
  hand.show(record.classes[0].grasp, orientation.quaternion_xyzw, record.hand);
  drawStrategy(record.strategy, record.error);
  const { explained: _, ...rest } = record;
  $("record").textContent = JSON.stringify(rest, null, 1);
  $("answer").focus({ preventScroll: true });
  $("answer").scrollIntoView({ block: "nearest" });
}

function drawClasses({ classes }) {
  const rows = classes.map(({ grasp, cutkosky, probability }, at) => {
    const fill = element("span");
    fill.style.width = `${100 * probability}%`;
    const bar = element("div", { className: "bar" }, fill);
    bar.setAttribute("aria-hidden", "true");
    return element("tr", { className: at === 0 ? "first" : "" },
      element("th", { scope: "row", title: `Cutkosky ${cutkosky}` }, inWords(grasp)),
      element("td", {}, bar), element("td", {}, percent(probability)));
  });
  $("classes").querySelector("tbody").replaceChildren(...rows);
}

// Neighbours that are shown, however many vote.
const MOST_NEIGHBOURS = 12;
// Stored views of fewer pixels a side are too small to see fingers in: a hand is drawn as they were turned.
const LARGE_ENOUGH = 40;

// The paper's Figure 5.
function drawNeighbours({ neighbours, classes, explained, search, hand: side }) {
  const stored = served?.thumbnail_side ?? LARGE_ENOUGH;
  const modelled = stored < LARGE_ENOUGH;
  $("neighbours").replaceChildren(...neighbours.slice(0, MOST_NEIGHBOURS).map((neighbour) => {
    const name = inWords(neighbour.grasp);
    const view = element("div", { className: "view" });
    if (modelled && neighbour.quaternion_xyzw) {
      const canvas = element("canvas", { width: 320, height: 320 });
      canvas.setAttribute("aria-hidden", "true");
      if (hand.draw(neighbour.grasp, neighbour.quaternion_xyzw, side, canvas)) view.append(canvas);
    }
    if (stored > 0) {
      const picture = element("img", { alt: `${name}, ${neighbour.stage}`, width: 160, height: 160 });
      if (view.hasChildNodes()) picture.className = "inset";
      picture.src = `v1/neighbours/${neighbour.id}/thumbnail.png?generation=${explained.generation}`;
      picture.onerror = () => { picture.hidden = true; };
      view.append(picture);
    }
    const item = element("li", { className: neighbour.grasp === classes[0].grasp ? "agrees" : "", title: neighbour.file }, view);
    if (neighbour.quaternion_xyzw) item.append(axes(neighbour.quaternion_xyzw));
    item.append(element("strong", {}, name), `distance ${neighbour.distance.toFixed(3)}`, element("br"),
      element("span", { className: "faint" }, [neighbour.hand_shape, neighbour.stage].filter(Boolean).join(", ")));
    return item;
  }));
  $("views-note").textContent = modelled
    ? `Large: a model hand, turned as the view is. ${stored > 0 ? "Small: the view itself, as the index stores it. " : ""}` : "";
  const voted = neighbours.length > MOST_NEIGHBOURS ? `These are the first ${MOST_NEIGHBOURS} of ${neighbours.length} that voted. ` : "";
  const share = 100 * search.share_of_database;
  const part = share < 0.1 ? "less than 0.1" : share.toFixed(share < 10 ? 1 : 0);
  $("cost").textContent = voted + (search.exact
    ? "Every entry was compared."
    : `${search.candidates.toLocaleString("en")} entries were compared, ${part} % of the index.`);
}

// Where the hand's x (fingers) and z (back) point in the picture.
function axes(quaternion) {
  const m = matrixOf(quaternion);
  const line = (axis, name) => {
    const [x, y, z] = [m[axis], m[3 + axis], m[6 + axis]];
    const away = z > 0.15 ? " away" : "";
    return drawn("line", { x1: 0, y1: 0, x2: (18 * x).toFixed(1), y2: (18 * y).toFixed(1), class: name + away });
  };
  const svg = drawn("svg", { viewBox: "-20 -20 40 40", role: "img" }, line(2, "z"), line(0, "x"));
  const words = (x, y) => (Math.hypot(x, y) < 0.4 ? "toward or away from the camera" : `${y < -0.38 ? "up " : y > 0.38 ? "down " : ""}${x < -0.38 ? "left" : x > 0.38 ? "right" : ""}`.trim());
  svg.setAttribute("aria-label", `fingers ${words(m[0], m[3])}, back of the hand ${words(m[2], m[5])}`);
  return svg;
}

// What a network makes of a hand: a shade a value.
function drawEmbedding(values) {
  const [across, side] = [32, 10];
  const canvas = element("canvas", { width: across * side, height: Math.ceil(values.length / across) * side });
  const context = canvas.getContext("2d");
  const [least, most] = [Math.min(...values), Math.max(...values)];
  values.forEach((value, at) => {
    const shade = Math.round(255 * (value - least) / Math.max(1e-9, most - least));
    context.fillStyle = `rgb(${shade} ${shade} ${shade})`;
    context.fillRect((at % across) * side, Math.floor(at / across) * side, side - 1, side - 1);
  });
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", "The values of the descriptor as shades");
  $("descriptor").replaceChildren(element("figure", {}, canvas));
  $("descriptor-caption").textContent = `The ${values.length} values that are compared: what a network makes of the hand. Hands that are held and seen alike have about the same (black the smallest, white the largest).`;
}

// The paper's Figure 4: for each direction of edges, how much of it each cell holds; coarser levels beside the finest.
function drawDescriptor({ cells, edges_deg, dim, values }) {
  if (values.length) return drawEmbedding(values);
  const side = 128;
  const largest = {};
  for (const { level, histogram } of cells) largest[level] = Math.max(largest[level] ?? 1e-9, ...histogram);
  $("descriptor").replaceChildren(...edges_deg.map((degrees, bin) => {
    const canvas = element("canvas", { width: 1.5 * side + 4, height: side });
    const context = canvas.getContext("2d");
    for (const { level, cells_a_side, row, column, histogram } of cells) {
      const size = side >> (level - 1);
      const cell = size / cells_a_side;
      const left = level === 1 ? 0 : side + 4;
      const top = level === 1 ? 0 : side - Math.min(side, 2 * size);
      const shade = Math.round(255 * Math.max(0, Math.min(1, histogram[bin] / largest[level])));
      context.fillStyle = `rgb(${shade} ${shade} ${shade})`;
      context.fillRect(left + column * cell, top + row * cell, Math.max(1, cell - 1), Math.max(1, cell - 1));
    }
    const lie = { 0: " (level)", 90: " (upright)" }[degrees] ?? "";
    const title = `edges at ${Math.round(10 * degrees) / 10}°${lie}`;
    canvas.setAttribute("role", "img");
    canvas.setAttribute("aria-label", `How much each cell holds of ${title}`);
    const turn = degrees * Math.PI / 180;
    const [x, y] = [(7 * Math.cos(turn)).toFixed(1), (-7 * Math.sin(turn)).toFixed(1)];
    const sign = drawn("svg", { viewBox: "-9 -9 18 18", "aria-hidden": "true" }, drawn("line", { x1: -x, y1: -y, x2: x, y2: y }));
    return element("figure", {}, canvas, element("figcaption", {}, sign, ` ${title}`));
  }));
  const finest = Math.max(...cells.map((cell) => cell.cells_a_side));
  $("descriptor-caption").textContent = `The ${dim} values that are compared: for each direction of edges, how much of it each cell of the hand holds (black none, white most). Large: ${finest} × ${finest} cells; beside it, coarser.`;
}

// On a phone, what explains the answer waits until it is asked for.
const narrow = window.matchMedia("(max-width: 40rem)");
function fold() {
  for (const details of document.querySelectorAll("details.fold")) details.open = !narrow.matches;
}
narrow.addEventListener("change", fold);
fold();

$("show-mask").addEventListener("change", () => { $("mask").hidden = !$("show-mask").checked; });
$("home").addEventListener("click", () => hand.home());
