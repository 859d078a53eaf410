// The pixel inspector: a chosen pixel's fragments, every technique's visibility against the exact one, its colour
// and what it has stored.
"use strict";
(function () {
  const { element, number } = ropsim;
  const kPart = 1e-4;  // curves are whole numbers of this part

  const srgb = (linear) => {
    const value = Math.min(Math.max(linear ?? 0, 0), 1);
    return Math.round(255 * (value <= 0.0031308 ? 12.92 * value : 1.055 * value ** (1 / 2.4) - 0.055));
  };
  const swatch = (rgb) => element("i", { class: "swatch", style: `background:rgb(${rgb.map(srgb).join(",")})` });
  const table = (headings, rows, left) => element("div", { class: "scroll", role: "region", tabindex: 0, "aria-label": headings.join(", ") },
    element("table", {}, element("thead", {}, element("tr", {}, ...headings.map((heading, i) =>
      element("th", { scope: "col", class: left.includes(i) ? "left" : null }, heading)))),
    element("tbody", {}, ...rows.map((cells) => element("tr", {}, ...cells.map((cell, i) =>
      element("td", { class: left.includes(i) ? "left" : null }, cell)))))));
  // Depths crowd together: as many digits as tell the nearest and the farthest apart.
  const depth_text = (z, range) => z.toFixed(Math.min(9, Math.max(4, 3 - Math.floor(Math.log10(Math.max(range, 1e-7))))));

  ropsim.Inspector = class {
    constructor(views, index, id) {
      this.views = views;
      this.id = id;
      this.index = index;
      this.hidden = new Set();
      this.heading = element("h3", { tabindex: -1 }, "Pixel inspector");
      this.why = element("p", { class: "note", role: "status" });
      this.panel = element("div", { class: "panel" });
      const options = index.pixels.map((pixel, i) => [i, `(${pixel.x}, ${pixel.y}) ${pixel.why}`]);
      this.menu = ropsim.menu(options, 0, (value) => this.go(Number(value), ""));
      const marks = ropsim.check("mark the pixels that are known", false, (on) =>
        views.mark(on ? index.pixels.map((pixel) => [pixel.x, pixel.y]) : []));
      this.box = element("div", { class: "inspector" }, this.heading,
        element("div", { class: "controls" }, ropsim.labelled("pixel", this.menu), marks), this.why, this.panel);
      if (index.pixels.length) this.go(0, "Click a picture, or use the arrow keys on it, to see another pixel.");
      else this.panel.append("No pixel has a visible fragment.");
    }

    click(x, y) {
      const far = (pixel) => Math.hypot(pixel.x - x, pixel.y - y);
      let best = 0;
      this.index.pixels.forEach((pixel, i) => { if (far(pixel) < far(this.index.pixels[best])) best = i; });
      if (!this.index.pixels.length) return;
      const pixel = this.index.pixels[best];
      this.go(best, pixel.x === x && pixel.y === y ? ""
        : `Of (${x}, ${y}) the page knows the picture only; this is the nearest pixel it knows whole, ${number(far(pixel))} pixels away. ` +
          `--inspect ${x},${y} makes it known.`);
    }

    // To the nearest known pixel in a direction, those straight on first.
    move(dx, dy) {
      const here = this.index.pixels[this.at];
      let best = -1, least = Infinity;
      this.index.pixels.forEach((pixel, i) => {
        const along = (pixel.x - here.x) * dx + (pixel.y - here.y) * dy;
        const aside = Math.abs((pixel.x - here.x) * dy) + Math.abs((pixel.y - here.y) * dx);
        if (along > 0 && aside <= 2 * along && along + 2 * aside < least) {
          least = along + 2 * aside;
          best = i;
        }
      });
      if (best >= 0) this.go(best, "");
    }

    go(index, note) {
      this.at = index;
      this.menu.value = index;
      const { x, y } = this.index.pixels[index];
      this.pixel = ropsim.json(`${this.id}-${x}-${y}`);
      this.views.choose([x, y]);
      this.why.textContent = note;
      this.draw();
    }

    highlight(technique) {
      this.technique = technique;
      if (this.pixel) this.draw();
    }

    draw() {
      const pixel = this.pixel;
      for (const chart of ropsim.charts.filter(({ owner }) => owner === this)) chart.chart.destroy();
      ropsim.charts = ropsim.charts.filter(({ owner }) => owner !== this);
      const facts = element("p", { class: "pixel-facts" }, element("b", {}, `(${pixel.x}, ${pixel.y})`), ` ${pixel.why}: ` +
        `${number(pixel.count)} ${pixel.count === 1 ? "fragment" : "fragments"}` +
        (pixel.hidden ? `, ${number(pixel.hidden)} more hidden by the opaque layer` : ""));
      this.panel.replaceChildren(facts);
      const curve = element("div", { class: "curve" });
      const lists = element("div", { class: "columns" }, this.colors(), this.fragments());
      this.panel.append(curve, lists, this.stored(), this.command());
      if (pixel.depths) this.curves(curve);
    }

    // The same curves in full.
    command() {
      const shown = this.names().filter((name, i) => this.pixel.techniques[i].visibility);
      if (!shown.length) return "";
      const text = `${this.views.data.curve} --pixel ${this.pixel.x},${this.pixel.y} ${shown.map((name) => "--technique " + name).join(" ")} -o curve`;
      return element("details", { class: "command", "data-print": true }, element("summary", {}, "The curves in full"), element("code", {}, text));
    }

    names() { return this.views.data.techniques.map((technique) => technique.name); }

    curves(box) {
      const canvas = element("canvas", { tabindex: 0, role: "img", "aria-label": "visibility over depth, exact and as each technique has it" });
      const pixel = this.pixel;
      const points = (values) => values.map((value, i) => ({ x: pixel.depths[i], y: value === null ? null : value * kPart }));
      const sets = () => [
        { label: "exact", data: points(pixel.exact), borderColor: ropsim.style("--rest"), borderWidth: 7, order: 100 },
        ...pixel.techniques.map((technique, i) => technique.visibility ? { label: this.names()[i], data: points(technique.visibility),
          borderColor: ropsim.hue(i), backgroundColor: ropsim.hue(i), borderDash: ropsim.dash(i),
          borderWidth: i === this.views.technique ? 3 : 1.5, order: i === this.views.technique ? 1 : 10, hidden: this.hidden.has(i), number: i } : null),
      ].filter(Boolean).map((set) => ({ showLine: true, pointRadius: 0, pointHitRadius: 6, ...set }));
      const range = this.shown_end() - pixel.depths[0];
      box.append(element("p", { class: "note" }, "Visibility in front of each depth: the product of what is strictly nearer lets through. " +
        "The broad grey line is exact, and falls at the fragments (at the 56 where it falls most, where there are more). Names switch curves on and off; " +
        "the number is the mean error at the fragments."));
      const key = element("div", { class: "key" });
      box.append(key, element("div", { class: "chart" }, canvas));
      const scale = (text) => ({ type: "linear", title: { display: true, text }, ticks: { maxTicksLimit: 8 }, grid: {} });
      const x = scale("window depth z"), y = scale("visibility");
      x.min = pixel.depths[0];
      x.max = this.shown_end();
      x.ticks.callback = (value) => depth_text(value, range);
      x.ticks.maxRotation = 0;
      y.min = 0;
      y.suggestedMax = 1;
      ropsim.color_axis(x);
      ropsim.color_axis(y);
      const chart = ropsim.chart(canvas, { type: "scatter", data: { datasets: sets() }, options: {
        interaction: { mode: "nearest", axis: "xy", intersect: false }, scales: { x, y }, parsing: false,
        plugins: { legend: { display: false }, tooltip: { ...ropsim.tooltip(), callbacks: {
          title: (items) => items[0]?.dataset.label ?? "",
          label: (item) => [`z ${depth_text(item.parsed.x, range)}`, `visibility ${item.parsed.y.toFixed(4)}`],
        } } } } }, (made) => {
        ropsim.color_axis(made.options.scales.x);
        ropsim.color_axis(made.options.scales.y);
        made.data.datasets = sets();
      });
      ropsim.charts[ropsim.charts.length - 1].owner = this;
      this.chart = chart;
      this.switches(key, chart, sets);
    }

    // The depth behind which no curve changes by as much as a line's width.
    shown_end() {
      const depths = this.pixel.depths;
      const curves = [this.pixel.exact, ...this.pixel.techniques.map((technique) => technique.visibility)].filter(Boolean);
      let last = depths.length - 1;
      while (last > 0 && curves.every((values) => Math.abs(values[last] - values[values.length - 1]) < 0.003 / kPart)) --last;
      const end = depths[0] + (depths[last] - depths[0]) * 1.2;
      return Math.min(end > depths[0] ? end : Infinity, depths[depths.length - 1]);
    }

    switches(key, chart, sets) {
      const buttons = this.pixel.techniques.map((technique, i) => technique.visibility ? element("button", { type: "button", class: "switch",
        "aria-pressed": String(!this.hidden.has(i)), onclick: (event) => {
          this.hidden.has(i) ? this.hidden.delete(i) : this.hidden.add(i);
          event.currentTarget.setAttribute("aria-pressed", String(!this.hidden.has(i)));
          chart.data.datasets = sets();
          chart.update("none");
        } }, element("i", { style: `border-top:3px ${ropsim.dash(i).length ? "dashed" : "solid"} ${ropsim.hue(i)}` }), this.names()[i],
        element("small", {}, technique.error === null || technique.error === undefined ? "" : technique.error.toFixed(4))) : null).filter(Boolean);
      key.append(...buttons);
      const without = this.pixel.techniques.map((technique, i) => technique.visibility ? null
        : `${this.names()[i]}${technique.why ? ` (${technique.why})` : ""}`).filter(Boolean);
      if (without.length) key.append(element("p", { class: "note" }, `No visibility curve: ${without.join(", ")}.`));
    }

    colors() {
      const error = (rgb) => Math.sqrt(rgb.reduce((sum, value, c) => sum + ((value ?? 0) - (this.pixel.reference[c] ?? 0)) ** 2, 0) / 3) * 255;
      const row = (name, rgb, far) => [name, swatch(rgb), far, ...rgb.map((value) => value === null ? "–" : value.toFixed(4))];
      const rows = this.pixel.techniques.map((technique, i) => row(this.names()[i], technique.color, error(technique.color).toFixed(2)));
      return element("div", {}, element("h4", {}, "Colour of the pixel"),
        table(["technique", "", "RMSE /255", "R", "G", "B"], [row("reference", this.pixel.reference, ""), ...rows], [0]));
    }

    fragments() {
      const list = this.pixel.fragments;
      const range = list.length ? list[list.length - 1][1] - list[0][1] : 0;
      const many = this.index.samples;
      let behind = 1;
      const rows = list.map(([arrival, z, alpha, r, g, b, coverage], i) => {
        const front = behind;
        behind *= 1 - alpha;
        const straight = alpha > 0 ? [r / alpha, g / alpha, b / alpha] : [r, g, b];
        return [i + 1, depth_text(z, range), number(alpha), swatch(straight), many === 1 ? front.toFixed(4) : coverage.toString(2).padStart(many, "0"), arrival];
      });
      const left_out = this.pixel.count - list.length;
      return element("div", {}, element("h4", {}, "Fragments, nearest first"),
        element("div", { class: "tall" }, table(["", "depth z", "alpha", "colour", many === 1 ? "visibility" : "coverage", "arrived"], rows, [])),
        left_out > 0 ? element("p", { class: "note" }, `${number(left_out)} farther ones are left out.`) : null);
    }

    stored() {
      const all = this.pixel.techniques.map((technique, i) => {
        const open = i === this.views.technique;
        if (!technique.surfaces) return technique.why ? element("details", { open }, element("summary", {}, this.names()[i]),
          element("p", { class: "note" }, `Not shown: ${technique.why}.`)) : null;
        return element("details", { open }, element("summary", {}, this.names()[i]), ...technique.surfaces.map((surface) => this.surface(surface)));
      }).filter(Boolean);
      return element("div", { class: "stored" }, element("h4", {}, "What each technique has stored after the last fragment"), ...all);
    }

    surface(surface) {
      const title = element("p", { class: "surface" }, element("b", {}, surface.name),
        ` ${surface.changed} of ${surface.elements} ${surface.elements === 1 ? "element" : "elements"} written` +
        (surface.rows.length < surface.changed ? `, the first ${surface.rows.length} shown` : ""));
      if (!surface.rows.length) return title;
      return element("div", {}, title, table(["element", ...surface.fields], surface.rows.map(([at, values]) => [at, ...values]), []));
    }
  };
})();
