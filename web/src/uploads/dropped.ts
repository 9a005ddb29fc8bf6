import type { NamedFile } from "./tar";

// Reads what was dropped or chosen, folders with all that is in them.
export interface Dropped {
  // The folder that was dropped; empty for files that were dropped alone.
  root: string;
  files: NamedFile[];
}

// Returns the entries of a drop, or its files where the browser knows no entries. It must be called
// in the drop's event, before anything is awaited.
export function entries_of(transfer: DataTransfer): (FileSystemEntry | File)[] {
  return [...transfer.items]
    .filter((item) => item.kind === "file")
    .map((item) => item.webkitGetAsEntry() ?? item.getAsFile())
    .filter((entry) => entry !== null);
}

export async function read_entries(entries: (FileSystemEntry | File)[]): Promise<Dropped[]> {
  const loose: Dropped = { root: "", files: [] };
  const dropped: Dropped[] = [];
  for (const entry of entries) {
    if (entry instanceof File) {
      loose.files.push({ path: entry.name, file: entry });
    } else if (entry.isDirectory) {
      const files: NamedFile[] = [];
      await walk(entry as FileSystemDirectoryEntry, "", files);
      dropped.push({ root: entry.name, files });
    } else {
      loose.files.push({ path: entry.name, file: await file_of(entry as FileSystemFileEntry) });
    }
  }
  return loose.files.length > 0 ? [loose, ...dropped] : dropped;
}

// Returns the files of an <input type="file">, of a folder where it chose one.
export function read_input(input: HTMLInputElement): Dropped[] {
  const files = [...(input.files ?? [])];
  const folders = new Map<string, NamedFile[]>();
  for (const file of files) {
    const parts = file.webkitRelativePath.split("/");
    const root = parts.length > 1 ? (parts[0] ?? "") : "";
    const path = parts.length > 1 ? parts.slice(1).join("/") : file.name;
    folders.set(root, [...(folders.get(root) ?? []), { path, file }]);
  }
  return [...folders].map(([root, named]) => ({ root, files: named }));
}

async function walk(folder: FileSystemDirectoryEntry, prefix: string, files: NamedFile[]): Promise<void> {
  const reader = folder.createReader();
  for (;;) {
    const batch = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
    if (batch.length === 0) return;
    for (const entry of batch) {
      const path = prefix + entry.name;
      if (entry.isDirectory) await walk(entry as FileSystemDirectoryEntry, `${path}/`, files);
      else files.push({ path, file: await file_of(entry as FileSystemFileEntry) });
    }
  }
}

function file_of(entry: FileSystemFileEntry): Promise<File> {
  return new Promise((resolve, reject) => entry.file(resolve, reject));
}
