#!/usr/bin/env python3
"""Attacks a running `mimbre live`: malformed, oversized and fragmented HTTP and WebSocket messages, connections that
vanish, say nothing or read nothing, pages of other origins that want control. Tells the monitor of the steps before,
during and after, and the memory of the process.

    mimbre live MODEL --port 8000 --no-open &
    python3 fuzz/attack_live.py 8000 --messages 100000 --process $!

Exit code 1 where the server stops answering, a stranger gets control, or the memory grows by more than 64 MB."""

import argparse
import base64
import json
import random
import socket
import struct
import sys
import time
import urllib.request
from pathlib import Path


def connect(port: int) -> socket.socket:
    return socket.create_connection(("127.0.0.1", port), timeout=5)


def status(port: int) -> dict:
    with urllib.request.urlopen(f"http://127.0.0.1:{port}/status", timeout=10) as answer:
        return json.load(answer)


def request(port: int, path: str = "/status", more: str = "") -> bytes:
    return f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{port}\r\n{more}\r\n".encode()


def upgrade(port: int, more: str = "") -> bytes:
    key = base64.b64encode(random.randbytes(16)).decode()
    fields = (
        f"Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n{more}"
    )
    return request(port, "/ws", fields)


def frame(payload: bytes, opcode: int = 1, final: bool = True, masked: bool = True, length: int | None = None) -> bytes:
    size = len(payload) if length is None else length
    head = bytes([(0x80 if final else 0) | opcode])
    bit = 0x80 if masked else 0
    if size < 126:
        head += bytes([bit | size])
    elif size < 65536:
        head += bytes([bit | 126]) + struct.pack(">H", size)
    else:
        head += bytes([bit | 127]) + struct.pack(">Q", size)
    if not masked:
        return head + payload
    mask = random.randbytes(4)
    return head + mask + bytes(b ^ mask[k % 4] for k, b in enumerate(payload))


def websocket(port: int, more: str = "") -> socket.socket | None:
    wire = connect(port)
    wire.sendall(upgrade(port, more))
    answer = b""
    while b"\r\n\r\n" not in answer:
        got = wire.recv(4096)
        if not got:
            break
        answer += got
    if b" 101 " in answer.split(b"\r\n", 1)[0]:
        return wire
    wire.close()
    return None


words = [
    b"",
    b"{",
    b"[]",
    b"null",
    b'{"do":1}',
    b'{"do":"pause"}',
    b'{"do":"reset"}',
    b'{"do":"inputs","values":{"steering":1}}',
    b'{"do":"channels","indices":[0,1,2,-5]}',
    b'{"do":"channels","indices":' + b"[" * 1000,
    b'{"do":"snapshot","name":"' + b"x" * 5000,
    b'{"do":"play","tracks":{"steering":{"times":[1e999],"values":[0]}}}',
    b'{"do":"record","on":true}',
    b"\xff\xfe\x00",
]


def bad_http(port: int) -> bytes:
    kind = random.randrange(8)
    good = request(port)
    if kind == 0:
        return random.randbytes(random.randrange(1, 2000))
    if kind == 1:
        return request(port, "/" + "a" * random.choice([10, 4000, 100_000]))
    if kind == 2:
        return request(port, more="X: " + "y" * random.choice([100, 9000, 200_000]) + "\r\n")
    if kind == 3:
        return good[: random.randrange(len(good))]
    if kind == 4:
        return request(port, more="Content-Length: 99999999999\r\n") + b"z" * 1000
    if kind == 5:
        return request(port, more="Transfer-Encoding: chunked\r\n") + b"FFFFFFFFFFFFFFFF\r\n" + b"z" * 100
    if kind == 6:
        return good.replace(b"GET", random.choice([b"PUT", b"G\x00T", b"POST", b"OPTIONS", b""]))
    mangled = bytearray(good)
    for _ in range(random.randrange(1, 6)):
        mangled[random.randrange(len(mangled))] = random.randrange(256)
    return bytes(mangled)


def bad_frame() -> bytes:
    kind = random.randrange(8)
    word = random.choice(words)
    if kind == 0:
        return frame(word)
    if kind == 1:
        return frame(word, opcode=random.randrange(16))
    if kind == 2:
        return frame(word, masked=False)
    if kind == 3:
        return frame(word, length=random.choice([2**31, 2**62, 2**63 - 1]))
    if kind == 4:
        return b"".join(
            frame(word[k : k + 1] or b"x", opcode=0 if k else 1, final=False) for k in range(min(len(word), 50))
        )
    if kind == 5:
        return random.randbytes(random.randrange(1, 300))
    if kind == 6:
        return frame(b"p" * random.choice([100, 125, 126, 1000]), opcode=random.choice([8, 9, 10]))
    return frame(b'"' * 70_000)


def push(wire: socket.socket, data: bytes) -> bool:
    """In pieces now and then. False where the other side has closed."""
    try:
        if random.random() < 0.2:
            for k in range(0, min(len(data), 64), 7):
                wire.sendall(data[k : k + 7])
            data = data[70:]
        wire.sendall(data)
    except OSError:
        return False
    return True


def memory(process: int | None) -> float:
    """MB."""
    if process is None:
        return 0
    for line in Path(f"/proc/{process}/status").read_text().splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    return 0


def tell(port: int, process: int | None, what: str) -> dict:
    now = status(port)
    cpu = {name: f"{1e3 * now['cpu'][name]:.3f}" for name in ("median", "p9999", "worst")}
    overruns, size = now["overruns"]["count"], memory(process)
    print(f"{what:28s} steps {now['steps']:9d}, CPU ms {cpu}, overruns {overruns}, {size:.1f} MB", flush=True)
    return now


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("port", type=int)
    parser.add_argument("--messages", type=int, default=100_000)
    parser.add_argument("--connections", type=int, default=200)
    parser.add_argument("--process", type=int)
    parser.add_argument("--seed", type=int, default=1)
    a = parser.parse_args()
    random.seed(a.seed)
    tell(a.port, a.process, "before")
    before = memory(a.process)

    sent = 0
    while sent < a.messages // 2:  # HTTP
        try:
            with connect(a.port) as wire:
                for _ in range(random.randrange(1, 4)):
                    sent += 1
                    if not push(wire, bad_http(a.port)):
                        break
        except OSError:
            continue
    tell(a.port, a.process, f"{sent} HTTP requests")
    while sent < a.messages:  # WebSocket
        try:
            wire = websocket(a.port)
            if wire is None:
                time.sleep(0.01)
                continue
            with wire:
                for _ in range(60):
                    sent += 1
                    if not push(wire, bad_frame()):
                        break
        except OSError:
            continue
    tell(a.port, a.process, f"{sent} messages in all")

    held = []
    for k in range(a.connections):  # that say nothing, half of something, or read nothing
        try:
            wire = websocket(a.port) if k % 4 == 0 else connect(a.port)
            if wire is None:
                continue
            if k % 4 == 1:
                wire.sendall(request(a.port, "/scene") * 20)
            if k % 4 == 2:
                wire.sendall(request(a.port)[:20])
            held.append(wire)
        except OSError:
            pass
    print(f"{len(held)} of {a.connections} connections are held")
    time.sleep(15)
    for wire in held[::2]:  # vanish, with a reset
        wire.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        wire.close()
    time.sleep(5)
    for wire in held[1::2]:
        wire.close()
    time.sleep(2)
    strangers = sum(
        websocket(a.port, f"Origin: {origin}\r\n") is not None
        for origin in (
            "http://evil.example",
            f"http://evil.example:{a.port}",
            "null",
            f"http://127.0.0.1:{a.port + 1}",
            "file://",
        )
    )
    after = tell(a.port, a.process, "after")
    grown = memory(a.process) - before
    print(f"pages of other origins that got in: {strangers}; memory grew by {grown:.1f} MB; state {after['state']}")
    return int(strangers > 0 or grown > 64 or after["state"] != "running")


if __name__ == "__main__":
    sys.exit(main())
