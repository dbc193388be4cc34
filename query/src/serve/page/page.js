// The page: takes a picture, sends it, and draws how the answer came about.
"use strict";

const $ = (id) => document.getElementById(id);
const hand = new HandView($("hand"));
const handLoaded = hand.load().catch(() => {});
let stream = null;
// The picture on the screen, to be asked about again when an option changes.
let current = null;
let asked = 0;

const inWords = (name) => name.replaceAll("-", " ");
const percent = (share) => `${Math.round(100 * share)} %`;

function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

function drawn(name, attributes, ...children) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

function tell(message) {
  $("problem").textContent = message;
  $("problem").hidden = !message;
}

async function ask(path, options = {}) {
  let response;
  try {
    response = await fetch(path, options);
  } catch {
    throw new Error("The service does not answer: it may have been stopped.");
  }
  if (response.ok) return response;
  if (response.status === 401) $("login").hidden = false;
  const body = await response.json().catch(() => null);
  const problem = new Error(body?.error?.message ?? `The service answered with ${response.status}.`);
  problem.status = response.status;
  problem.retry = Number(response.headers.get("Retry-After"));
  throw problem;
}

// A picture as a JPEG whose longer side is at most `side`.
async function shrunk(blob, side) {
  const bitmap = await createImageBitmap(blob);
  const scale = Math.min(1, side / Math.max(bitmap.width, bitmap.height));
  const canvas = element("canvas", { width: Math.round(scale * bitmap.width), height: Math.round(scale * bitmap.height) });
  canvas.getContext("2d").drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/jpeg", 0.95));
}

function request(blob) {
  const query = new URLSearchParams({ explained: "true", file: blob.name ?? "picture" });
  if ($("side").value !== "auto") query.set("hand", $("side").value);
  if ($("segmented").checked) query.set("segmented", "true");
  const robot = $("robot").value;
  if (!robot) return ask(`v1/recognise?${query}`, { method: "POST", body: blob });
  query.set("robot", robot);
  const form = new FormData();
  form.set("picture", blob);
  form.set("object", new Blob([$("object").value]));
  form.set("camera", new Blob([$("camera-pose").value]));
  return ask(`v1/strategy?${query}`, { method: "POST", body: form });
}

async function recognise(blob) {
  current = blob;
  const number = ++asked;
  tell("");
  $("busy").textContent = "Looking at the picture …";
  try {
    let response;
    for (let attempt = 0; ; attempt++) {
      try {
        response = await request(blob);
        break;
      } catch (problem) {
        // What is too large for the service need not be: it works at 512 pixels.
        if (problem.status === 413 && attempt === 0) blob = await shrunk(blob, 1600).catch(() => { throw problem; });
        else if (problem.status === 429 && attempt < 10) await new Promise((go) => setTimeout(go, 1000 * (problem.retry || 1)));
        else throw problem;
      }
    }
    const record = await response.json();
    await handLoaded;
    // Of several pictures in a row, the last one counts.
    if (number === asked) show(blob, record);
  } catch (problem) {
    if (number !== asked) return;
    $("answer").hidden = true;
    tell(problem.message);
  } finally {
    if (number === asked) $("busy").textContent = "";
  }
}

function show(blob, record) {
  const { explained, orientation } = record;
  $("answer").hidden = false;
  $("verdict").textContent = record.reason ? "unknown" : `${inWords(record.grasp)}, ${percent(record.probability)}`;
  $("words").textContent = `A ${record.hand} hand. The camera sees ${orientation.camera_sees}, the fingers point ${orientation.fingers_point}, give or take ${Math.round(orientation.spread_deg)}°.`
    + (record.reason ? ` Unknown: ${record.reason}.` : "");
  URL.revokeObjectURL($("picture").src);
  $("picture").src = URL.createObjectURL(blob);
  // A format that no browser knows shows as its mask alone.
  $("picture").onerror = () => { $("picture").hidden = true; };
  $("picture").hidden = false;
  $("seen").style.aspectRatio = `${explained.width} / ${explained.height}`;
  $("mask").src = explained.mask;
  $("hand-image").src = explained.hand_image;
  const flipped = record.hand === "left" ? ", flipped as it is looked up" : "";
  const rolled = record.roll_deg ? `, turned by ${Math.round(record.roll_deg)}°` : "";
  $("hand-caption").textContent = `Hand image${flipped}${rolled}`;
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

// The paper's Figure 4: for each orientation, how much each cell holds of it; coarser levels beside finer ones.
function drawDescriptor({ cells, bins, dim }) {
  const side = 128;
  const gap = 12;
  const canvas = $("descriptor");
  canvas.width = bins * (1.5 * side + 4 + gap) - gap;
  canvas.height = side;
  const context = canvas.getContext("2d");
  context.fillStyle = "#000";
  for (let bin = 0; bin < bins; bin++) context.fillRect(bin * (1.5 * side + 4 + gap), 0, 1.5 * side + 4, side);
  const largest = {};
  for (const { level, histogram } of cells) largest[level] = Math.max(largest[level] ?? 1e-9, ...histogram);
  for (const { level, cells_a_side, row, column, histogram } of cells) {
    const size = side >> (level - 1);
    const cell = size / cells_a_side;
    const left = level === 1 ? 0 : side + 4;
    const top = level === 1 ? 0 : side - Math.min(side, 2 * size);
    histogram.forEach((value, bin) => {
      const shade = Math.round(255 * Math.max(0, Math.min(1, value / largest[level])));
      context.fillStyle = `rgb(${shade} ${shade} ${shade})`;
      context.fillRect(bin * (1.5 * side + 4 + gap) + left + column * cell, top + row * cell, Math.max(1, cell - 1), Math.max(1, cell - 1));
    });
  }
  canvas.setAttribute("aria-label", `The descriptor, ${dim} values, as shades of grey in cells`);
  $("descriptor-caption").textContent = `The descriptor: ${dim} values. For each of ${bins} edge orientations, how much each cell holds of it, from fine to coarse`;
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
const MOST_NEIGHBOURS = 14;

// The paper's Figure 5.
function drawNeighbours({ neighbours, classes, explained, search }) {
  $("neighbours").replaceChildren(...neighbours.slice(0, MOST_NEIGHBOURS).map((neighbour) => {
    const name = inWords(neighbour.grasp);
    const picture = element("img", { alt: `${name}, ${neighbour.stage}`, width: 96, height: 96 });
    picture.src = `v1/neighbours/${neighbour.id}/thumbnail.png?generation=${explained.generation}`;
    // An index without thumbnails.
    picture.onerror = () => { picture.hidden = true; };
    const item = element("li", { className: neighbour.grasp === classes[0].grasp ? "agrees" : "", title: neighbour.file },
      element("div", { className: "view" }, picture));
    if (neighbour.quaternion_xyzw) item.append(axes(neighbour.quaternion_xyzw));
    item.append(element("strong", {}, name), `distance ${neighbour.distance.toFixed(3)}`, element("br"),
      element("span", { className: "faint" }, [neighbour.hand_shape, neighbour.stage].filter(Boolean).join(", ")));
    return item;
  }));
  const voted = neighbours.length > MOST_NEIGHBOURS ? `These are the first ${MOST_NEIGHBOURS} of ${neighbours.length} that voted. ` : "";
  $("cost").textContent = voted + (search.exact
    ? "Every entry was compared."
    : `${search.candidates} entries were compared, ${(100 * search.share_of_database).toFixed(search.share_of_database < 0.1 ? 1 : 0)} % of the index.`);
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

async function openCamera() {
  tell("");
  try {
    stream = await navigator.mediaDevices.getUserMedia({ video: { width: { ideal: 1280 }, facingMode: "environment" } });
  } catch {
    tell("The camera cannot be used: allow it for this page. Browsers give it to pages of this machine and to encrypted ones only.");
    return;
  }
  $("video").srcObject = stream;
  await $("video").play();
  $("viewfinder").hidden = false;
  $("take").focus();
}

function closeCamera() {
  for (const track of stream?.getTracks() ?? []) track.stop();
  stream = null;
  $("viewfinder").hidden = true;
}

function takePicture() {
  const video = $("video");
  const canvas = element("canvas", { width: video.videoWidth, height: video.videoHeight });
  canvas.getContext("2d").drawImage(video, 0, 0);
  canvas.toBlob((blob) => recognise(blob), "image/jpeg", 0.95);
}

function pictureIn(transfer) {
  return [...(transfer?.files ?? [])].find((file) => file.type.startsWith("image/") || /\.(pnm|ppm|pgm)$/i.test(file.name));
}

$("choose").addEventListener("click", () => $("file").click());
$("file").addEventListener("change", () => {
  const [file] = $("file").files;
  if (file) recognise(file);
  // The same file may be chosen again.
  $("file").value = "";
});
$("camera").addEventListener("click", openCamera);
$("take").addEventListener("click", takePicture);
$("leave").addEventListener("click", () => {
  closeCamera();
  $("camera").focus();
});
for (const name of ["dragenter", "dragover"]) {
  document.addEventListener(name, (event) => {
    event.preventDefault();
    $("drop").classList.add("over");
  });
}
document.addEventListener("dragleave", (event) => {
  if (!event.relatedTarget) $("drop").classList.remove("over");
});
document.addEventListener("drop", (event) => {
  event.preventDefault();
  $("drop").classList.remove("over");
  const file = pictureIn(event.dataTransfer);
  if (file) recognise(file);
  else tell("That is no picture: drop a PNG, JPEG or PNM file.");
});
document.addEventListener("paste", (event) => {
  const file = pictureIn(event.clipboardData);
  if (file) recognise(file);
});
for (const id of ["side", "segmented", "robot", "object", "camera-pose"]) {
  $(id).addEventListener("change", () => { if (current) recognise(current); });
}
$("show-mask").addEventListener("change", () => { $("mask").hidden = !$("show-mask").checked; });
$("home").addEventListener("click", () => hand.home());
$("login").addEventListener("submit", async (event) => {
  event.preventDefault();
  try {
    await ask("session", { method: "POST", headers: { Authorization: `Bearer ${$("token").value.trim()}` } });
    $("login").hidden = true;
    tell("");
    await about();
    if (current) recognise(current);
  } catch (problem) {
    tell(problem.message);
  }
});

async function about() {
  try {
    const index = await (await ask("v1/index")).json();
    $("about").textContent = `${index.entries.toLocaleString("en")} views of ${index.classes.length} grasps`;
    $("quiz").hidden = !index.quiz;
    if (!index.recognises) tell("The index that is served holds raw vectors: it cannot tell what pictures show.");
  } catch (problem) {
    if (problem.status !== 401) tell(problem.message);
  }
}

about();
