// Where questions go: to the server of the page, to the kernel of a notebook, or to WebAssembly in a worker.

import { engine } from "./engine.js";

// A question is refused if its answer takes longer, ms.
const PATIENCE = 15000;

// The server that has sent this page.
export function serverAsk() {
  const token = new URLSearchParams(location.search).get("token") ?? "";
  // The server ends when this stream does.
  const alive = new EventSource(`alive?token=${encodeURIComponent(token)}`);
  addEventListener("pagehide", () => alive.close());
  return async (question) => {
    const reply = await fetch("ask", {
      method: "POST",
      headers: { "Content-Type": "application/json", "X-Standfast-Token": token },
      body: JSON.stringify(question),
      signal: AbortSignal.timeout(PATIENCE),
    }).catch((error) => {
      throw error.name === "TimeoutError" ? new Error("stopped: no answer in time") : new Error("no answer: standfast explore has ended; start it again");
    });
    if (!reply.ok) throw new Error(`the server refuses: ${await reply.text()}`);
    return reply.json();
  };
}

// The kernel of a notebook, through the messages of a widget. A widget may be shown in several cells, which all get its messages.
export function kernelAsk(model) {
  const cell = Math.random().toString(36).slice(2);
  const waiting = new Map();
  let last = 0;
  model.on("msg:custom", ({ id, answer }) => {
    waiting.get(id)?.(JSON.parse(answer));
    waiting.delete(id);
  });
  return (question) => new Promise((resolve) => {
    last += 1;
    const id = `${cell}-${last}`;
    waiting.set(id, resolve);
    model.send({ id, question: JSON.stringify(question) });
  });
}

// The core as WebAssembly, in a worker, which is started again if an answer takes too long. bytes: of the module.
export function wasmAsk(bytes) {
  const program = `${engine}
    let ask;
    onmessage = ({ data }) => {
      if (data.bytes) ask = engine(new WebAssembly.Module(data.bytes));
      else postMessage({ id: data.id, answer: ask(data.question) });
    };`;
  const address = URL.createObjectURL(new Blob([program], { type: "text/javascript" }));
  let worker, last = 0;
  const waiting = new Map();
  const start = () => {
    worker = new Worker(address);
    worker.postMessage({ bytes });
    worker.onmessage = ({ data }) => {
      waiting.get(data.id)?.(JSON.parse(data.answer));
      waiting.delete(data.id);
    };
  };
  start();
  return (question) => new Promise((resolve) => {
    last += 1;
    const id = last;
    const timer = setTimeout(() => {
      worker.terminate();
      for (const answer of waiting.values()) answer({ error: "stopped" });
      waiting.clear();
      start();
    }, PATIENCE);
    waiting.set(id, (answer) => {
      clearTimeout(timer);
      resolve(answer);
    });
    worker.postMessage({ id, question: JSON.stringify(question) });
  });
}
