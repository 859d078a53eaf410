// What the page's scripts share: elements, data blocks, numbers, colours. Widgets add themselves to `widgets`.
"use strict";
const ropsim = { widgets: {}, charts: [] };

// An element with attributes (on...: listeners, others: attributes) and children.
ropsim.element = function (tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (value !== false && value !== null && value !== undefined) made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
};

ropsim.text = (id) => document.getElementById(id).textContent;
ropsim.json = (id) => JSON.parse(ropsim.text(id));

ropsim.style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
// Hues that colour-blind readers tell apart (Paul Tol's bright scheme), then the same again.
ropsim.hue = (index) => ropsim.style(`--h${index % 7}`);
// Points and lines past the seventh change their shape as well.
ropsim.shape = (index) => ["circle", "triangle", "rect", "rectRot", "star"][Math.floor(index / 7) % 5];
ropsim.dash = (index) => [[], [7, 4], [2, 3], [9, 3, 2, 3]][Math.floor(index / 7) % 4];

const kThin = "\u202f";
// Four significant digits, thin gaps between thousands.
ropsim.number = function (value) {
  if (value === null || value === undefined) return "–";
  const size = Math.abs(value);
  if (size >= 1e15 || (size > 0 && size < 1e-4)) return value.toExponential(2).replace("e", " e");
  const digits = size >= 1000 ? 0 : size === 0 ? 0 : Math.max(0, 3 - Math.floor(Math.log10(size)));
  let text = value.toFixed(Math.min(digits, 8));
  if (text.includes(".")) text = text.replace(/\.?0+$/, "");
  const [whole, rest] = text.split(".");
  return whole.replace(/\B(?=(\d{3})+(?!\d))/g, kThin) + (rest ? "." + rest : "");
};

ropsim.labelled = (text, control) => ropsim.element("label", {}, ropsim.element("span", {}, text), control);
ropsim.menu = function (options, chosen, onpick) {
  const menu = ropsim.element("select", { onchange: () => onpick(menu.value) });
  for (const [value, text] of options)
    menu.append(ropsim.element("option", { value, selected: String(value) === String(chosen) }, text));
  return menu;
};
ropsim.check = function (text, checked, onpick) {
  const box = ropsim.element("input", { type: "checkbox", checked, onchange: () => onpick(box.checked) });
  const label = ropsim.element("label", { class: "check" }, box, ropsim.element("span", {}, text));
  label.box = box;
  return label;
};

// Charts follow the page's colours when the reader's scheme changes, and get paper's before printing.
ropsim.chart = function (canvas, configuration, recolor) {
  const chart = new Chart(canvas, configuration);
  ropsim.charts.push({ chart, recolor });
  return chart;
};
ropsim.recolor = function () {
  ropsim.chart_defaults();
  for (const { chart, recolor } of ropsim.charts) {
    recolor(chart);
    chart.update("none");
  }
};
ropsim.chart_defaults = function () {
  Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
  Chart.defaults.font.size = 12;
  Chart.defaults.color = ropsim.style("--soft");
  Chart.defaults.borderColor = ropsim.style("--rule");
  Chart.defaults.animation = false;
  Chart.defaults.maintainAspectRatio = false;
};
// The colours of an axis; call again when they change.
ropsim.color_axis = function (axis) {
  axis.ticks.color = ropsim.style("--soft");
  axis.title.color = ropsim.style("--ink");
  axis.grid = { ...axis.grid, color: ropsim.style("--rule"), borderColor: ropsim.style("--soft") };
};
ropsim.tooltip = () => ({
  backgroundColor: ropsim.style("--strong"), titleColor: ropsim.style("--page"), bodyColor: ropsim.style("--page"),
  displayColors: false, padding: 10, cornerRadius: 4, caretSize: 0,
});
