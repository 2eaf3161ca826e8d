/** ZIP archives of files as they are: scenes compress little, and the line is rarely slower than the reader. */

/** @typedef {{path: string, file: File}} Part  path: within the archive, of names and slashes */

const LOCAL = 0x04034b50;
const CENTRAL = 0x02014b50;
const END = 0x06054b50;
const VERSION = 20;
const UTF8 = 0x0800;
/** 1 January 1980, from which ZIP counts. */
const DATE = 0x0021;
/** What sizes and places of a plain archive may be [bytes]. */
const MOST = 2 ** 32 - 1;

const TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  for (let bit = 0; bit < 8; bit++) byte = byte & 1 ? (byte >>> 1) ^ 0xedb88320 : byte >>> 1;
  return byte;
});

/** @param {Blob} blob */
async function crc32(blob) {
  let crc = -1;
  const reader = blob.stream().getReader();
  for (let read = await reader.read(); !read.done; read = await reader.read()) {
    for (const byte of read.value) crc = /** @type {number} */ (TABLE[(crc ^ byte) & 0xff]) ^ (crc >>> 8);
  }
  return ~crc >>> 0;
}

/** Numbers of two ("2") or four ("4") bytes, little-endian. @param {string} widths @param {number[]} values */
function fields(widths, ...values) {
  const view = new DataView(new ArrayBuffer([...widths].reduce((sum, width) => sum + Number(width), 0)));
  let at = 0;
  for (const [index, width] of [...widths].entries()) {
    const value = /** @type {number} */ (values[index]);
    if (width === "2") view.setUint16(at, value, true);
    else view.setUint32(at, value, true);
    at += Number(width);
  }
  return view.buffer;
}

/**
 * An archive; null where it would be larger than such can be.
 * @param {readonly Part[]} parts
 * @returns {Promise<Blob | null>} which reads the files when it is read
 */
export async function pack(parts) {
  /** @type {BlobPart[]} */
  const files = [];
  /** @type {BlobPart[]} */
  const directory = [];
  let [place, directorySize] = [0, 0];
  for (const { path, file } of parts) {
    const name = new TextEncoder().encode(path);
    // Version, flags, stored, time, date, CRC, sizes packed and not, length of the name; no extra field.
    const about = fields("2222244422", VERSION, UTF8, 0, 0, DATE, await crc32(file), file.size, file.size, name.length, 0);
    directory.push(fields("42", CENTRAL, VERSION), about, fields("22244", 0, 0, 0, 0, place), name);
    directorySize += 46 + name.length;
    files.push(fields("4", LOCAL), about, name, file);
    place += 30 + name.length + file.size;
    if (place + directorySize > MOST) return null;
  }
  const end = fields("42222442", END, 0, 0, parts.length, parts.length, directorySize, place, 0);
  return new Blob([...files, ...directory, end]);
}
