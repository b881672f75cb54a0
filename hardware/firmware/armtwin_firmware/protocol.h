// Numbers of the serial protocol; hardware/link/protocol.md is the specification, hardware/link/messages.py the host's side.
#pragma once
#include <stdint.h>

const uint32_t BAUD = 115200;
const uint8_t PROTOCOL_VERSION = 2;
const uint8_t FIRMWARE_MAJOR = 2;
const uint8_t FIRMWARE_MINOR = 0;

const uint8_t MIN_PAYLOAD = 2;   // bytes: type, sequence
const uint8_t MAX_PAYLOAD = 32;  // bytes
const uint8_t CRC_BYTES = 2;
const uint8_t MAX_BLOCK = MAX_PAYLOAD + CRC_BYTES + 1;  // COBS adds one byte

const uint16_t SILENCE_MS = 2000;       // the servos are detached when no good frame came for so long
const uint16_t MAX_DURATION_MS = 60000;

const uint8_t ANSWER = 0x80;  // bit of the type that tells an answer from a request
enum Type : uint8_t { HELLO = 1, ARM, MOVE, STATE, DETACH, STOP };
enum Status : uint8_t {
  OK = 0, UNKNOWN_TYPE, BAD_LENGTH, NO_HELLO, NOT_ARMED, ALREADY_ARMED, BAD_WIDTH, BAD_DURATION
};
enum DetachReason : uint8_t { NONE = 0, BOOT, COMMAND, SILENCE, NEW_HELLO };
