import preact from "@preact/preset-vite";
import { defineConfig } from "vitest/config";

// The pages of `rumu serve`. Built into the package; not committed.
export default defineConfig({
  plugins: [preact()],
  base: "./", // the pages work under any path of a host: all addresses are relative to the page
  build: {
    outDir: "../src/rumu/web/static",
    emptyOutDir: true,
    modulePreload: { polyfill: false },
    assetsInlineLimit: 0, // the service's Content-Security-Policy forbids inlined assets
    chunkSizeWarningLimit: 900,
  },
  server: { proxy: { "/api": "http://127.0.0.1:8000", "/iiif": "http://127.0.0.1:8000" } },
  // One page for all files: a new one for each took two fifths of the time. What one file has loaded is there for
  // the next, so a module cannot be replaced (`vi.mock`): give a component what a test wants to replace.
  test: { environment: "happy-dom", isolate: false, include: ["tests/**/*.test.{ts,tsx}"], css: true },
});
