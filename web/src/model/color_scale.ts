// The colours of heights and other values: cividis, which also reads without red or green.
const kStops = ["#00224e", "#123570", "#3b496c", "#575d6d", "#707173", "#8a8678", "#a59c74", "#c3b369", "#e1cc55", "#fee838"];

export const kGradient = `linear-gradient(to right, ${kStops.join(", ")})`;

// Returns the scale as bytes of a texture of 256 x 1.
export function scale_bytes(): Uint8Array {
  const colors = kStops.map((stop) => [1, 3, 5].map((at) => parseInt(stop.slice(at, at + 2), 16)));
  const bytes = new Uint8Array(256 * 4);
  for (let index = 0; index < 256; index += 1) {
    const place = (index / 255) * (colors.length - 1);
    const low = Math.min(Math.floor(place), colors.length - 2);
    const [from, to] = [colors[low] as number[], colors[low + 1] as number[]];
    for (let channel = 0; channel < 3; channel += 1) {
      const mixed = (from[channel] as number) + (place - low) * ((to[channel] as number) - (from[channel] as number));
      bytes[4 * index + channel] = Math.round(mixed);
    }
    bytes[4 * index + 3] = 255;
  }
  return bytes;
}
