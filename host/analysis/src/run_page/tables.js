// Lists below the curves: events with jumps, settings with a search, commands to copy.

"use strict";

const EVENT_KINDS = { command: "commands", push: "pushes", fault: "faults", mode: "modes", board: "board", link: "link" };

class EventTable {
  constructor() {
    this.body = document.querySelector("#events tbody");
    this.search = document.querySelector("#events input");
    this.hidden = new Set();
    const present = new Set(DATA.events.map((event) => event.kind));
    const filters = document.querySelector("#events .filters");
    for (const [kind, label] of Object.entries(EVENT_KINDS)) {
      if (!present.has(kind)) continue;
      const button = filters.appendChild(document.createElement("button"));
      button.type = "button";
      button.className = "key";
      button.textContent = label;
      button.setAttribute("aria-pressed", "true");
      button.addEventListener("click", () => {
        if (!this.hidden.delete(kind)) this.hidden.add(kind);
        button.setAttribute("aria-pressed", String(!this.hidden.has(kind)));
        this.filter();
      });
    }
    this.rows = DATA.events.map((event) => this.row(event));
    this.body.append(...this.rows);
    this.search.addEventListener("input", () => this.filter());
  }

  row({ time, kind, level, text }) {
    const row = document.createElement("tr");
    row.className = level;
    const at = row.appendChild(document.createElement("td"));
    at.className = "n";
    const button = at.appendChild(document.createElement("button"));
    button.type = "button";
    button.className = "jump";
    button.textContent = `${time.toFixed(3).replace("-", "−")} s`;
    button.addEventListener("click", () => seek(time));
    row.addEventListener("click", (event) => {
      if (event.target !== button && !String(getSelection())) seek(time);
    });
    for (const content of [kind, text]) row.appendChild(document.createElement("td")).textContent = content;
    return row;
  }

  filter() {
    const wanted = this.search.value.toLowerCase();
    DATA.events.forEach(({ kind, text }, i) => {
      this.rows[i].hidden = this.hidden.has(kind) || !`${kind} ${text}`.toLowerCase().includes(wanted);
    });
  }

  // Marks the last event.
  update(time) {
    const at = DATA.events.findLastIndex((event) => event.time <= time + 1e-9);
    if (at === this.at) return;
    this.rows[this.at]?.classList.remove("now");
    this.rows[at]?.classList.add("now");
    this.at = at;
  }
}

function attachSettings() {
  const search = document.querySelector("#settings input");
  search?.addEventListener("input", () => {
    const wanted = search.value.toLowerCase();
    for (const row of document.querySelectorAll("#settings tbody tr:not(.group)")) {
      row.hidden = !row.textContent.toLowerCase().includes(wanted);
    }
  });
}

function attachCopies() {
  for (const button of document.querySelectorAll("button.copy")) {
    button.addEventListener("click", async () => {
      const text = button.previousElementSibling.textContent;
      try {
        await navigator.clipboard.writeText(text);
      } catch {
        // Not every browser grants that to a file: select and copy.
        getSelection().selectAllChildren(button.previousElementSibling);
        document.execCommand("copy");
      }
      button.textContent = "copied";
      setTimeout(() => (button.textContent = "copy"), 1500);
    });
  }
}

// Numbers of both joints at the cursor.
function showReadout(time) {
  for (const cell of document.querySelectorAll("#readout [data-series]")) {
    const { series, digits, factor } = cell.dataset;
    const value = RUN.curves.at(series, time) * Number(factor);
    cell.textContent = signed(value, Number(digits));
  }
  document.getElementById("mode").textContent = modeAt(time);
}
