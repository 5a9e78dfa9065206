"""Packets of Protocol 2.0 as the vendor's SDK (package dynamixel-sdk, 4.1.0) builds them, and pypot,
another master, where it has the instruction and no byte has to be stuffed, which it does not.

    python protocol2_vectors.py > ../../shared/servo/tests/protocol2/vectors.txt

Each line has the instruction in words, and the packet that the SDK passes to its port. `txPacket` of
4.1.0 drops the result of `addStuffing` where it stuffs a byte, and so sends what a servo cannot read;
such packets, and status packets, which the SDK only receives, are made of its own stuffing and CRC.
"""

import random

from dynamixel_sdk import COMM_SUCCESS, DXL_HIBYTE, DXL_LOBYTE, Protocol2PacketHandler
from pypot.dynamixel.protocol import v2 as pypot


class Port:
    """A port that keeps what is written, and returns what it was given."""

    def __init__(self):
        self.is_using = False
        self.sent = b""
        self.given = []

    def clearPort(self):
        pass

    def writePort(self, packet):
        self.sent = bytes(packet)
        return len(packet)

    def readPort(self, length):
        taken, self.given = self.given[:length], self.given[length:]
        return taken

    def setPacketTimeout(self, _bytes):
        pass

    def setPacketTimeoutMillis(self, _ms):
        pass

    def isPacketTimeout(self):
        return not self.given


HANDLER = Protocol2PacketHandler()


def sent(call):
    """The packet that a call sends."""
    port = Port()
    call(port)
    assert b"\xff\xff\xfd" not in port.sent[7:-2]
    return port.sent.hex(" ").upper()


def stuffed(servo, code, parameters):
    """A packet by the SDK's stuffing and CRC."""
    packet = [0xFF, 0xFF, 0xFD, 0, servo, *word(3 + len(parameters)), code, *parameters, 0, 0]
    packet = list(HANDLER.addStuffing(packet))
    packet = packet[: 7 + packet[5] + 256 * packet[6]]
    packet[-2:] = word(HANDLER.updateCRC(0, packet, len(packet) - 2))
    return packet


def marks(generator, count):
    """Bytes that are rich in the mark FF FF FD."""
    return [generator.choice([0xFF, 0xFF, 0xFD, 0x00, generator.randrange(256)]) for _ in range(count)]


def listed(values):
    return bytes(values).hex(" ").upper()


def agreed(packet, other):
    """The packet of the SDK, which is that of pypot."""
    assert packet == listed(other.to_array()), (packet, other)
    return packet


def word(value):
    return [DXL_LOBYTE(value), DXL_HIBYTE(value)]


def status(servo, error, data):
    """A status packet, which the SDK reads as these data."""
    packet = stuffed(servo, 0x55, [error, *data])
    port = Port()
    port.given = packet[:]
    received, result = HANDLER.rxPacket(port, False)
    assert result == COMM_SUCCESS, result
    count = received[5] + 256 * received[6] - 4
    assert received[9 : 9 + count] == data, (received, data)
    return listed(packet)


def main():
    generator = random.Random(1)
    print("# Made by tests/python/protocol2_vectors.py with dynamixel-sdk 4.1.0.")
    ping = sent(lambda port: HANDLER.txPacket(port, [0, 0, 0, 0, 1, 3, 0, 1, 0, 0]))
    print("ping 1 |", agreed(ping, pypot.DxlPingPacket(1)))
    print("reboot 7 |", sent(lambda port: HANDLER.txPacket(port, [0, 0, 0, 0, 7, 3, 0, 8, 0, 0])))
    for servo, address, count in [(1, 132, 4), (252, 0, 147), (3, 634, 28)]:
        call = lambda port: HANDLER.readTx(port, servo, address, count)
        packet = agreed(sent(call), pypot.DxlReadDataPacket(servo, address, count))
        print(f"read {servo} {address} {count} |", packet)
    for _ in range(12):
        data = marks(generator, generator.randrange(1, 24))
        servo, address = generator.randrange(253), generator.randrange(662)
        packet = stuffed(servo, 3, [*word(address), *data])
        print(f"write {servo} {address} {listed(data)} |", listed(packet))
    call = lambda port: HANDLER.writeTxOnly(port, 1, 100, 2, [0x75, 0x03])
    packet = agreed(sent(call), pypot.DxlWriteDataPacket(1, 100, [0x75, 0x03]))
    print("write 1 100 75 03 |", packet)
    for servos in [[1, 2], [5], list(range(1, 13))]:
        for name, fast in [("sync_read", False), ("fast_sync_read", True)]:
            call = lambda port: HANDLER.syncReadTx(port, 124, 10, servos, len(servos), fast)
            packet = sent(call)
            if not fast:
                agreed(packet, pypot.DxlSyncReadPacket(servos, 124, 10))
            print(f"{name} 124 10 {listed(servos)} |", packet)
    for _ in range(4):
        blocks = [1, *marks(generator, 4), 2, *marks(generator, 4)]
        packet = stuffed(0xFE, 0x83, [*word(100), *word(4), *blocks])
        print(f"sync_write 100 4 {listed(blocks)} |", listed(packet))
    call = lambda port: HANDLER.syncWriteTxOnly(port, 100, 2, [1, 0, 1, 2, 0, 2], 6)
    print("sync_write 100 2 01 00 01 02 00 02 |", sent(call))
    items = [1, *word(144), *word(2), 2, *word(146), *word(1)]
    call = lambda port: HANDLER.bulkReadTx(port, items, len(items), False)
    print(f"bulk_read {listed(items)} |", sent(call))
    for _ in range(12):
        servo, error = generator.randrange(253), generator.choice([0, 0, 0x80, 7, 0x85])
        data = marks(generator, generator.randrange(0, 20))
        print(f"status {servo} {error} {listed(data)} |", status(servo, error, data))


if __name__ == "__main__":
    main()
