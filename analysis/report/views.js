// The picture viewer: a technique against the reference under a slider, beside it a layer of choice; both show the
// same pixels, whose values stand below. A click inspects.
"use strict";
(function () {
  const { element, number } = ropsim;

  class Views {
    constructor(box, data) {
      this.box = box;
      this.data = data;
      this.images = new Map();
      this.bytes = new Map();
      this.technique = this.most_telling();
      this.layer = "difference";
      this.view = new ropsim.View(data.width, data.height);
      this.build();
      this.inspector = data.pixels ? new ropsim.Inspector(this, ropsim.json(data.pixels), data.pixels) : null;
      if (this.inspector) box.append(this.inspector.box);
      this.cards();
      this.ready = this.refresh();
    }

    // Not the best nor the worst: something is to be seen.
    most_telling() {
      const order = this.data.techniques.map((technique, i) => [technique.rmse ?? 0, i]).sort((a, b) => a[0] - b[0]);
      return order[Math.floor(order.length / 2)][1];
    }

    image(id) {
      if (!this.images.has(id)) this.images.set(id, ropsim.load_image(id));
      return this.images.get(id);
    }
    async map(id, unit) {
      const key = "map " + id;
      if (!this.images.has(key)) this.images.set(key, this.image(id).then((image) => ropsim.heat_map(image, unit)));
      return this.images.get(key);
    }

    // What a technique is compared with: its own or that of all.
    reference_of(technique) { return technique.reference ?? this.data.reference; }

    build() {
      const data_names = this.data.names;
      const hear = {
        point: (pixel) => this.point(pixel), click: (x, y) => this.inspect(x, y), key: (event) => this.key(event),
        split: (part) => this.set_split(part),
      };
      this.left = new ropsim.Pane(this.view, `${data_names.ours} against ${data_names.theirs}` + (this.data.pixels ? "; arrow keys move among inspected pixels" : ""), hear);
      this.right = new ropsim.Pane(this.view, "layer", hear);
      this.slider = element("input", { type: "range", min: 0, max: 1000, value: 500, "aria-label": `${data_names.ours} to the left, ${data_names.theirs} to the right`,
        oninput: () => this.set_split(this.slider.value / 1000) });
      this.names = [element("span", {}), element("span", {}, data_names.theirs)];
      this.left.box.append(element("div", { class: "tags" }, ...this.names));
      this.right_name = element("span", {});
      this.right.box.append(element("div", { class: "tags" }, this.right_name));
      this.scale = element("div", { class: "below" });
      this.readout = element("p", { class: "said readout" });
      this.box.append(this.controls(), element("div", { class: "panes" },
        element("div", {}, this.left.box, element("div", { class: "below" }, this.slider)),
        element("div", {}, this.right.box, this.scale)), this.readout);
      this.left.split = 0.5;
    }

    controls() {
      const techniques = this.data.techniques.map((technique, i) => [i, technique.name]);
      const layers = [["difference", this.data.names.difference], ["reference", this.data.names.theirs], ["image", this.data.names.ours]];
      if (this.data.techniques.some((technique) => technique.tiles)) layers.push(["tiles", "bytes per tile"]);
      if (this.data.layers) layers.push(["layers", "depth complexity"]);
      this.technique_menu = ropsim.menu(techniques, this.technique, (value) => this.pick(Number(value)));
      this.layer_menu = ropsim.menu(layers, this.layer, (value) => { this.layer = value; this.refresh(); });
      const button = (text, label, act) => element("button", { type: "button", class: "button", "aria-label": label, title: label, onclick: act }, text);
      const [x, y, width, height] = this.data.detail;
      return element("div", { class: "controls" }, ropsim.labelled("technique", this.technique_menu),
        ropsim.labelled("beside it", this.layer_menu),
        element("div", { class: "zoom" }, button("−", "zoom out", () => this.zoom(0.5)), button("+", "zoom in", () => this.zoom(2)),
          button("whole", "the whole frame", () => this.view.fit()),
          width ? button("detail", "where the techniques err most",
            () => this.view.set(x + width / 2, y + height / 2, Math.min(this.data.width / width, this.data.height / height))) : null));
    }

    zoom(factor) {
      const [x, y] = this.left.chosen ?? [this.view.x, this.view.y];
      this.view.zoom_at(x, y, factor);
    }

    set_split(part) {
      this.left.split = part;
      this.slider.value = Math.round(part * 1000);
      this.left.draw();
      this.tags();
    }
    tags() {
      this.names[0].style.visibility = this.left.split > 0.15 ? "" : "hidden";
      this.names[1].style.visibility = this.left.split < 0.85 ? "" : "hidden";
    }

    pick(technique) {
      this.technique = technique;
      this.technique_menu.value = technique;
      this.inspector?.highlight(technique);
      return this.refresh();
    }

    async refresh() {
      const technique = this.data.techniques[this.technique];
      const wanted = [this.technique, this.layer].join();
      this.wanted = wanted;
      const [image, reference, beside] = await Promise.all([this.image(technique.image), this.image(this.reference_of(technique)), this.beside(technique)]);
      if (this.wanted !== wanted) return;  // picked something else meanwhile
      this.left.show([{ image }, { image: reference }]);
      this.names[0].textContent = technique.name;
      this.right.show(beside.image ? [beside] : []);
      this.right_name.textContent = beside.label;
      this.right.canvas.setAttribute("aria-label", `${beside.label} of ${technique.name}`);
      this.scale.replaceChildren(beside.map ? ropsim.heat_scale(beside.map) : element("div", { class: "soft" }, beside.note ?? ""));
      this.heat = beside.map ? beside : null;
      this.tags();
    }

    async beside(technique) {
      switch (this.layer) {
        case "reference": return { image: await this.image(this.reference_of(technique)), label: this.data.names.theirs };
        case "image": return { image: await this.image(technique.image), label: technique.name };
        case "tiles": {
          if (!technique.tiles) return { label: "no bytes per tile were measured" };
          const map = await this.map(technique.tiles, "bytes");
          return { image: map.canvas, map, cover: 8, label: "bytes per tile: " + technique.name };
        }
        case "layers": {
          const map = await this.map(this.data.layers, "layers");
          return { image: map.canvas, map, label: "depth complexity" };
        }
        default: return { image: await this.image(technique.difference), label: `${this.data.names.difference}: ${technique.name}`,
          note: this.data.names.note };
      }
    }

    async color_at(id, x, y) {
      if (!this.bytes.has(id)) this.bytes.set(id, this.image(id).then((image) => ropsim.bytes_of(image)));
      const bytes = await this.bytes.get(id);
      return [...bytes.slice(4 * (y * this.data.width + x), 4 * (y * this.data.width + x) + 3)];
    }

    async point(pixel) {
      for (const pane of [this.left, this.right]) {
        pane.cross = pixel;
        pane.draw();
      }
      this.pointed = pixel;
      if (!pixel) return;
      const [x, y] = pixel;
      const technique = this.data.techniques[this.technique];
      const [ours, theirs] = await Promise.all([this.color_at(technique.image, x, y), this.color_at(this.reference_of(technique), x, y)]);
      if (this.pointed !== pixel) return;
      const swatch = (rgb) => element("i", { class: "swatch", style: `background:rgb(${rgb.join(",")})` });
      const heat = this.heat ? `  ·  ${number(this.heat.map.values[Math.floor(y / (this.heat.cover ?? 1)) * this.heat.map.width + Math.floor(x / (this.heat.cover ?? 1))])} ${this.heat.map.unit}` : "";
      this.readout.replaceChildren(`(${x}, ${y})  `, swatch(ours), ` ${technique.name} ${ours.join(" ")}  `, swatch(theirs),
        ` ${this.data.names.theirs} ${theirs.join(" ")}  (sRGB, 8 bits)${heat}`);
    }

    inspect(x, y) {
      if (this.inspector) this.inspector.click(x, y);
    }
    // The inspector has gone to a pixel.
    choose(pixel) {
      for (const pane of [this.left, this.right]) {
        pane.chosen = pixel;
        pane.draw();
      }
    }
    mark(pixels) {
      for (const pane of [this.left, this.right]) {
        pane.marks = pixels;
        pane.draw();
      }
    }

    key(event) {
      if (event.ctrlKey || event.metaKey || event.altKey) return;  // the browser's own
      const move = { ArrowRight: [1, 0], ArrowLeft: [-1, 0], ArrowDown: [0, 1], ArrowUp: [0, -1] }[event.key];
      if (move && this.inspector) this.inspector.move(...move);
      else if (event.key === "+" || event.key === "=") this.zoom(2);
      else if (event.key === "-") this.zoom(0.5);
      else if (event.key === "0") this.view.fit();
      else return;
      event.preventDefault();
    }

    // The cards below pick their technique.
    cards() {
      const section = this.box.closest("section");
      for (const card of section.querySelectorAll(".card")) {
        const technique = Number(card.dataset.technique);
        if (technique < 0) continue;
        const name = this.data.techniques[technique].name;
        card.querySelector(".pair").replaceWith(element("button", { type: "button", class: "pair", "aria-label": `show ${name} in the viewer`, onclick: () => {
          this.pick(technique);
          this.box.scrollIntoView({ block: "start" });
        } }, ...card.querySelector(".pair").childNodes));
      }
    }
  }

  ropsim.widgets.views = (box) => { box.views = new Views(box, ropsim.json(box.dataset.source)); };
})();
