/** Names that the build defines in the bundle. */
declare const SHADERS: Record<string, string>;
declare const PACKAGE_VERSION: string;
declare const CHUNKS: Record<string, string>;
declare const WEBGL_CHUNK: string;
declare const PACKED_WORKER: string;
declare const PACKED_SHADERS: string;
declare const PACKED_TEXTS: string;
declare const bundle: () => void;

/** The address of `viewer.js`, in workers that run its source text. */
declare var viewerAddress: string | undefined;

/** Objects that preload.js leaves for the viewer. */
declare var preloadedAdapter: Promise<GPUAdapter | null> | undefined;
declare var preloadedWorker: { url: string; worker: Worker; messages: MessageEvent[] } | undefined;

/** What only workers have. */
declare var WorkerGlobalScope: object | undefined;
