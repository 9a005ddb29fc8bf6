import type { Dropped } from "./dropped";
import { sorted, tar_of, type NamedFile } from "./tar";

// What one upload would send, and what can be said about it before it is sent.
export interface Candidate {
  name: string;
  filename: string;
  blob: Blob;
  files: NamedFile[];
  is_archive: boolean;
  num_files: number;
  num_left_out: number;
  num_left: number;
  num_right: number;
  parts: string[];
  fingerprint: string;
}

const kArchive = /\.(zip|tar|tar\.gz|tgz|tar\.zst|tzst)$/i;
const kSystemFile = /(^|\/)(\.DS_Store|\._[^/]*|Thumbs\.db|desktop\.ini)$/i;
const kImage = /\.(png|jpe?g)$/i;

// Returns the dives in what was dropped: each archive is one, each folder with a mav0 in it, and
// the rest of a drop together.
export function candidates_of(dropped: Dropped[]): Candidate[] {
  return dropped.flatMap(({ root, files }) => {
    const kept = files.filter(({ path }) => !kSystemFile.test(path));
    const num_left_out = files.length - kept.length;
    if (root === "") {
      const archives = kept.filter(({ path }) => kArchive.test(path));
      const others = kept.filter(({ path }) => !kArchive.test(path));
      const rest = others.length > 0 ? [from_files(others[0]?.path.replace(/\.[^.]+$/, "") ?? "", others, num_left_out)] : [];
      return [...archives.map(from_archive), ...rest];
    }
    return dives_in(root, kept, num_left_out);
  });
}

function dives_in(root: string, files: NamedFile[], num_left_out: number): Candidate[] {
  if (root === "mav0") {
    return [from_files(root, files.map(({ path, file }) => ({ path: `mav0/${path}`, file })), num_left_out)];
  }
  const folders = new Set<string>();
  for (const { path } of files) {
    const found = /^(.*?)(^|\/)mav0\//.exec(path);
    if (found) folders.add(found[1] ?? "");
  }
  if (folders.size === 0 || folders.has("")) return files.length > 0 ? [from_files(root, files, num_left_out)] : [];
  return [...folders].sort().map((folder) => {
    const below = files.filter(({ path }) => path.startsWith(`${folder}/`));
    const named = below.map(({ path, file }) => ({ path: path.slice(folder.length + 1), file }));
    return from_files(folder.split("/").pop() ?? root, named, 0);
  });
}

function from_archive({ path, file }: NamedFile): Candidate {
  return {
    name: path.replace(kArchive, ""),
    filename: path,
    blob: file,
    files: [],
    is_archive: true,
    num_files: 1,
    num_left_out: 0,
    num_left: 0,
    num_right: 0,
    parts: [],
    fingerprint: `${path}:${file.size}:${file.lastModified}`,
  };
}

function from_files(name: string, files: NamedFile[], num_left_out: number): Candidate {
  const images_of = (camera: string): number =>
    files.filter(({ path }) => path.includes(`${camera}/`) && kImage.test(path)).length;
  const has = (word: string): boolean => files.some(({ path }) => path.includes(word));
  const parts = [
    ...["imu0", "ahrs0", "pressure0"].filter((sensor) => has(`${sensor}/`)),
    ...(has("dive.json") ? ["dive_json"] : []),
  ];
  return {
    name,
    filename: `${name}.tar`,
    blob: tar_of(files),
    files,
    is_archive: false,
    num_files: files.length,
    num_left_out,
    num_left: images_of("cam0"),
    num_right: images_of("cam1"),
    parts,
    fingerprint: `${name}:${hash(sorted(files).map(({ path, file }) => `${path}:${file.size}:${file.lastModified}`).join("\n"))}`,
  };
}

// Returns a short hash of a text (cyrb53), to tell the files of one upload from those of another.
export function hash(text: string): string {
  let high = 0xdeadbeef;
  let low = 0x41c6ce57;
  for (let index = 0; index < text.length; index += 1) {
    const code = text.charCodeAt(index);
    high = Math.imul(high ^ code, 2654435761);
    low = Math.imul(low ^ code, 1597334677);
  }
  high = Math.imul(high ^ (high >>> 16), 2246822507) ^ Math.imul(low ^ (low >>> 13), 3266489909);
  low = Math.imul(low ^ (low >>> 16), 2246822507) ^ Math.imul(high ^ (high >>> 13), 3266489909);
  return (4294967296 * (2097151 & low) + (high >>> 0)).toString(36);
}
