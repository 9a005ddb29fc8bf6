import { expect, it } from "vitest";
import { identity_of } from "../src/uploads/identity";
import { candidates_of } from "../src/uploads/candidates";

const file = (path: string) => ({ path, file: new File(["x"], path, { lastModified: 1 }) });

it("finds each dive in a folder of dives and leaves out what desktops add", () => {
  const found = candidates_of([
    { root: "week", files: [file("a/mav0/cam0/data/1.png"), file("a/mav0/cam1/data/1.png"), file("b/mav0/cam0/data/1.png"), file("a/.DS_Store")] },
  ]);
  expect(found.map(({ name, num_left, num_right, num_files }) => [name, num_left, num_right, num_files])).toEqual([
    ["a", 1, 1, 2],
    ["b", 1, 0, 1],
  ]);
});

it("sends an archive as it is, and knows it again", () => {
  const [first] = candidates_of([{ root: "", files: [file("dive.tar.zst")] }]);
  const [again] = candidates_of([{ root: "", files: [file("dive.tar.zst")] }]);
  expect(first?.is_archive).toBe(true);
  expect(first?.name).toBe("dive");
  expect(again?.fingerprint).toBe(first?.fingerprint);
});

it("puts mav0 back before the paths of a folder mav0", () => {
  const [candidate] = candidates_of([{ root: "mav0", files: [file("cam0/data/1.png"), file("imu0/data.csv")] }]);
  expect(candidate?.parts).toEqual(["imu0"]);
  expect(candidate?.num_left).toBe(1);
});

// The identity is compared with what sha256sum makes of the same files.
it("knows a dive by the hash of its files", async () => {
  const files = [
    { path: "mav0/cam1/data.csv", file: new File(["b\n"], "data.csv") },
    { path: "mav0/cam0/data.csv", file: new File(["a\n"], "data.csv") },
    { path: "dive.json", file: new File(["{}\n"], "dive.json") },
  ];
  expect(await identity_of(files)).toBe("ec713cc795f315efc1ef3b4310c7f864a12265e54a3d9f74875b9b3359ed10b4");
  expect(await identity_of([{ path: "left.mp4", file: new File(["x"], "left.mp4") }])).toBeUndefined();
});
