// SPDX-License-Identifier: GPL-3.0-or-later
// Draws curves as SVG.

const namespace = "http://www.w3.org/2000/svg";
const edges = { left: 56, right: 12, top: 10, bottom: 26 };

export function element(tag, attributes, ...children) {
  const made = document.createElementNS(namespace, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

/**
 * Returns a chart as an SVG element.
 * @param options  label for screen readers; size {width, height}; axes x and y, each {min, max, ticks, log}; curves,
 *                 each {points: [[x, y], ...], name, mark}, where mark is an optional position [x, y]
 */
export function chart({ label, size, x, y, curves }) {
  const { width, height } = size;
  const share = ({ min, max, log }, value) =>
    log ? Math.log(Math.max(value, min) / min) / Math.log(max / min) : (value - min) / (max - min || 1);
  const atX = (value) => edges.left + share(x, value) * (width - edges.left - edges.right);
  const atY = (value) => height - edges.bottom - Math.min(share(y, value), 1) * (height - edges.top - edges.bottom);
  const text = (place, anchor, value) => element("text", { ...place, "text-anchor": anchor }, String(value));
  const svg = element("svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": label });
  for (const tick of y.ticks) {
    svg.append(element("line", { class: "axis", x1: edges.left, x2: width - edges.right, y1: atY(tick), y2: atY(tick) }),
      text({ x: edges.left - 6, y: atY(tick) + 4 }, "end", tick));
  }
  for (const tick of x.ticks) svg.append(text({ x: atX(tick), y: height - 8 }, "middle", tick));
  for (const { points, name = "", mark } of curves) {
    const places = points.map(([px, py]) => `${atX(px).toFixed(1)},${atY(py).toFixed(1)}`);
    svg.append(element("polyline", { class: `curve ${name}`, points: places.join(" ") }));
    if (mark) svg.append(element("circle", { class: "mark", cx: atX(mark[0]), cy: atY(mark[1]), r: 4.5 }));
  }
  return svg;
}
