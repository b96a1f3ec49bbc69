// What TypeScript's own description of the browser lacks of WebGPU.
declare const GPUBufferUsage: Record<
  "VERTEX" | "MAP_READ" | "COPY_SRC" | "COPY_DST" | "INDEX" | "UNIFORM" | "STORAGE" | "INDIRECT" | "QUERY_RESOLVE",
  number
>;
declare const GPUTextureUsage: Record<"COPY_SRC" | "COPY_DST" | "TEXTURE_BINDING" | "RENDER_ATTACHMENT", number>;
declare const GPUMapMode: Record<"READ", number>;
