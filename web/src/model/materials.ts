import { DataTexture, DoubleSide, LinearFilter, NoColorSpace, RGBAFormat, ShaderMaterial, type Texture } from "three";
import { scale_bytes } from "./color_scale";

let scale: Texture | undefined;

function scale_texture(): Texture {
  if (!scale) {
    const texture = new DataTexture(scale_bytes(), 256, 1, RGBAFormat);
    texture.colorSpace = NoColorSpace;
    texture.minFilter = LinearFilter;
    texture.magFilter = LinearFilter;
    texture.needsUpdate = true;
    scale = texture;
  }
  return scale;
}

// Colours the surface by the height in the world, or by the attribute `shade` of its vertices, with
// the light of a lamp at the eye. Without a scale the surface is grey: its shape alone.
export function value_material(source: "height" | "shade" | "none"): ShaderMaterial {
  return new ShaderMaterial({
    side: DoubleSide,
    clipping: true,
    uniforms: { low: { value: 0 }, high: { value: 1 }, scale: { value: scale_texture() } },
    vertexShader: `
      #include <clipping_planes_pars_vertex>
      ${source === "shade" ? "attribute float shade;" : ""}
      varying float value;
      varying vec3 seen;
      void main() {
        vec4 world = modelMatrix * vec4(position, 1.0);
        value = ${source === "shade" ? "shade" : "world.z"};
        vec4 mvPosition = viewMatrix * world;
        seen = mvPosition.xyz;
        gl_Position = projectionMatrix * mvPosition;
        #include <clipping_planes_vertex>
      }`,
    fragmentShader: `
      #include <clipping_planes_pars_fragment>
      uniform float low;
      uniform float high;
      uniform sampler2D scale;
      varying float value;
      varying vec3 seen;
      void main() {
        #include <clipping_planes_fragment>
        vec3 normal = normalize(cross(dFdx(seen), dFdy(seen)));
        float light = 0.35 + 0.65 * abs(dot(normal, normalize(seen)));
        vec3 color = ${source === "none" ? "vec3(0.78, 0.8, 0.8)" : "texture2D(scale, vec2(clamp((value - low) / max(high - low, 1e-6), 0.0, 1.0), 0.5)).rgb"};
        gl_FragColor = vec4(color * light, 1.0);
      }`,
  });
}
