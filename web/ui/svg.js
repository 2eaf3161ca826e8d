/** Shapes over the picture. */

const SVG = "http://www.w3.org/2000/svg";

/** @typedef {import("../viewer/projection.js").Point} Point */
/** @typedef {import("../viewer/camera.js").Vec3} Vec3 */

/**
 * A new shape in `parent` with these attributes.
 * @template {keyof SVGElementTagNameMap} Tag
 * @param {Element} parent @param {Tag} tag @param {Readonly<Record<string, string | number>>} [attributes]
 * @returns {SVGElementTagNameMap[Tag]}
 */
export function shape(parent, tag, attributes = {}) {
  const made = document.createElementNS(SVG, tag);
  set(made, attributes);
  parent.append(made);
  return made;
}

/** @param {Element} element @param {Readonly<Record<string, string | number>>} attributes */
export function set(element, attributes) {
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, String(value));
}

/** Shows a shape at a place, or hides it where there is none. @param {SVGElement} element @param {Point | null} place */
export function put(element, place) {
  element.toggleAttribute("hidden", place === null);
  if (place) element.setAttribute("transform", `translate(${place.x.toFixed(1)} ${place.y.toFixed(1)})`);
}

/** Lines of the world as the shape of a path, as far as they are in front of the camera. @param {[Vec3, Vec3][]} lines @param {import("../viewer/projection.js").Projection} projection */
export function strokes(lines, projection) {
  const drawn = lines.map(([a, b]) => projection.line(a, b));
  return drawn.map((line) => line && `M${line.map(({ x, y }) => `${x.toFixed(1)} ${y.toFixed(1)}`).join("L")}`).join("");
}
