// Small drawings in SVG: pixels over the picture, arrows in the arm's plane, errors over order and direction.
const NS = "http://www.w3.org/2000/svg";
const ENLARGED_PX = 22;

function draw(svg, name, attributes, text) {
  const element = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
  if (text !== undefined) element.textContent = text;
  svg.append(element);
}

export function overlay(svg, shot, info, colours) {
  svg.replaceChildren();
  svg.setAttribute("viewBox", `-0.5 -0.5 ${info.image_width} ${info.image_height}`);
  const names = info.marker_names;
  const chain = places => names.filter(name => places[name]).map(name => places[name].join(",")).join(" ");
  draw(svg, "polyline", { points: chain(shot.twin_px), fill: "none", stroke: colours.twin, "stroke-width": 5, "stroke-dasharray": "14 9" });
  for (const name of names) {
    const expected = shot.twin_px[name], seen = shot.measured_px[name];
    if (expected) draw(svg, "circle", { cx: expected[0], cy: expected[1], r: 20, fill: "none", stroke: colours.twin, "stroke-width": 4 });
    if (!seen) continue;
    draw(svg, "circle", { cx: seen[0], cy: seen[1], r: 9, fill: colours.measured, stroke: "#fff", "stroke-width": 3 });
    draw(svg, "text", { x: seen[0] + 26, y: seen[1] - 14, "font-size": 30, "font-weight": 700, fill: colours.measured, stroke: "#fff", "stroke-width": 6, "paint-order": "stroke" }, name.toUpperCase());
  }
}

function frame(svg, x, y) {
  svg.replaceChildren();
  const width = svg.clientWidth || 300, height = svg.clientHeight || 240;
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const scale = (low, high, from, to) => value => from + (to - from) * (value - low) / ((high - low) || 1);
  return { X: scale(x[0], x[1], 46, width - 10), Y: scale(y[0], y[1], height - 22, 12), width, height };
}

function spread(values, least) {
  const low = Math.min(...values), high = Math.max(...values), more = Math.max((high - low) * 0.08, least);
  return [low - more, high + more];
}

export function arrows(svg, points, colours) {
  if (!points.length) { svg.replaceChildren(); return 1; }
  const longest = Math.max(...points.map(p => Math.hypot(p.dx, p.dy)), 1e-6);
  const xs = spread(points.map(p => p.x), 5), ys = spread(points.map(p => p.y), 5);
  const { X, Y, width, height } = frame(svg, xs, ys);
  const perMm = Math.min((width - 56) / (xs[1] - xs[0]), (height - 34) / (ys[1] - ys[0]));
  const middle = [(xs[0] + xs[1]) / 2, (ys[0] + ys[1]) / 2];
  const at = (x, y) => [(X(xs[0]) + X(xs[1])) / 2 + (x - middle[0]) * perMm, (Y(ys[0]) + Y(ys[1])) / 2 - (y - middle[1]) * perMm];
  const enlarged = ENLARGED_PX / (longest * perMm);
  for (const p of points) {
    const [x1, y1] = at(p.x, p.y), [x2, y2] = at(p.x + enlarged * p.dx, p.y + enlarged * p.dy);
    draw(svg, "line", { x1, y1, x2, y2, stroke: p.colour, "stroke-width": 2 });
    draw(svg, "circle", { cx: x2, cy: y2, r: 2.2, fill: colours.measured });
  }
  return enlarged;
}

export function scatter(svg, xs, ys, hues) {
  if (!ys.length) { svg.replaceChildren(); return; }
  const most = Math.max(...ys, 0.01);
  const { X, Y, width } = frame(svg, spread(xs, 0.5), [0, most * 1.08]);
  for (const value of [0, most]) draw(svg, "text", { x: 4, y: Y(value) + 4, "font-size": 12, fill: "#595959" }, value.toFixed(2));
  draw(svg, "line", { x1: 46, x2: width - 10, y1: Y(0), y2: Y(0), stroke: "#bbb" });
  xs.forEach((x, k) => draw(svg, "circle", { cx: X(x), cy: Y(ys[k]), r: 3, fill: hues[k], "fill-opacity": 0.75 }));
}
