// Brings the widgets to life, each when it first comes near the window; the rest of the page does not wait.
"use strict";
(function () {
  ropsim.chart_defaults();
  const start = (box) => {
    if (box.dataset.started) return;
    box.dataset.started = "yes";
    ropsim.widgets[box.dataset.widget](box);
  };
  const near = new IntersectionObserver((entries) => {
    for (const entry of entries)
      if (entry.isIntersecting) {
        near.unobserve(entry.target);
        start(entry.target);
      }
  }, { rootMargin: "600px" });
  const all = [...document.querySelectorAll("[data-widget]")];
  // Tables grow by their controls: at once, so that nothing jumps later.
  for (const box of all) box.dataset.widget === "table" ? start(box) : near.observe(box);

  // Paper has no clicks: what is folded away but belongs there is opened.
  let opened = [];
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", ropsim.recolor);
  addEventListener("beforeprint", () => {
    all.forEach(start);
    opened = [...document.querySelectorAll("details[data-print]:not([open])")];
    for (const details of opened) details.open = true;
    ropsim.recolor();
  });
  addEventListener("afterprint", () => {
    for (const details of opened) details.open = false;
    ropsim.recolor();
  });
})();
