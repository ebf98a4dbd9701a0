// Never sleeps: it works out numbers, measures and drives in each round. ATmega328P at 16 MHz.

#include <avr/io.h>
#include <stdint.h>

int main(void) {
  DDRB = (1 << PB0) | (1 << PB1) | (1 << PB2);
  DDRD = 1 << PD7;
  PORTB = 1 << PB0;
  PORTD = 1 << PD7;
  TCCR1A = (1 << COM1A1) | (1 << COM1B1) | (1 << WGM10);
  TCCR1B = (1 << WGM12) | (1 << CS11);
  ADMUX = 1 << REFS0;
  ADCSRA = (1 << ADEN) | 7;
  uint32_t number = 1;
  for (;;) {
    for (uint16_t i = 0; i < 500; i++) {
      number ^= number << 13;
      number ^= number >> 17;
      number ^= number << 5;
    }
    ADCSRA |= 1 << ADSC;
    while (ADCSRA & (1 << ADSC));
    OCR1A = 40 + (ADC >> 3);
    OCR1B = 40 + (number & 15);
  }
}
