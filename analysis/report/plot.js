// A plot of points: both axes picked from what was measured, coloured by a grouping, the Pareto front drawn.
"use strict";
(function () {
  const { element, number } = ropsim;

  // Points of which none is at least as good on both axes and better on one. -1: smaller is better, 1: larger.
  ropsim.pareto_front = function (points, better_x, better_y) {
    const sorted = [...points].sort((a, b) => better_x * (b.x - a.x) || better_y * (b.y - a.y));
    const front = [];
    for (const point of sorted) {
      const last = front[front.length - 1];
      if (!last || better_y * (point.y - last.y) > 0) front.push(point);
    }
    return front;
  };

  // Corners between the points of a front: what is reached without mixing techniques.
  function staircase(front) {
    const corners = [];
    for (let i = 0; i < front.length; ++i) {
      if (i > 0) corners.push({ x: front[i].x, y: front[i - 1].y });
      corners.push({ x: front[i].x, y: front[i].y });
    }
    return corners;
  }

  const direction = (axis) => ({ smaller: -1, larger: 1, neither: 0 })[axis.better];
  const title_of = (axis) => axis.name + (axis.unit ? ` [${axis.unit}]` : "");

  class PointPlot {
    constructor(figure, data) {
      this.data = data;
      this.figure = figure;
      this.pick = { x: data.x, y: data.y, log_x: data.log_x, log_y: data.log_y, by: data.groupings[0] ?? "", front: true };
      this.canvas = element("canvas", { tabindex: 0, role: "img", onkeydown: (event) => this.step(event) });
      this.said = element("p", { class: "said", "aria-live": "polite" });
      this.key = element("div", { class: "legend" });
      figure.querySelector(".stage").append(this.controls(), this.key,
        element("div", { class: "chart" }, this.canvas), this.said);
      this.chart = ropsim.chart(this.canvas, this.configuration(), (chart) => {
        ropsim.color_axis(chart.options.scales.x);
        ropsim.color_axis(chart.options.scales.y);
        chart.options.plugins.tooltip = { ...chart.options.plugins.tooltip, ...ropsim.tooltip() };
        chart.data.datasets = this.datasets();
        this.draw_key();
      });
      this.show();
    }

    axis(name) { return this.data.axes.find((axis) => axis.name === name); }

    controls() {
      const names = this.data.axes.map((axis) => [axis.name, title_of(axis)]);
      const changed = (key) => (value) => { this.pick[key] = value; this.show(); };
      const by = [["", "nothing"], ...this.data.groupings.map((name) => [name, name])];
      this.log_x = ropsim.check("log", this.pick.log_x, changed("log_x"));
      this.log_y = ropsim.check("log", this.pick.log_y, changed("log_y"));
      this.front_box = ropsim.check("Pareto front", true, changed("front"));
      return element("div", { class: "controls" },
        element("div", {}, ropsim.labelled("across", ropsim.menu(names, this.pick.x, changed("x"))), this.log_x),
        element("div", {}, ropsim.labelled("up", ropsim.menu(names, this.pick.y, changed("y"))), this.log_y),
        this.data.groupings.length ? element("div", {}, ropsim.labelled("colour by", ropsim.menu(by, this.pick.by, changed("by")))) : null,
        this.front_box);
    }

    // What the picked axes show, with each point's place among all.
    points() {
      const x = this.data.axes.findIndex((axis) => axis.name === this.pick.x);
      const y = this.data.axes.findIndex((axis) => axis.name === this.pick.y);
      const by = this.data.groupings.indexOf(this.pick.by);
      return this.data.points
        .map((point) => ({ x: point.values[x], y: point.values[y], name: point.name, groups: point.groups,
          group: by < 0 ? "" : point.groups[by] }))
        .filter((point) => point.x !== null && point.y !== null)
        .filter((point) => (!this.scale_is_log("x") || point.x > 0) && (!this.scale_is_log("y") || point.y > 0));
    }

    // A logarithmic axis leaves out zeros, and says so.
    scale_is_log(which) { return this.pick["log_" + which]; }

    groups() { return [...new Set(this.data.points.map((point) => {
      const by = this.data.groupings.indexOf(this.pick.by);
      return by < 0 ? "" : point.groups[by];
    }))]; }

    // A front of all points, or one of each group within which alone points may be compared; null where an axis has
    // no better end.
    fronts() {
      const [x, y] = [direction(this.axis(this.pick.x)), direction(this.axis(this.pick.y))];
      if (!x || !y || this.pick.x === this.pick.y) return null;
      const within = this.data.groupings.indexOf(this.data.within);
      const group = (point) => within < 0 ? "" : point.groups[within];
      const points = this.points();
      return [...new Set(points.map(group))].map((name) => ({
        name, points: ropsim.pareto_front(points.filter((point) => group(point) === name), x, y) }));
    }
    front_text(fronts) {
      return (fronts ?? []).map(({ name, points }) => `Pareto front${name ? " of " + name : ""}: ` +
        points.map((point) => point.name).join(" · ")).join("; ");
    }

    datasets() {
      const points = this.points();
      const sets = this.groups().map((group, index) => ({
        label: group, data: points.filter((point) => point.group === group), backgroundColor: ropsim.hue(index),
        borderColor: ropsim.hue(index), pointStyle: ropsim.shape(index), pointRadius: 5.5, pointHoverRadius: 9,
        pointHitRadius: 12, showLine: false,
      }));
      for (const front of (this.pick.front && this.fronts()) || []) sets.push({
        label: "Pareto front", data: staircase(front.points), showLine: true, pointRadius: 0, pointHitRadius: 0, pointHoverRadius: 0,
        borderColor: ropsim.style("--soft"), borderWidth: 1.5, borderDash: [5, 4], fill: false, order: 10,
      });
      return sets;
    }

    configuration() {
      const scale = () => ({ type: "linear", title: { display: true, font: { weight: 600 } },
        ticks: { maxTicksLimit: 8, callback: (value) => number(value) }, grid: {} });
      return {
        type: "scatter",
        data: { datasets: [] },
        plugins: [{ id: "names", afterDatasetsDraw: (chart) => this.draw_names(chart) }],
        options: {
          layout: { padding: { top: 16, right: 12 } },
          interaction: { mode: "nearest", intersect: true },
          onHover: (event, active) => { event.native.target.style.cursor = active.length ? "pointer" : "default"; },
          scales: { x: scale(), y: scale() },
          plugins: { legend: { display: false }, tooltip: { callbacks: {
            title: (items) => items[0]?.raw.name ?? "",
            label: (item) => this.lines(item.raw),
          } } },
        },
      };
    }

    lines(point) {
      const line = (axis, value) => `${axis.name}: ${number(value)}${axis.unit ? " " + axis.unit : ""}`;
      const groups = this.data.groupings.map((name, i) => `${name}: ${point.groups[i]}`);
      return [line(this.axis(this.pick.x), point.x), line(this.axis(this.pick.y), point.y), ...groups];
    }

    // Names beside the points, as far as they do not run into one another.
    draw_names(chart) {
      const context = chart.ctx;
      const area = chart.chartArea;
      const taken = [];
      const fits = (box) => box.left >= area.left && box.right <= area.right && box.top >= area.top - 14 &&
        box.bottom <= area.bottom &&
        taken.every((other) => box.right < other.left || box.left > other.right || box.bottom < other.top || box.top > other.bottom);
      const places = [];
      chart.data.datasets.forEach((set, index) => {
        if (set.showLine) return;
        chart.getDatasetMeta(index).data.forEach((shape, i) => places.push([shape, set.data[i]]));
      });
      for (const [shape] of places)
        taken.push({ left: shape.x - 5, right: shape.x + 5, top: shape.y - 5, bottom: shape.y + 5 });
      context.save();
      context.font = `11px ${Chart.defaults.font.family}`;
      context.fillStyle = ropsim.style("--ink");
      context.textBaseline = "middle";
      context.strokeStyle = ropsim.style("--page");
      context.lineWidth = 3;
      context.lineJoin = "round";
      for (const [shape, point] of places) {
        const width = context.measureText(point.name).width;
        const tries = [[shape.x + 9, shape.y], [shape.x - 9 - width, shape.y],
          [shape.x - width / 2, shape.y - 13], [shape.x - width / 2, shape.y + 13]];
        for (const [left, y] of tries) {
          const box = { left, right: left + width, top: y - 6, bottom: y + 6 };
          if (!fits(box)) continue;
          taken.push(box);
          context.strokeText(point.name, left, y);
          context.fillText(point.name, left, y);
          break;
        }
      }
      context.restore();
    }

    draw_key() {
      const groups = this.groups();
      const named = groups.length > 1 && groups.length <= 24;
      this.key.replaceChildren(...(named ? groups.map((group, index) => element("span", {},
        element("i", { class: "dot " + ropsim.shape(index), style: `background:${ropsim.hue(index)}` }), group)) : []));
    }

    show() {
      const options = this.chart.options;
      for (const which of ["x", "y"]) {
        const axis = this.axis(this.pick[which]);
        options.scales[which].type = this.scale_is_log(which) ? "logarithmic" : "linear";
        options.scales[which].title.text = title_of(axis);
        ropsim.color_axis(options.scales[which]);
      }
      options.plugins.tooltip = { ...options.plugins.tooltip, ...ropsim.tooltip() };
      this.chart.data.datasets = this.datasets();
      const fronts = this.fronts();
      this.front_box.box.disabled = !fronts;
      this.canvas.setAttribute("aria-label", `${this.pick.y} over ${this.pick.x}, ${this.points().length} points; ` +
        (fronts ? this.front_text(fronts) + "; " : "") + "arrow keys step through the points");
      this.draw_key();
      this.chart.update("none");
      this.say_fronts(fronts);
      this.at = -1;
    }

    say_fronts(fronts) {
      const shown = this.points().length;
      const left_out = this.data.points.length - shown;
      this.said.textContent = this.front_text(fronts) +
        (left_out ? `${fronts ? ". " : ""}${left_out} of ${this.data.points.length} have no value to show on these axes` : "");
    }

    step(event) {
      const move = { ArrowRight: 1, ArrowDown: 1, ArrowLeft: -1, ArrowUp: -1 }[event.key];
      if (!move) return;
      event.preventDefault();
      const order = [];
      this.chart.data.datasets.forEach((set, datasetIndex) => {
        if (!set.showLine) set.data.forEach((point, index) => order.push({ datasetIndex, index, point }));
      });
      if (!order.length) return;
      order.sort((a, b) => a.point.x - b.point.x);
      this.at = this.at < 0 ? (move > 0 ? 0 : order.length - 1) : (this.at + move + order.length) % order.length;
      const { datasetIndex, index, point } = order[this.at];
      const shape = this.chart.getDatasetMeta(datasetIndex).data[index];
      this.chart.setActiveElements([{ datasetIndex, index }]);
      this.chart.tooltip.setActiveElements([{ datasetIndex, index }], { x: shape.x, y: shape.y });
      this.chart.update("none");
      this.said.textContent = point.name + ": " + this.lines(point).join(", ");
    }
  }

  ropsim.widgets.plot = (figure) => { figure.plot = new PointPlot(figure, ropsim.json(figure.dataset.source)); };
})();
