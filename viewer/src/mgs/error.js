/** Control characters, ends of lines, halves of a pair. */
const UNSHOWN = /[\x00-\x1f\x7f-\x9f\u2028\u2029\p{Cs}]/gu;

/** The one class that every refusal of a file throws: one sentence, what is wrong and where. */
export class SceneError extends Error {
  name = "SceneError";

  /** @param {string} message may quote the file: what a terminal obeys, or nothing shows, is replaced */
  constructor(message) {
    super(message.replace(UNSHOWN, "\ufffd"));
  }
}
