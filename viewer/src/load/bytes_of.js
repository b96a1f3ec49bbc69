/** Opens the file of a scene. */

/**
 * The bytes of a scene, and how many; NaN while that is unknown.
 *
 * @param {{url: string} | {file: Blob}} request
 * @param {AbortSignal} [signal]
 * @returns {Promise<{source: ReadableStream<Uint8Array<ArrayBuffer>>, total: number}>}
 */
export async function bytesOf(request, signal) {
  if ("file" in request) return { source: request.file.stream(), total: request.file.size };
  let response;
  try {
    response = await fetch(request.url, { signal });
  } catch {
    signal?.throwIfAborted();
    throw new Error(
      `${request.url} cannot be reached: is the address right, the network there, and may this site load it (CORS)?`,
    );
  }
  if (!response.ok || response.body === null) {
    throw new Error(`${request.url} could not be loaded: the server says ${response.status}`);
  }
  // Content-Length counts compressed bytes where the transfer is compressed
  const length = response.headers.has("Content-Encoding") ? NaN : Number(response.headers.get("Content-Length"));
  return { source: response.body, total: length || NaN };
}
