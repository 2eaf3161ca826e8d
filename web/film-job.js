/** Has the server render films: asks for one, hears how far it is, and where it can be fetched. */

/** @typedef {{state: "queued" | "running" | "done" | "failed" | "cancelled", progress: number, pictures: number, error: string, url: string}} JobInfo */

export class FilmError extends Error {}

/** @param {URL} api @param {Readonly<Record<string, unknown>>} wanted @returns {Promise<JobInfo>} rejects with FilmError and words for the user */
export async function orderFilm(api, wanted) {
  let answer;
  try {
    const headers = { "Content-Type": "application/json" };
    answer = await fetch(new URL("films", api), { method: "POST", headers, body: JSON.stringify(wanted) });
  } catch {
    throw new FilmError("The server does not answer; try again.");
  }
  const body = await answer.json().catch(() => ({}));
  if (!answer.ok) throw new FilmError(body.message ?? `The server renders no films (status ${answer.status}).`);
  return body;
}

/** A job that was ordered before; null if the server knows of it no more. @param {URL} api @param {string} url @returns {Promise<JobInfo | null>} rejects if it does not say */
export async function findFilm(api, url) {
  const answer = await fetch(new URL("jobs", api));
  if (!answer.ok) throw new FilmError(`The server does not tell of its films (status ${answer.status}).`);
  const jobs = /** @type {JobInfo[]} */ (await answer.json());
  return jobs.find((job) => job.url === url) ?? null;
}

/**
 * Tells of a job until it has ended; a function that stops telling. The browser also loses one as it leaves the page.
 * @param {JobInfo} job @param {(job: JobInfo) => void} told @param {(words: string) => void} lost
 */
export function watchFilm(job, told, lost) {
  const events = new EventSource(new URL(`${job.url}/events`, document.baseURI));
  const hear = (/** @type {MessageEvent<string>} */ { data }) => told(JSON.parse(data));
  events.addEventListener("progress", hear);
  events.addEventListener("end", (event) => {
    events.close();
    hear(event);
  });
  events.addEventListener("error", () => {
    if (events.readyState === EventSource.CLOSED) lost("The server tells no more of this film. Load the page again to see what became of it.");
  });
  return () => events.close();
}

/** @param {JobInfo} job */
export async function cancelFilm({ url }) {
  await fetch(new URL(url, document.baseURI), { method: "DELETE" }).catch(() => null); // then it ends by itself
}

/** Where the film is, once it is done. @param {JobInfo} job */
export const resultOf = ({ url }) => new URL(`${url}/result`, document.baseURI).href;
