// Drives a motor shield of the first kind as its usual library does: ahead, a turn to the left, ahead again, and stop.
// ATmega328P at 16 MHz.
//
//     avr-gcc -mmcu=atmega328p -Os -o motor_shield.elf motor_shield.c && avr-objcopy -O ihex motor_shield.elf motor_shield.hex
//
// 12: latch, 4: clock, 8: data, 7: enable (low) of the shift register. 11, 3: PWM of M1 (left) and M2 (right), by timer 2.

#ifndef F_CPU
#define F_CPU 16000000UL
#endif
#include <avr/io.h>
#include <util/delay.h>

// The bits of the register that are the inputs of the bridges.
#define M1_A 2
#define M1_B 3
#define M2_A 1
#define M2_B 4

#define FORWARDS 1
#define BACKWARDS 2
#define RELEASED 0

static uint8_t latched;

static void latch(void) {
  PORTB &= ~(1 << PB4);
  PORTB &= ~(1 << PB0);
  for (uint8_t i = 0; i < 8; i++) {
    PORTD &= ~(1 << PD4);
    if (latched & (0x80 >> i)) PORTB |= 1 << PB0; else PORTB &= ~(1 << PB0);
    PORTD |= 1 << PD4;
  }
  PORTB |= 1 << PB4;
}

static void run(uint8_t a, uint8_t b, uint8_t command) {
  // The first input changes a moment before the second one, as in the library.
  if (command == FORWARDS) latched |= 1 << a; else latched &= ~(1 << a);
  latch();
  if (command == BACKWARDS) latched |= 1 << b; else latched &= ~(1 << b);
  latch();
}

static void drive(uint8_t left, uint8_t right, uint8_t speed) {
  OCR2A = OCR2B = speed;
  run(M1_A, M1_B, left);
  run(M2_A, M2_B, right);
}

int main(void) {
  DDRB = (1 << PB4) | (1 << PB0) | (1 << PB3);
  DDRD = (1 << PD4) | (1 << PD7) | (1 << PD3);
  latch();
  PORTD &= ~(1 << PD7);
  TCCR2A = (1 << COM2A1) | (1 << COM2B1) | (1 << WGM21) | (1 << WGM20);
  TCCR2B = 1 << CS22;
  drive(FORWARDS, FORWARDS, 200);
  _delay_ms(2000);
  drive(BACKWARDS, FORWARDS, 150);
  _delay_ms(500);
  drive(FORWARDS, FORWARDS, 200);
  _delay_ms(2000);
  drive(RELEASED, RELEASED, 0);
  for (;;);
}
