// The camera: a picture when it is asked for, or one answer after the other, drawn over what the camera sees.
"use strict";

// The longer side of the frames that are answered continuously: recognition itself works at 512 pixels.
const FRAME_SIDE = 640;
// Frames follow one another no faster than that.
const SHORTEST_MS = 60;

let stream = null;
// Ends the run of continuous answers that is under way; null where none is.
let running = null;

// Why there is no camera, and what can be done.
function noCamera(failure) {
  const reasons = {
    NotAllowedError: "The browser was told not to give the camera to this page: allow it (usually beside the address), then try again.",
    NotFoundError: "The browser finds no camera on this device.",
    NotReadableError: "The camera is there but cannot be opened: another program may be using it.",
  };
  if (window.isSecureContext && navigator.mediaDevices) return [reasons[failure?.name] ?? `The camera cannot be used: ${failure?.message ?? "the browser does not say why"}.`, []];
  return ["The browser gives no camera to this page, because the page came over an unencrypted connection from another machine.", [
    "Open the page over https://, where the service stands behind a server that encrypts.",
    `Or bring it to this machine through a tunnel, such as ssh -L 8750:localhost:${location.port || 80} ${location.hostname}, and open http://localhost:8750/.`,
    "Or use “Choose a picture”: phones offer their own camera there.",
  ]];
}

async function openCamera() {
  tell("");
  try {
    stream = await navigator.mediaDevices.getUserMedia({ video: { width: { ideal: 1280 }, facingMode: "environment" } });
    $("video").srcObject = stream;
    await $("video").play();
  } catch (failure) {
    closeCamera();
    const [message, advice] = noCamera(failure);
    tell(message, { advice });
    return;
  }
  for (const track of stream.getTracks()) {
    track.addEventListener("ended", () => {
      closeCamera();
      tell("The camera was switched off, or taken from this page.");
    });
  }
  $("viewfinder").hidden = false;
  $("drop").classList.add("filming");
  $("take").focus();
}

function closeCamera() {
  stopLive();
  for (const track of stream?.getTracks() ?? []) track.stop();
  stream = null;
  $("viewfinder").hidden = true;
  $("drop").classList.remove("filming");
}

// What the camera sees now, as a JPEG whose longer side is at most `side`.
function frameOf(video, side) {
  const scale = Math.min(1, side / Math.max(video.videoWidth, video.videoHeight, 1));
  const canvas = element("canvas", { width: Math.round(scale * video.videoWidth), height: Math.round(scale * video.videoHeight) });
  canvas.getContext("2d").drawImage(video, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve) => canvas.toBlob(resolve, "image/jpeg", 0.9));
}

async function takePicture() {
  stopLive();
  const blob = await frameOf($("video"), Infinity);
  if (!blob) return tell("The camera has given no picture: take it once more.");
  recognise(new File([blob], "camera.jpg", { type: "image/jpeg" }));
}

function stopLive() {
  running?.abort();
  running = null;
  $("live").setAttribute("aria-pressed", "false");
  $("live").textContent = "Answer continuously";
  $("live-note").hidden = true;
  $("live-words").hidden = true;
  $("overlay").getContext("2d").clearRect(0, 0, $("overlay").width, $("overlay").height);
}

// One frame at a time: the next is taken when the last is answered, so that a slow service is asked less.
async function startLive() {
  const run = new AbortController();
  running = run;
  $("answer").hidden = true;
  $("known").open = false;
  tell("");
  $("live").setAttribute("aria-pressed", "true");
  $("live").textContent = "Stop";
  $("live-note").hidden = false;
  let spoken = null;
  while (!run.signal.aborted) {
    const began = performance.now();
    try {
      const answer = await answerFrame(run.signal);
      if (run.signal.aborted) return;
      await drawLive(answer);
      const took = performance.now() - began;
      $("live-note").textContent = `Each frame is answered by itself, in ${Math.round(took)} ms; nothing is kept. Blue: where the fingers point; orange: where the back of the hand looks.`;
      // To those who listen only when it changes.
      const grasp = answer ? liveWords(answer)[0] : "no hand found";
      if (grasp !== spoken) $("spoken").textContent = grasp;
      spoken = grasp;
    } catch (problem) {
      if (run.signal.aborted) return;
      if (problem.status === 429 || problem.status === 503) {
        await pause(1000 * (problem.retry || 1));
        continue;
      }
      stopLive();
      tell(problem.message);
      return;
    }
    await pause(Math.max(0, SHORTEST_MS - (performance.now() - began)));
    // A page that nobody looks at asks nothing.
    while (document.hidden && !run.signal.aborted) await pause(250);
  }
}

// The record of what the camera sees now, or null where that is no hand.
async function answerFrame(signal) {
  const body = await frameOf($("video"), FRAME_SIDE);
  signal.throwIfAborted();
  if (!body) throw new Error("The browser cannot read the camera's picture.");
  try {
    const response = await ask(`v1/recognise?${parameters("camera")}`, { method: "POST", body, signal });
    return await response.json();
  } catch (problem) {
    if (problem.status === 422) return null;
    throw problem;
  }
}

function liveWords(record) {
  return record.reason ? ["unknown", ""] : [inWords(record.grasp), percent(record.probability)];
}

// Darkens what is not hand, and draws where the fingers point and where the back of the hand looks.
async function drawLive(record) {
  const words = $("live-words");
  words.hidden = false;
  const canvas = $("overlay");
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!record) {
    words.replaceChildren("no hand found");
    context.clearRect(0, 0, canvas.width, canvas.height);
    return;
  }
  const { explained, orientation } = record;
  const mask = element("img", { src: explained.mask });
  await mask.decode();
  // Setting the size clears the canvas: nothing of the last answer is left.
  canvas.width = explained.width;
  canvas.height = explained.height;
  context.drawImage(mask, 0, 0);
  const middle = middleOfHand(context.getImageData(0, 0, canvas.width, canvas.height));
  const m = matrixOf(orientation.quaternion_xyzw);
  const style = getComputedStyle($("stage"));
  const length = 0.2 * canvas.height;
  arrow(context, middle, [m[2], m[5]], length, style.getPropertyValue("--back"));
  arrow(context, middle, [m[0], m[3]], length, style.getPropertyValue("--fingers"));
  const [grasp, share] = liveWords(record);
  const warnings = (record.warnings ?? []).map(({ message }) => element("small", {}, onPage(message)));
  words.replaceChildren(element("strong", {}, grasp), ` ${share}`, ...warnings);
}

// The mean place of what the mask leaves clear.
function middleOfHand({ data, width, height }) {
  let [x, y, count] = [0, 0, 0];
  for (let at = 0; at < width * height; at++) {
    if (data[4 * at + 3]) continue;
    x += at % width;
    y += Math.floor(at / width);
    count++;
  }
  return count ? [x / count, y / count] : [width / 2, height / 2];
}

function arrow(context, [x, y], [dx, dy], length, colour) {
  const [endX, endY] = [x + length * dx, y + length * dy];
  const turn = Math.atan2(dy, dx);
  const head = 0.25 * length * Math.min(1, 2 * Math.hypot(dx, dy));
  context.strokeStyle = colour;
  context.lineWidth = Math.max(2, length / 16);
  context.lineCap = "round";
  context.beginPath();
  context.moveTo(x, y);
  context.lineTo(endX, endY);
  for (const side of [2.6, -2.6]) {
    context.moveTo(endX, endY);
    context.lineTo(endX + head * Math.cos(turn + side), endY + head * Math.sin(turn + side));
  }
  context.stroke();
}

$("camera").addEventListener("click", openCamera);
$("take").addEventListener("click", takePicture);
$("live").addEventListener("click", () => {
  if (running) stopLive();
  else startLive();
});
$("leave").addEventListener("click", () => {
  closeCamera();
  $("camera").focus();
});
