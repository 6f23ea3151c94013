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
    const told = await ask(`${here}/state?version=${known.version}&since=${known.mark}`);
    byId("connection").textContent = "";
    if (told) show(told);
    else if (known.waits) later();
  } catch (error) {
    byId("connection").textContent = error.answered ? error.message : "The server cannot be reached; trying again.";
    if (!error.answered) later();
  }
};

const send = async (what, sent) => {
  const problem = byId(what === "sit" ? "problem-sit" : "problem");
  problem.textContent = "";
  document.body.setAttribute("aria-busy", "true");
  try {
    show(await ask(`${here}/${what}`, { ...sent, since: known.mark }));
    return true;
  } catch (error) {
    problem.textContent = error.answered ? error.message : "The server cannot be reached; try again.";
    if (!error.answered) later();
    return false;
  } finally {
    document.body.removeAttribute("aria-busy");
  }
};

const kinds = (kind) => make("abbr", kind || "task", { class: "kind" });

const sentences = (told) => {
  const said = byId("said");
  const shown = told.said.map(({ kind, text }) => {
    const line = make("p");
    line.append(kinds(kind), " ", make("span", text));
    return line;
  });
  if (!shown.length) shown.push(make("p", told.heard ? "(silence)" : "(nothing yet)", { class: "quiet" }));
  const same = said.textContent === shown.map((line) => line.textContent).join("");
  if (!same || told.turn !== known.turn) said.replaceChildren(...shown); // else a screen reader would say it again
};

const drawTurns = (told) => {
  const list = byId("turns");
  while (list.children.length > told.first) list.lastElementChild.remove();
  // The server's own template has made and escaped this; nothing in it can run, by the page's security policy.
  for (const turn of told.turns) list.insertAdjacentHTML("beforeend", turn);
};

const status = (told) => {
  const total = Number(told.total.toPrecision(4));
  const turn = `Turn ${told.turn} of ${told.most}, reward ${total} in all.`;
  if (told.over) return `${turn} It is over.`;
  if (told.seat === "watcher") return turn;
  return told.mine ? `${turn} It is your turn.` : `${turn} Waiting for the ${told.waits}.`;
};

const student = (told) => {
  byId("expected").textContent = `The answer must be ${told.expected}.`;
  byId("answer").rows = told.lines ? 4 : 1;
  if (byId("buttons").childElementCount !== told.words.length) {
    byId("buttons").replaceChildren(...told.words.map((word) => {
      const button = make("button", word, { type: "button" });
      button.addEventListener("click", () => send("move", { act: word }));
      return button;
    }));
  }
};

const teacher = (told) => {
  const chooses = "claims" in told;
  byId("claims").hidden = !chooses;
  byId("own").hidden = chooses;
  if (chooses) {
    const legend = byId("claims").querySelector("legend");
    const choices = told.claims.map(({ kind, text }, number) => {
      const label = make("label");
      label.append(make("input", "", { type: "checkbox", value: number }), kinds(kind), make("span", text));
      return label;
    });
    if (!choices.length) choices.push(make("p", "There is nothing true to say.", { class: "quiet" }));
    byId("claims").replaceChildren(legend, ...choices);
  } else {
    byId("suggestion").textContent = told.suggestion ? `It would say: ${told.suggestion}` : "It would say nothing.";
  }
};

const show = (told) => {
  const moved = told.version !== known.version || known.turn === -1;
  byId("sit").hidden = !told.join;
  byId("lesson").hidden = told.join;
  byId("consent").textContent = told.consent;
  byId("agree").hidden = !told.consent;
  byId("code").hidden = !told.codes;
  byId("status").textContent = status(told);
  byId("now").textContent = told.now;
  sentences(told);
  drawTurns(told);
  if (moved) picture(told);
  byId("act").hidden = !(told.mine && told.seat === "student");
  byId("teach").hidden = !(told.mine && told.seat === "teacher");
  byId("watch").hidden = !(told.mine && told.seat === "watcher");
  byId("undo").hidden = !told.undo;
  if (told.seat === "student") student(told);
  if (told.mine && told.seat === "teacher") teacher(told);
  byId("end").hidden = !told.over;
  if (told.over) {
    const kept = told.kept ? " It is in the study." : "";
    byId("sum").textContent = `Over after ${told.turn} turns: ${told.success ? "solved" : "not solved"}.${kept} `;
    stop();
  }
  known = told;
  clearTimeout(timer);
  if (told.waits) later();
};

const picture = (told) => {
  const theme = dark.matches ? "dark" : "light";
  byId("picture").src = `${here}/frame.png?theme=${theme}&version=${told.version}`;
};

const stop = () => {
  clearInterval(playing);
  playing = null;
  byId("play").setAttribute("aria-pressed", "false");
};

const submit = (id, act) => byId(id).addEventListener("submit", (event) => {
  event.preventDefault();
  act();
});

submit("sit", async () => {
  const { agreed, code } = byId("sit").elements;
  if (await send("sit", { agreed: agreed.checked, code: code.value })) byId("status").focus();
});
submit("act", async () => {
  if (!byId("answer").value.trim()) return;
  if (await send("move", { act: byId("answer").value })) byId("answer").value = "";
  byId("answer").focus();
});
submit("teach", async () => {
  if (!byId("claims").hidden) {
    const chosen = [...byId("claims").querySelectorAll("input:checked")].map((box) => Number(box.value));
    await send("move", { claims: chosen });
  } else if (await send("move", { say: byId("words-own").value })) {
    byId("words-own").value = "";
  }
});
submit("watch", () => send("move", {}));
byId("silence").addEventListener("click", () => send("move", byId("claims").hidden ? { say: "" } : { claims: [] }));
byId("personality").addEventListener("click", () => send("move", { personality: true }));
byId("undo").addEventListener("click", () => send("undo", {}));
byId("play").addEventListener("click", () => {
  if (playing) return stop();
  byId("play").setAttribute("aria-pressed", "true");
  playing = setInterval(() => send("move", {}), 1500);
});
byId("answer").addEventListener("keydown", (event) => {
  if (event.key !== "Enter" || event.isComposing) return;
  if (byId("answer").rows > 1 ? event.ctrlKey || event.metaKey : !event.shiftKey) {
    event.preventDefault();
    byId("act").requestSubmit();
  }
});
byId("whole").href = `${here}/episode`;
if (byId("link")) {
  byId("link").value = location.origin + byId("link").dataset.path;
  byId("link").addEventListener("focus", () => byId("link").select());
}
document.addEventListener("visibilitychange", () => { if (!document.hidden) look(); });
dark.addEventListener("change", () => picture(known));
look();
