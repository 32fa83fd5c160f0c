"""Taking part in a simulation that runs against the clock in another process (docs/exchange.md).

    with UdpPeer(("127.0.0.1", 9000)) as peer:
        while (got := peer.receive()) is not None:
            peer.send({"torque": -40 * got["angle"]}, answers=got.sequence)

This module needs neither the compiled one nor a simulation; `mimbre live MODEL --udp 9000` is the other side."""

from __future__ import annotations

import contextlib
import mmap
import os
import socket
import struct
import time
from collections.abc import Mapping
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from typing_extensions import Self

_magic = 0x31584D4D
_hello, _names, _outputs, _inputs, _bye = 1, 2, 3, 4, 5
_head = struct.Struct("<IHHQQd")
_memory = struct.Struct("<IIQIIIIIIQ")
_block = struct.Struct("<QQd")


@dataclass(frozen=True)
class Outputs:
    """What the simulation gave after a step."""

    names: tuple[str, ...]
    values: NDArray[np.float64]
    #: the number of the step, to be given back with the inputs that answer it
    sequence: int
    #: s, of the simulation
    time: float

    def __getitem__(self, name: str) -> float:
        try:
            return float(self.values[self.names.index(name)])
        except ValueError:
            raise KeyError(f"the simulation gives no '{name}'; it gives {', '.join(self.names)}") from None


class _Names:
    """The names of both directions, as the simulation reports them."""

    def __init__(self, text: str) -> None:
        lines = text.splitlines()
        self.outputs, self.output_units, rest = self._take(lines, "outputs")
        self.inputs, self.input_units, _ = self._take(rest, "inputs")

    @staticmethod
    def _take(lines: list[str], word: str) -> tuple[tuple[str, ...], tuple[str, ...], list[str]]:
        count = int(lines[0].removeprefix(word + " "))
        rows = [(*line.split("\t", 1), "")[:2] for line in lines[1 : count + 1]]
        return tuple(row[0] for row in rows), tuple(row[1] for row in rows), lines[count + 1 :]

    def packed(self, values: Mapping[str, float]) -> NDArray[np.float64]:
        """Those that are not given are not numbers: they stay as they are."""
        packed = np.full(len(self.inputs), np.nan)
        for name, value in values.items():
            if name not in self.inputs:
                raise KeyError(f"the simulation takes no '{name}'; it takes {', '.join(self.inputs) or 'nothing'}")
            packed[self.inputs.index(name)] = value
        return packed


class _Peer:
    """What both have in common."""

    names: _Names

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of what the simulation gives."""
        return self.names.outputs

    @property
    def inputs(self) -> tuple[str, ...]:
        """Names of what it takes."""
        return self.names.inputs

    def close(self) -> None:
        raise NotImplementedError

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class UdpPeer(_Peer):
    """The other side of `mimbre live MODEL --udp PORT`.

    address: host and port of the simulation. timeout: s to wait for packets; raises TimeoutError when nobody
    answers the hello within that."""

    def __init__(self, address: tuple[str, int], timeout: float = 5.0) -> None:
        self._socket = socket.socket(socket.AF_INET6 if ":" in address[0] else socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.connect(address)
        self._layout = 0
        try:
            for _ in range(10):  # a packet may be lost, or the other side not be there yet
                self._socket.settimeout(timeout / 10)
                self._send(_hello, 0, b"", 0)
                if self._listen(timeout / 10):
                    break
            else:
                raise TimeoutError(f"no simulation answers at {address[0]} port {address[1]}")
        except BaseException:
            self._socket.close()
            raise
        self._socket.settimeout(timeout)

    def _listen(self, timeout: float) -> bool:
        until = time.monotonic() + timeout
        try:
            while time.monotonic() < until:  # outputs for another may come all the time
                data = self._socket.recv(65536)
                magic, kind, count, layout, _, _ = _head.unpack_from(data)
                if magic == _magic and kind == _names:
                    self._layout = layout
                    self.names = _Names(data[_head.size : _head.size + count].decode())
                    return True
            return False
        except ConnectionError:
            time.sleep(timeout)
            return False
        except TimeoutError:
            return False

    def receive(self) -> Outputs | None:
        """The next outputs; None when none come within the timeout, or the simulation has ended."""
        try:
            while True:
                data = self._socket.recv(65536)
                magic, kind, count, layout, sequence, when = _head.unpack_from(data)
                if magic == _magic and kind == _outputs and layout == self._layout:
                    values = np.frombuffer(data, "<f8", count, _head.size)
                    return Outputs(self.names.outputs, values, sequence, when)
        except (TimeoutError, ConnectionError):
            return None

    def send(self, values: Mapping[str, float], answers: int = 0) -> None:
        """Sets inputs by their names. answers: the sequence of the outputs that these follow from. Raises
        KeyError for a name that the simulation does not take."""
        packed = self.names.packed(values)
        self._send(_inputs, len(packed), packed.astype("<f8").tobytes(), answers)

    def _send(self, kind: int, count: int, body: bytes, sequence: int) -> None:
        with contextlib.suppress(ConnectionError):  # of a packet before: the other side was not there then
            self._socket.send(_head.pack(_magic, kind, count, self._layout, sequence, 0.0) + body)

    def close(self) -> None:
        """Reports that it wants no more outputs."""
        self._send(_bye, 0, b"", 0)
        self._socket.close()


class SharedPeer(_Peer):
    """The other side of `mimbre live MODEL --shared-memory NAME`, on the same machine (Linux).

    Raises FileNotFoundError where there is no such memory."""

    def __init__(self, name: str) -> None:
        with open(f"/dev/shm/{name}", "r+b") as file:
            self._map = mmap.mmap(file.fileno(), os.fstat(file.fileno()).st_size)
        magic, size, _, outputs, inputs, names, names_size, output_block, input_block, _ = _memory.unpack_from(
            self._map
        )
        if magic != _magic or size != len(self._map):
            raise ValueError(f"/dev/shm/{name} is no memory of a simulation")
        self.names = _Names(self._map[names : names + names_size].decode())
        self._output_block, self._input_block = output_block, input_block
        self._counts = outputs, inputs
        self._sequence = 0

    @property
    def alive(self) -> int:
        """1 before the first step and one more with each; 0 when the simulation has ended."""
        return int(_memory.unpack_from(self._map)[-1])

    def read(self) -> Outputs:
        """The newest outputs; their sequence is 0 before the first step. Raises TimeoutError where the simulation was
        killed while it wrote them."""
        at = self._output_block
        until = time.monotonic() + 1
        while time.monotonic() < until:
            version, sequence, when = _block.unpack_from(self._map, at)
            values = np.frombuffer(self._map[at + _block.size : at + _block.size + 8 * self._counts[0]], "<f8")
            if version % 2 == 0 and _block.unpack_from(self._map, at)[0] == version:
                return Outputs(self.names.outputs, values, sequence, when)
        raise TimeoutError("the outputs are only half written: the simulation was killed")

    def write(self, values: Mapping[str, float]) -> None:
        """Sets inputs by their names, from the next step on; others stay as they are. Raises KeyError for a
        name that the simulation does not take."""
        packed = self.names.packed(values)
        at = self._input_block
        version = _block.unpack_from(self._map, at)[0] | 1
        self._sequence += 1
        struct.pack_into("<Q", self._map, at, version)
        struct.pack_into("<Qd", self._map, at + 8, self._sequence, 0.0)
        self._map[at + _block.size : at + _block.size + 8 * len(packed)] = packed.astype("<f8").tobytes()
        struct.pack_into("<Q", self._map, at, version + 1)

    def close(self) -> None:
        """Lets go of the memory."""
        self._map.close()
