/** What was dropped on the page, or chosen: files, and of folders all that is in them. */

/** @typedef {import("./zip.js").Part} Part */

/** Files that the server takes in one archive. */
export const MOST_FILES = 2000;

/** @param {readonly File[]} files @returns {Part[]} */
export const partsOf = (files) => files.map((file) => ({ path: file.webkitRelativePath || file.name, file }));

/**
 * The files of entries and of all folders in them; no more than one above `MOST_FILES`.
 * @param {readonly FileSystemEntry[]} entries
 * @returns {Promise<Part[]>}
 */
export async function walk(entries) {
  /** @type {Part[]} */
  const found = [];
  const waiting = [...entries];
  for (let entry = waiting.shift(); entry && found.length <= MOST_FILES; entry = waiting.shift()) {
    if (entry.isDirectory) waiting.push(...(await within(/** @type {FileSystemDirectoryEntry} */ (entry))));
    else found.push({ path: entry.fullPath.replace(/^\//, ""), file: await read(/** @type {FileSystemFileEntry} */ (entry)) });
  }
  return found;
}

/** @param {FileSystemFileEntry} entry @returns {Promise<File>} */
const read = (entry) => new Promise((resolve, reject) => entry.file(resolve, reject));

/** A browser gives them in handfuls. @param {FileSystemDirectoryEntry} folder */
async function within(folder) {
  const reader = folder.createReader();
  /** @type {FileSystemEntry[]} */
  const found = [];
  for (;;) {
    const some = await /** @type {Promise<FileSystemEntry[]>} */ (new Promise((resolve, reject) => reader.readEntries(resolve, reject)));
    if (some.length === 0) return found;
    found.push(...some);
  }
}

/**
 * What an archive of files is called: as the folder that they are all in, else as the first of them that is a scene.
 * @param {readonly Part[]} parts
 * @param {readonly string[]} suffixes of scenes
 */
export function archiveName(parts, suffixes) {
  const folders = new Set(parts.map(({ path }) => path.slice(0, path.indexOf("/"))));
  const [folder] = folders;
  const scene = parts.find(({ path }) => suffixes.some((suffix) => path.toLowerCase().endsWith(suffix))) ?? parts[0];
  const name = folders.size === 1 && parts.every(({ path }) => path.includes("/")) ? folder : scene?.path.split("/").at(-1)?.replace(/\.[^.]*$/, "");
  return `${name || "scene"}.zip`;
}
