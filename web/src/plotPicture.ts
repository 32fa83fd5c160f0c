// The charts of a view, with their legends, on one canvas.
import { themeColor } from "./dom";

export function pictureOf(view: HTMLElement): HTMLCanvasElement | null {
  const figures = [...view.querySelectorAll("figure")];
  const charts = figures.map((figure) => figure.querySelector<HTMLCanvasElement>("canvas")).filter((chart): chart is HTMLCanvasElement => chart !== null);
  if (charts.length === 0) return null;
  const ratio = devicePixelRatio;
  const line = 20 * ratio;
  const margin = 12 * ratio;
  const canvas = document.createElement("canvas");
  canvas.width = Math.max(...charts.map(({ width }) => width)) + 2 * margin;
  const context = canvas.getContext("2d")!;
  const font = `${12 * ratio}px system-ui, sans-serif`;
  context.font = font;
  // The legends are wrapped as on the page.
  const legends = figures.map((figure) => {
    let x = margin;
    let row = 0;
    return [...figure.querySelectorAll<HTMLElement>(".entry")].map((entry) => {
      const swatch = entry.querySelector<HTMLElement>(".swatch");
      const text = [...entry.childNodes].filter((node) => node.nodeType === Node.TEXT_NODE).map((node) => node.textContent).join("");
      const width = context.measureText(text).width + 36 * ratio;
      if (x + width > canvas.width && x > margin) [x, row] = [margin, row + 1];
      const at = { text, x, row, color: swatch?.style.getPropertyValue("--line") ?? "" };
      x += width;
      return at;
    });
  });
  const legendHeight = legends.map((entries) => line * (1 + (entries[entries.length - 1]?.row ?? 0)));
  canvas.height = charts.reduce((sum, { height }, k) => sum + height + legendHeight[k] + margin, margin);
  context.fillStyle = themeColor("card");
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.font = font;
  context.textBaseline = "middle";
  let y = margin;
  charts.forEach((chart, k) => {
    for (const { text, x, row, color } of legends[k]) {
      const middle = y + (row + 0.5) * line;
      context.fillStyle = color;
      context.fillRect(x, middle - 1.5 * ratio, 14 * ratio, 3 * ratio);
      context.fillStyle = themeColor("text");
      context.fillText(text, x + 20 * ratio, middle);
    }
    y += legendHeight[k];
    context.drawImage(chart, margin, y);
    y += chart.height + margin;
  });
  return canvas;
}
