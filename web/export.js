/** Where a scene can be downloaded, as it is edited. */

/** @param {URL} api @param {import("./protocol.js").SceneInfo} scene */
export function exportAddress(api, { id, options: { up, unit, origin, variant, storeys } }) {
  const path = id.split("/").map(encodeURIComponent).join("/");
  const url = new URL(`scenes/${path}/export.glb`, api);
  const words = { up, unit, origin: origin && String(origin), variant };
  for (const [name, word] of Object.entries(words)) if (word) url.searchParams.set(name, word);
  for (const storey of storeys ?? []) url.searchParams.append("storeys", storey);
  return url.href;
}
