// A table that is filtered by text and by menus, and sorted by its headings.
"use strict";
(function () {
  const { element } = ropsim;

  class FilteredTable {
    constructor(box) {
      this.table = box.querySelector("table");
      this.body = this.table.tBodies[0];
      this.rows = [...this.body.rows];
      this.headings = [...this.table.tHead.rows[0].cells];
      this.chosen = new Map();
      this.search = element("input", { type: "search", placeholder: "any text", oninput: () => this.filter() });
      this.count = element("span", { class: "soft", role: "status" });
      const controls = element("div", { class: "controls" }, ropsim.labelled("find", this.search));
      this.headings.forEach((heading, column) => {
        if (heading.dataset.kind === "choice") this.add_menu(controls, heading, column);
        this.add_sorting(heading, column);
      });
      controls.append(this.count);
      box.insertBefore(controls, box.querySelector(".scroll"));
      this.filter();
    }

    add_menu(controls, heading, column) {
      const values = [...new Set(this.rows.map((row) => row.cells[column].textContent))].sort();
      if (values.length < 2) return;
      const options = [["", "all"], ...values.map((value) => [value, value || "(none)"])];
      controls.append(ropsim.labelled(heading.dataset.name, ropsim.menu(options, "", (value) => {
        this.chosen.set(column, value);
        this.filter();
      })));
    }

    add_sorting(heading, column) {
      const button = element("button", { type: "button", class: "sort", onclick: () => this.sort(heading, column) });
      button.append(heading.firstChild);  // the unit stays below
      heading.prepend(button);
      heading.setAttribute("aria-sort", "none");
    }

    filter() {
      const words = this.search.value.toLowerCase().split(/\s+/).filter(Boolean);
      let shown = 0;
      for (const row of this.rows) {
        const text = row.textContent.toLowerCase();
        const fits = words.every((word) => text.includes(word)) &&
          [...this.chosen].every(([column, value]) => value === "" || row.cells[column].textContent === value);
        row.hidden = !fits;
        shown += fits;
      }
      this.count.textContent = shown === this.rows.length ? `${shown} rows` : `${shown} of ${this.rows.length} rows`;
    }

    sort(heading, column) {
      const up = heading.getAttribute("aria-sort") !== "ascending";
      for (const other of this.headings) other.setAttribute("aria-sort", "none");
      heading.setAttribute("aria-sort", up ? "ascending" : "descending");
      const numeric = heading.dataset.kind === "number";
      const key = (row) => numeric ? (row.cells[column].dataset.value === undefined ? null : Number(row.cells[column].dataset.value))
        : row.cells[column].textContent;
      const compare = (a, b) => numeric ? a - b : a.localeCompare(b, "en", { numeric: true });
      // What was not measured stays at the end, whichever way.
      this.rows.sort((a, b) => {
        const [left, right] = [key(a), key(b)];
        if (left === null || right === null) return (left === null) - (right === null);
        return up ? compare(left, right) : compare(right, left);
      });
      this.body.append(...this.rows);
    }
  }

  ropsim.widgets.table = (box) => { box.filtered = new FilteredTable(box); };
})();
