/** Names that the build defines in the bundle. */
declare const SHADERS: Record<string, string>;
declare const PACKAGE_VERSION: string;
declare const bundle: () => void;

/** Objects that preload.js leaves for the viewer. */
declare var preloadedAdapter: Promise<GPUAdapter | null> | undefined;
declare var preloadedWorker: { url: string; worker: Worker; messages: MessageEvent[] } | undefined;
