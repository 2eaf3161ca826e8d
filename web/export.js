/** Where a scene can be downloaded, as all see it, or with a viewer's own edits. */

export class ExportError extends Error {}

/** @param {URL} api @param {import("./protocol.js").SceneInfo} scene */
export function exportAddress(api, { id, options: { up, unit, origin, variant, storeys } }) {
  const path = id.split("/").map(encodeURIComponent).join("/");
  const url = new URL(`scenes/${path}/export.glb`, api);
  const words = { up, unit, origin: origin && String(origin), variant };
  for (const [name, word] of Object.entries(words)) if (word) url.searchParams.set(name, word);
  for (const storey of storeys ?? []) url.searchParams.append("storeys", storey);
  return url.href;
}

/** The file with these edits, which an address has no room for. @param {string} address @param {import("./messages.js").SceneEdits} edits @returns {Promise<Blob>} rejects with ExportError and words for the user */
export async function withEdits(address, edits) {
  const headers = { "Content-Type": "application/json" };
  const answer = await fetch(address, { method: "POST", headers, body: JSON.stringify(edits) }).catch(() => null);
  if (!answer) throw new ExportError("The server does not answer; try again.");
  if (answer.ok) return answer.blob();
  const { message } = await answer.json().catch(() => ({}));
  throw new ExportError(message ?? `The server does not give this scene out (status ${answer.status}).`);
}
