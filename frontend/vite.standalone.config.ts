import { defineConfig } from "vite";

// The viewer alone, as one script without modules: `rumu gallery export --html` puts it into a page that opens from a disk.
export default defineConfig({
  build: {
    outDir: "../src/rumu/web/static",
    emptyOutDir: false,
    copyPublicDir: false,
    cssCodeSplit: false,
    lib: {
      entry: "standalone/main.ts",
      formats: ["iife"],
      name: "rumuViewer",
      fileName: () => "standalone.js",
      cssFileName: "standalone",
    },
  },
});
