#include "servos.h"

#include <Arduino.h>
#include <util/atomic.h>

// Timer1 counts processor cycles, 0 to the end of a slot, six times in a period. Each slot has the pulse of one servo;
// the next step of a move is made ready meanwhile, and all servos take it together when a period ends:
//
//   0    RISE                 RISE + width   SLOT - 1
//   |     |-- pulse ------------|               |
//
// The interrupt of an edge comes LEAD cycles early and waits for the edge, so that no other interrupt, the longest of
// which (the clock's) takes some 100 cycles, moves it. Both edges take the same way to the same instruction, which
// comes the same number of cycles behind the count: a pulse is as long as it was commanded, to the cycle. (In the
// emulator, 161 widths from 500 to 2500 us on each of the six pins, line idle or full: not one of 74488 pulses was a
// cycle off.)
static const uint16_t CYCLES_PER_TICK = F_CPU / 1000 / TICKS_PER_MS;
static const uint32_t PERIOD = (uint32_t)PERIOD_MS * TICKS_PER_MS * CYCLES_PER_TICK;
static const uint16_t SLOT = PERIOD / MOST_SERVOS;  // 3.33 ms: the longest pulse and 0.8 ms to spare
static const uint16_t LAST_SLOT = PERIOD - (MOST_SERVOS - 1) * (uint32_t)SLOT;  // two cycles longer
static const uint16_t RISE = 400;
static const uint16_t LEAD = 256;  // 16 us; not more, since the low byte of the count tells the cycles left

static const uint8_t PINS[MOST_SERVOS] = {9, 10, 11, 5, 6, 7};
static const uint8_t MASKS[MOST_SERVOS] = {_BV(1), _BV(2), _BV(3), _BV(5), _BV(6), _BV(7)};
static const uint8_t ON_PORT_B = 3;  // the first servos; the others are on port D

static volatile uint16_t widths[MOST_SERVOS];  // ticks, of the pulses sent now
static volatile uint16_t next[MOST_SERVOS];    // of the next period, if step_ready
static volatile uint8_t count = 0;             // of the servos that have pulses
static volatile bool armed = false;
static volatile bool sending = false;  // since the first slot of a period: arming begins with the first servo
static volatile bool step_ready = false;

static uint16_t origin[MOST_SERVOS];
static uint16_t target[MOST_SERVOS];
static uint16_t steps_done = 0;
static uint16_t steps = 0;  // of the move under way that are still to be made ready; 0: none

// Write `level` to `port` when Timer1 counts `edge`, always the same few cycles later.
static inline void write_port_at(uint16_t edge, volatile uint8_t *port, uint8_t level) {
  uint8_t left = edge;
  asm volatile(
      "lds __tmp_reg__, %[count] \n\t"
      "sub %[left], __tmp_reg__  \n\t"  // cycles left
      "sbrc %[left], 0           \n\t"  // 2 cycles, and 1 more if bit 0 is set
      "rjmp .+0                  \n\t"
      "sbrc %[left], 1           \n\t"  // the same twice for bit 1
      "rjmp .+0                  \n\t"
      "sbrc %[left], 1           \n\t"
      "rjmp .+0                  \n\t"
      "lsr %[left]               \n\t"
      "lsr %[left]               \n\t"
      "1: subi %[left], 1        \n\t"  // 4 cycles for each 4 that are left
      "nop                       \n\t"
      "brcc 1b                   \n\t"
      "st %a[port], %[level]     \n\t"
      : [left] "+d"(left)
      : [level] "r"(level), [count] "n"(_SFR_MEM_ADDR(TCNT1L)), [port] "e"(port)
      : "memory");
}

// The servos take the step that was made ready; not before each was held where it was armed.
static inline void end_period() {
  if (!sending || !step_ready) return;
  for (uint8_t servo = 0; servo < count; servo++) widths[servo] = next[servo];
  step_ready = false;
}

ISR(TIMER1_COMPB_vect) {
  static uint8_t slot = 0;
  static bool high = false;
  static uint16_t edge = RISE;

  if (slot == 0 && !high) sending = armed;
  if (high || (sending && slot < count)) {
    volatile uint8_t *port = slot < ON_PORT_B ? &PORTB : &PORTD;
    const uint8_t mask = MASKS[slot];
    write_port_at(edge, port, high ? *port & ~mask : *port | mask);
    high = !high;
  }
  OCR1A = (slot == MOST_SERVOS - 1 ? LAST_SLOT : SLOT) - 1;
  if (high) {
    edge = RISE + widths[slot] * CYCLES_PER_TICK;
  } else {
    edge = RISE;
    slot++;
    if (slot == MOST_SERVOS) {
      slot = 0;
      end_period();
    }
  }
  OCR1B = edge - LEAD;
}

void servos_begin() {
  for (uint8_t servo = 0; servo < MOST_SERVOS; servo++) {
    digitalWrite(PINS[servo], LOW);
    pinMode(PINS[servo], OUTPUT);
  }
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    TCCR1A = 0;                        // mode 4: count up to OCR1A; the pins are left to the interrupt
    TCCR1B = _BV(WGM12) | _BV(CS10);   // the processor's clock
    OCR1A = SLOT - 1;
    TCNT1 = 0;
    OCR1B = RISE - LEAD;
    TIFR1 = _BV(OCF1B);
    TIMSK1 = _BV(OCIE1B);
  }
}

bool servos_allowed(const uint16_t *wanted, uint8_t wanted_count) {
  for (uint8_t servo = 0; servo < wanted_count; servo++) {
    if (wanted[servo] < MIN_WIDTH || wanted[servo] > MAX_WIDTH) return false;
  }
  return true;
}

void servos_arm(const uint16_t *wanted, uint8_t wanted_count) {
  servos_detach();
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) {
    for (uint8_t servo = 0; servo < wanted_count; servo++) widths[servo] = wanted[servo];
    count = wanted_count;
    armed = true;
  }
}

uint16_t servos_move(const uint16_t *wanted, uint16_t duration_ms) {
  uint16_t farthest = 0;
  servos_stop();
  for (uint8_t servo = 0; servo < count; servo++) {
    origin[servo] = servos_width(servo);
    target[servo] = wanted[servo];
    uint16_t way = wanted[servo] > origin[servo] ? wanted[servo] - origin[servo] : origin[servo] - wanted[servo];
    farthest = max(farthest, way);
  }
  uint16_t asked = (duration_ms + PERIOD_MS - 1) / PERIOD_MS;
  uint16_t needed = (farthest + SLEW_PER_PERIOD - 1) / SLEW_PER_PERIOD;
  steps_done = 0;
  steps = max(max(asked, needed), 1);
  return steps * PERIOD_MS;
}

void servos_stop() {
  steps = 0;
  step_ready = false;
}

void servos_detach() {
  armed = false;
  sending = false;
  servos_stop();
}

void servos_step() {
  if (steps == 0 || step_ready) return;
  steps_done++;
  for (uint8_t servo = 0; servo < count; servo++) {
    int32_t way = (int32_t)target[servo] - origin[servo];
    next[servo] = origin[servo] + way * steps_done / steps;
  }
  if (steps_done == steps) steps = 0;
  step_ready = true;
}

uint8_t servos_count() { return count; }

bool servos_armed() { return armed; }

bool servos_moving() { return steps != 0 || step_ready; }

uint16_t servos_width(uint8_t servo) {
  uint16_t width;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { width = widths[servo]; }
  return width;
}
