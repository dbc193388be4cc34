// The page of the quiz. The server knows the order and the answers; this draws them and sends what is chosen.
"use strict";

const $ = (id) => document.getElementById(id);
let choices = [];
let state = null;
// The picture on the screen: the next to answer, or the one before it.
let viewing = 0;
// No answer is taken before its picture is seen.
let busy = true;

async function ask(path, body) {
  const options = body === undefined ? {} : {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(body),
  };
  let response;
  try {
    response = await fetch(path, options);
  } catch {
    throw new Error("The program does not answer: it may have been stopped. Answers given so far are kept; start it again and reload this page.");
  }
  if (!response.ok) {
    const body = await response.json().catch(() => null);
    throw new Error(body?.error?.message ?? `The program answered with status ${response.status}.`);
  }
  return response.json();
}

function tell(problem) {
  $("problem").textContent = problem.message;
  $("problem").hidden = false;
}

function only(section) {
  for (const id of ["asking", "done", "result"]) $(id).hidden = id !== section;
}

function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

const inWords = (grasp) => grasp.replaceAll("-", " ");
const percent = (share) => `${Math.round(100 * share)} %`;

function drawChoices() {
  choices.forEach((choice, at) => {
    const example = element("span", { className: "example" });
    example.setAttribute("aria-hidden", "true");
    example.style.backgroundPosition = `${20 * at}% 0`;
    const name = element("span", { className: "name" }, element("kbd", {}, String(at + 1)), inWords(choice.grasp));
    const button = element("button", { type: "button" }, example, name, element("span", { className: "words" }, choice.words));
    button.addEventListener("click", () => answer(at + 1));
    $("choices").append(element("li", {}, button));
  });
}

function show(number) {
  viewing = number;
  $("bar").max = state.total;
  $("bar").value = state.answered;
  if (number >= state.total) {
    $("progress").textContent = `${state.total} of ${state.total} answered`;
    only("done");
    $("finish").focus();
    busy = false;
    return;
  }
  busy = true;
  only("asking");
  const isAgain = number < state.answered;
  $("progress").textContent = `Picture ${number + 1} of ${state.total}${isAgain ? ", again" : ""}`;
  $("back").textContent = isAgain ? "Forward" : "Back";
  $("back").disabled = !isAgain && state.answered === 0;
  document.querySelectorAll("#choices button").forEach((button, at) => {
    if (isAgain) button.setAttribute("aria-pressed", String(state.last === at + 1));
    else button.removeAttribute("aria-pressed");
  });
  const picture = $("picture");
  picture.classList.add("waiting");
  picture.src = `picture/${number}`;
}

async function answer(number) {
  if (busy || $("asking").hidden) return;
  busy = true;
  try {
    state = await ask("answer", { picture: viewing, answer: number });
    $("problem").hidden = true;
    show(state.answered);
  } catch (problem) {
    tell(problem);
    busy = false;
  }
}

function back() {
  if (busy || !$("result").hidden || state.answered === 0) return;
  show(viewing < state.answered ? state.answered : state.answered - 1);
}

async function finish() {
  try {
    drawResult(await ask("finish", {}));
  } catch (problem) {
    tell(problem);
  }
}

function matrix(title, score) {
  const [low, high] = score.interval.map((bound) => Math.round(100 * bound));
  const small = element("small", {}, `${percent(score.share.top1)} right (${low} to ${high} % with 95 % confidence)`);
  const table = element("table", {}, element("caption", {}, title, small));
  const number = (at) => (choices[at] ? String(choices[at].cutkosky) : "none");
  // Who always answers needs no column for no answer.
  const columns = score.confusion.counts.some((row) => row.at(-1) > 0) ? choices.length + 1 : choices.length;
  const head = element("tr", {}, element("td", { className: "corner" }));
  for (let at = 0; at < columns; at++) {
    head.append(element("th", { scope: "col", title: choices[at] ? inWords(choices[at].grasp) : "no answer" }, number(at)));
  }
  const body = element("tbody");
  score.confusion.counts.forEach((row, at) => {
    const sum = row.reduce((total, count) => total + count, 0);
    const line = element("tr", {}, element("th", { scope: "row" }, `${inWords(choices[at].grasp)} ${choices[at].cutkosky}`));
    row.slice(0, columns).forEach((count) => {
      const cell = element("td", { className: count ? "" : "zero" }, String(count));
      // Never so dark that the number could not be read.
      cell.style.setProperty("--share", `${sum ? Math.round(50 * count / sum) : 0}%`);
      line.append(cell);
    });
    body.append(line);
  });
  table.append(element("thead", {}, head), body);
  return element("div", { className: "matrix" }, table);
}

function drawResult(result) {
  only("result");
  $("progress").textContent = `${result.n} of ${result.total} answered`;
  $("bar").value = result.n;
  document.title = "The result";
  document.querySelector("h1").textContent = "The result";
  const { person, machine, alike, paper } = result;
  $("verdict").textContent = `You named ${person.share.right} of ${person.share.n} grasps rightly`;
  $("compared").textContent = machine
    ? `The program named ${machine.share.right} of the same pictures rightly; on ${alike.right} you and it agree.`
    : "There was no index to compare with: name one with --index.";
  const drawn = [matrix("You", person)];
  if (machine) drawn.push(matrix("The program", machine));
  $("matrices").replaceChildren(...drawn);
  $("paper").textContent = `Rows are what the pictures show, columns what was answered, by Cutkosky's numbers. In the paper a person named ${percent(paper.human_top1.top1)} of ${paper.human_top1.n} other pictures rightly, and its program ${percent(paper.top1.top1)}.`;
  $("result").focus();
}

$("picture").addEventListener("load", () => {
  $("picture").classList.remove("waiting");
  busy = false;
});
$("picture").addEventListener("error", () => {
  busy = false;
  tell(new Error("The picture cannot be loaded: the program may have been stopped. Start it again and reload this page."));
});
$("back").addEventListener("click", back);
$("reopen").addEventListener("click", back);
$("finish").addEventListener("click", finish);
document.addEventListener("keydown", (event) => {
  // A key that is held down would answer pictures that nobody has seen.
  if (event.repeat || event.ctrlKey || event.altKey || event.metaKey) return;
  if (/^[1-6]$/.test(event.key)) answer(Number(event.key));
  else if (event.key === "Backspace") {
    event.preventDefault();
    back();
  }
});

(async () => {
  try {
    [choices, state] = await Promise.all([ask("choices"), ask("state")]);
    drawChoices();
    if (state.finished) await finish();
    else show(state.answered);
  } catch (problem) {
    tell(problem);
  }
})();
