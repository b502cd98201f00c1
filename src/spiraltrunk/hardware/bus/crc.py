"""Checksums of the RoboMaster serial frame.

Parameters are unconfirmed by DJI: they are those of the tables in public RoboMaster firmware, which begin 0x00, 0x5E,
0xBC and 0x0000, 0x1189, 0x2312. Both are reflected, start from all ones and end without inversion.
"""

from __future__ import annotations

import functools

CRC8_POLYNOMIAL = 0x8C
"""x^8 + x^5 + x^4 + 1 (0x31), bits reversed."""

CRC16_POLYNOMIAL = 0x8408
"""x^16 + x^12 + x^5 + 1 (0x1021), bits reversed."""


def compute_crc8(data: bytes | bytearray) -> int:
    """Checksum of a frame's header."""
    table, crc = _build_table(CRC8_POLYNOMIAL), 0xFF
    for byte in data:
        crc = table[crc ^ byte]
    return crc


def compute_crc16(data: bytes | bytearray) -> int:
    """Checksum of a whole frame (known as CRC-16/MCRF4XX)."""
    table, crc = _build_table(CRC16_POLYNOMIAL), 0xFFFF
    for byte in data:
        crc = (crc >> 8) ^ table[(crc ^ byte) & 0xFF]
    return crc


@functools.cache
def _build_table(polynomial: int) -> tuple[int, ...]:
    """Checksum of each byte alone, from zero."""
    table = []
    for byte in range(256):
        crc = byte
        for _ in range(8):
            crc = (crc >> 1) ^ polynomial if crc & 1 else crc >> 1
        table.append(crc)
    return tuple(table)
