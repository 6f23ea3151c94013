"use strict";
// What the pages have in common.

export const byId = (id) => document.getElementById(id);

// An element with text; what is said is never taken for markup.
export const make = (name, text = "", attributes = {}) => {
  const element = document.createElement(name);
  element.textContent = text;
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  return element;
};

// Ask the server. Gives what it says, null for nothing new; throws an Error with a sentence.
export const ask = async (path, sent = null) => {
  const settings = sent === null ? {} : {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(sent),
  };
  const answer = await fetch(path, { ...settings, credentials: "same-origin" });
  if (answer.status === 204) return null;
  const body = await answer.json().catch(() => ({ error: "the server gave no answer that can be read" }));
  if (!answer.ok) throw Object.assign(new Error(body.error), { answered: true, status: answer.status });
  return body;
};
