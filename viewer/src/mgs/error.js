/** Control characters, line ends, unpaired surrogates. */
const UNSHOWN = /[\x00-\x1f\x7f-\x9f\u2028\u2029\p{Cs}]/gu;

/** A malformed or unsupported file; the message says in one sentence what is wrong and where. */
export class SceneError extends Error {
  name = "SceneError";

  /** @param {string} message may quote the file: control characters are replaced */
  constructor(message) {
    super(message.replace(UNSHOWN, "\ufffd"));
  }
}
