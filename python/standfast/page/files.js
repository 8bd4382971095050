// Scenes in addresses, pictures and downloads.

// A scene as the part of an address after "#".
export function encoded(scene) {
  const bytes = new TextEncoder().encode(JSON.stringify(scene));
  return `scene=${btoa(String.fromCharCode(...bytes)).replace(/\+/g, "-").replace(/\//g, "_").replace(/=+$/, "")}`;
}

// The scene in that part of an address; null if there is none. Throws where there is something else.
export function decoded(hash) {
  const text = new URLSearchParams(hash.slice(1)).get("scene");
  if (text === null) return null;
  const bytes = Uint8Array.from(atob(text.replace(/-/g, "+").replace(/_/g, "/")), (c) => c.charCodeAt(0));
  return JSON.parse(new TextDecoder().decode(bytes));
}

// The picture of a stage as PNG, with two pixels for each of the screen.
export async function png(stage) {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(stage.picture())}`;
  await image.decode();
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [2 * stage.width, 2 * stage.height];
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  return new Promise((resolve) => canvas.toBlob(resolve));
}

export function download(name, blob) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
