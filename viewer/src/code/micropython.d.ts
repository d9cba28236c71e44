declare module '@micropython/micropython-webassembly-pyscript/micropython.mjs' {
  export interface MicroPython {
    registerJsModule(name: string, module: object): void;
    runPython(program: string): unknown;
    runPythonAsync(program: string): Promise<unknown>;
  }
  export function loadMicroPython(options: {
    url: string;
    /** Bytes. */
    heapsize: number;
    stdout: (line: string) => void;
    stderr: (line: string) => void;
    linebuffer: boolean;
  }): Promise<MicroPython>;
}
