import { values_of } from "./ply";

// Reads a mesh in a thread of its own, so that the page stays fluent.
self.onmessage = (message: MessageEvent<ArrayBuffer>) => {
  try {
    const values = values_of(message.data);
    const buffers = [values.position.buffer, values.sigma.buffer, values.observations.buffer, values.index.buffer];
    self.postMessage(values, { transfer: buffers as ArrayBuffer[] });
  } catch (thrown) {
    self.postMessage({ error: thrown instanceof Error ? thrown.message : String(thrown) });
  }
};
