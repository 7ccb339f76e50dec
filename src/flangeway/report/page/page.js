// What the page does by itself: copies tables, enlarges pictures on small screens, and shows itself light or dark.
(() => {
  "use strict";
  const FITS_A_PHONE_PX = 480; // width of a picture that a phone shows about as large as it is

  function tableText(table) {
    const rows = Array.from(table.rows, (row) => Array.from(row.cells, (cell) => cell.textContent.trim()));
    return rows.map((cells) => cells.join("\t").replaceAll("\u2013", "")).join("\n") + "\n";
  }

  async function copy(text) {
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      // pages opened from a disk may not be trusted with the clipboard
      const field = Object.assign(document.createElement("textarea"), { value: text });
      document.body.append(field);
      field.select();
      const done = document.execCommand("copy");
      field.remove();
      if (!done) throw new Error("the browser refused");
    }
  }

  function addCopyButton(place, text, what) {
    const button = Object.assign(document.createElement("button"), { type: "button", textContent: "Copy" });
    button.className = "copy";
    button.setAttribute("aria-label", `Copy: ${what}`);
    button.addEventListener("click", async () => {
      try {
        await copy(text());
        button.textContent = "Copied";
      } catch {
        button.textContent = "Not copied";
      }
      document.getElementById("announcement").textContent = `${button.textContent}: ${what}`;
      setTimeout(() => (button.textContent = "Copy"), 2000);
    });
    if (place.tagName === "PRE") place.prepend(button);
    else place.append(button);
  }

  for (const table of document.querySelectorAll("table")) {
    const what = table.caption.textContent;
    addCopyButton(table.caption, () => tableText(table), what);
  }
  for (const block of document.querySelectorAll("pre[data-copy]")) {
    addCopyButton(block, () => `${block.querySelector("code").textContent.trimEnd()}\n`, block.dataset.copy);
  }

  for (const image of document.querySelectorAll("figure img")) {
    if (parseFloat(image.style.maxWidth) < FITS_A_PHONE_PX) continue;
    const figure = image.closest("figure");
    const button = Object.assign(document.createElement("button"), { type: "button", className: "enlarge" });
    const label = () => (button.textContent = figure.classList.contains("large") ? "Fit the picture" : "Enlarge");
    for (const each of [image, button]) {
      each.addEventListener("click", () => {
        figure.classList.toggle("large");
        label();
      });
    }
    label();
    figure.querySelector("figcaption").before(button);
  }

  const button = document.getElementById("theme");
  const system = matchMedia("(prefers-color-scheme: dark)");
  const now = () => document.documentElement.dataset.theme ?? (system.matches ? "dark" : "light");
  const other = () => (now() === "dark" ? "light" : "dark");
  const label = () => (button.textContent = `Show ${other()}`);
  button.addEventListener("click", () => {
    document.documentElement.dataset.theme = other();
    label();
  });
  system.addEventListener("change", label);
  button.hidden = false;
  label();
})();
