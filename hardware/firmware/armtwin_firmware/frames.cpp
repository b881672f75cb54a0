#include "frames.h"

#include <string.h>
#include <util/crc16.h>

static uint16_t crc16(const uint8_t *data, uint8_t size) {  // CRC-16/CCITT-FALSE
  uint16_t crc = 0xFFFF;
  while (size--) crc = _crc_xmodem_update(crc, *data++);
  return crc;
}

// Decode `size` bytes that hold no zero; returns the length of `out`, or 0 if they are not COBS.
static uint8_t cobs_decode(const uint8_t *block, uint8_t size, uint8_t *out) {
  uint8_t read = 0, written = 0;
  while (read < size) {
    uint8_t code = block[read++];
    if (code - 1 > size - read) return 0;
    for (uint8_t i = 1; i < code; i++) out[written++] = block[read++];
    if (read < size) out[written++] = 0;  // no block is long enough for the code 255, which stands for no zero
  }
  return written;
}

bool FrameReader::feed(uint8_t byte, uint8_t *payload, uint8_t *size) {
  if (byte != 0) {
    if (length < MAX_BLOCK) block[length] = byte;
    if (length <= MAX_BLOCK) length++;
    return false;
  }
  uint8_t blocks_length = length;
  length = 0;
  if (blocks_length == 0) return false;  // two zeros in a row
  if (blocks_length <= MAX_BLOCK) {
    uint8_t data[MAX_BLOCK];
    uint8_t decoded = cobs_decode(block, blocks_length, data);
    if (decoded >= MIN_PAYLOAD + CRC_BYTES) {
      uint8_t content = decoded - CRC_BYTES;
      uint16_t sent = data[content] | (uint16_t)data[content + 1] << 8;
      if (crc16(data, content) == sent) {
        memcpy(payload, data, content);
        *size = content;
        return true;
      }
    }
  }
  bad_frames++;
  return false;
}

uint8_t encode_frame(const uint8_t *payload, uint8_t size, uint8_t *out) {
  uint16_t crc = crc16(payload, size);
  uint8_t written = 0, code_at = 1;
  out[written++] = 0;
  written++;  // the first code
  for (uint8_t i = 0; i < size + CRC_BYTES; i++) {
    uint8_t byte = i < size ? payload[i] : i == size ? (uint8_t)crc : (uint8_t)(crc >> 8);
    if (byte != 0) {
      out[written++] = byte;
    } else {
      out[code_at] = written - code_at;
      code_at = written++;
    }
  }
  out[code_at] = written - code_at;
  out[written++] = 0;
  return written;
}
