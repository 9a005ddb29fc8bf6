import { BufferAttribute, BufferGeometry, Group, Mesh } from "three";
import { value_material } from "./materials";
import type { VertexValues } from "./ply";

// Reads mesh.ply in a worker and returns it as a mesh with the attributes sigma and observations.
export async function values_group(bytes: ArrayBuffer): Promise<{ group: Group; values: VertexValues }> {
  const worker = new Worker(new URL("./ply_worker.ts", import.meta.url), { type: "module" });
  try {
    const values = await new Promise<VertexValues>((resolve, reject) => {
      worker.onmessage = ({ data }: MessageEvent<VertexValues | { error: string }>) =>
        "error" in data ? reject(new Error(data.error)) : resolve(data);
      worker.onerror = (event) => reject(new Error(event.message));
      worker.postMessage(bytes, [bytes]);
    });
    return { group: group_of(values), values };
  } finally {
    worker.terminate();
  }
}

function group_of(values: VertexValues): Group {
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new BufferAttribute(values.position, 3));
  geometry.setAttribute("sigma", new BufferAttribute(values.sigma, 1));
  geometry.setAttribute("observations", new BufferAttribute(values.observations, 1));
  geometry.setIndex(new BufferAttribute(values.index, 1));
  const group = new Group();
  group.add(new Mesh(geometry, value_material("shade")));
  return group;
}
