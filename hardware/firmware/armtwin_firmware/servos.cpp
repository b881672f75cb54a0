#include "servos.h"

#include <Arduino.h>
#include <util/atomic.h>

// Timer1 counts processor cycles, 0 to SLOT - 1, five times in a period. Three slots have the pulse of one servo each,
// in the other two the next step of a move is made ready:
//
//   0    RISE                 RISE + width   SLOT - 1
//   |     |-- pulse ------------|               |
//
// The interrupt of an edge comes LEAD cycles early and waits for the edge, so that no other interrupt, the longest of
// which (the clock's) takes some 100 cycles, moves it. Both edges take the same way to the same instruction, which
// comes the same number of cycles behind the count: a pulse is as long as it was commanded, to the cycle. (In the
// emulator, 161 widths from 500 to 2500 us on each pin, line idle or full: not one of 5796 pulses was a cycle off.)
static const uint16_t CYCLES_PER_TICK = F_CPU / 1000 / TICKS_PER_MS;
static const uint16_t SLOT = 64000;  // 4 ms: the longest pulse and time to spare
static const uint8_t SLOTS = (uint32_t)PERIOD_MS * TICKS_PER_MS * CYCLES_PER_TICK / SLOT;
static const uint16_t RISE = 400;
static const uint16_t LEAD = 256;  // 16 us; not more, since the low byte of the count tells the cycles left

static volatile uint16_t widths[N_SERVOS];  // ticks, of the pulses sent now
static volatile bool armed = false;
static volatile bool period_over = false;

static uint16_t origin[N_SERVOS];
static uint16_t target[N_SERVOS];
static uint16_t steps_done = 0;
static uint16_t steps = 0;  // of the move under way; 0: none

// Write `level` to port B when Timer1 counts `edge`, always the same few cycles later.
static inline void write_port_at(uint16_t edge, uint8_t level) {
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
      "out %[port], %[level]     \n\t"
      : [left] "+d"(left)
      : [level] "r"(level), [count] "n"(_SFR_MEM_ADDR(TCNT1L)), [port] "I"(_SFR_IO_ADDR(PORTB)));
}

ISR(TIMER1_COMPB_vect) {
  static uint8_t slot = 0;
  static bool high = false;
  static bool sending = false;  // since the first slot of a period: arming begins with the first servo
  static uint16_t edge = RISE;

  if (slot == 0 && !high) sending = armed;
  if (high || (sending && armed && slot < N_SERVOS)) {
    const uint8_t mask = 1 << (PORTB1 + slot);
    write_port_at(edge, high ? PORTB & ~mask : PORTB | mask);
    high = !high;
  }
  if (high) {
    edge = RISE + widths[slot] * CYCLES_PER_TICK;
  } else {
    edge = RISE;
    slot++;
    if (slot == N_SERVOS) period_over = sending;  // no servo moves before it was held where it was armed
    if (slot == SLOTS) slot = 0;
  }
  OCR1B = edge - LEAD;
}

static void set_width(uint8_t servo, uint16_t width) {
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { widths[servo] = width; }
}

void servos_begin() {
  for (uint8_t servo = 0; servo < N_SERVOS; servo++) {
    digitalWrite(FIRST_PIN + servo, LOW);
    pinMode(FIRST_PIN + servo, OUTPUT);
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

bool servos_allowed(const uint16_t *wanted) {
  for (uint8_t servo = 0; servo < N_SERVOS; servo++) {
    if (wanted[servo] < MIN_WIDTH || wanted[servo] > MAX_WIDTH) return false;
  }
  return true;
}

void servos_arm(const uint16_t *wanted) {
  for (uint8_t servo = 0; servo < N_SERVOS; servo++) set_width(servo, wanted[servo]);
  steps = 0;
  period_over = false;
  armed = true;
}

uint16_t servos_move(const uint16_t *wanted, uint16_t duration_ms) {
  uint16_t farthest = 0;
  for (uint8_t servo = 0; servo < N_SERVOS; servo++) {
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

void servos_stop() { steps = 0; }

void servos_detach() {
  armed = false;
  steps = 0;
}

void servos_step() {
  if (!period_over) return;
  period_over = false;
  if (steps == 0) return;
  steps_done++;
  for (uint8_t servo = 0; servo < N_SERVOS; servo++) {
    int32_t way = (int32_t)target[servo] - origin[servo];
    set_width(servo, origin[servo] + way * steps_done / steps);
  }
  if (steps_done == steps) steps = 0;
}

bool servos_armed() { return armed; }

bool servos_moving() { return steps != 0; }

uint16_t servos_width(uint8_t servo) {
  uint16_t width;
  ATOMIC_BLOCK(ATOMIC_RESTORESTATE) { width = widths[servo]; }
  return width;
}
