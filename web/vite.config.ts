import { svelte } from "@sveltejs/vite-plugin-svelte";
import { defineConfig } from "vitest/config";
import { development_session } from "./development_session";

// `npm run dev` serves the page from sources and passes requests on to DIVEMESH_SERVER,
// with the token in DIVEMESH_TOKEN.
const server = process.env.DIVEMESH_SERVER ?? "http://127.0.0.1:8080";
const token = process.env.DIVEMESH_TOKEN ?? "";
const proxy = { target: server, ws: true, headers: token ? { Authorization: `Bearer ${token}` } : {} };

export default defineConfig({
  plugins: [svelte(), development_session(token)],
  server: { proxy: { "/api": proxy, "/healthz": proxy } },
  build: {
    target: "es2022",
    assetsDir: "assets",
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    rollupOptions: { output: { manualChunks: { three: ["three"] } } },
    chunkSizeWarningLimit: 700,
  },
  test: { include: ["tests/**/*.test.ts"] },
});
