// A block of examples is copied as code that can be run: without its prompts and without what it prints.
document.addEventListener(
  "click",
  (event) => {
    const button = event.target.closest("[data-clipboard-target]");
    const block = button && document.querySelector(button.dataset.clipboardTarget);
    if (!block) return;
    const prompt = /^(>>> ?|\.\.\. ?|\$ )/;
    const lines = block.textContent.split("\n");
    if (!lines.some((line) => /^(>>>|\$ )/.test(line))) return;
    // An interactive Python takes a loop only with an empty line behind it.
    const code = lines
      .filter((line) => prompt.test(line))
      .map((line, k, all) => (line.startsWith(">>>") && all[k - 1]?.startsWith("...") ? "\n" : "") + line.replace(prompt, ""));
    button.dataset.clipboardText = `${code.join("\n")}\n`;
  },
  true,
);
