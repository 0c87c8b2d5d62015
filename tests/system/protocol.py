"""Dynamixel protocol 2.0 as the e-manual has it: what a host sends to the board, and what it finds in the answers."""
import struct

BOARD = 200
HEADER = b"\xff\xff\xfd\x00"


def checksum(data):
    """CRC-16, polynomial 8005h, initial value 0, not reflected."""
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ (0x8005 if crc & 0x8000 else 0)) & 0xFFFF
    return crc


def packet(instruction, parameters):
    body = bytes([instruction]) + parameters
    body = body.replace(b"\xff\xff\xfd", b"\xff\xff\xfd\xfd")
    head = HEADER + bytes([BOARD]) + struct.pack("<H", len(body) + 2)
    return head + body + struct.pack("<H", checksum(head + body))


def answers(data):
    """Takes the whole packets out of `data`: instruction, error and parameters of those of the board that are not broken."""
    while True:
        start = data.find(HEADER)
        if start < 0 or len(data) < start + 7:
            return
        end = start + 7 + struct.unpack_from("<H", data, start + 5)[0]
        if len(data) < end:
            return
        found = bytes(data[start:end])
        del data[:end]
        if checksum(found[:-2]) == struct.unpack("<H", found[-2:])[0] and found[4] == BOARD:
            yield found[7:-2].replace(b"\xff\xff\xfd\xfd", b"\xff\xff\xfd")
