// A program to be debugged: adds up numbers, one every 5 ms, while a timer counts milliseconds. ATmega328P at 16 MHz.
#include <avr/interrupt.h>
#include <avr/io.h>

volatile uint8_t ticks_ms;
volatile uint16_t total;

ISR(TIMER0_COMPA_vect) { ticks_ms++; }

__attribute__((noinline)) uint16_t add(uint16_t sum, uint8_t number) {
  sum += number;
  return sum;
}

int main(void) {
  OCR0A = 249;
  TCCR0A = 1 << WGM01;
  TCCR0B = 1 << CS01 | 1 << CS00;
  TIMSK0 = 1 << OCIE0A;
  sei();
  for (uint8_t number = 1;; number++) {
    total = add(total, number);
    while (ticks_ms < 5);
    ticks_ms = 0;
  }
}
