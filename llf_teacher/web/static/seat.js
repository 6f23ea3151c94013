"use strict";
// A seat of a lesson. All there is to know is on the server: this page asks for it, and shows it.
import { ask, byId, make } from "./common.js";

const here = location.pathname;
const PATIENCE = 1000; // milliseconds between two looks at what the other seat does, or at a server that is away
const dark = matchMedia("(prefers-color-scheme: dark)");
let known = { version: -1, mark: "", turn: -1 };
let playing = null;
let timer = null;

const later = () => {
  clearTimeout(timer);
  timer = setTimeout(look, PATIENCE);
};

const look = async () => {
  try {
    const state = await ask(`${here}/state?version=${known.version}&since=${known.mark}`);
    byId("connection").textContent = "";
    if (state) show(state);
    else if (known.waits) later();
  } catch (error) {
    byId("connection").textContent = error.answered ? error.message : "The server cannot be reached; trying again.";
    if (!error.answered) later();
  }
};

const send = async (what, sent) => {
  const problem = byId("problem");
  problem.textContent = "";
  document.body.setAttribute("aria-busy", "true");
  try {
    show(await ask(`${here}/${what}`, { ...sent, turn: known.turn, since: known.mark }));
    return true;
  } catch (error) {
    problem.textContent = error.answered ? error.message : "The server cannot be reached; try again.";
    if (!error.answered || error.status === 409) later(); // another page has moved, or the answer was lost
    return false;
  } finally {
    document.body.removeAttribute("aria-busy");
  }
};

// A sentence with its kind and verdict. The server's own template has made and escaped it, as the turns below.
const drawn = (name, { html }) => {
  const line = make(name, "", { class: "sentence" });
  line.innerHTML = html;
  return line;
};

const sentences = (state) => {
  const said = byId("said");
  byId("did").textContent = state.did;
  const shown = state.said.map((each) => drawn("p", each));
  if (!shown.length) shown.push(make("p", state.heard ? "(silence)" : "(nothing yet)", { class: "quiet" }));
  const same = said.textContent === shown.map((line) => line.textContent).join("");
  if (!same || state.turn !== known.turn) said.replaceChildren(...shown); // else a screen reader would say it again
};

const drawTurns = (state) => {
  const list = byId("turns");
  while (list.children.length > state.first) list.lastElementChild.remove();
  // The server's own template has made and escaped this; nothing in it can run, by the page's security policy.
  for (const turn of state.turns) list.insertAdjacentHTML("beforeend", turn);
  // The last one is above already, in large.
  [...list.children].forEach((turn, number) => { turn.hidden = number === state.turn; });
  byId("past").hidden = ![...list.children].some((turn) => !turn.hidden);
};

const status = (state) => {
  const total = Number(state.total.toPrecision(4));
  const solved = state.success && !state.over ? " Solved." : "";
  const turn = `Turn ${state.turn} of ${state.most}, reward ${total} in all.${solved}`;
  if (state.over) return `${turn} It is over.`;
  if (state.seat === "watcher") return turn;
  return state.mine ? `${turn} It is your turn.` : `${turn} Waiting for the ${state.waits}.`;
};

const student = (state) => {
  byId("expected").textContent = `The answer must be ${state.expected}.`;
  byId("expected").classList.toggle("unseen", state.words.length > 0); // the buttons say it
  byId("answer").rows = state.lines ? 4 : 1;
  if (byId("buttons").childElementCount !== state.words.length) {
    byId("buttons").replaceChildren(...state.words.map((word) => {
      const button = make("button", word, { type: "button" });
      button.addEventListener("click", () => move({ act: word }));
      return button;
    }));
  }
};

const teacher = (state) => {
  const chooses = "claims" in state;
  byId("claims").hidden = !chooses;
  byId("own").hidden = chooses;
  if (chooses) {
    const legend = byId("claims").querySelector("legend");
    const choices = state.claims.map((each, number) => {
      const label = make("label");
      label.append(make("input", "", { type: "checkbox", value: number }), drawn("span", each));
      return label;
    });
    if (!choices.length) choices.push(make("p", "There is nothing true to say.", { class: "quiet" }));
    byId("claims").replaceChildren(legend, ...choices);
  } else {
    byId("understood-head").hidden = !state.understood.length;
    byId("understood").replaceChildren(...state.understood.map((each) => drawn("p", each)));
    byId("suggestion").textContent = state.suggestion ? `It would say: ${state.suggestion}` : "It would say nothing.";
  }
};

const show = (state) => {
  const moved = state.version !== known.version || known.turn === -1;
  byId("status").textContent = status(state);
  byId("now").textContent = state.now;
  byId("unmeasured").hidden = !state.unmeasured;
  byId("unmeasured").textContent = `How much sentences say cannot be measured: ${state.unmeasured}.`;
  sentences(state);
  drawTurns(state);
  if (moved) picture(state);
  byId("act").hidden = !(state.mine && state.seat === "student");
  byId("teach").hidden = !(state.mine && state.seat === "teacher");
  byId("watch").hidden = !(state.mine && state.seat === "watcher");
  byId("intro").hidden = state.turn > 0 && state.seat !== "watcher";
  byId("undo").hidden = !state.undo;
  const row = byId("do").querySelector("form:not([hidden]) .row") ?? byId("do");
  if (byId("undo").parentElement !== row) row.append(byId("undo"));
  if (state.seat === "student") student(state);
  if (state.mine && state.seat === "teacher") teacher(state);
  byId("end").hidden = !state.over;
  if (state.over) {
    byId("sum").textContent = `Over after ${state.turn} turns: ${state.success ? "solved" : "not solved"}. `;
    stop();
  }
  known = state;
  clearTimeout(timer);
  if (state.waits) later();
};

const picture = (state) => {
  const theme = dark.matches ? "dark" : "light";
  byId("large").href = byId("picture").src = `${here}/frame.png?theme=${theme}&version=${state.version}`;
};

const stop = () => {
  clearInterval(playing);
  playing = null;
  byId("play").setAttribute("aria-pressed", "false");
};

// A move of this person. What is clicked while one is under way is left out.
let moving = false;
const move = async (sent, what = "move") => {
  if (moving) return false;
  moving = true;
  const done = await send(what, sent);
  moving = false;
  refocus();
  return done;
};

// Where the focus was on what is no longer there, it goes to the line that says whose turn it is.
const refocus = () => {
  const focused = document.activeElement;
  if (!focused || focused === document.body || !focused.checkVisibility()) byId("status").focus({ preventScroll: true });
};

const submit = (id, act) => byId(id).addEventListener("submit", (event) => {
  event.preventDefault();
  act();
});

submit("act", async () => {
  if (!byId("answer").value.trim()) return;
  if (await move({ act: byId("answer").value })) byId("answer").value = "";
});
submit("teach", async () => {
  if (!byId("claims").hidden) {
    const chosen = [...byId("claims").querySelectorAll("input:checked")].map((box) => Number(box.value));
    await move({ claims: chosen });
  } else if (await move({ say: byId("words-own").value })) {
    byId("words-own").value = "";
  }
});
submit("watch", () => move({}));
byId("silence").addEventListener("click", () => move(byId("claims").hidden ? { say: "" } : { claims: [] }));
byId("personality").addEventListener("click", () => move({ personality: true }));
byId("undo").addEventListener("click", () => move({}, "undo"));
byId("play").addEventListener("click", () => {
  if (playing) return stop();
  byId("play").setAttribute("aria-pressed", "true");
  playing = setInterval(() => move({}), 1500);
});
byId("answer").addEventListener("keydown", (event) => {
  if (event.key !== "Enter" || event.isComposing) return;
  if (byId("answer").rows > 1 ? event.ctrlKey || event.metaKey : !event.shiftKey) {
    event.preventDefault();
    byId("act").requestSubmit();
  }
});
byId("whole").href = `${here}/episode`;
document.addEventListener("visibilitychange", () => { if (!document.hidden) look(); });
dark.addEventListener("change", () => picture(known));
look().then(refocus);
