// Frames on the wire: 00 | COBS(payload | CRC-16) | 00. Free of the Arduino core.
#pragma once
#include <stdint.h>

#include "protocol.h"

// Collects the bytes of a stream into blocks; noise of any length takes no more room than one block.
struct FrameReader {
  uint8_t block[MAX_BLOCK];
  uint8_t length;        // MAX_BLOCK + 1: too long, dropped up to the next zero
  uint16_t bad_frames;

  // Take one byte. True if it completed a good frame: `payload`, MAX_PAYLOAD bytes of room, and `size` hold it then.
  bool feed(uint8_t byte, uint8_t *payload, uint8_t *size);
};

// Write the frame of `payload` to `out` (MAX_BLOCK + 2 bytes of room), both zeros included; returns its length.
uint8_t encode_frame(const uint8_t *payload, uint8_t size, uint8_t *out);
