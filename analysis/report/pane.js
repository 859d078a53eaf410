// One canvas of the picture viewer: draws layers under a view that it shares with its neighbours, and tells them
// what the pointer does to it.
"use strict";
(function () {
  const { element } = ropsim;
  const kMostZoom = 64;

  // The part of the frame that all panes show: `x`, `y` (frame pixels) in the middle, `zoom` 1 where it just fits.
  ropsim.View = class {
    constructor(width, height) {
      this.width = width;
      this.height = height;
      this.listeners = [];
      this.fit();
    }
    changed() { for (const listener of this.listeners) listener(); }
    fit() { this.set(this.width / 2, this.height / 2, 1); }
    set(x, y, zoom) {
      this.zoom = Math.min(Math.max(zoom, 1), kMostZoom);
      const half = { x: this.width / 2 / this.zoom, y: this.height / 2 / this.zoom };
      this.x = Math.min(Math.max(x, half.x), this.width - half.x);
      this.y = Math.min(Math.max(y, half.y), this.height - half.y);
      this.changed();
    }
    // Zooms so that the frame's place (x, y) stays where it is.
    zoom_at(x, y, factor) {
      const zoom = Math.min(Math.max(this.zoom * factor, 1), kMostZoom);
      const kept = this.zoom / zoom;
      this.set(x + (this.x - x) * kept, y + (this.y - y) * kept, zoom);
    }
  };

  ropsim.Pane = class {
    // `hear`: {point(x, y) hovered or null, click(x, y), key(event), split(part) where the pane has a slider}
    constructor(view, label, hear) {
      this.view = view;
      this.hear = hear;
      this.layers = [];
      this.marks = [];
      this.cross = null;
      this.split = null;
      this.pointers = new Map();
      this.canvas = element("canvas", { tabindex: 0, role: "img", "aria-label": label, style: `aspect-ratio:${view.width}/${view.height}` });
      this.box = element("div", { class: "pane" }, this.canvas);
      this.listen();
      new ResizeObserver(() => this.resize()).observe(this.canvas);
      view.listeners.push(() => this.draw());
    }

    resize() {
      const ratio = window.devicePixelRatio || 1;
      const [width, height] = [Math.round(this.canvas.clientWidth * ratio), Math.round(this.canvas.clientHeight * ratio)];
      if (!width || (this.canvas.width === width && this.canvas.height === height)) return;
      this.canvas.width = width;
      this.canvas.height = height;
      this.draw();
    }

    // Canvas pixels a frame's pixel, and the frame's place at the canvas' corner.
    scale() { return this.canvas.width / this.view.width * this.view.zoom; }
    place(event) {
      const box = this.canvas.getBoundingClientRect();
      const scale = this.scale() * box.width / this.canvas.width;
      return { x: this.view.x + (event.clientX - box.left - box.width / 2) / scale,
        y: this.view.y + (event.clientY - box.top - box.height / 2) / scale,
        part: (event.clientX - box.left) / box.width, scale };
    }
    pixel(place) {
      const inside = (value, size) => Math.min(Math.max(Math.floor(value), 0), size - 1);
      return [inside(place.x, this.view.width), inside(place.y, this.view.height)];
    }

    // `layers`: [{image, label}], the first left of the slider, the second right of it; an image of another size
    // than the frame (tiles) covers it to the pixels it has.
    show(layers) {
      this.layers = layers;
      this.draw();
    }

    draw() {
      const context = this.canvas.getContext("2d");
      const { width, height } = this.canvas;
      context.fillStyle = "#000";
      context.fillRect(0, 0, width, height);
      const scale = this.scale();
      context.imageSmoothingEnabled = scale < 1;
      context.imageSmoothingQuality = "high";
      const left = width / 2 - this.view.x * scale, top = height / 2 - this.view.y * scale;
      const at = this.split === null ? width : Math.round(this.split * width);
      this.layers.forEach((layer, index) => {
        context.save();
        context.beginPath();
        context.rect(index === 0 ? 0 : at, 0, index === 0 ? at : width - at, height);
        context.clip();
        const cover = layer.cover ?? 1;
        if (cover > 1) context.imageSmoothingEnabled = false;
        context.drawImage(layer.image, left, top, layer.image.width * cover * scale, layer.image.height * cover * scale);
        context.restore();
      });
      this.draw_marks(context, left, top, scale);
      if (this.split !== null) {
        context.fillStyle = "#fff";
        context.fillRect(at - 1, 0, 2, height);
      }
    }

    draw_marks(context, left, top, scale) {
      const ratio = window.devicePixelRatio || 1;
      const frame = ([x, y], color, around) => {
        const size = Math.max(scale, 5 * ratio) + 2 * around;
        context.strokeStyle = color;
        context.lineWidth = 1.5 * ratio;
        context.strokeRect(left + (x + 0.5) * scale - size / 2, top + (y + 0.5) * scale - size / 2, size, size);
      };
      for (const mark of this.marks) frame(mark, "rgba(102,204,238,.75)", 0);
      if (this.cross) frame(this.cross, "#fff", 0);
      if (this.chosen) {
        frame(this.chosen, "#000", 3 * ratio);
        frame(this.chosen, "#ffe14d", 1.5 * ratio);
      }
    }

    listen() {
      const on = (name, listener, options) => this.canvas.addEventListener(name, listener, options);
      on("pointerdown", (event) => this.down(event));
      on("pointermove", (event) => this.move(event));
      on("pointerup", (event) => this.up(event, true));
      on("pointercancel", (event) => this.up(event, false));
      on("pointerleave", () => this.hear.point(null));
      on("keydown", (event) => this.hear.key(event));
      // The page keeps its scrolling: a wheel zooms with Ctrl (as a pinch on a touchpad reports itself).
      on("wheel", (event) => {
        if (!event.ctrlKey && !event.metaKey) return;
        event.preventDefault();
        const place = this.place(event);
        this.view.zoom_at(place.x, place.y, Math.exp(-event.deltaY / 200));
      }, { passive: false });
    }

    down(event) {
      this.canvas.setPointerCapture(event.pointerId);
      const place = this.place(event);
      this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      const box = this.canvas.getBoundingClientRect();
      const on_line = this.split !== null && Math.abs(place.part - this.split) * box.width < 12;
      this.drag = { on_line, moved: this.pointers.size > 1, start: { x: event.clientX, y: event.clientY } };
    }

    move(event) {
      const place = this.place(event);
      const pointer = this.pointers.get(event.pointerId);
      if (!pointer) {
        this.hear.point(this.pixel(place));
        return;
      }
      const [dx, dy] = [event.clientX - pointer.x, event.clientY - pointer.y];
      if (this.pointers.size === 2) {
        const [other] = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, at]) => at);
        const spread = (a) => Math.hypot(a.x - other.x, a.y - other.y) || 1;
        this.view.zoom_at(place.x, place.y, spread({ x: event.clientX, y: event.clientY }) / spread(pointer));
      } else {
        const far = Math.hypot(event.clientX - this.drag.start.x, event.clientY - this.drag.start.y) > 4;
        this.drag.moved = this.drag.moved || far;
        if (this.drag.on_line && this.drag.moved) this.hear.split(Math.min(Math.max(place.part, 0), 1));
        else if (this.drag.moved && this.view.zoom > 1)
          this.view.set(this.view.x - dx / place.scale, this.view.y - dy / place.scale, this.view.zoom);
      }
      pointer.x = event.clientX;
      pointer.y = event.clientY;
    }

    up(event, clicked) {
      const last = this.pointers.size === 1;
      this.pointers.delete(event.pointerId);
      if (clicked && last && this.drag && !this.drag.moved) this.hear.click(...this.pixel(this.place(event)));
    }
  };
})();
