"""The Python side of the exchange with `mimbre live`, against the real program."""

import json
import random
import shutil
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import mimbre
import pytest
from mimbre.exchange import SharedPeer, UdpPeer

patience = 120  # s, much: the machine may have other work


@contextmanager
def live(model: str, folder: Path, *options: str) -> Iterator[subprocess.Popen[str]]:
    file = folder / "rod.yaml"
    file.write_text(model)
    words = [sys.executable, "-m", "mimbre", "live", str(file), "--no-open", "--no-lock", "--json", *options]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        assert process.stdout
        assert process.stdout.readline().startswith("http://127.0.0.1:")
        yield process
    finally:
        process.terminate()
        process.wait(patience)


def summary(process: subprocess.Popen[str]) -> dict[str, object]:
    """Of a simulation that is ended."""
    process.send_signal(signal.SIGINT)
    out, error = process.communicate(timeout=patience)
    assert process.returncode == 0, error
    result: dict[str, object] = json.loads(out)
    return result


def free_port() -> int:
    """Below those that systems give to whoever asks for any: nobody takes it meanwhile."""
    while True:
        port = random.randrange(20_000, 32_000)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as some:
            try:
                some.bind(("127.0.0.1", port))
            except OSError:
                continue
            return port


def test_a_controller_by_udp_holds_the_rod(rod: str, tmp_path: Path) -> None:
    port = free_port()
    with live(rod, tmp_path, "--udp", str(port), "--udp-wait", "10") as process:
        last = None
        with UdpPeer(("127.0.0.1", port), timeout=patience) as peer:
            assert peer.outputs == ("angle",)
            assert peer.inputs == ("torque",)
            with pytest.raises(KeyError, match="takes no 'force'"):
                peer.send({"force": 1})
            before = None
            for _ in range(1500):  # 3 s, from whenever this program has its turn
                got = peer.receive()
                assert got is not None
                rate = 0.0 if before is None else (got["angle"] - before) / 0.002
                before = got["angle"]
                peer.send({"torque": -60 * got["angle"] - 6 * rate}, answers=got.sequence)
                last = got
        assert last is not None
        # Weight at half a metre against the spring of the controller.
        assert abs(last["angle"]) < 0.15
        told = summary(process)
        assert isinstance(told["udp"], dict)
        assert told["udp"]["answers"] > 1000
        assert told["udp"]["refused"] == 0


def test_shared_memory_hands_values_both_ways(rod: str, tmp_path: Path) -> None:
    name = f"mimbre-test-{free_port()}"
    with pytest.raises(FileNotFoundError):
        SharedPeer(name)
    with live(rod, tmp_path, "--shared-memory", name, "--speed", "0.5") as process:
        with SharedPeer(name) as peer:
            assert peer.outputs == ("angle",)
            peer.write({"torque": 4.905})  # the weight's moment when the rod lies
            seen: set[int] = set()
            deadline = time.monotonic() + patience
            while len(seen) <= 3:
                assert time.monotonic() < deadline
                seen.add(peer.read().sequence)
            assert peer.alive > 0
            assert abs(peer.read()["angle"]) < 1.6
        process.terminate()
        process.wait(patience)
    assert not Path(f"/dev/shm/{name}").exists()


def test_nobody_answers() -> None:
    with pytest.raises(TimeoutError, match="no simulation answers"):
        UdpPeer(("127.0.0.1", free_port()), timeout=0.3)


def test_code_takes_part_as_a_simulation_does(tmp_path: Path) -> None:
    """The example of hardware in the loop: generated code, and a controller at its port."""
    compiler = shutil.which("cc")
    if not compiler:
        pytest.skip("there is no C compiler")
    repository = Path(__file__).resolve().parents[2]
    model = mimbre.Model.from_text(
        """
        mimbre: 1
        bodies: {slider: {mass: 2, com: [0, 0, 0], inertia: [1, 1, 1]}}
        joints: {guide: {type: prismatic, between: [ground, slider], at: [0, 0, 0], axis: [1, 0, 0]}}
        inputs: {push: 0, other: 0}
        actuators: {motor: {joint: guide, force: push}}
        outputs: [{name: place, joint: guide}, {name: speed, joint_velocity: guide}]
        simulation: {step: 2 ms}
        """
    )
    model.generate(tmp_path / "code", name="model")
    source = repository / "examples/hardware-in-the-loop/loop.c"
    includes = [f"-I{repository / 'include'}", f"-I{tmp_path / 'code'}"]
    program = tmp_path / "loop"
    strict = ["-std=c11", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]
    code = tmp_path / "code/model.c"
    subprocess.run([compiler, *strict, *includes, source, code, "-o", program, "-lm"], check=True)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    words = [program, "-u", str(port), "-d", "60"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        with UdpPeer(("127.0.0.1", port), timeout=patience) as peer:
            assert peer.outputs == ("place", "speed")
            assert peer.inputs == ("push", "other")
            before, gains = None, []
            for _ in range(200):
                got = peer.receive()
                assert got is not None
                if before is not None:
                    gains.append((got["speed"] - before["speed"]) / (got.time - before.time))
                    assert got.sequence - before.sequence == round((got.time - before.time) / 0.002)
                peer.send({"push": 3.0}, answers=got.sequence)
                before = got
            assert gains[-1] == pytest.approx(1.5, rel=1e-9)
            assert gains[0] <= 1.5
            # Packets that make no sense change nothing.
            peer._socket.send(b"nonsense")
            peer.send({"push": float("nan")})
            for _ in range(20):
                got = peer.receive()
                assert got is not None
            assert (got["speed"] - before["speed"]) / (got.time - before.time) == pytest.approx(1.5, rel=1e-9)
        process.send_signal(signal.SIGINT)
        out, error = process.communicate(timeout=patience)
        assert process.returncode == 0, error
        assert "computation of a step" in out
        assert "delay of a step's start" in out
    finally:
        process.kill()
