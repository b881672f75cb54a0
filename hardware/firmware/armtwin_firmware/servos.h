// Three servos on pins 9, 10 and 11, pulsed by Timer1, to the processor's cycle; no pulse before servos_arm().
#pragma once
#include <stdint.h>

const uint8_t N_SERVOS = 3;
const uint8_t FIRST_PIN = 9;             // Arduino pins 9, 10, 11 = PB1, PB2, PB3; joint 1, 2, 3
const uint16_t TICKS_PER_MS = 2000;      // widths are commanded in ticks of 0.5 us
const uint16_t MIN_WIDTH = 1000;         // ticks: 500 us, the shortest pulse that common servos take
const uint16_t MAX_WIDTH = 5000;         // ticks: 2500 us, the longest
const uint8_t PERIOD_MS = 20;            // from one pulse of a servo to its next
const uint16_t SLEW_PER_PERIOD = 80;     // ticks: 40 us in 20 ms, for usual servos (180 deg in 2000 us) 180 deg/s
const uint16_t SLEW_PER_S = SLEW_PER_PERIOD * (1000 / PERIOD_MS);

void servos_begin();

// Whether all widths lie within MIN_WIDTH and MAX_WIDTH.
bool servos_allowed(const uint16_t *widths);

// Start pulses at these widths.
void servos_arm(const uint16_t *widths);

// Set out for these widths on a straight line; returns the ms that it takes, more than asked if the slew limit demands.
uint16_t servos_move(const uint16_t *widths, uint16_t duration_ms);

// Hold the widths of this moment.
void servos_stop();

// No more pulses; one that has begun is finished, since a cut pulse is a command to another place.
void servos_detach();

// Take the next step of a move if a period has passed; call it often.
void servos_step();

bool servos_armed();
bool servos_moving();
uint16_t servos_width(uint8_t servo);
