// One to six servos, pulsed by Timer1, to the processor's cycle; no pulse before servos_arm(), which says how many.
// Servos 1 to 3 are on pins 9, 10, 11, servos 4 to 6 on pins 5, 6, 7; not on pin 13, on which the boot loader blinks.
#pragma once
#include <stdint.h>

const uint8_t MOST_SERVOS = 6;
const uint16_t TICKS_PER_MS = 2000;      // widths are commanded in ticks of 0.5 us
const uint16_t MIN_WIDTH = 1000;         // ticks: 500 us, the shortest pulse that common servos take
const uint16_t MAX_WIDTH = 5000;         // ticks: 2500 us, the longest
const uint8_t PERIOD_MS = 20;            // from one pulse of a servo to its next
const uint16_t SLEW_PER_PERIOD = 80;     // ticks: 40 us in 20 ms, for usual servos (180 deg in 2000 us) 180 deg/s
const uint16_t SLEW_PER_S = SLEW_PER_PERIOD * (1000 / PERIOD_MS);

void servos_begin();

// Whether `count` widths lie within MIN_WIDTH and MAX_WIDTH.
bool servos_allowed(const uint16_t *widths, uint8_t count);

// Start pulses at these widths on the first `count` servos.
void servos_arm(const uint16_t *widths, uint8_t count);

// Set out for these widths on a straight line; returns the ms that it takes, more than asked if the slew limit demands.
uint16_t servos_move(const uint16_t *widths, uint16_t duration_ms);

// Hold the widths of this moment.
void servos_stop();

// No more pulses; one that has begun is finished, since a cut pulse is a command to another place.
void servos_detach();

// Make the next step of a move ready for the next period; call it often.
void servos_step();

uint8_t servos_count();  // of the last servos_arm(); 0 before it

bool servos_armed();
bool servos_moving();
uint16_t servos_width(uint8_t servo);
