import preact from "@preact/preset-vite";
import { defineConfig } from "vite";

// The viewer alone, as one script without modules: `rumu gallery export --html` writes it into a page that can be opened from a disk.
export default defineConfig({
  plugins: [preact()],
  define: { "process.env.NODE_ENV": '"production"' },
  build: {
    outDir: "../src/rumu/web/static",
    emptyOutDir: false,
    copyPublicDir: false,
    cssCodeSplit: false,
    chunkSizeWarningLimit: 900,
    lib: {
      entry: "standalone/main.ts",
      formats: ["iife"],
      name: "rumuViewer",
      fileName: () => "standalone.js",
      cssFileName: "standalone",
    },
  },
});
