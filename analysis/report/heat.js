// Whole numbers packed into the colours of exact pictures, and their heat maps on a logarithmic scale.
"use strict";
(function () {
  const { element, number } = ropsim;

  ropsim.load_image = (id) => new Promise((resolve, reject) => {
    const image = new Image();
    image.onload = () => resolve(image);
    image.onerror = () => reject(new Error(`picture ${id} cannot be read`));
    image.src = ropsim.text(id);
  });

  // The picture's pixels as bytes: R, G, B, A.
  ropsim.bytes_of = function (image) {
    const canvas = element("canvas", { width: image.width, height: image.height });
    const context = canvas.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    return context.getImageData(0, 0, image.width, image.height).data;
  };

  // Stops of matplotlib's "inferno" (CC0), which darkens evenly also without colours.
  const kStops = [[0, 0, 4], [40, 11, 84], [101, 21, 110], [159, 42, 99], [212, 72, 66], [245, 125, 21], [250, 193, 39], [252, 255, 164]];
  function heat_color(part) {
    const at = Math.min(Math.max(part, 0), 1) * (kStops.length - 1);
    const low = Math.min(Math.floor(at), kStops.length - 2);
    return kStops[low].map((value, c) => value + (kStops[low + 1][c] - value) * (at - low));
  }

  // A map of numbers: values, the largest, a canvas of a pixel each; zero is black.
  ropsim.heat_map = function (image, unit) {
    const bytes = ropsim.bytes_of(image);
    const values = new Float64Array(image.width * image.height);
    let most = 0;
    for (let i = 0; i < values.length; ++i) {
      values[i] = bytes[4 * i] * 65536 + bytes[4 * i + 1] * 256 + bytes[4 * i + 2];
      most = Math.max(most, values[i]);
    }
    let least = most;
    for (const value of values) if (value > 0) least = Math.min(least, value);
    const span = Math.log(most / least) || 1;
    const canvas = element("canvas", { width: image.width, height: image.height });
    const context = canvas.getContext("2d");
    const out = context.createImageData(image.width, image.height);
    values.forEach((value, i) => {
      const color = value > 0 ? heat_color(0.12 + 0.88 * Math.log(value / least) / span) : [0, 0, 0];
      out.data.set([...color, 255], 4 * i);
    });
    context.putImageData(out, 0, 0);
    return { values, width: image.width, height: image.height, least, most, canvas, unit };
  };

  // The scale below a heat map.
  ropsim.heat_scale = function (map) {
    if (!map.most) return element("div", { class: "heat-scale" }, "nothing to show");
    const stops = [];
    for (let i = 0; i <= 8; ++i) stops.push(`rgb(${heat_color(0.12 + 0.88 * i / 8).map(Math.round).join(",")})`);
    const middle = Math.round(Math.sqrt(map.least * map.most));
    return element("div", { class: "heat-scale" },
      element("div", { class: "ramp", style: `background:linear-gradient(to right,${stops.join(",")})` }),
      element("div", { class: "ends" }, element("span", {}, number(map.least)), element("span", {}, number(middle)),
        element("span", {}, `${number(map.most)} ${map.unit}`)));
  };
})();
