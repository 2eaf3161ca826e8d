/** Sends scene files to the server. */

/** @typedef {import("./protocol.js").SceneName} SceneName */

export class UploadError extends Error {}

/**
 * Sends a file; rejects with UploadError and words for the user, or with AbortError when cancelled.
 * @param {URL} scenes where scenes are listed and taken
 * @param {File} file
 * @param {(fraction: number) => void} progress 1: all is sent, the server reads it
 * @param {AbortSignal} signal cancels
 * @returns {Promise<string>} the new scene's id
 */
export function upload(scenes, file, progress, signal) {
  const url = new URL(scenes);
  url.searchParams.set("name", file.name);
  const request = new XMLHttpRequest(); // fetch does not tell how much has been sent
  request.open("POST", url);
  request.setRequestHeader("Content-Type", "application/octet-stream");
  request.responseType = "json";
  return new Promise((resolve, reject) => {
    request.upload.addEventListener("progress", ({ loaded, total }) => progress(total > 0 ? loaded / total : 1));
    request.addEventListener("load", () => {
      const { status, response } = request;
      if (status === 201 && typeof response?.id === "string") resolve(response.id);
      else reject(new UploadError(response?.message ?? `The server does not take scenes (status ${status}).`));
    });
    request.addEventListener("error", () => reject(new UploadError("The connection was lost before all was sent.")));
    request.addEventListener("abort", () => reject(new DOMException("cancelled", "AbortError")));
    signal.addEventListener("abort", () => request.abort());
    request.send(file);
  });
}

/** The scenes that can be chosen now. @param {URL} scenes @returns {Promise<SceneName[]>} rejects with UploadError and words for the user */
export async function listScenes(scenes) {
  const answer = await fetch(scenes).catch(() => null);
  if (!answer) throw new UploadError("The file was sent, but the server does not answer any more; reload the page.");
  if (!answer.ok) throw new UploadError(`The server does not list its scenes (status ${answer.status}).`);
  return answer.json();
}
