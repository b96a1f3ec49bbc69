/** Long computations in pieces, between which messages are handled. */

/** Milliseconds between two yields. */
const PATIENCE = 8;

/** Time of the last yield. */
let last = 0;

/** Let waiting messages be handled, at most every 8 ms: a yield takes a millisecond or two. */
export async function yieldToMessages() {
  if (performance.now() - last < PATIENCE) return;
  const { port1, port2 } = new MessageChannel();
  await new Promise((resolve) => {
    port1.onmessage = () => {
      port1.close();
      resolve(null);
    };
    port2.postMessage(null);
  });
  last = performance.now();
}
