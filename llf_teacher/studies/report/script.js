"use strict";
// Tables are sorted by a click on the head of a column, and filtered by words of their first column.
const number = (cell) => Number.parseFloat(cell.textContent.replace("\u2212", "-").replace("<", ""));
const compare = (column) => (one, other) => {
  const [a, b] = [one, other].map((row) => row.cells[column]);
  const [x, y] = [number(a), number(b)];
  if (column === 0 || (Number.isNaN(x) && Number.isNaN(y))) return a.textContent.localeCompare(b.textContent);
  return Number.isNaN(x) ? 1 : Number.isNaN(y) ? -1 : x - y;
};
for (const table of document.querySelectorAll("table")) {
  const body = table.tBodies[0];
  if (body.rows.length < 2) continue;
  [...table.tHead.rows[table.tHead.rows.length - 1].cells].forEach((head, column) => {
    const button = document.createElement("button");
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const up = head.getAttribute("aria-sort") === "ascending";
      for (const each of table.tHead.querySelectorAll("[aria-sort]")) each.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", up ? "descending" : "ascending");
      const rows = [...body.rows].sort(compare(column));
      body.append(...(up ? rows.reverse() : rows));
    });
  });
}
const field = document.createElement("input");
Object.assign(field, { type: "search", placeholder: "Filter rows of tables, e.g. oracle" });
field.setAttribute("aria-label", "Show only rows of tables that contain");
field.addEventListener("input", () => {
  const words = field.value.toLowerCase();
  for (const row of document.querySelectorAll("tbody tr")) row.hidden = !row.cells[0].textContent.toLowerCase().includes(words);
});
document.querySelector("nav").append(field);
// What is wider than its place says so, and can be scrolled by keys.
const wide = document.querySelectorAll(".wide");
const fit = () => {
  for (const each of wide) {
    const more = each.scrollWidth > each.clientWidth + 1;
    each.classList.toggle("more", more);
    if (more) each.tabIndex = 0;
    else each.removeAttribute("tabindex");
  }
};
addEventListener("resize", fit);
document.addEventListener("toggle", fit, true);
fit();
// What a link points into is opened.
const open = () => {
  const target = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  for (let each = target; each; each = each.parentElement) if (each.tagName === "DETAILS") each.open = true;
};
addEventListener("hashchange", open);
open();
