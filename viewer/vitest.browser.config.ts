import { defineConfig } from 'vitest/config';

/** Tests that drive the built page in a real browser; one file at a time, the pictures are drawn in software. */
export default defineConfig({
  test: {
    include: ['browser/**/*.test.ts'],
    environment: 'node',
    fileParallelism: false,
    testTimeout: 150_000,
    hookTimeout: 120_000,
  },
});
