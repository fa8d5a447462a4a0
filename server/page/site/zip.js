// SPDX-License-Identifier: GPL-3.0-or-later
// Packs files into a ZIP archive.

const crcTable = Uint32Array.from({ length: 256 }, (_, value) => {
  let crc = value;
  for (let bit = 0; bit < 8; ++bit) crc = crc & 1 ? (crc >>> 1) ^ 0xedb88320 : crc >>> 1;
  return crc;
});

function crcOf(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) crc = (crc >>> 8) ^ crcTable[(crc ^ byte) & 0xff];
  return ~crc >>> 0;
}

/** Returns numbers of 2 or 4 bytes, which pairs of a number and its size list, in the order of bytes of ZIP. */
function numbers(...pairs) {
  const view = new DataView(new ArrayBuffer(pairs.reduce((sum, [, size]) => sum + size, 0)));
  let at = 0;
  for (const [number, size] of pairs) {
    if (size === 2) view.setUint16(at, number, true);
    else view.setUint32(at, number, true);
    at += size;
  }
  return new Uint8Array(view.buffer);
}

const version = 20;  // 2.0: deflate
const isUtf8 = 1 << 11;
const deflate = 8;
const firstDay = 0x21;  // 1 January 1980

/** Packs files, [{name, blob}], of less than 4 GiB in all into a ZIP archive. */
export async function zipOf(files) {
  const [parts, directory] = [[], []];
  let at = 0;
  for (const { name, blob } of files) {
    const title = new TextEncoder().encode(name);
    const packed = await new Response(blob.stream().pipeThrough(new CompressionStream("deflate-raw"))).blob();
    const crc = crcOf(new Uint8Array(await blob.arrayBuffer()));
    const shared = [[version, 2], [isUtf8, 2], [deflate, 2], [0, 2], [firstDay, 2], [crc, 4], [packed.size, 4], [blob.size, 4], [title.length, 2], [0, 2]];
    const local = [numbers([0x04034b50, 4], ...shared), title, packed];
    directory.push(numbers([0x02014b50, 4], [version, 2], ...shared, [0, 2], [0, 2], [0, 2], [0, 4], [at, 4]), title);
    parts.push(...local);
    at += local[0].length + title.length + packed.size;
  }
  const size = directory.reduce((sum, { length }) => sum + length, 0);
  const end = numbers([0x06054b50, 4], [0, 2], [0, 2], [files.length, 2], [files.length, 2], [size, 4], [at, 4], [0, 2]);
  return new Blob([...parts, ...directory, end], { type: "application/zip" });
}
