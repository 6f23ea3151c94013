"use strict";
// The form by which a lesson is chosen.
import { ask, byId } from "./common.js";

const form = byId("choose");
const whole = (text) => (text === "" ? null : Number(text));

const fit = () => {
  const seat = form.elements.seat.value;
  form.elements.two.disabled = seat === "watch";
  form.elements.bits.disabled = seat === "student";
  const two = form.elements.two.checked && seat !== "watch";
  form.elements.student.disabled = two || seat === "student";
  for (const each of form.elements.speech) each.disabled = !two && seat !== "teacher";
};
form.addEventListener("change", fit);
fit();

form.addEventListener("submit", async (event) => {
  event.preventDefault();
  const { elements } = form;
  const button = form.querySelector("button[type=submit]");
  button.disabled = true;
  byId("problem").textContent = "";
  try {
    const { page } = await ask("/lessons", {
      id: elements.id.value,
      seat: elements.seat.value,
      two: elements.two.checked && elements.seat.value !== "watch",
      bits: elements.bits.checked && !elements.bits.disabled,
      teacher: elements.teacher.value,
      student: elements.student.value,
      speech: elements.speech.value,
      instruction_type: elements.instruction_type.value,
      feedback_type: elements.feedback_type.value,
      max_turns: whole(elements.max_turns.value),
      seed: whole(elements.seed.value),
    });
    location.assign(page);
  } catch (error) {
    byId("problem").textContent = error.answered ? error.message : "The server cannot be reached; is it running?";
    button.disabled = false;
  }
});
