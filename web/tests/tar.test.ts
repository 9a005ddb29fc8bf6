import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, it } from "vitest";
import { tar_of } from "../src/uploads/tar";

// The archive is compared with what GNU tar makes of it.
it("is read by tar, with long and foreign names", async () => {
  const folder = mkdtempSync(join(tmpdir(), "divemesh-tar-"));
  try {
    const long = `mav0/cam0/data/${"a".repeat(140)}.png`;
    const files = [
      { path: "mav0/cam0/data.csv", file: new File(["1,a.png\n"], "data.csv") },
      { path: long, file: new File([new Uint8Array(700)], "a.png") },
      { path: "notes/Überfahrt.txt", file: new File(["x"], "x") },
    ];
    const archive = join(folder, "dive.tar");
    writeFileSync(archive, new Uint8Array(await tar_of(files).arrayBuffer()));
    execFileSync("tar", ["-xf", archive, "-C", folder]);
    expect(readFileSync(join(folder, "mav0/cam0/data.csv"), "utf8")).toBe("1,a.png\n");
    expect(readFileSync(join(folder, long)).length).toBe(700);
    expect(readFileSync(join(folder, "notes/Überfahrt.txt"), "utf8")).toBe("x");
  } finally {
    rmSync(folder, { recursive: true });
  }
});
