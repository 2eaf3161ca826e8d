/** Icons made by scripts, of the symbols in index.html. */

/** @param {string} id of a symbol @returns {SVGSVGElement} */
export function icon(id) {
  const space = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(space, "svg");
  const use = document.createElementNS(space, "use");
  svg.ariaHidden = "true";
  use.setAttribute("href", `#${id}`);
  svg.append(use);
  return svg;
}
