"""A viewer, written from the protocol's specification, at `armbridge foxglove`.

    python live.py ws://127.0.0.1:PORT [--arm]

Reads what is advertised, decodes telemetry by the schema that came with it, changes
parameters, calls services. With --arm, has the arm held and leaves. Exit code 0 if all
is as it should be; otherwise 1, and the first thing that is not on stderr.

The protocol, `foxglove.sdk.v1`: JSON both ways, but for messages (opcode 1: subscription,
log time, payload) and calls of services (2 there, 3 back: service, call, length of the
encoding's name, encoding, payload). Integers are little endian.
"""

import argparse
import base64
import json
import os
import socket
import struct
import sys
import time
from urllib.parse import urlparse

from google.protobuf import descriptor_pb2, descriptor_pool, message_factory
from websockets.sync.client import connect

from topics import LINK_TOPICS as TOPICS

PROTOCOL = "foxglove.sdk.v1"
PATIENCE_S = 20.0
MODE_IDLE, MODE_REGULATE, MODE_FAULT = 1, 4, 12


def check(condition, complaint):
    if not condition:
        raise AssertionError(complaint)


class Viewer:
    """One connection."""

    def __init__(self, url):
        self.socket = connect(url, subprotocols=[PROTOCOL], max_size=None)
        check(self.socket.subprotocol == PROTOCOL, self.socket.subprotocol)
        self.info, self.channels, self.services = None, {}, {}
        self.ticks, self.complaints = [], []
        self.telemetry, self.calls = None, 0

    def send(self, **message):
        self.socket.send(json.dumps(message))

    def wait_for(self, wanted, seconds=PATIENCE_S):
        """Takes what comes until something is `wanted`, and returns that."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            try:
                came = self.socket.recv(timeout=left)
            except TimeoutError:
                break
            message = self.binary(came) if isinstance(came, bytes) else self.text(came)
            if wanted(message):
                return message
        return None

    def text(self, came):
        message = json.loads(came)
        if message["op"] == "serverInfo":
            self.info = message
        elif message["op"] == "advertise":
            self.channels |= {channel["topic"]: channel for channel in message["channels"]}
        elif message["op"] == "advertiseServices":
            self.services |= {service["name"]: service for service in message["services"]}
        elif message["op"] == "status":
            self.complaints.append(message["message"])
        return message

    def binary(self, came):
        if came[0] == 1:
            subscription, at_ns = struct.unpack_from("<IQ", came, 1)
            message = {"op": "data", "subscription": subscription, "at_ns": at_ns}
            if subscription == self.channels["/telemetry"]["id"] and self.telemetry:
                tick = self.telemetry.FromString(came[13:])
                self.ticks.append((at_ns, tick))
                message["tick"] = tick
            return message
        if came[0] == 3:
            _, call, length = struct.unpack_from("<III", came, 1)
            answer = json.loads(came[13 + length :])
            return {"op": "answer", "callId": call, "answer": answer}
        return {"op": f"binary {came[0]}"}

    def meet(self):
        """Waits for what the server has to offer."""
        self.wait_for(lambda _: len(self.channels) >= len(TOPICS) and len(self.services) >= 3)
        check(self.info, "no server info came")

    def subscribe(self, topic):
        channel = self.channels[topic]
        if topic == "/telemetry":
            self.telemetry = message_type(channel)
        subscription = {"id": channel["id"], "channelId": channel["id"]}
        self.send(op="subscribe", subscriptions=[subscription])

    def until_mode(self, mode):
        found = self.wait_for(lambda message: "tick" in message and message["tick"].board_mode == mode)
        check(found, f"no tick in mode {mode} within {PATIENCE_S} s")

    def answer(self, name):
        self.calls += 1
        head = struct.pack("<BIII", 2, self.services[name]["id"], self.calls, 4)
        self.socket.send(head + b"json" + b"{}")
        return self.wait_for(
            lambda message: message["op"] in ("answer", "serviceCallFailure")
            and message["callId"] == self.calls
        )

    def call(self, name, while_refused=None):
        """Calls a service, again as long as it is refused in these words."""
        end = time.monotonic() + PATIENCE_S
        answer = self.answer(name)
        while while_refused and while_refused in str(answer) and time.monotonic() < end:
            answer = self.answer(name)
        check(answer and answer.get("answer", {}).get("success"), f"{name}: {answer}")

    def parameters(self, name, **message):
        self.send(id=name, **message)
        answer = self.wait_for(
            lambda message: message["op"] == "parameterValues" and message.get("id") == name
        )
        check(answer, f"{message}: no answer")
        return {one["name"]: one["value"] for one in answer["parameters"]}


def message_type(channel):
    check(channel["encoding"] == channel["schemaEncoding"] == "protobuf", channel)
    files = descriptor_pb2.FileDescriptorSet.FromString(base64.b64decode(channel["schema"]))
    pool = descriptor_pool.DescriptorPool()
    for file in files.file:
        pool.Add(file)
    return message_factory.GetMessageClass(pool.FindMessageTypeByName(channel["schemaName"]))


def advertised(viewer, may_arm):
    check({"parameters", "services"} <= set(viewer.info["capabilities"]), viewer.info)
    schemas = {topic: channel["schemaName"] for topic, channel in viewer.channels.items()}
    check(schemas == TOPICS, f"advertised: {schemas}")
    for channel in viewer.channels.values():
        message_type(channel)
    names = {"/stop", "/disarm", "/park", "/clear_fault"} | ({"/arm", "/hold", "/upright", "/float"} if may_arm else set())
    check(set(viewer.services) == names, f"services: {sorted(viewer.services)}")
    print(f"{len(schemas)} topics, {len(names)} services")


def every_tick(viewer):
    """Ticks come one after the other, at the rate of the board's clock."""
    viewer.ticks.clear()
    viewer.wait_for(lambda _: len(viewer.ticks) >= 2000)
    check(len(viewer.ticks) >= 2000, f"{len(viewer.ticks)} ticks in {PATIENCE_S} s")
    numbers = [tick.tick for _, tick in viewer.ticks]
    gaps = [b - a for a, b in zip(numbers, numbers[1:]) if b - a != 1]
    check(not gaps, f"gaps between ticks: {gaps}")
    span_s = (viewer.ticks[-1][1].time_s - viewer.ticks[0][1].time_s)
    rate = (len(numbers) - 1) / span_s
    check(abs(rate - 1000) < 1, f"{rate} ticks per second of the board")
    late_s = time.time() - viewer.ticks[-1][0] / 1e9
    check(abs(late_s) < 5, f"messages are stamped {late_s} s from now")
    print(f"{len(numbers)} ticks in a row, {rate:.1f} a second")


def parameters(viewer):
    everything = viewer.parameters("all", op="getParameters", parameterNames=[])
    check(len(everything) > 40, f"parameters: {sorted(everything)}")
    key, before = "limits.hold_ms", everything["limits.hold_ms"]
    wanted = [{"name": key, "value": before - 20}]
    reported = viewer.parameters("set", op="setParameters", parameters=wanted)
    check(reported == {key: before - 20}, f"set: {reported}")
    # By another way: what the board itself reported.
    again = viewer.parameters("again", op="getParameters", parameterNames=[key, "arm.l1_m"])
    check(again == {key: before - 20, "arm.l1_m": everything["arm.l1_m"]}, f"get: {again}")
    for value in (100_000, "long"):
        viewer.complaints.clear()
        wanted = [{"name": key, "value": value}]
        reported = viewer.parameters(f"bad {value}", op="setParameters", parameters=wanted)
        check(reported == {key: before - 20}, f"{value} was taken: {reported}")
        viewer.wait_for(lambda _: viewer.complaints, 2)
        check(any(key in complaint for complaint in viewer.complaints), viewer.complaints)
    print(f"{len(everything)} parameters; {key} {before} -> {before - 20}; {viewer.complaints[0]}")


def stop(viewer):
    viewer.call("/stop")
    viewer.until_mode(MODE_FAULT)
    viewer.call("/clear_fault", while_refused="not yet seen to be off")
    viewer.until_mode(MODE_IDLE)
    viewer.call("/disarm")
    print("stopped, cleared, disarmed")


def slow_viewer(url, channel):
    """Subscribes, and never reads again."""
    place = urlparse(url)
    slow = socket.socket()
    slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    slow.connect((place.hostname, place.port))
    key = base64.b64encode(os.urandom(16)).decode()
    slow.sendall(
        f"GET / HTTP/1.1\r\nHost: {place.netloc}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        f"Sec-WebSocket-Key: {key}\r\nSec-WebSocket-Version: 13\r\n"
        f"Sec-WebSocket-Protocol: {PROTOCOL}\r\n\r\n".encode()
    )
    check(slow.recv(12) == b"HTTP/1.1 101", "the slow viewer was not let in")
    one = {"id": channel["id"], "channelId": channel["id"]}
    text = json.dumps({"op": "subscribe", "subscriptions": [one]}).encode()
    mask = os.urandom(4)
    masked = bytes(byte ^ mask[i % 4] for i, byte in enumerate(text))
    slow.sendall(bytes([0x81, 0x80 | len(text)]) + mask + masked)
    return slow


def hold(url, viewer):
    """Held by a viewer, let go when it leaves."""
    viewer.call("/hold")
    viewer.until_mode(MODE_REGULATE)
    angle = viewer.ticks[-1][1].angle_rad_1
    check(abs(angle - 0.3) < 0.1, f"held at {angle} rad, where it was let go is 0.3")
    viewer.socket.close()
    time.sleep(1)
    later = Viewer(url)
    later.meet()
    later.subscribe("/telemetry")
    later.until_mode(MODE_IDLE)
    print(f"held at {angle:.2f} rad, disarmed when the viewer left")


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("url")
    arguments.add_argument("--arm", action="store_true")
    arguments = arguments.parse_args()
    viewer = Viewer(arguments.url)
    viewer.meet()
    advertised(viewer, arguments.arm)
    viewer.subscribe("/telemetry")
    viewer.until_mode(MODE_IDLE)
    if arguments.arm:
        hold(arguments.url, viewer)
        return
    every_tick(viewer)
    parameters(viewer)
    stop(viewer)
    slow = slow_viewer(arguments.url, viewer.channels["/telemetry"])
    every_tick(viewer)
    every_tick(viewer)
    slow.close()


if __name__ == "__main__":
    try:
        main()
    except AssertionError as complaint:
        sys.exit(str(complaint))
