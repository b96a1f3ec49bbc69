/** The version of the package, which the build defines. */
declare const PACKAGE_VERSION: string;

/** Base64 of a deflated text, which the build makes: a worker, or the shaders of a language as JSON. */
declare module "*.packed.js" {
  export const text: string;
}

/** Objects that preload.js leaves for the viewer. */
declare var preloadedAdapter: Promise<GPUAdapter | null> | undefined;
declare var preloadedWorker: { url: string; worker: Worker; messages: MessageEvent[] } | undefined;

/** Members that only workers have. */
declare var WorkerGlobalScope: object | undefined;
