// @ts-check
// The least and most of the numbers in requests. Written by `python -m tests.page_requests`.

export const LIMITS = {
  speed: { factor: [0.1, 4] },
  arrange: { distance: [0.001, 1000] },
  tune: { value: [-3600, 3600] },
  lengthen: { steps: [-1000, 1000] },
  draw: { parts: [0, 12] },
  perform: { parts: [0, 12] },
}
