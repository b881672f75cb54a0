// Firmware of the armtwin bench for an Arduino Uno: one to six servos, told what to do over USB serial. Servos 1 to 3 are
// on pins 9, 10, 11, servos 4 to 6 on pins 5, 6, 7.
//
// It boots without pulses, sends pulses only after ARM, refuses widths out of range, is never faster than its slew
// limit, and detaches the servos when the host was silent for two seconds. If the sketch itself hangs, the processor's
// watchdog resets it after half a second, which detaches the servos too.
// The protocol is described, byte for byte, in hardware/link/protocol.md.
#include <avr/sleep.h>
#include <avr/wdt.h>

#include "frames.h"
#include "protocol.h"
#include "servos.h"

static FrameReader reader;
static uint8_t answer[MAX_PAYLOAD];  // the last one, kept to repeat it
static uint8_t answer_size = 0;
static bool greeted = false;          // a HELLO came since boot
static bool answered = false;         // `answer` belongs to a request after the last HELLO
static DetachReason detach_reason = BOOT;
static uint32_t heard_ms = 0;

static uint16_t read_u16(const uint8_t *bytes) { return bytes[0] | (uint16_t)bytes[1] << 8; }

static void read_widths(const uint8_t *bytes, uint16_t *widths, uint8_t count) {
  for (uint8_t servo = 0; servo < count; servo++) widths[servo] = read_u16(bytes + 2 * servo);
}

static void put_u16(uint16_t value) {
  answer[answer_size++] = value;
  answer[answer_size++] = value >> 8;
}

static void put_u32(uint32_t value) {
  put_u16(value);
  put_u16(value >> 16);
}

static void send_answer() {
  uint8_t frame[MAX_BLOCK + 2];
  Serial.write(frame, encode_frame(answer, answer_size, frame));
}

static void detach(DetachReason reason) {
  if (servos_armed()) detach_reason = reason;
  servos_detach();
}

static Status do_hello(const uint8_t *, uint8_t size) {
  if (size != 1) return BAD_LENGTH;  // the host's protocol version: the host judges whether it fits
  detach(NEW_HELLO);
  greeted = true;
  return OK;
}

static void put_hello() {
  answer[answer_size++] = PROTOCOL_VERSION;
  answer[answer_size++] = FIRMWARE_MAJOR;
  answer[answer_size++] = FIRMWARE_MINOR;
  answer[answer_size++] = MOST_SERVOS;
  put_u16(MIN_WIDTH);
  put_u16(MAX_WIDTH);
  put_u16(SLEW_PER_S);
  put_u16(SILENCE_MS);
}

static Status do_arm(const uint8_t *body, uint8_t size) {
  uint16_t widths[MOST_SERVOS];
  uint8_t count = size / 2;
  if (size % 2 != 0 || count == 0 || count > MOST_SERVOS) return BAD_LENGTH;
  if (servos_armed()) return ALREADY_ARMED;  // to begin elsewhere now would be a jump
  read_widths(body, widths, count);
  if (!servos_allowed(widths, count)) return BAD_WIDTH;
  detach_reason = NONE;
  servos_arm(widths, count);
  return OK;
}

static Status do_move(const uint8_t *body, uint8_t size) {
  uint16_t widths[MOST_SERVOS];
  if (size > 2 + 2 * MOST_SERVOS) return BAD_LENGTH;
  if (!servos_armed()) return NOT_ARMED;
  uint8_t count = servos_count();
  if (size != 2 + 2 * count) return BAD_LENGTH;
  uint16_t duration_ms = read_u16(body);
  if (duration_ms > MAX_DURATION_MS) return BAD_DURATION;
  read_widths(body + 2, widths, count);
  if (!servos_allowed(widths, count)) return BAD_WIDTH;
  put_u16(servos_move(widths, duration_ms));
  return OK;
}

static Status do_state(uint8_t size) {
  if (size != 0) return BAD_LENGTH;
  answer[answer_size++] = (servos_armed() ? 1 : 0) | (servos_moving() ? 2 : 0);
  answer[answer_size++] = detach_reason;
  put_u32(millis());
  put_u16(reader.bad_frames);
  for (uint8_t servo = 0; servo < servos_count(); servo++) put_u16(servos_width(servo));
  return OK;
}

static Status do_request(uint8_t type, const uint8_t *body, uint8_t size) {
  if (type == HELLO) {
    Status status = do_hello(body, size);
    if (status == OK) put_hello();
    return status;
  }
  if (type == DETACH || type == STOP) {  // always obeyed, known host or not
    if (size != 0) return BAD_LENGTH;
    if (type == DETACH) detach(COMMAND);
    servos_stop();
    return OK;
  }
  if (type != ARM && type != MOVE && type != STATE) return UNKNOWN_TYPE;
  if (!greeted) return NO_HELLO;
  if (type == ARM) return do_arm(body, size);
  if (type == MOVE) return do_move(body, size);
  return do_state(size);
}

static void receive(const uint8_t *payload, uint8_t size) {
  uint8_t type = payload[0], sequence = payload[1];
  if (type & ANSWER) return;  // our own words come back over a faulty cable: answering them would never end
  heard_ms = millis();
  // Sent again because our answer was lost. What is safe to do twice is done, so that it never depends on a number.
  bool repeatable = type == HELLO || type == DETACH || type == STOP;
  if (!repeatable && answered && sequence == answer[1]) {
    send_answer();
    return;
  }
  answer[0] = type | ANSWER;
  answer[1] = sequence;
  answer_size = 3;
  answer[2] = do_request(type, payload + 2, size - 2);
  answered = type != HELLO;
  send_answer();
}

void setup() {
  wdt_disable();  // still on, at its shortest, if it was the watchdog that reset us
  servos_begin();
  Serial.begin(BAUD);
  wdt_enable(WDTO_500MS);
  set_sleep_mode(SLEEP_MODE_IDLE);
}

// A pass takes one byte at most and sends one answer at most, some 2 ms: however fast frames come, a move goes on and
// the watchdog, which tells a program that hangs from one that is busy, stays content.
void loop() {
  uint8_t payload[MAX_PAYLOAD], size;
  wdt_reset();
  if (Serial.available() > 0 && reader.feed(Serial.read(), payload, &size)) receive(payload, size);
  servos_step();
  if (servos_armed() && millis() - heard_ms > SILENCE_MS) detach(SILENCE);
  if (Serial.available() == 0) sleep_mode();  // until the next interrupt: a byte, an edge, or the clock in 1 ms
}
