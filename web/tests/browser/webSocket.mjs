// As much of a WebSocket server (RFC 6455) as the tests of the live page need.
import { createHash } from "node:crypto";

const salt = "258EAFA5-E914-47DA-95CA-C5AB0DC85B11";

function frame(kind, payload) {
  const length = payload.length;
  const head = Buffer.alloc(length < 126 ? 2 : length < 65536 ? 4 : 10);
  head[0] = 0x80 | kind;
  if (length < 126) head[1] = length;
  else if (length < 65536) {
    head[1] = 126;
    head.writeUInt16BE(length, 2);
  } else {
    head[1] = 127;
    head.writeBigUInt64BE(BigInt(length), 2);
  }
  return Buffer.concat([head, payload]);
}

/** Accepts an upgrade; whole messages of text arrive at `onText`. */
export function accept(request, socket, protocol) {
  const key = createHash("sha1").update(request.headers["sec-websocket-key"] + salt).digest("base64");
  socket.write(`HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: ${key}\r\nSec-WebSocket-Protocol: ${protocol}\r\n\r\n`);
  socket.setNoDelay(true);
  const peer = {
    onText: () => {},
    onClose: () => {},
    text: (value) => socket.writable && socket.write(frame(1, Buffer.from(JSON.stringify(value)))),
    binary: (bytes) => socket.writable && socket.writableLength < 1e6 && socket.write(frame(2, bytes)),
    close(code) {
      const payload = Buffer.alloc(2);
      payload.writeUInt16BE(code);
      if (socket.writable) socket.end(frame(8, payload));
    },
  };
  let rest = Buffer.alloc(0);
  socket.on("data", (data) => {
    rest = Buffer.concat([rest, data]);
    for (;;) {
      if (rest.length < 2) return;
      const kind = rest[0] & 15;
      let length = rest[1] & 127;
      let at = 2;
      if (length === 126) {
        if (rest.length < 4) return;
        length = rest.readUInt16BE(2);
        at = 4;
      } else if (length === 127) {
        if (rest.length < 10) return;
        length = Number(rest.readBigUInt64BE(2));
        at = 10;
      }
      if (rest.length < at + 4 + length) return;
      const mask = rest.subarray(at, at + 4);
      const payload = Buffer.from(rest.subarray(at + 4, at + 4 + length)).map((byte, k) => byte ^ mask[k % 4]);
      rest = rest.subarray(at + 4 + length);
      if (kind === 1) peer.onText(payload.toString());
      else if (kind === 8) peer.close(1000);
    }
  });
  let gone = false;
  const leave = () => {
    if (!gone) peer.onClose();
    gone = true;
  };
  for (const event of ["close", "end", "error"]) socket.on(event, leave);
  return peer;
}
