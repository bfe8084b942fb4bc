import { defineConfig } from "vitest/config";

// The built page is committed: it is served without Node and without internet, from whatever path it is put under.
export default defineConfig({
  base: "./",
  build: {
    outDir: "../src/understudy/ui/web/static",
    emptyOutDir: true,
    target: "es2022",
    sourcemap: false,
    modulePreload: { polyfill: false },
    assetsInlineLimit: 0,
    rollupOptions: { input: ["index.html", "recording.html", "driving.html"] },
  },
  test: { css: true }, // style sheets are tested, too: else they are empty
  server: {
    proxy: {
      "/ws": { target: "http://127.0.0.1:8611", ws: true },
      "/library.zip": { target: "http://127.0.0.1:8611" },
    },
  },
});
