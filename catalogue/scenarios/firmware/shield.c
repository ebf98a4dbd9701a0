// An exported brain on a Boe-Bot's shield: catalogue/scenarios/shield.toml. ATmega328P at 16 MHz.
//
//     baudbot export-brain avoid --lang c --scenario shield --out brain.c
//     avr-gcc -mmcu=atmega328p -std=c99 -Os -I. -o shield.elf shield.c -lm
//
// A0 to A2: infra-red eyes on the left, in front and on the right. 13, 12: the left and the right servo.

#include <avr/io.h>

#include "brain.c"

// The places of the eyes among the robot's sensors and values, as the head of brain.c lists them: behind whiskers and sonar.
#define FIRST_EYE 3
#define EYES 3
#define TURN_US 20000UL
#define NEUTRAL_US 1500
#define HALF_RANGE_US 200

static struct brain brain;
static struct brain_readings readings;
static struct brain_command command;

static uint16_t measure(uint8_t channel) {
  ADMUX = (1 << REFS0) | channel;
  ADCSRA |= 1 << ADSC;
  while (ADCSRA & (1 << ADSC));
  return ADC;
}

// Timer 1 counts half microseconds.
static uint16_t pulse(brain_real signal) {
  if (signal > 1) signal = 1;
  if (signal < -1) signal = -1;
  return 2 * (uint16_t)(NEUTRAL_US + HALF_RANGE_US * signal + (brain_real)0.5);
}

int main(void) {
  uint16_t begun = 0, left, right, passed;
  DDRB |= (1 << PB5) | (1 << PB4);
  TCCR1B = 1 << CS11;
  ADCSRA = (1 << ADEN) | (1 << ADPS2) | (1 << ADPS1) | (1 << ADPS0);
  brain_init(&brain);
  for (;;) {
    readings.at_ns += TURN_US * 1000;
    for (uint8_t i = 0; i < EYES; i++) {
      readings.values[FIRST_EYE + i] = measure(i) / (brain_real)1023;
      readings.is_new[FIRST_EYE + i] = 1;
    }
    brain_turn(&brain, &readings, &command);
    // The right servo is mounted the other way round.
    left = pulse(command.left);
    right = pulse(-command.right);
    PORTB |= (1 << PB5) | (1 << PB4);
    uint16_t up = TCNT1;
    while (PORTB & ((1 << PB5) | (1 << PB4))) {
      passed = TCNT1 - up;
      if (passed >= left) PORTB &= ~(1 << PB5);
      if (passed >= right) PORTB &= ~(1 << PB4);
    }
    while ((uint16_t)(TCNT1 - begun) < 2 * TURN_US);
    begun += 2 * TURN_US;
  }
}
