// Where rays meet the surface of a mesh.ply, computed without the page.
import { add, scale, subtract } from "./world_of_truth.mjs";

const cross = ([a, b, c], [d, e, f]) => [b * f - c * e, c * d - a * f, a * e - b * d];
const dot = (a, b) => a.reduce((sum, value, axis) => sum + value * b[axis], 0);

// Returns the triangles of a binary little-endian PLY as triples of points.
export function triangles_of(bytes) {
  const end = bytes.indexOf("end_header\n") + "end_header\n".length;
  const header = bytes.subarray(0, end).toString("latin1").split("\n");
  const count = (element) => Number(header.find((line) => line.startsWith(`element ${element} `)).split(" ")[2]);
  const sizes = { float: 4, uint: 4, int: 4, uchar: 1 };
  const before_faces = header.slice(0, header.findIndex((line) => line.startsWith("element face")));
  const stride = before_faces.filter((line) => line.startsWith("property ")).reduce((sum, line) => sum + sizes[line.split(" ")[1]], 0);
  const vertex = (index) => [0, 4, 8].map((offset) => bytes.readFloatLE(end + index * stride + offset));
  const faces = end + count("vertex") * stride;
  return Array.from({ length: count("face") }, (_, face) => [1, 5, 9].map((offset) => vertex(bytes.readInt32LE(faces + 13 * face + offset))));
}

// Returns the first point of the triangles on the ray from `eye` through `through` (Moeller and Trumbore 1997).
export function first_hit(triangles, eye, through) {
  const direction = subtract(through, eye);
  let nearest = Infinity;
  for (const [a, b, c] of triangles) {
    const [u, v] = [subtract(b, a), subtract(c, a)];
    const across = cross(direction, v);
    const determinant = dot(u, across);
    if (Math.abs(determinant) < 1e-15) continue;
    const from_a = subtract(eye, a);
    const first = dot(from_a, across) / determinant;
    const turned = cross(from_a, u);
    const second = dot(direction, turned) / determinant;
    const range = dot(v, turned) / determinant;
    if (first >= 0 && second >= 0 && first + second <= 1 && range > 1e-6 && range < nearest) nearest = range;
  }
  return add(eye, scale(direction, nearest));
}
