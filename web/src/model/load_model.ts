import { Group, type Material, Mesh, type Texture } from "three";
import { MeshoptDecoder } from "three/examples/jsm/libs/meshopt_decoder.module.js";
import { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
import { acceleratedRaycast, MeshBVH } from "three-mesh-bvh";
import { send } from "../api/client";

// Reads a body and states how much of it has arrived.
export async function read_with_progress(
  address: string,
  size_bytes: number,
  on_fraction: (fraction: number) => void,
  signal: AbortSignal,
): Promise<ArrayBuffer> {
  const response = await send(address, { signal });
  if (!response.body) return response.arrayBuffer();
  const reader = response.body.getReader();
  const bytes = new Uint8Array(size_bytes);
  let length = 0;
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return bytes.buffer.slice(0, length);
    bytes.set(value.subarray(0, size_bytes - length), length);
    length += value.length;
    on_fraction(Math.min(1, length / size_bytes));
  }
}

// Returns the model in the world frame (z up); glTF has y up.
export async function parse_model(bytes: ArrayBuffer): Promise<Group> {
  const loader = new GLTFLoader();
  loader.setMeshoptDecoder(MeshoptDecoder);
  const gltf = await loader.parseAsync(bytes, "");
  const group = new Group();
  group.add(gltf.scene);
  gltf.scene.rotation.x = Math.PI / 2;
  group.updateMatrixWorld(true);
  return group;
}

// Prepares the meshes for picking in far less than a frame.
export function index_for_picking(group: Group): void {
  group.traverse((object) => {
    if (!(object instanceof Mesh)) return;
    object.geometry.boundsTree = new MeshBVH(object.geometry);
    object.raycast = acceleratedRaycast;
  });
}

// Frees the memory of the graphics card.
export function dispose_of(group: Group): void {
  group.traverse((object) => {
    if (!(object instanceof Mesh)) return;
    object.geometry.dispose();
    for (const material of [object.material].flat() as (Material & { map?: Texture | null })[]) {
      material.map?.dispose();
      material.dispose();
    }
  });
}
