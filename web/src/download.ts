// Files made by the page.

export function save(name: string, content: Blob): void {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(content);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Of the page's title, with what may stand in a file's name. */
export function fileName(what: string, ending: string): string {
  const stem = document.title.replace(/ – mimbre.*$/, "").replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "").slice(0, 60);
  return `${stem || "mimbre"}-${what}.${ending}`;
}

export function saveCanvas(canvas: HTMLCanvasElement, what: string): void {
  canvas.toBlob((blob) => blob && save(fileName(what, "png"), blob), "image/png");
}
