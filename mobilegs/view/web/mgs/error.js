/** The one class that every refusal of a file throws: one sentence, what is wrong and where. */
export class SceneError extends Error {
  name = "SceneError";
}
