// The form of the faults, built from what the effects declare.
const DEGREE = 180 / Math.PI;

// People think in degrees; the bench in radians.
const shown = name => name.replace(/_rad$/, ", °").replace(/_(mm|px|kg|s|m)$/, ", $1").replaceAll("_", " ");
const factor = name => name.endsWith("_rad") ? DEGREE : 1;

// A size that shows at once, within what is possible.
function suggestion(parameter) {
  if (parameter.default !== null && parameter.default !== undefined) return parameter.default * factor(parameter.name);
  if (parameter.kind === "sample") return 40;
  if (parameter.name.endsWith("_rad")) return 1;
  const [low, high] = parameter.bounds;
  if (parameter.kind === "whole") return Math.min(Math.max(1, low), high);
  return Number((low <= 0 && high >= 0 ? high * 0.1 : low + (high - low) * 0.55).toPrecision(2));
}

function field(label, input, hint) {
  const element = document.createElement("label");
  element.append(`${label} `, input);
  if (hint) element.append(" ", Object.assign(document.createElement("small"), { textContent: hint }));
  return element;
}

function choice(name, values) {
  const select = Object.assign(document.createElement("select"), { name });
  values.forEach(value => select.append(new Option(String(value).toUpperCase(), value)));
  return select;
}

export function faultForm(effect, fields, markers) {
  fields.replaceChildren();
  if (effect.joints.length) fields.append(field("joint", choice("joint", effect.joints)));
  if (effect.markers.length) fields.append(field("marker", choice("marker", effect.markers)));
  for (const parameter of effect.parameters) {
    if (parameter.kind === "marker") { fields.append(field(shown(parameter.name), choice(parameter.name, markers))); continue; }
    const list = parameter.kind === "samples";
    const input = Object.assign(document.createElement("input"), { name: parameter.name, type: list ? "text" : "number", step: "any" });
    input.required = parameter.required;
    input.value = list ? "20, 45" : parameter.required || parameter.default !== null ? suggestion(parameter) : "";
    const bounds = parameter.kind === "number" || parameter.kind === "whole"
      ? parameter.bounds.map(bound => Number((bound * factor(parameter.name)).toPrecision(3))).join(" to ") : "";
    fields.append(field(shown(parameter.name), input, bounds));
  }
}

export function faultOf(effect, form) {
  const fault = { name: effect.name, parameters: {} };
  const value = name => form.elements.namedItem(name)?.value ?? "";
  if (effect.joints.length) fault.joint = Number(value("joint"));
  if (effect.markers.length) fault.marker = value("marker");
  for (const parameter of effect.parameters) {
    const text = value(parameter.name).trim();
    if (!text) continue;
    if (parameter.kind === "marker") fault.parameters[parameter.name] = text;
    else if (parameter.kind === "samples") fault.parameters[parameter.name] = text.split(/[\s,;]+/).map(Number);
    else fault.parameters[parameter.name] = parameter.kind === "number" ? Number(text) / factor(parameter.name) : Number(text);
  }
  return fault;
}

export function faultText(fault) {
  const where = fault.joint ? `, joint ${fault.joint}` : fault.marker ? `, marker ${fault.marker.toUpperCase()}` : "";
  const sizes = Object.entries(fault.parameters).map(([name, value]) =>
    `${shown(name)} ${typeof value === "number" ? Number((value * factor(name)).toPrecision(4)) : value}`);
  return `${fault.name}${where}: ${sizes.join("; ")}`;
}
