#include "servos.h"

#include <Arduino.h>
#include <util/atomic.h>

// A period, in ticks of Timer1, which counts 0 to 39999 and begins again:
//
//   0   100            6100           12100                            39999
//   |   |-- servo 1 --|-- servo 2 ----|-- servo 3 --| rest: step of a move |
//
// The interrupt of each edge comes LEAD ticks early and waits for its tick, so that no other interrupt, the longest of
// which (a received byte) takes about 5 us, moves an edge.
static const uint16_t PERIOD = PERIOD_MS * TICKS_PER_MS;
static const uint16_t FIRST_RISE = 100;
static const uint16_t SLOT = 6000;  // 3 ms: the longest pulse and time to spare
static const uint16_t LEAD = 32;    // 16 us

static volatile uint16_t widths[N_SERVOS];  // ticks, of the pulses sent now
static volatile bool armed = false;
static volatile bool period_over = false;

static uint16_t origin[N_SERVOS];
static uint16_t target[N_SERVOS];
static uint16_t steps_done = 0;
static uint16_t steps = 0;  // of the move under way; 0: none

ISR(TIMER1_COMPB_vect) {
  static uint8_t servo = 0;
  static bool high = false;
  static uint16_t edge = FIRST_RISE;

  if (!high && !armed) {
    servo = 0;
    edge = FIRST_RISE;
    OCR1B = edge - LEAD;
    return;
  }
  const uint8_t mask = 1 << (PORTB1 + servo);
  const uint8_t level = high ? PORTB & ~mask : PORTB | mask;
  while ((int8_t)(TCNT1L - (uint8_t)edge) < 0) {
    // LEAD is below 128, so the low byte tells before from after
  }
  PORTB = level;  // the same instructions for both edges, so that they cancel in the width
  if (!high) {
    edge += widths[servo];
  } else if (++servo < N_SERVOS) {
    edge = FIRST_RISE + servo * SLOT;
  } else {
    servo = 0;
    edge = FIRST_RISE;
    period_over = true;
  }
  high = !high;
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
    TCCR1B = _BV(WGM12) | _BV(CS11);   // 16 MHz / 8
    OCR1A = PERIOD - 1;
    TCNT1 = 0;
    OCR1B = FIRST_RISE - LEAD;
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
