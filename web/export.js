/** Where a scene can be downloaded, as all see it, or with a viewer's own edits. */

/** @param {URL} api @param {import("./protocol.js").SceneInfo} scene */
export function exportAddress(api, { id, options: { up, unit, origin, variant, storeys } }) {
  const path = id.split("/").map(encodeURIComponent).join("/");
  const url = new URL(`scenes/${path}/export.glb`, api);
  const words = { up, unit, origin: origin && String(origin), variant };
  for (const [name, word] of Object.entries(words)) if (word) url.searchParams.set(name, word);
  for (const storey of storeys ?? []) url.searchParams.append("storeys", storey);
  return url.href;
}

/** @param {string} address @param {import("./messages.js").SceneEdits} edits */
export function withEdits(address, edits) {
  const url = new URL(address);
  url.searchParams.set("edits", JSON.stringify(edits));
  return url.href;
}
