// Reads what the page colours by from mesh.ply: binary little-endian, triangles.
export interface VertexValues {
  position: Float32Array;
  sigma: Float32Array;
  observations: Float32Array;
  index: Uint32Array;
}

const kSizes: Record<string, number> = { char: 1, uchar: 1, short: 2, ushort: 2, int: 4, uint: 4, float: 4, double: 8, int8: 1, uint8: 1, int16: 2, uint16: 2, int32: 4, uint32: 4, float32: 4, float64: 8 };

interface Header {
  num_vertices: number;
  num_faces: number;
  stride: number;
  offsets: Map<string, number>;
  start: number;
}

export function values_of(bytes: ArrayBuffer): VertexValues {
  const header = header_of(bytes);
  const view = new DataView(bytes);
  const { num_vertices, stride, start } = header;
  const at = (name: string): number => {
    const offset = header.offsets.get(name);
    if (offset === undefined) throw new Error(`mesh.ply has no vertex property ${name}`);
    return offset;
  };
  const [x, sigma_at, count_at] = [at("x"), at("sigma"), at("num_observations")];
  const position = new Float32Array(3 * num_vertices);
  const sigma = new Float32Array(num_vertices);
  const observations = new Float32Array(num_vertices);
  for (let vertex = 0; vertex < num_vertices; vertex += 1) {
    const row = start + vertex * stride;
    for (let axis = 0; axis < 3; axis += 1) position[3 * vertex + axis] = view.getFloat32(row + x + 4 * axis, true);
    sigma[vertex] = view.getFloat32(row + sigma_at, true);
    observations[vertex] = view.getUint32(row + count_at, true);
  }
  return { position, sigma, observations, index: triangles_of(view, header) };
}

function header_of(bytes: ArrayBuffer): Header {
  const text = new TextDecoder("latin1").decode(bytes.slice(0, 4096));
  const end = text.indexOf("end_header\n");
  if (end < 0 || !text.includes("format binary_little_endian")) throw new Error("mesh.ply is not a binary little-endian PLY file");
  const header: Header = { num_vertices: 0, num_faces: 0, stride: 0, offsets: new Map(), start: end + "end_header\n".length };
  let element = "";
  for (const line of text.slice(0, end).split("\n")) {
    const words = line.split(" ");
    if (words[0] === "element") {
      element = words[1] ?? "";
      if (element === "vertex") header.num_vertices = Number(words[2]);
      if (element === "face") header.num_faces = Number(words[2]);
    } else if (words[0] === "property" && element === "vertex") {
      header.offsets.set(words[2] ?? "", header.stride);
      header.stride += kSizes[words[1] ?? ""] ?? 0;
    }
  }
  return header;
}

function triangles_of(view: DataView, { num_vertices, num_faces, stride, start }: Header): Uint32Array {
  const index = new Uint32Array(3 * num_faces);
  let offset = start + num_vertices * stride;
  for (let face = 0; face < num_faces; face += 1) {
    if (view.getUint8(offset) !== 3) throw new Error("mesh.ply has a face that is no triangle");
    for (let corner = 0; corner < 3; corner += 1) index[3 * face + corner] = view.getInt32(offset + 1 + 4 * corner, true);
    offset += 13;
  }
  return index;
}

// Returns the sigma of the vertex nearest to a point; nothing where none is within the reach.
export function sigma_near({ position, sigma }: VertexValues, [x, y, z]: readonly [number, number, number], reach_m: number): number | undefined {
  let nearest = -1;
  let least = reach_m ** 2;
  for (let vertex = 0; vertex < sigma.length; vertex += 1) {
    const dx = (position[3 * vertex] as number) - x;
    const dy = (position[3 * vertex + 1] as number) - y;
    const dz = (position[3 * vertex + 2] as number) - z;
    const squared = dx * dx + dy * dy + dz * dz;
    if (squared >= least) continue;
    least = squared;
    nearest = vertex;
  }
  return nearest < 0 ? undefined : sigma[nearest];
}

// Returns the values below which the given shares of them lie.
export function quantiles(values: Float32Array, shares: number[]): number[] {
  const sorted = Float32Array.from(values).sort();
  return shares.map((share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? 0);
}
