import type { NamedFile } from "./tar";

const kAtOnce = 4;
const kLargestFile_bytes = 512 * 1024 * 1024;

// Returns the identity of a dive: SHA-256 over the lines "<sha256>  <path>" of its files, sorted by the
// bytes of the path (docs/dives.md). Nothing where it cannot be known here: without a mav0, with a file
// too large to hash in one go, or on a page that came without TLS, where browsers offer no SHA-256.
export async function identity_of(files: NamedFile[]): Promise<string | undefined> {
  const is_dive = files.some(({ path }) => path.startsWith("mav0/"));
  if (!is_dive || !globalThis.crypto?.subtle || files.some(({ file }) => file.size > kLargestFile_bytes)) return undefined;
  const lines: { path: Uint8Array; text: string }[] = [];
  const waiting = [...files];
  const encoder = new TextEncoder();
  const hash_waiting = async (): Promise<void> => {
    for (let next = waiting.pop(); next; next = waiting.pop()) {
      const sha256 = await sha256_of(await next.file.arrayBuffer());
      lines.push({ path: encoder.encode(next.path), text: `${sha256}  ${next.path}\n` });
    }
  };
  await Promise.all(Array.from({ length: kAtOnce }, hash_waiting));
  lines.sort((a, b) => compare(a.path, b.path));
  return sha256_of(encoder.encode(lines.map(({ text }) => text).join("")).buffer);
}

function compare(a: Uint8Array, b: Uint8Array): number {
  const common = Math.min(a.length, b.length);
  for (let index = 0; index < common; index += 1) {
    const difference = (a[index] as number) - (b[index] as number);
    if (difference !== 0) return difference;
  }
  return a.length - b.length;
}

async function sha256_of(bytes: ArrayBuffer): Promise<string> {
  const digest = new Uint8Array(await crypto.subtle.digest("SHA-256", bytes));
  return [...digest].map((byte) => byte.toString(16).padStart(2, "0")).join("");
}
