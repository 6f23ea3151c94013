"use strict";
// An episode that is over: turn by turn, or all of it.
import { ask, byId } from "./common.js";

const turns = [...document.querySelectorAll("ol.turns > li")];
let shown = turns.length;
const show = (count) => {
  shown = Math.min(Math.max(count, 1), turns.length);
  turns.forEach((turn, number) => { turn.hidden = number >= shown; });
  byId("back").disabled = shown === 1;
  byId("on").disabled = byId("all").disabled = shown === turns.length;
  byId("place").textContent = `turn ${shown - 1} of ${turns.length - 1}`;
};
const step = (by) => {
  show(by < 0 && shown === turns.length ? 1 : shown + by);
  turns[shown - 1].scrollIntoView({ block: "nearest" });
};
byId("back").addEventListener("click", () => show(shown - 1));
byId("on").addEventListener("click", () => step(1));
byId("all").addEventListener("click", () => show(turns.length));
addEventListener("keydown", (event) => {
  if (event.target.closest("input, textarea, select") || event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key === "ArrowRight") show(shown + 1);
  if (event.key === "ArrowLeft") show(shown - 1);
});
byId("steps").hidden = false;
show(turns.length);

// The film takes longer than other files: it is asked for, and taken when it is made.
const PATIENCE = 1000; // milliseconds between two questions whether it is made
const film = byId("film");
let taken = false;
const making = async () => {
  try {
    const { made } = await ask("film", {});
    byId("making").textContent = made ? "" : "It is being made, which may take minutes; the page can be used meanwhile.";
    if (!made) return setTimeout(making, PATIENCE);
    taken = true;
    film.click();
    taken = false;
  } catch (error) {
    byId("making").textContent = error.answered ? error.message : "The server cannot be reached; try again.";
  }
};
if (film) {
  film.addEventListener("click", (event) => {
    if (taken) return;
    event.preventDefault();
    making();
  });
  if ("asked" in film.dataset) making();
}
