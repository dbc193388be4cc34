// The page: takes a picture, sends it, and shows the answer or why there is none.
"use strict";

const $ = (id) => document.getElementById(id);
const hand = new HandView($("hand"));
const handLoaded = hand.load().catch(() => {});
// The picture on the screen, to be asked about again when an option changes.
let current = null;
let asked = 0;
// What `v1/index` says of the index that answers.
let served = null;

const inWords = (name) => name.replaceAll("-", " ");

// A share in percent; what is neither nothing nor all does not look so.
function percent(share) {
  if (share > 0 && share < 0.005) return "< 1 %";
  if (share >= 0.995 && share < 1) return "> 99 %";
  return `${Math.round(100 * share)} %`;
}

// A message of the service, with where on this page its advice is followed.
const onPage = (message) => message.replaceAll("a mask can be given", "a mask can be given above, under “It is found”").replaceAll("say which it is", "say which it is above, under “Hand”");

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

// Says what is wrong, with what can be done about it and beside the picture where there is one; an empty message hides it all.
function tell(message, { picture = null, advice = [] } = {}) {
  $("problem").textContent = message;
  $("problem").hidden = !message;
  $("advice").replaceChildren(...advice.map((text) => element("li", {}, text)));
  $("unanswered").hidden = !message;
  const figure = $("rejected").closest("figure");
  figure.hidden = !picture;
  if (picture) showBlob($("rejected"), picture, () => { figure.hidden = true; });
  $("rejected-name").textContent = picture?.name ?? "";
}

// Shows a picture in an <img>; `otherwise` is called where the browser does not know its format.
function showBlob(image, blob, otherwise) {
  URL.revokeObjectURL(image.src);
  image.onerror = otherwise;
  image.src = URL.createObjectURL(blob);
}

async function ask(path, options = {}) {
  let response;
  try {
    response = await fetch(path, options);
  } catch (failure) {
    if (failure.name === "AbortError") throw failure;
    throw new Error("The service does not answer: it may have been stopped.");
  }
  if (response.ok) return response;
  if (response.status === 401) $("login").hidden = false;
  const body = await response.json().catch(() => null);
  const problem = new Error(body?.error?.message ?? `The service answered with ${response.status}.`);
  problem.status = response.status;
  problem.kind = body?.error?.kind;
  problem.retry = Number(response.headers.get("Retry-After"));
  throw problem;
}

// A picture as a JPEG whose longer side is at most `side`.
async function shrunk(blob, side) {
  const bitmap = await createImageBitmap(blob);
  const scale = Math.min(1, side / Math.max(bitmap.width, bitmap.height));
  const canvas = element("canvas", { width: Math.round(scale * bitmap.width), height: Math.round(scale * bitmap.height) });
  canvas.getContext("2d").drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  const jpeg = await new Promise((resolve) => canvas.toBlob(resolve, "image/jpeg", 0.95));
  return new File([jpeg], blob.name ?? "picture", { type: "image/jpeg" });
}

// The options of a request that hold for pictures and for the camera's frames.
function parameters(name) {
  const query = new URLSearchParams({ explained: "true", file: name });
  if ($("side").value !== "auto") query.set("hand", $("side").value);
  if ($("source").value === "segmented") query.set("segmented", "true");
  if ($("source").value === "skin") query.set("segment", "skin");
  return query;
}

// What is still missing before a picture can be sent.
function missing() {
  const source = $("source").value;
  if (source === "mask" && !$("mask-file").files[0]) return "Choose the mask as well.";
  if (source === "depth" && !$("depth-file").files[0]) return "Choose the depth picture as well.";
  if (source === "depth" && !($("near").value && $("far").value)) return "Say from which distance to which the hand lies.";
  return null;
}

function request(blob) {
  const query = parameters(blob.name ?? "picture");
  const source = $("source").value;
  const robot = $("robot").value;
  if (!robot && source !== "mask" && source !== "depth") {
    return ask(`v1/recognise?${query}`, { method: "POST", body: blob });
  }
  const form = new FormData();
  form.set("picture", blob);
  if (source === "mask") form.set("mask", $("mask-file").files[0]);
  if (source === "depth") {
    form.set("depth", $("depth-file").files[0]);
    query.set("depth_range", `${$("near").value}..${$("far").value}`);
  }
  if (robot) {
    query.set("robot", robot);
    form.set("object", new Blob([$("object").value]));
    form.set("camera", new Blob([$("camera-pose").value]));
  }
  return ask(`v1/${robot ? "strategy" : "recognise"}?${query}`, { method: "POST", body: form });
}

async function recognise(blob) {
  current = blob;
  const number = ++asked;
  tell("");
  $("busy").textContent = missing() ?? "Looking at the picture …";
  if (missing()) return;
  try {
    let response;
    for (let attempt = 0; ; attempt++) {
      try {
        response = await request(blob);
        break;
      } catch (problem) {
        // What is too large for the service need not be: it works at 512 pixels. A mask would no longer fit.
        const mayShrink = !["mask", "depth"].includes($("source").value);
        if (problem.status === 413 && attempt === 0 && mayShrink) blob = await shrunk(blob, 1600).catch(() => { throw problem; });
        else if (problem.status === 429 && attempt < 10) await pause(1000 * (problem.retry || 1));
        else throw problem;
      }
    }
    const record = await response.json();
    await handLoaded;
    if (served && served.generation !== record.explained.generation) await about();
    // Of several pictures in a row, the last one counts.
    if (number !== asked) return;
    $("known").open = false;
    show(blob, record);
  } catch (problem) {
    if (number !== asked) return;
    $("answer").hidden = true;
    const words = problem.kind === "no_hand" ? noHand() : { message: onPage(problem.message), advice: [] };
    tell(words.message, { picture: blob, advice: words.advice });
    $("unanswered").scrollIntoView({ block: "nearest" });
  } finally {
    if (number === asked) $("busy").textContent = "";
  }
}

const pause = (milliseconds) => new Promise((go) => setTimeout(go, milliseconds));

// Why no hand was found, by how it was looked for, and what may help.
function noHand() {
  const seen = {
    scene: ["Nothing in the picture looks like a hand.", [
      "The hand should be well lit, and large in the picture.",
      "If it is bare and before another colour: choose “by the colour of skin” above.",
      "If another program can find the hand: choose “by a mask” above.",
    ]],
    skin: ["Nothing in the picture has the colour and the size of a hand.", [
      "The hand should be bare, well lit, and large in the picture.",
      "Skin-coloured things around it (wood, cardboard, a face) hide it: take another background.",
      "If another program can find the hand: choose “by a mask” above.",
    ]],
    segmented: ["The picture is black all over.", ["For a picture as a camera takes it, choose “by what hands look like” above."]],
    mask: ["The mask is black all over.", ["It must be white where the hand is."]],
    depth: ["Nothing of a hand's size lies between the two distances.", ["They are in the unit of the depth picture, often millimetres; 0 means that nothing was measured."]],
  }[$("source").value];
  return { message: `No hand found. ${seen[0]}`, advice: seen[1] };
}

function pictureIn(transfer) {
  return [...(transfer?.files ?? [])].find((file) => file.type.startsWith("image/") || /\.(pnm|ppm|pgm)$/i.test(file.name));
}

function askAgain() {
  if (current) recognise(current);
}

$("choose").addEventListener("click", () => $("file").click());
$("file").addEventListener("change", () => {
  const [file] = $("file").files;
  if (file) recognise(file);
  // The same file may be chosen again.
  $("file").value = "";
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
  else tell("This is not a picture: drop a PNG, JPEG or PNM file.");
});
document.addEventListener("paste", (event) => {
  const file = pictureIn(event.clipboardData);
  if (file) recognise(file);
});
$("source").addEventListener("change", () => {
  for (const source of ["mask", "depth"]) $(`${source}-choice`).hidden = $("source").value !== source;
});
for (const id of ["side", "source", "mask-file", "depth-file", "near", "far", "robot", "object", "camera-pose"]) {
  $(id).addEventListener("change", askAgain);
}
$("login").addEventListener("submit", async (event) => {
  event.preventDefault();
  try {
    await ask("session", { method: "POST", headers: { Authorization: `Bearer ${$("token").value.trim()}` } });
    $("login").hidden = true;
    tell("");
    await about();
    askAgain();
  } catch (problem) {
    tell(problem.message);
  }
});

async function about() {
  try {
    served = await (await ask("v1/index")).json();
    $("about").textContent = `${served.entries.toLocaleString("en")} views of ${served.classes.length} grasps`;
    $("quiz").hidden = !served.quiz;
    if (!served.recognises) tell("The index that is served holds raw vectors: it cannot say what pictures show.");
    await handLoaded;
    drawKnown(served.classes);
  } catch (problem) {
    if (problem.status !== 401) tell(problem.message);
  }
}

// All scripts have run by then.
document.addEventListener("DOMContentLoaded", about);
