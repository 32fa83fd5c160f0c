// The page of `mimbre live`: shows a running simulation, and drives it.
import "uplot/dist/uPlot.min.css";
import "./style.css";
import "./live.css";
import { element } from "./dom";
import type { Socket } from "./liveLink";
import { LivePage } from "./livePage";
import { decodeLiveScene, protocol, type PackedLiveScene } from "./liveProtocol";

const page = document.getElementById("page")!;

/** With the token of the page's address, which the server requires where it has one. */
function addressOf(path: string): URL {
  const url = new URL(path, location.href);
  const token = new URLSearchParams(location.search).get("token");
  if (token !== null) url.searchParams.set("token", token);
  return url;
}

async function ask(path: string): Promise<Response> {
  const answer = await fetch(addressOf(path));
  if (answer.status === 403) throw new Error("the server rejected this address; open the address that it printed at its start, with everything after the “?”");
  if (!answer.ok) throw new Error(`the server responded with ${answer.status} ${answer.statusText}`);
  return answer;
}

const fetchScene = async () => (await (await ask("/scene")).json()) as PackedLiveScene;

function open(): Socket {
  const address = addressOf("/ws");
  address.protocol = address.protocol.replace("http", "ws");
  const socket = new WebSocket(address, protocol);
  socket.binaryType = "arraybuffer";
  return socket as Socket;
}

async function start(): Promise<void> {
  const packed = await fetchScene();
  document.title = `${packed.title || "Untitled model"} – mimbre live`;
  page.append(...new LivePage(packed, decodeLiveScene(packed), fetchScene, async () => (await ask("/inputs")).text(), open).parts);
}

start().catch((error: unknown) => {
  console.error(error);
  const again = element("button", {}, "Try again");
  again.addEventListener("click", () => location.reload());
  page.replaceChildren(element("p", { class: "warning", role: "alert" }, `The simulation cannot be shown: ${error instanceof Error ? error.message : error} `, again));
});
