// The engine in a page, a worker or Node: `const ask = engine(module)` with a WebAssembly.Module; then `ask(question)` is the answer, both
// JSON texts. After a panic of the engine, which no question should cause, the next question finds a new instance.
export function engine(module) {
  let exports = null;
  return (question) => {
    exports ??= new WebAssembly.Instance(module).exports;
    const { alloc, free, ask, memory } = exports;
    try {
      const bytes = new TextEncoder().encode(question);
      // Pointers are unsigned; JavaScript sees the upper half of the memory as negative numbers.
      const asked = alloc(bytes.length) >>> 0;
      new Uint8Array(memory.buffer, asked, bytes.length).set(bytes);
      const answered = ask(asked, bytes.length) >>> 0;
      free(asked, bytes.length);
      // The memory may have grown, and then its buffer is another one.
      const length = new DataView(memory.buffer).getUint32(answered, true);
      const answer = new TextDecoder().decode(new Uint8Array(memory.buffer, answered + 4, length));
      free(answered, 4 + length);
      return answer;
    } catch (error) {
      exports = null;
      return JSON.stringify({ error: `the engine stopped: ${error.message}` });
    }
  };
}
