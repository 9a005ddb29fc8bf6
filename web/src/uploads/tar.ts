// A tar archive of files as a Blob: its parts refer to the files, so nothing is read into memory,
// and the same files give the same bytes, so an upload can be resumed after a reload.
const kBlock = 512;
const kLargestOctal_bytes = 8 * 1024 ** 3;
const encoder = new TextEncoder();

export interface NamedFile {
  path: string;
  file: File;
}

export function tar_of(files: NamedFile[]): Blob {
  const parts: BlobPart[] = [];
  for (const { path, file } of sorted(files)) {
    parts.push(...headers_of(path, file.size), file, zeros(padding_of(file.size)));
  }
  parts.push(zeros(2 * kBlock));
  return new Blob(parts, { type: "application/x-tar" });
}

export function sorted(files: NamedFile[]): NamedFile[] {
  return [...files].sort((a, b) => (a.path < b.path ? -1 : a.path > b.path ? 1 : 0));
}

function padding_of(size: number): number {
  return (kBlock - (size % kBlock)) % kBlock;
}

function zeros(count: number): Uint8Array<ArrayBuffer> {
  return new Uint8Array(count);
}

// Returns the header of an entry, after a pax header where name or size do not fit into it.
function headers_of(path: string, size: number): Uint8Array<ArrayBuffer>[] {
  const name = encoder.encode(path);
  const is_plain = name.length <= 100 && name.length === path.length && size < kLargestOctal_bytes;
  if (is_plain) return [header(name, size, "0")];
  const records = encoder.encode(pax_record("path", path) + pax_record("size", String(size)));
  return [
    header(encoder.encode("pax_header"), records.length, "x"),
    padded(records),
    header(name.slice(0, 100), size < kLargestOctal_bytes ? size : 0, "0"),
  ];
}

function padded(bytes: Uint8Array): Uint8Array<ArrayBuffer> {
  const block = zeros(bytes.length + padding_of(bytes.length));
  block.set(bytes);
  return block;
}

// Returns "LENGTH key=value\n", in which LENGTH counts itself.
function pax_record(key: string, value: string): string {
  const rest = encoder.encode(` ${key}=${value}\n`).length;
  let length = rest + String(rest).length;
  if (rest + String(length).length !== length) length += 1;
  return `${length} ${key}=${value}\n`;
}

function header(name: Uint8Array, size: number, type: string): Uint8Array<ArrayBuffer> {
  const block = zeros(kBlock);
  const put = (offset: number, text: string): void => block.set(encoder.encode(text), offset);
  block.set(name, 0);
  put(100, "0000644\0");
  put(108, "0000000\0");
  put(116, "0000000\0");
  put(124, `${size.toString(8).padStart(11, "0")}\0`);
  put(136, "00000000000\0");
  put(148, "        ");
  put(156, type);
  put(257, "ustar\0");
  put(263, "00");
  const sum = block.reduce((total, byte) => total + byte, 0);
  put(148, `${sum.toString(8).padStart(6, "0")}\0 `);
  return block;
}
